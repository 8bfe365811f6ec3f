"""How a result shows itself: the page or picture that the renderer, far above it, makes of it.

This is the one way up in the house: `library.notebook` is called by name, when somebody looks.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Displayed:
    """A result that a notebook shows as a page."""

    __slots__ = ()

    def _repr_html_(self) -> str:
        page: str = _notebook().page(self)
        return page


class Plotted(Displayed):
    """A result that also has a picture."""

    __slots__ = ()

    def plot(self) -> Figure:
        """Return its picture, a matplotlib figure.

        A notebook shows it after ``%matplotlib inline``.
        """
        figure: Figure = _notebook().picture(self)
        return figure


def _notebook() -> Any:
    return import_module("scara_iso.library.notebook")
