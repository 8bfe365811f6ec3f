"""The document of a diagnosis, of one pose or of several: what it is, where, how sure, what next.

Behind the answer stands every figure.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from scara_iso.diagnosis import (
    ODD,
    SECOND,
    ByAxis,
    Diagnosis,
    DiagnosisOfPoses,
    Foretold,
    Found,
    FoundAtPoses,
    Repeatabilities,
    UnseenRP,
    Verdict,
)
from scara_iso.reporting.backlash import reversals_section
from scara_iso.reporting.joints import (
    followed_brief,
    followed_section,
    scatter_brief,
    scatter_section,
    size_in_words,
)
from scara_iso.reporting.named_effects import (
    NOTHING,
    NOTHING_MORE,
    Failure,
    cause_by_place,
    confirm_by_place,
    how_likely,
    is_of_a_kind,
    is_suspected,
    length,
    nearest,
    odd_in_words,
    page_of,
    parameters_in_words,
    places_in_words,
    probability_in_words,
    rivals_in_words,
    sizes_in_words,
    sureness,
    unexplained,
)
from scara_iso.reporting.shared.blocks import (
    Block,
    Columns,
    NextStep,
    Notice,
    Report,
    Section,
    Strip,
    Table,
    Text,
    note,
)
from scara_iso.reporting.shared.digits import (
    Cell,
    Number,
    U_of_scatter,
    of_scatter,
    p_equals,
    p_value,
    result,
    rounded,
    share,
    words,
)
from scara_iso.run import FloatArray

_UNSEEN = "cycles that the fit did not see, the choice of effect repeated"
_UNITS = "lengths in mm, angles in degrees"
_MOST_NOTES, _MOST_NOTES_OF_POSES = 3, 5
_GAP = "   "
_RARE = 0.01
_COMPLETED = "completed model [95 % interval]"
_PLANES = {"XY": ("X", "Y"), "XYZ": ("X", "Y", "Z")}
Again = Callable[..., str]
"""Names the table in a command line, with the options that read it and further ones."""


def diagnosis_report(diagnosis: Diagnosis, again: Again | None = None) -> Report:
    """Return the document of one pose's diagnosis; ``again`` names its table in a command line."""
    course = again and f"scara-iso diagnose {again(plot='course.svg')}"
    following = _next(diagnosis, again, NextStep(course or "", "look at the course"))
    lines = [*_answer(diagnosis), *_RP_in_words(diagnosis), *_why(diagnosis)]
    notes = _notes_in_short(diagnosis.notes, "errors, shares, rivals", _MOST_NOTES)
    return (
        Section.of_answer([*lines, *_doubts(diagnosis)], following),
        Section("", tuple(_courses(diagnosis))),
        Section("", (Text(_error_in_words(diagnosis)), *notes), depth="more"),
        *Section.in_detail(_details(diagnosis)),
    )


def poses_report(found: DiagnosisOfPoses, again: Again | None = None) -> Report:
    """Return the document of several poses: what acts where, then each pose."""
    first = next(iter(found.effects[0].poses if found.effects else found.poses))
    alone = again and f"scara-iso diagnose {again(pose=first)}"
    following = _next(found, again, NextStep(alone or "", "one pose alone"))
    effects = {effect.effect.replace("_lagged", "") for effect in found.effects}
    scatter = found.joint_scatter
    joints = [*([] if scatter is None else scatter_brief(scatter))]
    joints += followed_brief(found.followed, effects)
    lines: list[Block] = [*_answer_of_poses(found), *_places(found), *_why(found)]
    notes = _notes_in_short(found.notes, "shares, rivals", _MOST_NOTES_OF_POSES)
    details = [
        *([] if scatter is None else [scatter_section(scatter)]),
        followed_section(found.followed),
        *(section for pose, one in found.poses.items() for section in _of_pose(pose, one)),
        Section("notes", tuple(map(Text, found.notes))),
    ]
    return (
        Section.of_answer(lines, following),
        Section("", (_table_of_poses(found),)),
        Section("", (*joints, *_doubts_of_poses(found))),
        Section("", tuple(notes), depth="more"),
        *Section.in_detail(details),
    )


