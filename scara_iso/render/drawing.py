"""The door to matplotlib, which takes half a second: it opens where a picture is drawn.

Pictures have matplotlib's own defaults and our style, the same bytes everywhere: not the settings
of the user, nor those that lie in a folder of readings. A user's session keeps its own.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator, Mapping
from contextlib import chdir, contextmanager, nullcontext
from io import BytesIO
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal

from scara_iso.base import trust
from scara_iso.reporting import printable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SESSION = {"backend", "date.epoch"}
"""Settings that a process has once: none that a picture here depends on."""
_FONT = {"font.sans-serif": ["DejaVu Sans"]}
"""It comes with matplotlib; the next ones of its list may be there or not."""


AREA, EDGE, SOLID, PLANE, INK = "#e8eef4", "#7f97ad", "#1f4e79", "#e69f00", "#444444"
COLOURS = {"ink": INK, "blue": SOLID, "orange": PLANE, "grey": EDGE}


def in_picture(text: str) -> str:
    """Return text of a file as a picture takes it: no mathematics, nothing without a shape."""
    return printable(text).replace("$", r"\$")


def new_figure(
    width: float, height: float, *, layout: Literal["constrained"] | None = None
) -> Figure:
    """Return an empty figure of a size in inches, which a notebook shows as its picture."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - half a second, for pictures only

    class Picture(Figure):
        def _repr_png_(self) -> bytes:
            file = BytesIO()
            self.savefig(file, format="png")
            return file.getvalue()

    return Picture(figsize=(width, height), layout=layout)


@contextmanager
def own_style(style: Mapping[str, Any] = MappingProxyType({})) -> Iterator[None]:
    """Draw by matplotlib's defaults and a style while this lasts; afterwards as before."""
    mpl = _matplotlib()
    defaults = {key: mpl.rcParamsDefault[key] for key in mpl.rcParamsDefault.keys() - _SESSION}
    with mpl.rc_context({**defaults, **_FONT, **style}), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing")  # a box stands for it
        yield


def font_file(name: str) -> Path:
    """Return the file of one of the fonts that come with matplotlib."""
    return Path(_matplotlib().get_data_path()) / "fonts" / "ttf" / name


def _matplotlib() -> Any:
    """Return matplotlib, which reads the settings of the folder that it is first imported in.

    In a process of the program that is a folder of ours, where they say nothing.
    """
    with _among_our_settings() if trust.program else nullcontext():
        import matplotlib as mpl  # noqa: PLC0415 - half a second, for pictures only
    return mpl


@contextmanager
def _among_our_settings() -> Iterator[None]:
    try:
        os.chdir(Path.cwd())  # whether there is a way back
    except OSError:  # it is gone or closed to us, and no settings can be read there
        yield
        return
    with chdir(Path(__file__).parent / "settings"):
        yield
