"""Pictures of one robot over months: a figure with its intervals, and control charts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from scara_iso.render.plots import AREA, ARM, EDGE, PLANE, SOLID
from scara_iso.reporting import ControlPicture, MonthsPicture
from scara_iso.run import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MARKS = ("o-", "s-")
_MONTH = 30.0  # days


def draw_months(axes: Axes, data: MonthsPicture) -> None:
    """Draw a figure by date, its intervals, trend, limit and services."""
    zero = _first_day()
    when = data.days + zero
    below, above = data.values - data.ends[0], data.ends[1] - data.values
    reach = np.nan_to_num(np.maximum(np.stack([below, above]), 0))
    axes.errorbar(when, data.values, yerr=reach, fmt="o", color=ARM, ms=3, lw=0.7, label="95 %")
    if data.fitted is not None:
        last = when[-len(data.fitted) :]
        axes.plot(last, data.fitted, color=PLANE, lw=1.8, label="trend")
    if data.ahead is not None:
        axes.plot(data.ahead[0] + zero, data.ahead[1], color=PLANE, lw=1.4, ls=(0, (2, 2)))
    if data.limit is not None:
        axes.axhline(data.limit, color=SOLID, lw=1.2, ls=(0, (5, 3)), label="limit")
    axes.set_ylim(bottom=0)
    _finish(axes, data.label, when, [day + zero for day in data.events])


def draw_control(axes: Axes, data: ControlPicture) -> None:
    """Draw a control chart by date; a test at which it speaks is ringed."""
    zero = _first_day()
    when = data.days + zero
    axes.fill_between(when, data.low, data.high, color=AREA, lw=0, step="mid")
    axes.plot(when, data.centre, color=EDGE, lw=0.8)
    for (name, values), mark, colour in zip(data.lines.items(), _MARKS, (ARM, SOLID), strict=False):
        axes.plot(when, values, mark, color=colour, ms=2.6, lw=0.8, label=name)
        at = [k for k in data.alarms if values[k] > data.high[k] or values[k] < data.low[k]]
        axes.plot(when[at], values[at], "o", mfc="none", mec=PLANE, mew=1.6, ms=7)
    _finish(axes, data.label, when, [day + zero for day in data.events])


def _first_day() -> float:
    """Return 1970-01-01 as the session counts days, which may be set to begin elsewhere."""
    from matplotlib import dates  # noqa: PLC0415 - half a second, for pictures only

    return float(dates.date2num(np.datetime64("1970-01-01")))  # type: ignore[no-untyped-call]


def _finish(axes: Axes, label: str, days: FloatArray, events: Sequence[float]) -> None:
    from matplotlib import dates  # noqa: PLC0415 - half a second, for pictures only

    for day in events:
        axes.axvline(day, color=SOLID, lw=0.9, ls=":")
    axes.xaxis_date()
    axes.margins(x=0.07)
    if np.ptp(days) == 0:
        axes.set_xlim(days[0] - _MONTH, days[0] + _MONTH)
    locator = dates.AutoDateLocator(minticks=3, maxticks=7)  # type: ignore[no-untyped-call]
    formatter = dates.ConciseDateFormatter(locator, show_offset=False)  # type: ignore[no-untyped-call]
    axes.xaxis.set_major_locator(locator)
    axes.xaxis.set_major_formatter(formatter)
    axes.set_ylabel(label)
    if axes.get_legend_handles_labels()[1]:
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 0.98), ncols=4, frameon=False)