def _next(
    found: Diagnosis | DiagnosisOfPoses, again: Again | None, look: NextStep
) -> NextStep | None:
    if again is None:
        return None
    if odd_in_words(found):
        return NextStep(f"scara-iso explain {ODD}", "what it means, and how to be sure")
    if found.verdict is Verdict.NOTHING:
        return NextStep(f"scara-iso report {again(condition=None)}", "the report to sign")
    return (page_of(found.effects[0]) if found.effects else None) or look


def _notes_in_short(notes: Sequence[str], what: str, most: int) -> Iterator[Text]:
    yield from (Text(f"- {note}", "quiet") for note in notes[:most])
    count = len(notes) - most
    more = f"{count} more note{'s' * (count > 1)}, " if count > 0 else ""
    yield Text(f"{_UNITS}; {more}{what}: `full=`", "quiet")


def _details(diagnosis: Diagnosis) -> Iterator[Section]:
    text = f"p-value of any structure at all: {p_equals(diagnosis)}"
    left_over = diagnosis.verdict is Verdict.UNEXPLAINED
    near = f"nearest: {rivals_in_words(diagnosis.candidates)}"
    structure = (Text(text), Text(near if left_over and diagnosis.candidates else ""))
    yield Section("structure", (*structure, *_seen(diagnosis), Text(_UNITS, "quiet")))
    for found in diagnosis.effects:
        yield Section(words(found.effect), tuple(_effect(found)))
    if diagnosis.reversals is not None:
        yield reversals_section(diagnosis.reversals)
    yield Section("error and repeatability", tuple(_figures(diagnosis)))
    columns: Columns[tuple[str, Any]] = {
        "variance": lambda row: row[0],
        "effects": lambda row: share(row[1].effects),
        "resolution": lambda row: share(row[1].resolution),
        "unexplained" if left_over else "scatter": lambda row: share(row[1].unexplained),
    }
    yield Section("what RP is made of", (Table.of(diagnosis.shares.items(), columns),))
    yield Section("notes", tuple(_notices(diagnosis)))


def _of_pose(pose: str, one: Diagnosis) -> Iterator[Section]:
    """Yield what was found at one of several poses, nothing where that is nothing."""
    name = f"pose {pose}"
    for found in one.effects:
        yield Section(f"{name}: {words(found.effect)}", tuple(_effect(found)))
    if one.effects:
        yield Section(f"{name}: error and repeatability", tuple(_figures(one)))
    yield Section(f"{name}: unexplained", tuple(_seen(one)))
    yield Section(f"{name}: notes", tuple(_notices(one)))


def _answer(diagnosis: Diagnosis) -> Iterator[Block]:
    if diagnosis.verdict is Verdict.NOTHING:
        odd = odd_in_words(diagnosis)
        shown, model = diagnosis.series.measured, diagnosis.series.predicted_before
        declared = any(np.ptp(model[name]) > 0.01 * np.ptp(shown[name]) for name in model)
        nothing = NOTHING_MORE if declared else NOTHING
        yield _nothing(odd, nothing)
    if diagnosis.effects:
        named = "; ".join(map(sureness, diagnosis.effects))
        yield Text(f"{_introduced(diagnosis)}: {named}", "strong")
    yield from unexplained(diagnosis)
    for found in diagnosis.effects:
        sizes = sizes_in_words(found) or ["size not estimated"]
        yield Text(f"{_of_effect(found, diagnosis)}{_GAP.join(sizes)}")


def _of_effect(one: Found, found: Diagnosis | DiagnosisOfPoses) -> str:
    return f"{words(one.effect)}: " if len(found.effects) > 1 else ""


def _RP_in_words(diagnosis: Diagnosis) -> Iterator[Text]:  # noqa: N802 - the field's symbol
    RP, n = diagnosis.repeatability, len(diagnosis.series.cycle)
    named = [name for name in RP.measured if name != "XYZ"]
    name = "XY" if "XY" in named else named[0]
    removed = RP.with_effect_removed.get(name) if diagnosis.effects else None
    of, unit = _labelled(diagnosis, name), _unit(diagnosis, name)
    measured = of_scatter(RP.measured[name], n, unit)
    yield Text(f"RP  {of} {measured}{_without(RP.measured[name], removed, n)}")
    if (expected := RP.completed.get(name)) is not None:
        cell = result(expected.value, expected.interval, unit)
        between = f"95 % prediction interval {cell.interval.in_brackets if cell.interval else ''}"
        yield Text(f"Expected in a repeat test: {of} {cell.value}, {between}")


def _unit(found: Diagnosis, name: str) -> str:
    return found.series.units.get(name, length(name))


