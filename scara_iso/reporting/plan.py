"""The documents of a planned test: what it will find, its poses and visits, and how far it is."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from datetime import date
from shlex import quote

from scara_iso.diagnosis import (
    GIVEN,
    PROPOSED,
    STANDARD,
    Alike,
    ChangeOfPoses,
    Design,
    DesignOfPoses,
    PlannedPosesTest,
    PosesApart,
    SeparatingPlan,
    Travels,
)
from scara_iso.iso9283 import PlannedPose, PosePlan, PoseTestConditions
from scara_iso.reporting.shared.blocks import (
    Block,
    Columns,
    NextStep,
    Notice,
    Report,
    Row,
    Section,
    Table,
    Text,
    note,
)
from scara_iso.reporting.shared.digits import Cell, Number, decimals, numbers, share, words
from scara_iso.robot import Rated
from scara_iso.tables import PLAIN, SheetLocale, write_rows
from scara_iso.testfolder import Folder, PartState, about, lacking, seconds_left

_MICRO = 1e6
_SETS = {PROPOSED: "proposed", GIVEN: "of the model", STANDARD: "of ISO 9283"}


def design_report(found: Design) -> Report:
    """Return the smallest effects, with the gain of each change of plan beside them."""
    plan, changes = found.plan, _lettered(found.changes)
    of_plan = f"{plan.cycles} cycles, scatter {plan.sigma:g} mm, dial {plan.division:g} mm"
    head = (
        Text("what this test will be able to tell", "strong"),
        Text(f"{of_plan}, columns: {', '.join(plan.columns) or 'none'}"),
        Text("travel: lowest to highest reading of an effect, without scatter", "quiet"),
    )
    travels = {"as planned": found.smallest, **{k: one.smallest for k, one in changes.items()}}
    notes = "; ".join(f"{letter}: {one.change}" for letter, one in changes.items())
    smallest = _travels(travels, decimals([plan.sigma]), 1.0, notes)
    return (
        Section("", head),
        Section("smallest travel found in 80 % of tests [mm]", (smallest,)),
        Section("cannot be told apart", tuple(_alike(found.alike))),
    )


def _lettered(changes: Sequence[Row]) -> Mapping[str, Row]:
    return {chr(ord("a") + k): change for k, change in enumerate(changes)}


def _travels(columns: Mapping[str, Travels], places: int, scale: float, notes: str = "") -> Table:
    names = list(dict.fromkeys(name for column in columns.values() for name in column))

    def cell(column: Travels, name: str) -> Cell:
        travel = column.get(name)
        missing = "-" if name in column else ""
        return missing if travel is None else Number(travel * scale, f".{places}f")

    cells = {head: [cell(column, name) for name in names] for head, column in columns.items()}
    return Table.in_columns({"effect": list(map(words, names)), **cells}, notes)


def _alike(pairs: Sequence[Alike]) -> list[Text]:
    if not pairs:
        return [Text("every pair of effects has shapes that differ")]
    return [Text(f"{' and '.join(map(words, a.effects))} (cosine {a.cosine:.2f})") for a in pairs]


def design_of_poses_report(found: DesignOfPoses) -> Report:
    """Return the smallest effects in the joints, and what would help, the largest gain first."""
    smallest = _travels(found.smallest, 1, _MICRO)
    return (
        Section("", tuple(_head_of_poses(found.plan, found.apart))),
        Section("smallest travel in a joint found in 80 % of tests [µrad]", (smallest,)),
        Section("what would help, the largest gain first", (_helps(found),)),
        Section("cannot be told apart", tuple(_alike(found.alike))),
    )


def _head_of_poses(plan: PlannedPosesTest, apart: PosesApart) -> Iterator[Text]:
    *joints, (_, dial) = plan.sources.items()
    scatter = ", ".join(f"{name} {one.value * _MICRO:.1f} µrad" for name, one in joints)
    steps = " and ".join(f"{step:g}" for step in dict.fromkeys(plan.division))
    seen = ", ".join(f"{name} to {value * _MICRO:.1f} µrad" for name, value in plan.sigma.items())
    columns = ", ".join(plan.columns) or "none"
    yield Text("what this test will be able to tell of the joints", "strong")
    yield Text(f"{plan.cycles} cycles at {', '.join(plan.joints_deg)}; columns: {columns}")
    yield Text(f"scatter: {scatter}, dials {dial.value:.2g} mm and their division of {steps} mm")
    yield Text(f"so the poses of one cycle show {seen}")
    yield Text(
        f"joints 1 and 2 are {apart.angle_deg:.0f} degrees apart against the scatter; nearest are "
        f"{' and '.join(apart.between)}, by {apart.smallest_angle_deg:.0f} degrees"
    )


def _helps(found: DesignOfPoses) -> Table:
    lettered = _lettered(found.changes)
    rows: list[dict[str, Cell]] = [{"change": "as planned", **dict.fromkeys(found.smallest, "")}]
    rows[0]["apart"] = Number(found.apart.angle_deg, ".0f")
    for letter, one in lettered.items():
        sizes = {name: share(size - 1, "+.0%") for name, size in one.size_needed.items()}
        rows.append({"change": letter, **sizes, "apart": Number(one.apart.angle_deg, ".0f")})
    text = "; ".join(f"{letter}: {_in_words(one)}" for letter, one in lettered.items())
    return Table.by_name(rows, f"{text}. {note('size_needed')}")


def _in_words(one: ChangeOfPoses) -> str:
    adds = ", ".join(map(words, one.adds))
    return f"{one.change} (tells {adds} besides)" if adds else one.change


def plan_report(plan: PosePlan, robot: str = "") -> Report:
    """Return the report on a plan: size, poses, how they are visited."""
    places = {k: numbers(v, ".1f") for k, v in zip("xyz", plan.corners.T, strict=True)}
    names = [f"C{k}" for k in range(1, len(plan.corners) + 1)]
    corners = Table.in_columns({"corner": names, **places})
    how, *missing = _how(plan.conditions, plan.rated)
    visits = (how, Text(note("same_side")), *missing, Text(note("dwell"), "quiet"))
    return (
        Section("", tuple(_verdict(plan, robot))),
        Section("poses", (_poses(plan.poses),)),
        Section("corners", (corners,)),
        Section("visits", visits),
    )


def separating_report(plan: SeparatingPlan, robot: str = "") -> Report:
    """Return the report on poses that tell the joints apart: how well, where, how visited."""
    sets: Columns[tuple[str, PosesApart]] = {
        "poses": lambda row: _SETS[row[0]],
        "joints 1, 2": lambda row: Number(row[1].angle_deg, ".0f"),
        "index": lambda row: Number(row[1].observability_index, ".2f"),
        "size to": lambda row: Number(row[1].uncertainty, ".2f"),
        "smallest": lambda row: Number(row[1].smallest_angle_deg, ".0f"),
        "which is of": lambda row: " and ".join(row[1].between),
    }
    head = (
        Text(f"Poses that tell the joints{_of_robot(robot)} apart", "strong"),
        Table.of(plan.apart.items(), sets, note("apart")),
        Text("these are not the poses of ISO 9283: figures of that test need its cube", "warn"),
        Text(f"elbow {plan.elbow.value} throughout; {note('room')}"),
    )
    first = plan.poses[0]
    joints = f"[{first.joint_1_deg:.2f}, {first.joint_2_deg:.2f}]"
    in_model = f"[pose.{first.name}] joint_deg = {joints}, and so on"
    return (
        Section("", head),
        Section("poses", (_poses(plan.poses), Text(f"{note('in_model')} {in_model}"))),
        Section("visits", tuple(_how(plan.conditions, plan.rated))),
    )


def visits_csv(plan: PosePlan | SeparatingPlan, locale: SheetLocale = PLAIN) -> str:
    """Return one cycle's visits as CSV, one row each in their order."""
    rows = plan.rows()
    cells = [[round(v, 6) if isinstance(v, float) else v for v in row.values()] for row in rows]
    return locale.bom + write_rows([list(rows[0]), *cells], locale)


