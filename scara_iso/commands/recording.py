"""A recording as the command line asks for it: what to record, who operates, where it shows."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from scara_iso.base.disk import check_folder
from scara_iso.base.errors import InstrumentError, UsageError
from scara_iso.commands.keyboard import Keys, Lines, TypedKeys, TypedLines, open_keyboard
from scara_iso.commands.output import settings
from scara_iso.commands.screen import Screen, write_line
from scara_iso.commands.watching import Watcher
from scara_iso.iso9283 import past_due
from scara_iso.rawfile import History, Tour
from scara_iso.recorder import (
    BENCH_FILE,
    Command,
    Done,
    Enter,
    GaugeSpec,
    Job,
    Listen,
    Noticed,
    Operator,
    RecordingPlan,
    RememberedBench,
    RobotLine,
    Said,
    SystemDisk,
    Trigger,
    check_files,
    check_metadata,
    choose_clock,
    earlier_of,
    is_keyboard,
    is_recorded,
    name_dialects,
    parse_gauges,
    parse_metadata,
    parse_poses,
    parse_trigger,
    read_bench,
    read_metadata,
    rebuild,
    record,
    refuse_absent,
    when_started,
)
from scara_iso.render import LiveScreen, open_console
from scara_iso.reporting import printable
from scara_iso.testfolder import Assignment, assign, is_test_folder, read_folder

if TYPE_CHECKING:
    from scara_iso.testfolder import Folder


class Nobody:
    """An operator who never says anything."""

    def poll(self) -> Command | None:
        """Return None."""
        return None


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordOptions:
    """The options of the command, as given."""

    table: Path | None
    gauges: tuple[str, ...]
    trigger: str | None
    cycles: int | None
    pose: str | None
    stable: int
    rearm: float | None
    unit: str | None
    meta: tuple[str, ...]
    meta_file: Path | None
    resume: bool
    part: str | None
    repeat: str | None
    excel_locale: str | None
    json: bool
    bench: Path | None = None
    watch: bool | None = None
    quiet: bool = False
    usual_trigger: str | None = None
    of_bench: Mapping[str, str] = field(default_factory=dict)
    """What bench.toml states of its instruments, as lines of the table's head."""

    @property
    def shown(self) -> bool:
        """Whether the recording shows on a terminal."""
        return not self.json and sys.stdout.isatty()

    @property
    def watched(self) -> bool:
        """Whether the readings are watched: on a terminal unless it is not wanted."""
        return self.shown if self.watch is None else self.watch

    @property
    def guided(self) -> bool:
        """Whether somebody is there to be asked, and to see the questions."""
        return self.shown and sys.stdin.isatty()


def complete(options: RecordOptions) -> RecordOptions:
    """Return the options with what was left out: asked for, remembered, or found on the port."""
    if options.gauges:
        return replace(options, gauges=name_dialects(options.gauges, say))
    bench = usual_bench(options)
    if bench is None:
        return options
    return replace(
        options,
        gauges=name_dialects(bench.gauges, say),
        usual_trigger=bench.trigger,
        of_bench=instruments_of(options, bench),
    )


def instruments_of(options: RecordOptions, bench: RememberedBench) -> dict[str, str]:
    """Return what the bench's file states of its instruments, as lines of a table; say whose."""
    from scara_iso.testfolder import lines_of, read_instruments

    path = _bench_file(options)
    found = read_instruments(path)
    if found:
        say(f"certificates of {path}: {', '.join(found)}")
    return lines_of(found, [gauge.partition("=")[0].strip() for gauge in bench.gauges])


def usual_bench(options: RecordOptions) -> RememberedBench | None:
    """Return the bench that the options name, or that lies beside the table; say which it is.

    What was found and not named may be another's: a server in it, or a request of its own, is
    confirmed before it is used.
    """
    path = _bench_file(options)
    if options.bench is None and not path.is_file():
        return None
    bench = read_bench(path)
    say(f"gauges of {path}: {'  '.join(bench.gauges)}")
    if options.bench is None and (reached := bench.reaches_out()):
        confirm(
            reached,
            f"{path} reaches beyond this machine's ports, or sends words of its own, with",
            remedy=f"if this is your bench: --bench {shlex.quote(str(path))}",
            on_terminal=options.shown,
        )
    return bench


def _bench_file(options: RecordOptions) -> Path:
    table = options.table or Path()
    folder = table if table.is_dir() else table.parent
    return options.bench or folder / BENCH_FILE


def say(text: str) -> None:
    """Say on standard error what was decided for the user."""
    sys.stderr.write(f"scara-iso: {printable(text)}\n")


def confirm(named: Sequence[str], said: str, *, remedy: str, on_terminal: bool) -> None:
    """Have the ports confirmed that a file names: whoever wrote it chose what they reach."""
    if on_terminal and sys.stdin.isatty():
        sys.stdout.write(f"{printable(said)}\n")
        sys.stdout.writelines(f"  {printable(gauge)}\n" for gauge in named)
        with suppress(EOFError):
            if input("Go on with these? [y/N] ").strip().lower() in ("y", "yes"):
                return
            raise UsageError("stopped; nothing was changed")
    raise UsageError("a file names the ports, and they are to be confirmed", remedy=remedy)


