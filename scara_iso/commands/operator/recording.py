"""One way to record, for library and command: what is asked for becomes a job, the job a table.

Who operates, the screen and the questions stand around it and hear what the session says.
"""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from scara_iso import iso9283, rawfile, recorder, testfolder
from scara_iso.base.errors import InstrumentError, UsageError
from scara_iso.base.files import Disk, check_folder
from scara_iso.commands.operator.watching import Announced, Watcher
from scara_iso.commands.shared.output import say_in_words

EXAMPLE = "scara-iso record run.csv --gauge X=opto-rs232@/dev/ttyUSB0 --trigger data"
_GO_ON = "continue with `resume=True`"
_REARM_S = 0.5
_REARM_KEY_S = 1.0
"""A key held down repeats after 0.25 to 0.7 s."""


def remark(text: str) -> None:
    """Say on standard error what was decided for the user."""
    say_in_words(f"scara-iso: {text}")


def refuse_unconfirmed(_named: Sequence[str], _in_words: str, *, remedy: str) -> None:
    """Raise `UsageError`: nobody is there to agree to the ports that a file names."""
    raise UsageError("the ports come from a file, and must be confirmed", remedy=remedy)


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordOptions:
    """What is to be recorded, as it was asked for; what is None is found, or as usual."""

    table: Path | None = None
    gauges: tuple[str, ...] = ()
    trigger: str | None = None
    cycles: int | None = None
    pose: str | Sequence[str] | None = None
    stable: int = 1
    rearm: float | None = None
    unit: str | None = None
    metadata: Mapping[str, str] = field(default_factory=dict)
    resume: bool = False
    part: str | None = None
    repeat: str | None = None
    excel_locale: str | None = None
    watch: bool = False
    pause_on_alarm: bool = False
    usual_trigger: str | None = None
    """Where neither the options nor a recording that is resumed name one."""
    certificates: Mapping[str, str] = field(default_factory=dict)
    """What bench.toml states of its instruments, as lines of the table's head."""
    keys: bool = False
    """Whether the operator presses keys of a terminal."""
    remembered: bool = False
    """Whether a bench gave the gauges: then only the table is asked for."""
    tell: Callable[[str], None] = lambda _: None
    """Hears which dialect a port speaks."""
    confirm: Callable[..., None] = refuse_unconfirmed
    """Raises unless the gauges are agreed to that a file names, and not the user."""


@dataclass(frozen=True, slots=True)
class Prepared:
    """A job as it was asked for, what was recorded of it before, and which part of a test it is."""

    options: RecordOptions
    job: recorder.Job
    earlier: rawfile.History | None = None
    part: testfolder.Assignment | None = None


def check_place(table: Path, *, resume: bool) -> None:
    """Raise as `check_files`, or `check_folder` for that of a test, before a port is asked."""
    if testfolder.is_test_folder(table):
        check_folder(table)
    else:
        recorder.check_files(table, resume=resume)


def prepare(options: RecordOptions) -> Prepared | None:
    """Return what is to be recorded; None where nothing of a test is missing."""
    table = options.table
    if table is None:
        raise UsageError("no table to write is named", remedy=f"name it and its gauges: {EXAMPLE}")
    check_place(table, resume=options.resume)
    if any(f"={recorder.AUTO}" in gauge for gauge in options.gauges):
        options.tell("trying every driver on the ports of `auto` (up to half a minute each) ...")
    options = replace(options, gauges=recorder.name_dialects(options.gauges, options.tell))
    if not testfolder.is_test_folder(table):
        if options.part is not None or options.repeat is not None:
            raise UsageError(
                "`part=` and `repeat=` are for the folder of a test",
                where=str(table),
                remedy="leave them out, or make one: scara-iso test new DIR --model MODEL.toml",
            )
        return _recording(options, table, None)
    part = _part(options, table)
    if part is None:
        return None
    of_part = replace(options, cycles=part.cycles, resume=part.resume)
    job = (found := _recording(of_part, part.table, part)).job
    if not part.part.other_tests:
        job = _announced(job, part)
    return replace(found, job=job, options=options)


