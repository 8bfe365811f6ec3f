"""What is said of scatter traced to the joints, and of RP where nobody measured."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence

from scara_iso.diagnosis import (
    FollowedInJoints,
    JointCorrelation,
    JointScatter,
    PoseLeftOut,
    PredictedRP,
    ReachMap,
    SizeInJoint,
    SourceOfScatter,
)
from scara_iso.reporting.blocks import Block, Cell, Number, Section, Table, Text
from scara_iso.reporting.brief import digits_of, figure_cells, figure_said
from scara_iso.reporting.words import printable, words

_SAID = {"dial": "dial's own", "neither": "neither"}
_MEANING = (
    "standard deviations beside effects and rounding; dial's own: alike in X and Y at every pose; "
    "neither: in one direction at single poses; variance: share of X and Y over the poses"
)
_FOLLOWED = (
    "lost motion: half of the distance between the approaches; everywhere: a dial or its datum; "
    "each beside all the others; one interval in twenty misses the truth"
)
_ODD = 0.05
_MICRO = 1e6
_WORTH_A_WORD = 0.05
"""Share of the variance from which the short form names a source that is no joint."""


def scatter_sections(found: JointScatter | None) -> tuple[Section, ...]:
    """Return what scatters, RP at other poses, and how well the poses foretell each other."""
    if found is None:
        return ()
    blocks: list[Block] = [_sources(found.sources)]
    if found.together is not None:
        blocks.append(_together(found.together))
    if found.predicted_RP:
        rows = tuple(_predicted(pose, one) for pose, one in found.predicted_RP.items())
        note = "XY, mm; the interval holds what 30 cycles there would measure, 19 times of 20"
        blocks.append(Table(("RP where nobody measured", "", "95 % interval"), rows, note))
    blocks += [_held_out(pose, one) for pose, one in found.held_out.items()]
    if found.left_out:
        blocks.append(_left_out(found.left_out))
    blocks += _checked(found)
    blocks += [] if found.reach is None else [_extremes(found.reach)]
    return (Section("scatter, traced to the joints", tuple(blocks)),)


def scatter_brief(found: JointScatter | None) -> Iterator[Text]:
    """Yield a line on what scatters, one on RP at other poses, and what was asked beside them."""
    if found is None:
        return
    said = (
        _in_short(_SAID.get(name, name), one)
        for name, one in found.sources.items()
        if one.unit == "rad" or (one.share or 0) >= _WORTH_A_WORD
    )
    yield Text(f"Scatter: {', '.join(said)}")
    if found.together is not None:
        yield _together(found.together)
    elsewhere = (
        figure_said(pose, one.value, (one.low, one.high), "mm")
        for pose, one in found.predicted_RP.items()
    )
    if found.predicted_RP:
        yield Text(f"RP in XY where nobody measured: {', '.join(elsewhere)}")
    yield from (_held_out(pose, one) for pose, one in found.held_out.items())
    if found.reach is not None:
        yield _extremes(found.reach)


def followed_sections(found: Sequence[FollowedInJoints]) -> tuple[Section, ...]:
    """Return what follows recorded columns, in each joint, along the links and in the dials."""
    if not found:
        return ()
    rows = tuple(
        (words(one.effect) if k == 0 else "", source, *_size(size))
        for one in found
        for k, (source, size) in enumerate(one.sizes.items())
    )
    table = Table(("follows", "in", "", "95 % interval", ""), rows, _FOLLOWED)
    odd = [one for one in found if one.misfit_p_value < _ODD]
    said = (
        f"{words(one.effect)}: the poses follow {printable(one.column)} otherwise than joints, "
        f"links and dials let them (p = {one.misfit_p_value:.2g}); intervals are widened for it"
        for one in odd
    )
    blocks: tuple[Block, ...] = (table, *(Text(text, "warn") for text in said))
    return (Section("what follows the recorded columns, traced to the joints", blocks),)


def followed_brief(
    followed: Sequence[FollowedInJoints], effects: Collection[str]
) -> Iterator[Text]:
    """Yield a line for each recorded column of which an effect was found, joints and links only.

    Others stand in the long form: of so many intervals some miss 0 by chance.
    """
    for one in followed:
        if one.effect in effects:
            joints = {name: size for name, size in one.sizes.items() if "everywhere" not in name}
            said = ", ".join(" ".join((name, *_joined(size))) for name, size in joints.items())
            yield Text(f"Follows {printable(one.column)}, {words(one.effect)}: {said}")


def _joined(size: SizeInJoint) -> tuple[str, ...]:
    value, between, unit = _size(size)
    low, _, high = between.partition("..")
    return f"{value} {unit}", f"[{low}, {high}]"


def _size(size: SizeInJoint) -> tuple[str, str, str]:
    """Return a size and its interval as far as the interval tells, and the unit."""
    first, _, per = size.unit.partition("/")
    factor, unit = (1.0, "mm") if first == "mm" else (_MICRO, "µrad" if first == "rad" else "µm/m")
    value, low, high = (factor * v for v in (size.value, size.low, size.high))
    spec = f"+.{digits_of(value, (low, high))}f"
    return f"{value:{spec}}", f"{low:{spec}}..{high:{spec}}", unit + (f"/{per}" if per else "")


def _in_short(name: str, one: SourceOfScatter) -> str:
    scale, unit = (_MICRO, "µrad") if one.unit == "rad" else (1.0, one.unit)
    return figure_said(name, one.value * scale, (one.low * scale, one.high * scale), unit)


def _sources(sources: Mapping[str, SourceOfScatter]) -> Table:
    rows = tuple(_source(_SAID.get(name, name), one) for name, one in sources.items())
    return Table(("scatter of", "", "95 % interval", "", "variance"), rows, _MEANING)


def _source(name: str, one: SourceOfScatter) -> tuple[Cell, ...]:
    joint = one.unit == "rad"
    scale, unit = (_MICRO, "µrad") if joint else (1.0, one.unit)
    value, between = figure_cells(one.value * scale, (one.low * scale, one.high * scale))
    share = "" if one.share is None else Number(one.share, ".0%")
    return (name, value, between, unit, share)


def _together(found: JointCorrelation) -> Text:
    return Text(
        f"The joints scatter together: correlation {found.value:+.2f} [{found.low:+.2f}, "
        f"{found.high:+.2f}], p = {found.p_value:.2g}; one cause moves both, such as the supply, "
        "the controller or the base",
        "warn",
    )


def _predicted(pose: str, one: PredictedRP) -> tuple[Cell, ...]:
    return (pose, *figure_cells(one.value, (one.low, one.high)))


def _held_out(pose: str, one: PoseLeftOut) -> Text:
    predicted = one.predicted
    ends = (predicted.low, predicted.high)
    said = figure_said(f"{pose} held out: RP", predicted.value, ends, "mm predicted")
    measured, left = (figure_cells(value, ends)[0] for value in (one.measured, one.effects_removed))
    error = "" if one.error is None else f" ({one.error:+.0%})"
    where = "inside" if one.inside else "OUTSIDE"
    moved = one.measured != one.effects_removed
    without = f", {left} without the effects found" if moved else ""
    brought = _brought(one) if moved else ""
    return Text(
        f"{said}, {measured} measured{without}{error}: {where} the interval{brought}",
        "good" if one.inside else "warn",
    )


def _brought(one: PoseLeftOut) -> str:
    """Return what the effects of the joints, found elsewhere, bring at a pose held out."""
    changed = ", ".join(
        f"{axis} {before:.2g} to {one.rms_after[axis]:.2g}"
        for axis, before in one.rms_before.items()
    )
    return f"; error there with the effects of the other poses, rms: {changed} mm"


def _left_out(poses: Mapping[str, PoseLeftOut]) -> Table:
    rows = tuple(
        (
            pose,
            figure_cells(one.effects_removed, (one.predicted.low, one.predicted.high))[0],
            *figure_cells(one.predicted.value, (one.predicted.low, one.predicted.high)),
            "" if one.error is None else Number(one.error, "+.0%"),
        )
        for pose, one in poses.items()
    )
    header = ("left out by turns", "RP", "predicted", "95 % interval", "error")
    return Table(
        header, rows, "each from all the other poses; RP in XY without the effects found, mm"
    )


def _checked(found: JointScatter) -> Iterator[Text]:
    rms = found.left_out_rms
    if rms is not None:
        outside = [pose for pose, one in found.left_out.items() if not one.inside]
        missed = f"; outside its interval: {', '.join(outside)}" if outside else ""
        yield Text(
            f"Each pose left out by turns: the others foretell its RP within {rms:.0%} rms; "
            f"chance alone makes {found.left_out_chance:.0%}{missed}",
            "warn" if outside else "plain",
        )


def _extremes(reach: ReachMap) -> Text:
    (x, y, least), (u, v, most) = reach.best, reach.worst
    said = (
        f"RP over the reach: {least:.3g} mm at best, such as {round(x)} mm along x and {round(y)} "
        f"along y; {most:.3g} mm at worst, such as {round(u)} and {round(v)}"
    )
    if reach.limit is None:
        return Text(said)
    kept = reach.share_kept
    return Text(
        f"{said}; {reach.limit:g} mm is kept in {kept:.0%} of it: 39 of 40 tests there would "
        "measure less",
        "good" if kept == 1 else "warn",
    )
