"""The document of a diagnosis of several poses: which effect, where in the robot, what it brings.

What scatters, traced to the joints, and RP where nobody measured.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence, Set
from typing import Any

from scara_iso.diagnosis import (
    UNKNOWN,
    DiagnosisOfPoses,
    FollowedInJoints,
    Foretold,
    FoundAtPoses,
    JointCorrelation,
    JointScatter,
    PoseLeftOut,
    ReachMap,
    SizeInJoint,
    SourceOfScatter,
    Verdict,
)
from scara_iso.reporting.blocks import (
    Block,
    Cell,
    Headline,
    NextStep,
    Number,
    Report,
    Section,
    Table,
    Text,
    U_of_scatter,
    answer_lines,
    at_depth,
    digits_of,
    figure_cells,
    figure_in_words,
    p_equals,
    printable,
    rounded,
    words,
)
from scara_iso.reporting.diagnosis import Again, doubts, notes_in_short, of_pose
from scara_iso.reporting.named_effects import (
    page_of,
    parameters_in_words,
    rivals_in_words,
    sureness,
    unexplained_in_words,
)

_WORDING = {"dial": "dial's own", "neither": "neither"}
_MEANING = (
    "standard deviations without effects and rounding; dial's own: alike in X and Y at every pose; "
    "neither: in one direction at single poses; variance: share of X and Y over the poses"
)
_FOLLOWED = (
    "lost motion: half of the distance between the approaches; everywhere: a dial or its datum; "
    "each fitted with all the others; one interval in twenty misses the truth"
)
_ODD = 0.05
_MILLION = 1e6
_WORTH_A_WORD = 0.05
"""Share of the variance from which the short form names a source that is no joint."""


def scatter_sections(found: JointScatter | None) -> tuple[Section, ...]:
    """Return what scatters, RP at other poses, and how well the poses predict each other."""
    if found is None:
        return ()
    blocks: list[Block] = [_sources(found.sources)]
    if found.together is not None:
        blocks.append(_together(found.together))
    if found.predicted_RP:
        rows = tuple(_predicted(pose, one) for pose, one in found.predicted_RP.items())
        note = "XY, mm; the interval holds what 30 cycles there would measure, 19 times of 20"
        blocks.append(Table(("RP where nobody measured", "", "95 % interval"), rows, note))
    blocks += [_pose_left_out(pose, one) for pose, one in found.held_out.items()]
    if found.left_out:
        blocks.append(_left_out(found.left_out))
    blocks += _checked(found)
    blocks += [] if found.reach is None else [_extremes(found.reach)]
    return (Section("scatter, traced to the joints", tuple(blocks)),)


def scatter_brief(found: JointScatter | None) -> Iterator[Text]:
    """Yield a line on what scatters, one on RP at other poses, and what was asked beside them."""
    if found is None:
        return
    parts = (
        _in_short(_WORDING.get(name, name), one)
        for name, one in found.sources.items()
        if one.unit == "rad" or (one.share or 0) >= _WORTH_A_WORD
    )
    yield Text(f"Scatter: {', '.join(parts)}")
    if found.together is not None:
        yield _together(found.together)
    elsewhere = (
        figure_in_words(pose, one.value, one.interval, "mm")
        for pose, one in found.predicted_RP.items()
    )
    if found.predicted_RP:
        yield Text(f"RP in XY where nobody measured: {', '.join(elsewhere)}")
    yield from (_pose_left_out(pose, one) for pose, one in found.held_out.items())
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
    parts = (
        f"{words(one.effect)}: the poses follow {printable(one.column)} otherwise than joints, "
        f"links and dials let them (p = {one.misfit_p_value:.2g}); intervals are widened for it"
        for one in odd
    )
    blocks: tuple[Block, ...] = (table, *(Text(text, "warn") for text in parts))
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
            text = ", ".join(" ".join((name, *_joint_size(size))) for name, size in joints.items())
            yield Text(f"Follows {printable(one.column)}, {words(one.effect)}: {text}")


def _joint_size(size: SizeInJoint) -> tuple[str, ...]:
    value, between, unit = _size(size)
    low, _, high = between.partition("..")
    return f"{value} {unit}", f"[{low}, {high}]"


def _size(size: SizeInJoint) -> tuple[str, str, str]:
    """Return a size and its interval as far as the interval tells, and the unit."""
    first, _, per = size.unit.partition("/")
    factor, unit = (
        (1.0, "mm") if first == "mm" else (_MILLION, "µrad" if first == "rad" else "µm/m")
    )
    value, low, high = (factor * v for v in (size.value, *size.interval))
    spec = f"+.{digits_of(value, (low, high))}f"
    return f"{value:{spec}}", f"{low:{spec}}..{high:{spec}}", unit + (f"/{per}" if per else "")


def _scaled(ends: tuple[float, float], scale: float) -> tuple[float, float]:
    return ends[0] * scale, ends[1] * scale


def _in_short(name: str, one: SourceOfScatter) -> str:
    scale, unit = (_MILLION, "µrad") if one.unit == "rad" else (1.0, one.unit)
    return figure_in_words(name, one.value * scale, _scaled(one.interval, scale), unit)


def _sources(sources: Mapping[str, SourceOfScatter]) -> Table:
    rows = tuple(_source(_WORDING.get(name, name), one) for name, one in sources.items())
    return Table(("scatter of", "", "95 % interval", "", "variance"), rows, _MEANING)


def _source(name: str, one: SourceOfScatter) -> tuple[Cell, ...]:
    joint = one.unit == "rad"
    scale, unit = (_MILLION, "µrad") if joint else (1.0, one.unit)
    value, between = figure_cells(one.value * scale, _scaled(one.interval, scale))
    share = "" if one.share is None else Number(one.share, ".0%")
    return (name, value, between, unit, share)


def _together(found: JointCorrelation) -> Text:
    low, high = found.interval
    return Text(
        f"The joints scatter together: correlation {found.value:+.2f} [{low:+.2f}, "
        f"{high:+.2f}], p = {found.p_value:.2g}; one cause moves both, such as the supply, "
        "the controller or the base",
        "warn",
    )


def _predicted(pose: str, one: Foretold) -> tuple[Cell, ...]:
    return (pose, *figure_cells(one.value, one.interval))


def _pose_left_out(pose: str, one: PoseLeftOut) -> Text:
    predicted = one.predicted
    ends = predicted.interval
    text = figure_in_words(f"{pose} held out: RP", predicted.value, ends, "mm predicted")
    measured, left = (figure_cells(value, ends)[0] for value in (one.measured, one.effects_removed))
    error = "" if one.error is None else f" ({one.error:+.0%})"
    where = "inside" if one.inside else "OUTSIDE"
    moved = one.measured != one.effects_removed
    without = f", {left} without the effects found" if moved else ""
    brought = _brought(one) if moved else ""
    return Text(
        f"{text}, {measured} measured{without}{error}: {where} the interval{brought}",
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
            figure_cells(one.effects_removed, one.predicted.interval)[0],
            *figure_cells(one.predicted.value, one.predicted.interval),
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
            f"Each pose left out by turns: the others predict its RP within {rms:.0%} rms; "
            f"chance alone makes {found.left_out_chance:.0%}{missed}",
            "warn" if outside else "plain",
        )


def _extremes(reach: ReachMap) -> Text:
    best, worst = reach.best, reach.worst
    text = (
        f"RP over the reach: {best.RP:.3g} mm at best, such as {round(best.x_mm)} mm along x and "
        f"{round(best.y_mm)} along y; {worst.RP:.3g} mm at worst, such as {round(worst.x_mm)} and "
        f"{round(worst.y_mm)}"
    )
    if reach.limit is None:
        return Text(text)
    kept = reach.share_kept
    return Text(
        f"{text}; {reach.limit:g} mm is kept in {kept:.0%} of it: 39 of 40 tests there would "
        "measure less",
        "good" if kept == 1 else "warn",
    )


_SURE = 0.9
_MOST_NOTES = 5
_MICRO = {"rad": "µrad", "1": "µm/m"}
"""Units of which a millionth is said."""


def poses_report(found: DiagnosisOfPoses, again: Again | None = None) -> Report:
    """Return the document of several poses: what acts where, then each pose."""
    following = None if again is None else _next(found, again)
    effects = {effect.effect.replace("_lagged", "") for effect in found.effects}
    joints = (*scatter_brief(found.joint_scatter), *followed_brief(found.followed, effects))
    head = answer_lines([*_answer(found), *_places(found), *_why(found)], following)
    notes = notes_in_short(found.notes, "shares, rivals", _MOST_NOTES)
    return (
        Section("", head),
        Section("", (_table(found),)),
        Section("", (*joints, *_doubts(found))),
        Section("", tuple(notes), depth="more"),
        *at_depth("detail", _details(found)),
    )


def _details(found: DiagnosisOfPoses) -> Iterator[Section]:
    yield from scatter_sections(found.joint_scatter)
    yield from followed_sections(found.followed)
    for pose, one in found.poses.items():
        yield from of_pose(f"pose {pose}", one)
    if found.notes:
        yield Section("notes", tuple(map(Text, found.notes)))


def _answer(found: DiagnosisOfPoses) -> Iterator[Headline]:
    if found.verdict is Verdict.NOTHING:
        text = "Nothing besides scatter and the dial's division at any pose"
        yield Headline((text,), "good")
    if found.effects:
        effects = "; ".join(
            f"{sureness(one, on_axes=False)} {_where(one)}" for one in found.effects
        )
        yield Headline((f"{_introduced(found)}: {effects}; {p_equals(found)}",))
    if found.verdict is Verdict.UNEXPLAINED:
        yield Headline((unexplained_in_words(found),), "warn")


def _introduced(found: DiagnosisOfPoses) -> str:
    """Return how an effect is introduced: one that foretells no unseen cycle is suspected."""
    before, after = (
        sum(rms**2 for rms in error.held_out_rms.values())
        for error in (found.error.before, found.error.after)
    )
    return "Found" if after < before else "Suspected"


def _where(found: FoundAtPoses) -> str:
    """Return where an effect acts, as far as the poses tell, and how sure that is."""
    if found.joint_candidates:
        names = " or ".join(f"joint {number}" for number in found.joint_candidates)
        return f"in {names}: these poses do not tell"
    if found.place is None or found.place not in found.places or found.place == "every axis":
        return f"at {', '.join(found.poses)}"
    p = found.places[found.place]
    sure = "" if p >= _SURE else f" ({p:.0%})"
    if found.place in found.poses:
        return f"at {found.place} alone{sure}: a fixture or an indicator there"
    if found.joint == found.place == "along the arm":
        return f"along the arm{sure}: the links grow"
    if found.place.endswith(" everywhere"):
        return f"in {found.place.removesuffix(' everywhere')} alike at every pose{sure}"
    or_dial = " or the theta indicator" if found.joint == "joint 4" else ""
    return f"in {found.place}{or_dial}{sure}"


def _places(found: DiagnosisOfPoses) -> Iterator[Headline]:
    """Yield the size of each effect where it acts, its course, and the most that a dial moves."""
    for one in found.effects:
        others = [n for n, value in one.parameters.items() if not isinstance(value, Mapping)]
        course = [parameters_in_words(one, others)] if others else []
        parts = [*_at_joint(one), *course, *_farthest(one)]
        of = f"{words(one.effect)}: " if len(found.effects) > 1 else ""
        if parts:
            yield Headline((f"{of}{parts[0]}", *parts[1:]), "plain")


def _at_joint(found: FoundAtPoses) -> Iterator[str]:
    at = found.at_joint
    if at is None:
        return
    factor = 1e6 if at.unit in _MICRO else 1.0
    value, ends = at.value * factor, _scaled(at.interval, factor)
    spec = f"+.{digits_of(value, ends)}f"
    unit = _MICRO.get(at.unit, at.unit)
    yield f"size {value:{spec}} {unit} [{ends[0]:{spec}}, {ends[1]:{spec}}]"


def _farthest(found: FoundAtPoses) -> Iterator[str]:
    """Yield where an effect moves the readings most."""
    sizes: Any = next((v for v in found.parameters.values() if isinstance(v, Mapping)), {})
    by_axis = {(pose, axis): size for pose, own in sizes.items() for axis, size in own.items()}
    if by_axis:
        (pose, axis), most = max(by_axis.items(), key=lambda item: abs(item[1]))
        yield f"at most {most:+.2g}{'' if axis == 'theta' else ' mm'} in {axis} at {pose}"


def _why(found: DiagnosisOfPoses) -> Iterator[Block]:
    for one in found.effects:
        because = _because(one)
        if because:
            yield Text(f"Likely: {because}")
        usual = f"Usual causes of a {words(one.effect)}" if because else "Likely"
        yield Text(f"{usual}: {one.cause}")
        yield Text(f"To be sure: {one.confirm_by}")
    near = [rival for rival in found.candidates if rival.effect != UNKNOWN]
    if found.verdict is Verdict.UNEXPLAINED and near:
        yield Text(f"Nearest known effects: {rivals_in_words(near)}")
    if found.verdict is Verdict.NOTHING:
        yield Text(
            f"An effect that is too small for these cycles would not show ({p_equals(found)})."
        )


def _because(found: FoundAtPoses) -> str:
    """Return what the place says of the cause; nothing where it says no more than a single pose."""
    place = found.place or ""
    if found.joint == "along the arm":
        return "the links grow, as when warm: every pose moves away from the base axis"
    if found.joint == "joint 4":
        return "joint 4, or the theta indicator: theta turns alike at every pose"
    if found.joint is not None:
        return f"gear, belt, encoder or bearing of {place}, as all poses move with it"
    if place.endswith(" everywhere"):
        axis = place.removesuffix(" everywhere")
        return f"the {axis} indicator, its stand or its datum: {axis} moves alike at every pose"
    return ""


def _next(found: DiagnosisOfPoses, again: Again) -> NextStep:
    if found.verdict is Verdict.NOTHING:
        return NextStep(f"scara-iso report {again()}", "the report to sign")
    pose = next(iter(found.effects[0].poses if found.effects else found.poses))
    alone = NextStep(f"scara-iso diagnose {again(pose=pose)}", "one pose alone")
    return (page_of(found.effects[0]) if found.effects else None) or alone


def _table(found: DiagnosisOfPoses) -> Table:
    """Return, for each pose, what acts there, RP with it and without, and the held-out error."""
    rows: list[tuple[Cell, ...]] = []
    moved = {axis for one in found.effects for axis in one.axes}
    for pose, one in found.poses.items():
        RP, n = one.repeatability, len(one.series.cycle)
        name, axes = _shown(RP.measured, moved)
        before, after = (
            math.sqrt(sum(error.held_out_rms.get(axis, 0.0) ** 2 for axis in axes))
            for error in (one.error.before, one.error.after)
        )
        acting = ", ".join(words(effect.effect) for effect in one.effects) or "-"
        figures = (RP.measured[name], RP.with_effect_removed[name], before, after)
        rows.append((pose, acting, name, *(rounded(v, U_of_scatter(v, n)) for v in figures)))
    return Table(
        ("pose", "acts", "RP of", "measured", "effect removed", "error before", "after"),
        tuple(rows),
        "error: root mean square of the same axes on cycles that the fit did not see",
    )


def _shown(measured: Mapping[str, float], moved: Set[str]) -> tuple[str, tuple[str, ...]]:
    """Return the RP that shows what was moved, and its axes."""
    planes = {"XY": ("X", "Y"), "XYZ": ("X", "Y", "Z")}
    for name, axes in planes.items():
        if name in measured and moved <= set(axes):
            return name, axes
    name = next((axis for axis in measured if axis in moved), next(iter(measured)))
    return name, (name,)


def _doubts(found: DiagnosisOfPoses) -> Iterator[Text]:
    if any(one.joint_candidates for one in found.effects) and found.separation is not None:
        yield Text(
            f"! joint 1 and joint 2 move these poses alike (angle {found.separation.angle_deg:.0f} "
            f"degrees, observability index {found.separation.observability_index:.2g}): add poses "
            "at other angles of joint 2",
            "warn",
        )
    for one in found.effects:
        yield from (Text(f"! {line}", "warn") for line in one.unidentified)
    for pose, at in found.poses.items():
        yield from (
            Text(f"! {pose} {text.text.removeprefix('! ')}", text.tone)
            for text in doubts(at, effects=False)
        )