def _verdict(plan: PosePlan, robot: str) -> Iterator[Block]:
    x, y, z = plan.size_mm
    yield Text(f"ISO 9283 test{_of_robot(robot)}", "strong")
    yield Text(f"largest {plan.solid.value}: {x:.1f} x {y:.1f} x {z:.1f} mm", "strong")
    stroke = "the stroke limits the cube; `solid=box` takes the largest area instead"
    yield Text(stroke if plan.stroke_limits else "", "warn")
    yield Text(
        f"plane {plan.plane.value}, elbow {plan.elbow.value}; m = {plan.m_mm:.1f} mm = "
        f"{plan.m_over_diagonal:.3g} L of the diagonal L = {plan.diagonal_mm:.1f} mm of the plane, "
        "within (0.1 ± 0.02) L"
    )


def _of_robot(robot: str) -> str:
    return f" of {robot}" if robot else ""


def _poses(poses: Sequence[PlannedPose]) -> Table:
    columns: Columns[PlannedPose] = {
        "pose": lambda pose: pose.name,
        "x": lambda pose: Number(pose.x_mm, ".1f"),
        "y": lambda pose: Number(pose.y_mm, ".1f"),
        "z": lambda pose: Number(pose.z_mm, ".1f"),
        "joint 1": lambda pose: Number(pose.joint_1_deg, ".2f"),
        "joint 2": lambda pose: Number(pose.joint_2_deg, ".2f"),
        "joint 3": lambda pose: Number(pose.joint_3_mm, ".1f"),
        "joint 4": lambda pose: Number(pose.joint_4_deg, ".2f"),
        "singular": lambda pose: Number(pose.singularity_deg, ".1f"),
    }
    return Table.of(poses, columns, note("planned_poses"))