def _announced(job: recorder.Job, assigned: testfolder.Assignment) -> recorder.Job:
    """Return the job of a part with what a robot's program says of it, and of the others."""
    part, test = assigned.part, assigned.folder.test
    done = [one.part for one in assigned.folder.parts if not (one.is_open or one.part.other_tests)]
    programs = {
        part_program(one, test): test.visits_of(one)
        for one in done
        if one.condition.load == part.condition.load
    }
    return replace(job, program=part_program(part, test), recorded=programs)


def part_program(part: testfolder.Part, test: testfolder.WholeTest) -> str:
    """Return what the HELLO of a robot's program states of a part."""
    return recorder.program_id((part.pose,), test.visits_of(part), part.name)


def each_part(first: Prepared, stack: ExitStack) -> Iterator[Prepared]:
    """Yield a recording and, of a test that a robot paces at an address served here, what follows.

    That are the parts that lack and need no other load, in the order of the test, until one is
    ended before it is whole.
    """
    options, trigger, part = first.options, first.job.plan.trigger, first.part
    folder = options.table
    served = isinstance(trigger, recorder.RobotLine) and trigger.address.startswith(recorder.LISTEN)
    if not served or part is None or part.part.other_tests or options.part or folder is None:
        yield first
        return
    address = str(trigger)
    line = stack.enter_context(closing(recorder.ListeningLine(address)))
    kept = recorder.RobotLine(address, line)
    options = replace(options, gauges=tuple(gauge.text for gauge in first.job.gauges))
    found: Prepared | None = first
    while found is not None and found.part is not None:
        plan = replace(found.job.plan, trigger=kept)
        yield replace(found, job=replace(found.job, plan=plan))
        recorded, states = found.part.part, testfolder.read_folder(folder)
        following = testfolder.next_of_load(states, recorded.condition.load)
        left = [one.part.name for one in states.parts if one.is_open]
        if following is None or recorded.name in left:
            return
        found = prepare(replace(options, part=following))


def _part(options: RecordOptions, folder: Path) -> testfolder.Assignment | None:
    if options.cycles is not None:
        raise UsageError("test.toml states the number of cycles", remedy="leave `cycles=` out")
    if options.pose is not None:
        raise UsageError("a part is one pose of test.toml", remedy="name it: `part=P3-v50-l100`")
    axes = [spec.axis for spec in recorder.parse_gauges(options.gauges, unit=options.unit)]
    found = testfolder.read_folder(folder)
    named = options.part
    if named is None and (options.trigger or "").startswith(recorder.LISTEN):
        named = testfolder.next_of_load(found)  # in the order of the robot's program
    return testfolder.assign(found, axes, part=named, repeat=options.repeat)


def _recording(options: RecordOptions, table: Path, part: testfolder.Assignment | None) -> Prepared:
    earlier = recorder.earlier_of(table) if options.resume else None
    header = earlier.header if earlier else {}
    recorded = tuple(str(found["spec"]) for found in header.get("gauges", {}).values())
    other_bench = options.remembered and {*options.gauges} != {*recorded}
    gauges = () if recorded and other_bench else options.gauges
    if recorded and not gauges:
        options.confirm(
            recorded,
            "The recording continues with the gauges that it was made with",
            remedy="the raw file names its gauges; give them: "
            + " ".join(f"--gauge {shlex.quote(gauge)}" for gauge in recorded),
        )
    specs = recorder.parse_gauges(gauges or recorded, unit=options.unit)
    plan = _plan(options, specs, header)
    job = recorder.Job(
        table, specs, plan, _metadata(options, part), options.resume, options.excel_locale
    )
    return Prepared(options, job, earlier, part)