def _labelled(found: Diagnosis, name: str, unit: str = "") -> str:
    """Return of what an RP is; of an angle, whose RP by 7.2.2 is +/- 3 S, by which equations."""
    return f"{name} ({unit}eq. 2-6)" if _unit(found, name) == "deg" else name


def _without(measured: float, removed: float | None, n: int) -> str:
    if removed is None:
        return ""
    no_less = "no less " if removed >= measured else ""
    return f"; {no_less}without the effect: {of_scatter(removed, n)}"


def _why(found: Diagnosis | DiagnosisOfPoses) -> Iterator[Text]:
    every = (line for one in found.effects for line in _causes(one, how_likely(found, one)))
    yield from map(Text, dict.fromkeys(every))
    yield from _seen(found) if isinstance(found, Diagnosis) else ()
    yield nearest(found)
    if found.verdict is Verdict.NOTHING:
        yield Text(f"An effect too small for these cycles would not show ({p_equals(found)}).")


def _causes(one: Found, likely: str) -> Iterator[str]:
    if isinstance(one, FoundAtPoses) or is_of_a_kind(one):
        because = cause_by_place(one) if isinstance(one, FoundAtPoses) else ""
        name = words(one.effect)
        article = "an" if name.startswith(("a", "e", "i", "o", "u")) else "a"
        usual = f"Usual causes of {article} {name}" if because else likely
        yield because and f"{likely}: {because}"
        yield f"{usual}: {one.cause}"
        confirm = confirm_by_place(one) if isinstance(one, FoundAtPoses) else one.confirm_by
        yield f"To be sure: {confirm}"
    else:
        yield "To be sure: repeat the run; chance does not come back, a cause does"


def _doubts(diagnosis: Diagnosis) -> Iterator[Text]:
    if diagnosis.effects and diagnosis.p_value > _RARE:
        often = f"{100 * diagnosis.p_value:.0f} of 100 tests"
        yield Text(f"! scatter alone would show as much in {often}", "warn")
    yield from _unsure(diagnosis.effects)
    yield from _flagged(diagnosis, "")


def _unsure(effects: Sequence[Found]) -> Iterator[Text]:
    yield from (Text(f"! {line}", "warn") for found in effects for line in found.unidentified)


def _flagged(diagnosis: Diagnosis, at: str) -> Iterator[Text]:
    for flag in diagnosis.flags:
        apart = f"the reading of cycle {flag.cycle} stands apart; look at the record"
        yield Text(f"! {at}{flag.axis}: {apart}", "warn")


def _courses(diagnosis: Diagnosis) -> Iterator[Block]:
    """Yield the axes that an effect moves, before and after; the others in one line."""
    series, moved = diagnosis.series, _changed_axes(diagnosis)
    is_all = bool(moved) and diagnosis.verdict is Verdict.EXPLAINED
    still = [axis for axis in series.measured if is_all and axis not in moved]
    for axis, measured in series.measured.items():
        if axis not in still:
            yield Strip(f"{axis} measured", measured, _spread(axis, measured))
        if axis in moved:
            left = (measured - series.predicted_after[axis]).round(12)
            yield Strip(f"{axis} left", left, _spread(axis, left))
    yield Text(f"{', '.join(still)}: {NOTHING}" if still else "")


def _changed_axes(diagnosis: Diagnosis) -> set[str]:
    learned = set() if diagnosis.learned is None else set(diagnosis.learned.axes)
    return learned.union(*(found.axes for found in diagnosis.effects))


def _spread(axis: str, readings: FloatArray) -> str:
    return f"range {np.ptp(readings):.2g} {length(axis)}".rstrip()


def _error_in_words(diagnosis: Diagnosis) -> str:
    before, after = diagnosis.error.before.held_out_rms, diagnosis.error.after.held_out_rms
    n, named = len(diagnosis.series.cycle), _changed_axes(diagnosis)
    parts = [
        f"{axis} {_rms(after[axis], n)}, before {_rms(before[axis], n)}"
        f"{', no better' * (after[axis] >= before[axis])}"
        for axis in before
        if axis in named
    ]
    return f"Error on cycles that the model has not seen: {'; '.join(parts)}" if parts else ""


def _rms(figure: float, n: int) -> Number:
    return rounded(figure, 2 * U_of_scatter(figure, n))


