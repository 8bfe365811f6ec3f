"""Predicted RP over the reach, as a picture or as a table of places."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from scara_iso.diagnosis import JointScatter, ReachMap
from scara_iso.disk import write_file
from scara_iso.errors import UsageError
from scara_iso.render.plots import plot_reach, save_figure

_ENDINGS = (".png", ".svg", ".csv")


def check_map(path: Path) -> None:
    """Raise `UsageError` for an ending that no map has."""
    if path.suffix.lower() not in _ENDINGS:
        raise UsageError(
            f"{path.name}: a map is written as a picture or a table",
            remedy=f"let the name end in {', '.join(_ENDINGS)}",
        )


def save_map(found: JointScatter, path: Path) -> None:
    """Write the map of ``found`` to ``path``, as its ending says.

    Raises as `check_map` and `write_file`.
    """
    check_map(path)
    if found.reach is None:
        return
    if path.suffix.lower() == ".csv":
        write_file(path, _rows(found.reach).encode())
    else:
        save_figure(plot_reach(found.reach), path)


def _rows(reach: ReachMap) -> str:
    """Return a line for each place that the arm reaches [mm], with a limit whether it is kept."""
    limited = reach.limit is not None
    lines = ["x_mm,y_mm,RP_mm,low_mm,high_mm" + (",kept" if limited else "")]
    kept = reach.kept
    for row, column in np.argwhere(~np.isnan(reach.RP)):
        cell = (reach.RP[row, column], reach.low[row, column], reach.high[row, column])
        place = f"{reach.x[column]:.3f},{reach.y[row]:.3f}"
        line = ",".join([place, *(f"{value:.6f}" for value in cell)])
        lines.append(f"{line},{kept[row, column]:.0f}" if limited else line)
    return "\n".join(lines) + "\n"
