"""The way into pandas and out of it; it is imported only where a frame is asked for."""

from __future__ import annotations

import re
import sys
from collections import Counter
from collections.abc import Container, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from scara_iso.base.errors import DataError
from scara_iso.base.quantities import find_unit

if TYPE_CHECKING:
    import pandas as pd
    from typing_extensions import TypeIs

_LEAVE_OUT = "leave the row out and say `allow_gaps=True`, the cycles' numbers in a column 'cycle'"
_WITH_UNIT = re.compile(r"(.+?)(?: ?[\[(](.+)[\])]|[_ ]([^_ ]+))")
FRAME = "data frame"
"""Where errors and reports say that a run is from."""


def make_frame(
    columns: dict[str, Any] | list[dict[str, Any]], attributes: Mapping[str, Any]
) -> pd.DataFrame:
    """Return a pandas table of columns, each of shape (rows,), or of rows, with ``attrs``."""
    import pandas as pd  # noqa: PLC0415 - half a second that the command line need not pay

    frame = pd.DataFrame(columns)
    frame.attrs.update(attributes)
    return frame


def frame_of(rows: Sequence[Mapping[str, Any]], attributes: Mapping[str, Any]) -> pd.DataFrame:
    """Return a pandas table of one row or more, by name, with ``attrs``; NaN where one has none."""
    return make_frame([*map(dict, rows)], attributes)


def stacked(frames: Sequence[pd.DataFrame]) -> pd.DataFrame:
    """Return tables one below the other, with a column ``source`` of what their ``attrs`` state."""
    import pandas as pd  # noqa: PLC0415 - as above

    return pd.concat(
        [pd.DataFrame(), *(frame.assign(source=frame.attrs["source"]) for frame in frames)],
        ignore_index=True,
    )


def axis_attributes(axes: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return what the axes of a run state beside their readings, for the ``attrs`` of a table."""
    stated = ("unit", "resolution", "uncertainty", "command")
    found = {name: {key: getattr(axis, key) for key in stated} for name, axis in axes.items()}
    for sizes in found.values():
        if isinstance(sizes["command"], Mapping):
            sizes["command"] = dict(sizes["command"])
    return found


def numbers_of(name: str, column: pd.Series) -> npt.NDArray[np.float64]:
    """Return a column's numbers, shape (rows,); `DataError` where one is missing or not finite."""
    try:
        values = column.to_numpy(dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise DataError(
            f"column {name!r} is not numeric",
            where=FRAME,
            remedy="leave it out, or name it 'pose' if it tells the poses",
        ) from error
    bad = np.flatnonzero(~np.isfinite(values))
    if len(bad):
        what = f"column {name!r}, row {bad[0] + 1}: missing or not finite"
        raise DataError(what, where=FRAME, remedy=_LEAVE_OUT)
    return values


def check_axes(
    frame: pd.DataFrame, axes: Sequence[str], with_unit: Container[str], unit: str | None
) -> None:
    """Raise `DataError` for no axis, one in other letters or with its unit, and one without any."""
    columns = [str(name) for name in frame.columns]
    twice = [name for name, count in Counter(columns).items() if count > 1]
    known = {axis.casefold(): axis for axis in axes}
    other = {name: known.get(_bare(name).casefold(), name) for name in columns}
    wrong = {name: axis for name, axis in other.items() if name != axis}
    silent = [axis for axis in axes if axis in columns and axis not in with_unit]
    if twice:
        what, remedy = f"several columns are called {', '.join(twice)}", "name each apart"
    elif wrong or not any(axis in columns for axis in axes):
        both = [name for name, axis in wrong.items() if axis in columns]
        renamed = wrong or {columns[0] if columns else "reading": axes[0]}
        rename = f"frame.drop(columns={both})" if both else f"frame.rename(columns={renamed})"
        what = f"no axis is called {', '.join(wrong or columns) or 'anything'}"
        remedy = f"axes are {', '.join(axes)}: {rename}"
    elif silent and unit is None:
        what, remedy = f"no unit stated for {', '.join(silent)}", 'state it, such as unit="mm"'
    else:
        return
    raise DataError(what, where=FRAME, remedy=remedy)


def _bare(name: str) -> str:
    """Return a column's name without a unit behind it: ``X`` of ``X [um]`` and ``X_um``."""
    found = _WITH_UNIT.fullmatch(name.strip())
    return found[1] if found and find_unit(found[2] or found[3]) else name.strip()


def is_frame(found: object) -> TypeIs[pd.DataFrame]:
    """Say whether this is a pandas table; none is where pandas was never imported."""
    pandas = sys.modules.get("pandas")
    return pandas is not None and isinstance(found, pandas.DataFrame)