def summary_report(tables: Sequence[str], found: Sequence[Diagnosis | Failure]) -> Report:
    """Return one row for each of several tables, and how many there are of each verdict."""
    rows: list[dict[str, Cell]] = []
    failures: list[Block] = []
    apart: list[Block] = []
    for name, one in zip(tables, found, strict=True):
        if isinstance(one, Failure):
            rows.append({"": name, "verdict": "not diagnosed"})
            failures.append(Notice("error", "not-diagnosed", name, one.message))
        else:
            effects = "; ".join(map(sureness, one.effects))
            rows.append(
                {"": name, "verdict": one.verdict.value, "effects": effects, "p": p_value(one)}
            )
            apart += _flagged(one, f"{name}, ")
    verdicts = [row["verdict"] for row in rows]
    counts = ", ".join(f"{verdicts.count(v)} {v}" for v in dict.fromkeys(verdicts))
    answer = Text(f"{len(tables)} diagnosed: {counts}", "strong")
    return (Section("", (answer, Table.by_name(rows), *apart, *failures)),)


def _effect(found: Found) -> Iterator[Block]:
    yield Text(f"{p_equals(found)}, {probability_in_words(found.probability, found.rivals)}")
    yield Text(parameters_in_words(found))
    if found.joint is not None and found.joint in found.angles:
        angle = found.angles[found.joint]
        yield Text(f"moves along {found.joint.removeprefix('along ')}, within {angle:.0f} degrees")
    elif found.angles:
        angles = ", ".join(f"{name} {angle:.0f}" for name, angle in found.angles.items())
        yield Text(f"names no joint: degrees from {angles}", "quiet")
    if not is_of_a_kind(found):
        yield Text(f"cause: {found.cause}")
        yield Text(f"confirm: {found.confirm_by}")
    for line in found.unidentified:
        yield Text(f"not identifiable: {line}", "warn")


def _figures(diagnosis: Diagnosis) -> Iterator[Block]:
    before, after = diagnosis.error.before, diagnosis.error.after
    RP, n = diagnosis.repeatability, len(diagnosis.series.cycle)
    second = RP.unseen is not None and RP.unseen.of == SECOND
    errors = {
        "before": before.rms,
        "after": after.rms,
        "held out, before": before.held_out_rms,
        "held out, after": after.held_out_rms,
    }
    held_out = f"held out: on {'the second table' if second else _UNSEEN}"
    yield _by_axis("rms error", errors, n, held_out)
    figures = {
        "measured": RP.measured,
        **_before_model(RP),
        "model after": RP.model_after,
        "effect removed": RP.with_effect_removed,
    }
    labels = {name: _labelled(diagnosis, name, "deg, ") for name in RP.measured}
    by_axis = partial(_by_axis, labels=labels)
    yield by_axis("RP", figures, n, note("removed"))
    grown = [n for n, value in RP.with_effect_removed.items() if value > RP.measured[n] * 1.001]
    if diagnosis.effects and grown:
        yield Text(f"{', '.join(grown)}: {note('grown')}", "quiet")
    measured = {"measured": RP.measured}
    yield by_axis("RP expected in a repeat test", measured, n, note("completed"), RP.completed)
    if (unseen := RP.unseen) is not None:
        measured = {"measured": unseen.measured, **_before_model(unseen)}
        of = f"of {unseen.of}: {unseen.cycles} cycles that the completed model has not seen"
        yield by_axis("RP of unseen cycles", measured, unseen.cycles, of, unseen.completed)


def _by_axis(
    heading: str,
    columns: Mapping[str, ByAxis],
    n: int,
    below: str,
    completed: Mapping[str, Foretold] | None = None,
    labels: Mapping[str, str] | None = None,
) -> Table:
    names = list(next(iter(columns.values())) if completed is None else completed)
    shown: dict[str, list[Cell]] = {heading: [(labels or {}).get(name, name) for name in names]}
    for column, of in columns.items():
        shown[column] = [of_scatter(of[name], n) if name in of else "" for name in names]
    if completed is not None:
        shown[_COMPLETED] = [result(one.value, one.interval) for one in completed.values()]
    return Table.in_columns(shown, below)


def _before_model(RP: Repeatabilities | UnseenRP) -> Mapping[str, ByAxis]:
    """Return the column of the model before; without a model, which predicts no scatter, none."""
    return {"model before": RP.model_before} if any(RP.model_before.values()) else {}