ASKED = ("robot", "payload", "velocity", "temperature", "operator", "calibration_date")
"""Metadata asked for at the start, where someone is there to answer and gave none."""
_CYCLES = 31
_GO_ON = "go on with `resume=True`"
_REARM_S = 0.5
_REARM_KEY_S = 1.0
"""A key held down repeats after 0.25 to 0.7 s."""
_SHOWN = 5


def record_as_asked(options: RecordOptions) -> None:
    """Record a table, or a part of the test in a folder; raises as `record_table`."""
    if options.table is not None:
        _check_place(options.table, resume=options.resume)
    options = complete(options)
    if options.table is None:
        raise UsageError("no table to write is named", remedy="scara-iso record OUT.csv --gauge …")
    if is_test_folder(options.table):
        _record_part(options, options.table)
        return
    if options.part is not None or options.repeat is not None:
        raise UsageError(
            "--part and --repeat are for the folder of a test",
            where=str(options.table),
            remedy="make one: scara-iso test new DIR --model MODEL.toml",
        )
    record_table(options, options.table)


def _check_place(table: Path, *, resume: bool) -> None:
    """Raise as `check_files`, or `check_folder` for that of a test, before a port is asked."""
    if is_test_folder(table):
        check_folder(table)
    else:
        check_files(table, resume=resume)


def _record_part(options: RecordOptions, path: Path) -> None:
    """Record one part of a test; what test.toml states is neither asked nor to be given."""
    if options.cycles is not None:
        raise UsageError("test.toml says how many cycles", remedy="leave --cycles out")
    if options.pose is not None:
        raise UsageError("a part is one pose of test.toml", remedy="name it: --part P3-v50-l100")
    axes = [spec.axis for spec in parse_gauges(options.gauges, unit=options.unit)]
    folder = read_folder(path)
    found = assign(folder, axes, part=options.part, repeat=options.repeat)
    if found is None:
        _say_nothing_missing(folder, as_json=options.json or not sys.stdout.isatty())
        return
    record_table(
        replace(options, cycles=found.cycles, resume=found.resume), found.table, assignment=found
    )


def _say_nothing_missing(folder: Folder, *, as_json: bool) -> None:
    faulty = [state.part.name for state in folder.parts if state.why]
    said = "every part is recorded" if not faulty else f"faulty: {', '.join(faulty)}"
    if as_json:
        write_line(Noticed("", f"nothing is missing: {said}"))
    else:
        sys.stdout.write(printable(f"{folder.path}: nothing is missing, {said}") + "\n")


def record_table(
    options: RecordOptions, table: Path, *, assignment: Assignment | None = None
) -> None:
    """Record a table, new or resumed; raises as `record` and for options that are missing.

    An ``assignment`` says of which part of a test it is.
    """
    on_terminal = options.shown
    earlier = earlier_of(table) if options.resume else None
    if earlier is not None:
        _tell_damage(earlier)
    header = earlier.header if earlier else {}
    recorded = tuple(str(found["spec"]) for found in header.get("gauges", {}).values())
    if recorded and not options.gauges:
        confirm(
            recorded,
            "The recording was made with",
            remedy="the raw file names its gauges, which are to be confirmed; give them: "
            + " ".join(f"--gauge {shlex.quote(gauge)}" for gauge in recorded),
            on_terminal=on_terminal,
        )
    specs = parse_gauges(options.gauges or recorded, unit=options.unit)
    trigger = _trigger(
        options.trigger or header.get("trigger") or _usual_trigger(options, specs),
        on_terminal=on_terminal,
    )
    plan = RecordingPlan(
        trigger,
        options.cycles or int(header.get("cycles", _CYCLES)),
        options.stable,
        _rearm(trigger, specs) if options.rearm is None else options.rearm,
        Tour(tuple(header.get("poses", ())) if options.pose is None else parse_poses(options.pose)),
    )
    if plan.stable > 1 and plan.trigger == Listen():
        raise UsageError("--stable: --trigger data asks for no reading", remedy="leave it out")
    metadata = {} if options.meta_file is None else read_metadata(options.meta_file)
    metadata |= parse_metadata(options.meta)
    if assignment is not None:
        metadata = check_metadata(dict(assignment.metadata)) | metadata
    if not set(metadata) & set(options.of_bench):  # a certificate is that of one indicator
        metadata = check_metadata(options.of_bench) | metadata
    if not options.resume and on_terminal and plan.trigger == Enter() and sys.stdin.isatty():
        metadata = metadata or _ask_metadata(specs)
    job = Job(table, specs, plan, metadata, options.resume, options.excel_locale)
    _run(job, earlier, options, assignment=assignment)


