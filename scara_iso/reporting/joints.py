"""What scatters and what follows columns, traced to the joints; RP at poses not measured."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from typing import Protocol

from scara_iso.diagnosis import (
    FollowedInJoints,
    Foretold,
    JointScatter,
    PoseLeftOut,
    ReachMap,
    SourceOfScatter,
)
from scara_iso.reporting.shared.blocks import Block, Columns, Section, Table, Text, note
from scara_iso.reporting.shared.digits import (
    FIGURE,
    Cell,
    Number,
    Result,
    printable,
    result,
    share,
    words,
)

_WORDING = {"dial": "dial's own", "neither": "neither"}
_ODD = 0.05
_WORTH_A_WORD = 0.05
"""Share of the variance from which the short form names a source that is no joint."""
_SHOWN = {"rad": (1e6, "µrad"), "1": (1e6, "µm/m")}
"""Units of which millionths are shown."""


class _Sized(Protocol):
    """A size in ``rad``, ``1`` of a length, ``mm``, or one of these per the unit of a column."""

    @property
    def value(self) -> float: ...
    @property
    def unit(self) -> str: ...
    @property
    def interval(self) -> tuple[float, float]: ...


def _size(one: _Sized, sign: str = "+") -> Result:
    of, _, per = one.unit.partition("/")
    factor, unit = _SHOWN.get(of, (1.0, of))
    low, high = one.interval
    shown = f"{unit}/{per}" if per else unit
    return result(one.value * factor, (low * factor, high * factor), shown, sign=sign)


def size_in_words(name: str, one: _Sized, sign: str = "+") -> str:
    """Return ``joint 1 +41.9 µrad [41.4, 42.4]``."""
    return f"{name} {_size(one, sign)}"


def scatter_section(found: JointScatter) -> Section:
    """Return what scatters, RP at other poses, and how well the poses predict each other."""
    sources: Columns[tuple[str, SourceOfScatter]] = {
        "scatter of": lambda row: _WORDING.get(row[0], row[0]),
        FIGURE: lambda row: _size(row[1], ""),
        "variance": lambda row: share(row[1].share),
    }
    elsewhere: Columns[tuple[str, Foretold]] = {
        "RP at poses not measured": lambda row: row[0],
        FIGURE: lambda row: result(row[1].value, row[1].interval),
    }
    left_out: Columns[tuple[str, PoseLeftOut]] = {
        "left out by turns": lambda row: row[0],
        "RP": lambda row: _alike(row[1], row[1].effects_removed),
        "predicted [95 % interval]": lambda row: _predicted(row[1]),
        "error": lambda row: share(row[1].error, "+.0%"),
    }
    blocks: tuple[Block, ...] = (
        Table.of(found.sources.items(), sources, note("scatter_of")),
        *_together(found),
        Table.of(found.predicted_RP.items(), elsewhere, note("predicted_RP")),
        *(_pose_left_out(pose, one) for pose, one in found.held_out.items()),
        Table.of(found.left_out.items(), left_out, note("left_out")),
        *_checked(found),
        *_extremes(found.reach),
    )
    return Section("scatter, traced to the joints", blocks)


def _predicted(one: PoseLeftOut, unit: str = "") -> Result:
    return result(one.predicted.value, one.predicted.interval, unit)


def _alike(one: PoseLeftOut, RP: float) -> Number:
    """Return an RP to the same place as the predicted one."""
    return replace(_predicted(one).value, value=RP)


def scatter_brief(found: JointScatter) -> Iterator[Text]:
    """Yield a line on what scatters, one on RP at other poses, and what was asked beside them."""
    parts = [
        size_in_words(_WORDING.get(name, name), one, "")
        for name, one in found.sources.items()
        if one.unit == "rad" or (one.share or 0) >= _WORTH_A_WORD
    ]
    yield Text(f"Scatter: {', '.join(parts)}")
    yield from _together(found)
    elsewhere = ", ".join(
        f"{pose} {result(one.value, one.interval, 'mm')}"
        for pose, one in found.predicted_RP.items()
    )
    yield Text(f"Predicted RP in XY at poses not measured: {elsewhere}" if elsewhere else "")
    yield from (_pose_left_out(pose, one) for pose, one in found.held_out.items())
    yield from _extremes(found.reach)


def followed_section(found: Sequence[FollowedInJoints]) -> Section:
    """Return what follows recorded columns, in each joint, along the links and in the dials."""
    rows: list[dict[str, Cell]] = [
        {"follows": words(one.effect), "of": source, FIGURE: _size(size)}
        for one in found
        for source, size in one.sizes.items()
    ]
    odd = (
        f"{words(one.effect)}: the poses follow {printable(one.column)} otherwise than joints, "
        f"links and dials let them (p = {one.misfit_p_value:.2g}); intervals are widened for it"
        for one in found
        if one.misfit_p_value < _ODD
    )
    sizes = Table.by_name(rows, note("followed"))
    heading = "what follows the recorded columns, traced to the joints"
    return Section(heading, (sizes, *(Text(text, "warn") for text in odd)))


def followed_brief(
    followed: Sequence[FollowedInJoints], effects: Collection[str]
) -> Iterator[Text]:
    """Yield a line for each recorded column of which an effect was found, joints and links only.

    Others stand in the long form: of so many intervals some miss 0 by chance.
    """
    for one in followed:
        if one.effect in effects:
            joints = (item for item in one.sizes.items() if "everywhere" not in item[0])
            text = ", ".join(size_in_words(*item) for item in joints)
            yield Text(f"Follows {printable(one.column)}, {words(one.effect)}: {text}")


def _together(found: JointScatter) -> Iterator[Text]:
    if (both := found.together) is not None:
        low, high = both.interval
        yield Text(
            f"The joints scatter together: correlation {both.value:+.2f} [{low:+.2f}, "
            f"{high:+.2f}], p = {both.p_value:.2g}; one cause moves both, such as the supply, "
            "the controller or the base",
            "warn",
        )


def _pose_left_out(pose: str, one: PoseLeftOut) -> Text:
    measured, left = (_alike(one, RP) for RP in (one.measured, one.effects_removed))
    text = f"{pose} held out: RP {_predicted(one, 'mm')} predicted, {measured} measured"
    error = "" if one.error is None else f" ({one.error:+.0%})"
    where = "inside" if one.inside else "OUTSIDE"
    without, brought = "", ""
    if one.measured != one.effects_removed:
        without = f", {left} without the effects found"
        changed = ", ".join(
            f"{axis} {before:.2g} to {one.rms_after[axis]:.2g}"
            for axis, before in one.rms_before.items()
        )
        brought = f"; error there with the effects of the other poses, rms: {changed} mm"
    return Text(
        f"{text}{without}{error}: {where} the interval{brought}",
        "good" if one.inside else "warn",
    )


def _checked(found: JointScatter) -> Iterator[Text]:
    if (rms := found.left_out_rms) is not None:
        outside = [pose for pose, one in found.left_out.items() if not one.inside]
        missed = f"; outside its interval: {', '.join(outside)}" if outside else ""
        yield Text(
            f"Each pose left out by turns: the others predict its RP within {rms:.0%} rms; "
            f"chance alone makes {found.left_out_chance:.0%}{missed}",
            "warn" if outside else "plain",
        )


def _extremes(reach: ReachMap | None) -> Iterator[Text]:
    if reach is None:
        return
    best, worst = reach.best, reach.worst
    text = (
        f"RP over the reach: {best.RP:.3g} mm at best, such as {round(best.x_mm)} mm along x and "
        f"{round(best.y_mm)} along y; {worst.RP:.3g} mm at worst, such as {round(worst.x_mm)} and "
        f"{round(worst.y_mm)}"
    )
    if reach.limit is None:
        yield Text(text)
        return
    kept = reach.share_kept
    yield Text(
        f"{text}; {reach.limit:g} mm is kept in {kept:.0%} of it: 39 of 40 tests there would "
        "measure less",
        "good" if kept == 1 else "warn",
    )