def _notices(diagnosis: Diagnosis) -> Iterator[Block]:
    for flag in diagnosis.flags:
        apart = f"the reading of cycle {flag.cycle} stands apart ({p_equals(flag)} in Gaussian "
        text = f"{apart}scatter): look at the raw record"
        yield Notice("warning", "check-the-sheet", flag.axis, text)
    yield from map(Text, diagnosis.notes)


def _seen(diagnosis: Diagnosis) -> Iterator[Text]:
    yield from (Text(f"{one.axis} {one.words}") for one in diagnosis.courses if one.words)


def _answer_of_poses(found: DiagnosisOfPoses) -> Iterator[Text]:
    if found.verdict is Verdict.NOTHING:
        odd = odd_in_words(found)
        yield _nothing(odd, f"{NOTHING} at any pose")
    if found.effects:
        effects = "; ".join(
            f"{sureness(one, on_axes=False, in_full=True)} {at}"
            for one, at in zip(found.effects, places_in_words(found.effects), strict=True)
        )
        yield Text(f"{_introduced(found)}: {effects}; {p_equals(found)}", "strong")
    yield from unexplained(found)


def _nothing(odd: str, nothing: str) -> Text:
    """Return the verdict where nothing was found: readings to look at come first."""
    if odd:
        return Text(f"{odd[0].upper()}{odd[1:]}; else {nothing}", "warn")
    return Text(nothing.capitalize(), "good")


def _introduced(found: Diagnosis | DiagnosisOfPoses) -> str:
    return "Suspected" if is_suspected(found) else "Found"


def _places(found: DiagnosisOfPoses) -> Iterator[Text]:
    for one in found.effects:
        others = [n for n, value in one.parameters.items() if not isinstance(value, Mapping)]
        sized = [name for name in one.parameters if name not in others]
        sizes: Any = one.parameters[sized[0]] if sized else {}
        per = one.units.get(sized[0], "").partition("/")[2] if sized else ""
        rate = f" per {per}" if per not in ("", "unit") else ""
        parts = [] if one.at_joint is None else [size_in_words("size", one.at_joint) + rate]
        parts += [parameters_in_words(one, others)] if others else []
        by_axis = {(pose, axis): size for pose, own in sizes.items() for axis, size in own.items()}
        if by_axis:
            (pose, axis), most = max(by_axis.items(), key=lambda item: abs(item[1]))
            largest = f"at most {most:+.2g} {length(axis)}".rstrip()
            parts.append(f"{largest}{rate} in {axis} at {pose}")
        if parts:
            yield Text(f"{_of_effect(one, found)}{parts[0]}", parts=tuple(parts[1:]))


def _table_of_poses(found: DiagnosisOfPoses) -> Table:
    moved = {axis for one in found.effects for axis in one.axes}
    rows: list[dict[str, Cell]] = []
    for pose, one in found.poses.items():
        RP, n = one.repeatability, len(one.series.cycle)
        shown = (name for name in _PLANES if name in RP.measured and moved <= {*_PLANES[name]})
        single = next((axis for axis in RP.measured if axis in moved), next(iter(RP.measured)))
        name = next(shown, single)
        before, after = (
            math.hypot(*(error.held_out_rms.get(axis, 0.0) for axis in _PLANES.get(name, (name,))))
            for error in (one.error.before, one.error.after)
        )
        rows.append(
            {
                "pose": pose,
                "acts": ", ".join(words(effect.effect) for effect in one.effects) or "-",
                "RP of": _labelled(one, name, "deg, "),
                "measured": of_scatter(RP.measured[name], n),
                "effect removed": of_scatter(RP.with_effect_removed[name], n),
                "error before": of_scatter(before, n),
                "after": of_scatter(after, n),
            }
        )
    unseen = "error: root mean square of the same axes on cycles that the fit did not see"
    return Table.by_name(rows, unseen)


def _doubts_of_poses(found: DiagnosisOfPoses) -> Iterator[Text]:
    if any(one.joint_candidates for one in found.effects) and found.separation is not None:
        yield Text(
            f"! joint 1 and joint 2 move these poses alike (angle {found.separation.angle_deg:.0f} "
            f"degrees, observability index {found.separation.observability_index:.2g}): add poses "
            "at other angles of joint 2",
            "warn",
        )
    yield from _unsure(found.effects)
    for pose, at in found.poses.items():
        yield from _flagged(at, f"{pose} ")