def _run(
    job: Job,
    earlier: History | None,
    options: RecordOptions,
    *,
    assignment: Assignment | None,
) -> None:
    on_terminal = options.shown
    clock = choose_clock(spec.address for spec in job.gauges)
    with ExitStack() as stack:
        operator = _operator(job, stack, on_terminal=on_terminal)
        typed = operator.typed if isinstance(operator, TypedKeys | TypedLines) else None
        tell: Callable[[Said], None] = write_line
        if on_terminal:
            screen = _screen(job, earlier, operator, assignment, quiet=options.quiet)
            operator = stack.enter_context(screen)
            tell = screen.tell
        if options.watched:
            tell = Watcher(job, earlier, tell).told
        if assignment is not None:
            tell = when_started(partial(assignment.begin, job.table.parent), tell)
        try:
            record(
                job,
                disk=SystemDisk(),
                clock=clock,
                operator=operator,
                tell=tell,
                attended=on_terminal and sys.stdin.isatty(),
                typed=typed,
                remarks=past_due,
            )
        except InstrumentError as error:
            if assignment is not None:  # which the same command goes on with
                error.remedy = error.remedy.replace(_GO_ON, "record again")
            raise


def _screen(
    job: Job,
    earlier: History | None,
    operator: Operator,
    assignment: Assignment | None,
    *,
    quiet: bool,
) -> Screen:
    live = LiveScreen(open_console(sys.stdout, no_color=settings.no_color))
    stored = earlier.shown() if earlier else {}
    where = job.table.name if assignment is None else job.table.parent
    place = None if assignment is None else assignment.said
    return Screen(
        live,
        operator,
        title=f"scara-iso record {where}",
        earlier=stored,
        place=place,
        quiet=quiet,
        following=None if assignment is None else f"test status {job.table.parent}",
    )


def _operator(job: Job, stack: ExitStack, *, on_terminal: bool) -> Operator:
    typed = any(is_keyboard(spec.address) for spec in job.gauges)
    by_hand = typed or job.plan.trigger == Enter()
    if sys.stdin.isatty() and (on_terminal or by_hand):
        return (TypedKeys if typed else Keys)(stack.enter_context(open_keyboard()))
    if not by_hand:
        return Nobody()
    return (TypedLines if typed else Lines)(sys.stdin)


def _rearm(trigger: Trigger, specs: Sequence[GaugeSpec]) -> float:
    """Return the time; recorded streams and lines of a script say what they mean."""
    if trigger == Enter():
        return _REARM_KEY_S if sys.stdin.isatty() else 0.0
    typed = any(is_keyboard(spec.address) for spec in specs)
    if isinstance(trigger, RobotLine) or (typed and not sys.stdin.isatty()):
        return 0.0
    recorded = all(is_recorded(spec.address) for spec in specs)
    return 0.0 if recorded else _REARM_S


def _usual_trigger(options: RecordOptions, specs: Sequence[GaugeSpec]) -> str | None:
    """Return the trigger of bench.toml; a line that is typed is its own."""
    typed = any(is_keyboard(spec.address) for spec in specs)
    return "data" if typed else options.usual_trigger


def _trigger(text: str | None, *, on_terminal: bool) -> Trigger:
    if text is not None:
        return parse_trigger(str(text))
    if on_terminal and sys.stdin.isatty():
        return Enter()
    raise UsageError(
        "no terminal to press Enter on",
        remedy="give --trigger data, timer:SECONDS, settled, the robot's line (socket://HOST:PORT, "
        "line:PORT), or enter for lines of standard input",
    )


def _ask_metadata(specs: Sequence[GaugeSpec]) -> dict[str, str]:
    """Ask once for what the report will want to state; an empty answer leaves it out.

    Raises `InstrumentError` before anybody types, where a port is not there.
    """
    for spec in specs:
        refuse_absent(spec.address, spec.dialect.line)
    sys.stdout.write("For the head of the table (Enter leaves a line out):\n")
    width = max(map(len, ASKED))
    answers: dict[str, str] = {}
    with suppress(EOFError):
        for key in ASKED:
            answers[key] = input(f"  {key.replace('_', ' '):<{width}} ").strip()
    return check_metadata({key: answer for key, answer in answers.items() if answer})


def rebuild_table(raw: Path, table: Path | None, *, excel_locale: str | None, json: bool) -> None:
    """Make the table of a raw file and say so."""
    written, history = rebuild(raw, table, disk=SystemDisk(), excel_locale=excel_locale)
    _tell_damage(history)
    cycles, planned = history.cycles, int(history.header["cycles"])
    if json or not sys.stdout.isatty():
        write_line(Done(cycles, planned, str(written), str(raw)))
    else:
        sys.stdout.write(printable(f"{written}: {cycles} of {planned} cycles") + "\n")


def _tell_damage(history: History) -> None:
    sys.stderr.writelines(f"scara-iso: {printable(line)}\n" for line in history.doubts)
    if history.damaged:
        lines = ", ".join(map(str, history.damaged[:_SHOWN]))
        sys.stderr.write(
            f"scara-iso: {printable(history.source)}: {len(history.damaged)} torn or damaged, "
            f"left out: line {lines}\n"
        )