def _how(how: PoseTestConditions, rated: Rated) -> Iterator[Block]:

    def of(value: float | None, unit: str) -> str:
        return "" if value is None else f" ({value:g} {unit})"

    yield Text(
        f"{how.cycles} cycles, {how.used} used, each from P1 through {', '.join(how.order)}; "
        f"{how.velocity_percent:g} % of the rated velocity{of(rated.velocity_mm_s, 'mm/s')}, "
        f"{how.load_percent:g} % of the rated load{of(rated.load_kg, 'kg')}, "
        f"{how.dwell_s:g} s at each pose before its reading"
    )
    stated = {"velocity_mm_s": rated.velocity_mm_s, "load_kg": rated.load_kg}
    missing = [name for name, value in stated.items() if value is None]
    if missing:
        yield Text(f"the model states no rated {' and '.join(missing)}: add [rated]", "warn")


def status_report(folder: Folder, today: date) -> Report:
    """Return the states of a test's parts as a table of poses and conditions, and what is next.

    Calibrations are to hold on the day of the test, or ``today`` where none is stated.
    """
    test, conditions = folder.test, folder.test.conditions()
    columns: dict[str, list[Cell]] = {"pose": [*test.poses]}
    for condition in conditions:
        columns[condition.name] = [_cell(state) for state in folder.under(condition)]
    others: Columns[PartState] = {"other tests": lambda state: state.part.name, "": _cell}
    head = (*_progress(folder), *_past_due(folder, today))
    parts = {
        "Struck": [f"{s.recording}: {s.reason}" for state in folder.parts for s in state.struck],
        "Out of its conditions": [
            f"{state.part.name}: {finding.message} [{finding.code}]"
            for state in folder.parts
            for finding in state.deviations
        ],
        "Faulty": [f"{one.part.name}: {one.why}" for one in folder.parts if one.why],
        "Planned, and not measured": list(folder.unmeasured),
        "Not part of the test": list(folder.foreign),
    }
    title = f"Test of {test.robot.name or folder.path.name}"
    return (
        Section(title, (*head, Table.in_columns(columns), Table.of(folder.other_tests, others))),
        *(Section(heading, tuple(map(Text, lines))) for heading, lines in parts.items()),
    )


def missing_report(what: str, missing: tuple[str, ...]) -> Report:
    """Return the report on a condition of which no part is recorded."""
    return (Section(what, (Text(f"nothing to analyse yet; missing: {', '.join(missing)}"),)),)


def _past_due(folder: Folder, today: date) -> Iterator[Block]:
    day = folder.test.schedule.date or today
    for axis, one in folder.test.instruments.items():
        if one.calibration_due is not None and one.calibration_due < day:
            text = f"calibration_due {one.calibration_due} is past: calibrate it, or use another"
            yield Notice("warning", "calibration-date", axis, text)


def _cell(state: PartState) -> str:
    if state.recording is None or state.is_whole or state.why:
        return state.state
    done, wanted = state.recording.cycles
    return f"{done} of {wanted} cycles"


def _progress(folder: Folder) -> Iterator[Block]:
    whole = sum(state.is_whole for state in folder.parts)
    yield Text(f"{whole} of {len(folder.parts)} parts are recorded")
    following = folder.next
    if following is None:
        faulty = [state for state in folder.parts if state.why]
        yield Text("Nothing is missing" + (", but parts are faulty" if faulty else ""), "strong")
        yield _mend(folder, faulty[0]) if faulty else NextStep(_called("report", folder))
        return
    left = seconds_left(folder)
    pace = f", {about(left)} left at the pace so far" if left is not None else ""
    yield Text(f"Next part: {lacking(following)}{pace}", "strong")
    if following.part.is_push:
        yield Text(f"Now: write force_N and reading into {folder.path / following.part.name}.csv")
    else:
        yield NextStep(_called("record", folder, "`gauge=AXIS=DRIVER@PORT`"))


def _called(command: str, folder: Folder, *options: str) -> str:
    return " ".join(["scara-iso", command, quote(str(folder.path)), *options])


def _mend(folder: Folder, state: PartState) -> Block:
    if state.part.is_push:
        return Text(f"Now: correct {folder.path / state.part.name}.csv")
    again = f"`part={state.part.name}` `repeat='the reason'` `gauge=AXIS=DRIVER@PORT`"
    return NextStep(_called("record", folder, again), "or correct what is named below")
