"""What one search over all poses found: which effect, where in the robot, what each pose gains."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Set
from typing import Any

from scara_iso.diagnosis import UNKNOWN, DiagnosisOfPoses, Found, Verdict
from scara_iso.reporting.blocks import (
    Block,
    Cell,
    Headline,
    NextStep,
    Report,
    Section,
    Table,
    Text,
)
from scara_iso.reporting.brief import digits_of, first_three
from scara_iso.reporting.brief_diagnosis import Again, doubts, is_explained
from scara_iso.reporting.diagnosis import (
    of_pose,
    parameters_said,
    rivals_said,
    sureness,
    unexplained_said,
)
from scara_iso.reporting.digits import U_of_scatter, p_equals, rounded
from scara_iso.reporting.joint_scatter import (
    followed_brief,
    followed_sections,
    scatter_brief,
    scatter_sections,
)
from scara_iso.reporting.words import words

_SURE = 0.9
_MOST_NOTES = 5
_MICRO = {"rad": "µrad", "1": "µm/m"}
"""Units of which a millionth is said."""


def poses_brief(found: DiagnosisOfPoses, again: Again) -> Report:
    """Return what was found and where, a line for each pose, and what to do next."""
    head = [*_answer(found), *_places(found), *_why(found)]
    notes = [Text(f"- {note}", "quiet") for note in found.notes[:_MOST_NOTES]]
    more = len(found.notes) - _MOST_NOTES
    rest = f"{more} more notes, " if more > 0 else ""
    notes.append(Text(f"lengths in mm, angles in degrees; {rest}shares, rivals: `full=`", "quiet"))
    return (
        Section(
            "",
            first_three(head, _next(found, again))
            if len(head) > 1
            else (*head, _next(found, again)),
        ),
        Section("", (_table(found),)),
        Section(
            "", (*scatter_brief(found.joint_scatter), *_followed(found), *_doubts(found), *notes)
        ),
    )


def _followed(found: DiagnosisOfPoses) -> Iterator[Text]:
    named = {effect.effect.replace("_lagged", "") for effect in found.effects}
    return followed_brief(found.followed, named)


def poses_report(found: DiagnosisOfPoses, title: str) -> Report:
    """Return the report on several poses: what acts where, then each pose."""
    head: tuple[Block, ...] = (
        Text(f"diagnosis of {title}", "strong"),
        *(Text(note, "quiet") for note in found.notes),
        *_answer(found),
        *_places(found),
        *_why(found),
        *_doubts(found),
        _table(found),
    )
    behind = (part for pose, one in found.poses.items() for part in of_pose(f"pose {pose}", one))
    joints = (*scatter_sections(found.joint_scatter), *followed_sections(found.followed))
    return (Section("", head), *joints, *behind)


def _answer(found: DiagnosisOfPoses) -> Iterator[Headline]:
    if found.verdict is Verdict.NOTHING:
        said = "Nothing besides scatter and the dial's division at any pose"
        yield Headline((said,), "good")
    if found.effects:
        effects = "; ".join(
            f"{sureness(one, on_axes=False)} {_where(one)}" for one in found.effects
        )
        yield Headline((f"Found: {effects}",))
    if found.verdict is Verdict.UNEXPLAINED:
        yield Headline((unexplained_said(found),), "warn")


def _where(found: Found) -> str:
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
    beside = " or the theta indicator" if found.joint == "joint 4" else ""
    return f"in {found.place}{beside}{sure}"


def _places(found: DiagnosisOfPoses) -> Iterator[Headline]:
    """Yield the size of each effect where it acts, its course, and the most that a dial moves."""
    for one in found.effects:
        others = [n for n, value in one.parameters.items() if not isinstance(value, Mapping)]
        course = [parameters_said(one, others)] if others else []
        parts = [*_at_joint(one), *course, *_farthest(one)]
        of = f"{words(one.effect)}: " if len(found.effects) > 1 else ""
        if parts:
            yield Headline((f"{of}{parts[0]}", *parts[1:]), "plain")


def _at_joint(found: Found) -> Iterator[str]:
    at = found.at_joint
    if at is None:
        return
    factor = 1e6 if at.unit in _MICRO else 1.0
    value, half = at.value * factor, 2 * at.standard_error * factor
    ends = value - half, value + half
    spec = f"+.{digits_of(value, ends)}f"
    unit = _MICRO.get(at.unit, at.unit)
    yield f"size {value:{spec}} {unit} [{ends[0]:{spec}}, {ends[1]:{spec}}]"


def _farthest(found: Found) -> Iterator[str]:
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
        yield Text(f"Nearest known effects: {rivals_said(near)}")
    if found.verdict is Verdict.NOTHING:
        yield Text(
            f"An effect that is too small for these cycles would not show ({p_equals(found)})."
        )


def _because(found: Found) -> str:
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
    if not found.effects or not is_explained(found.effects[0]):
        pose = next(iter(found.effects[0].poses if found.effects else found.poses))
        return NextStep(f"scara-iso diagnose {again(pose=pose)}", "one pose alone")
    return NextStep(
        f"scara-iso explain {found.effects[0].effect}", "what it means, and how to be sure"
    )


def _table(found: DiagnosisOfPoses) -> Table:
    """Return, for each pose, what acts there, RP with it and without, and the held-out error."""
    rows: list[tuple[Cell, ...]] = []
    moved = {axis for one in found.effects for axis in one.axes}
    for pose, one in found.poses.items():
        RP, n = one.repeatability, len(one.series.cycle)
        name, axes = _shown(RP.measured, moved)
        before, after = (
            math.sqrt(sum(error.held_out_rms.get(axis, 0.0) ** 2 for axis in axes))
            for error in (one.error_before, one.error_after)
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
            Text(f"! {pose} {said.text.removeprefix('! ')}", said.tone)
            for said in doubts(at, effects=False)
        )