def _plan(
    options: RecordOptions, specs: Sequence[recorder.GaugeSpec], header: Mapping[str, Any]
) -> recorder.RecordingPlan:
    trigger = _trigger(options, specs, header.get("trigger"))
    poses = header.get("poses", ()) if options.pose is None else recorder.parse_poses(options.pose)
    plan = recorder.RecordingPlan(
        trigger,
        options.cycles or int(header.get("cycles", iso9283.CYCLES_RUN)),
        options.stable,
        _rearm(trigger, specs, keys=options.keys) if options.rearm is None else options.rearm,
        rawfile.Tour(tuple(poses)),
    )
    if plan.stable > 1 and plan.trigger == "data":
        raise UsageError("`trigger=data` never asks for a reading", remedy="leave `stable=` out")
    return plan


def is_typed(specs: Sequence[recorder.GaugeSpec]) -> bool:
    """Say whether somebody types the readings of one of the gauges."""
    return any(recorder.port_kind(spec.address) == "keyboard" for spec in specs)


def _trigger(
    options: RecordOptions, specs: Sequence[recorder.GaugeSpec], recorded: object
) -> recorder.Trigger:
    """Return the trigger; a line that is typed is its own."""
    usual = "data" if is_typed(specs) else options.usual_trigger
    text = options.trigger or recorded or usual
    if text is None:
        raise UsageError(
            "no terminal to press Enter on",
            remedy="give `trigger=data`, timer:SECONDS, settled, the robot's line "
            "(socket://HOST:PORT, line:PORT), or enter for lines of standard input",
        )
    return recorder.parse_trigger(str(text))


def _rearm(trigger: recorder.Trigger, specs: Sequence[recorder.GaugeSpec], *, keys: bool) -> float:
    """Return the time [s]; recorded streams and lines of a script say what they mean."""
    if trigger == "enter":
        return _REARM_KEY_S if keys else 0.0
    if isinstance(trigger, recorder.RobotLine) or (is_typed(specs) and not keys):
        return 0.0
    return 0.0 if all(recorder.port_kind(spec.address) == "replay" for spec in specs) else _REARM_S


def _metadata(options: RecordOptions, part: testfolder.Assignment | None) -> dict[str, str]:
    """Return the lines of the table's head; a certificate is that of one indicator."""
    head = recorder.check_metadata({} if part is None else dict(part.metadata))
    head |= recorder.check_metadata(options.metadata)
    if set(head) & set(options.certificates):
        return head
    return recorder.check_metadata(options.certificates) | head


def record_prepared(
    recording: Prepared,
    operator: recorder.Operator,
    tell: Callable[[Announced], None],
    *,
    attended: bool = False,
    typed: Callable[[], bytes] | None = None,
) -> None:
    """Record; raises what `recorder.record` raises."""
    job, part, options = recording.job, recording.part, recording.options
    if options.pause_on_alarm:
        paced = isinstance(job.plan.trigger, recorder.RobotLine)
        if isinstance(operator, recorder.Unattended) and not paced:
            raise UsageError(
                "a pause at an alarm needs an operator to end it",
                remedy="leave `pause_on_alarm=True` out, or record on a terminal",
            )
    if options.watch or options.pause_on_alarm:
        watcher = Watcher(job, recording.earlier, tell, operator)
        operator, tell = watcher if options.pause_on_alarm else operator, watcher.hear
    if part is not None:
        tell = recorder.when_started(partial(part.begin, job.table.parent), tell)
    try:
        recorder.record(
            job,
            disk=Disk(),
            clock=recorder.choose_clock(spec.address for spec in job.gauges),
            operator=operator,
            tell=tell,
            attended=attended,
            typed=typed,
            remarks=iso9283.past_due,
        )
    except InstrumentError as error:
        if part is not None:  # which the same command goes on with
            error.remedy = error.remedy.replace(_GO_ON, "record again")
        raise
