"""How a notebook shows a result.

Results stand far below the renderer and cannot name it: the face of the whole puts it here.
"""

TYPE_CHECKING = False  # nothing is imported before the program begins: scara_iso.base.process
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

    from matplotlib.figure import Figure


def _none() -> "Any":
    raise NotImplementedError("no renderer")


notebook: "Callable[[], Any]" = _none
"""Gives ``page(result)`` and ``figure(result)``; called when somebody looks."""


class Displayed:
    """A result that a notebook shows as a page."""

    __slots__ = ()

    def _repr_html_(self) -> str:
        page: str = notebook().page(self)
        return page


class Plotted(Displayed):
    """A result that also has a picture."""

    __slots__ = ()

    def plot(self) -> "Figure":
        """Return its picture, a matplotlib figure; a notebook shows it."""
        figure: Figure = notebook().figure(self)
        return figure
