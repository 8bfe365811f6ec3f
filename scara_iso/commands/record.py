"""`record`: indicators to a table, no reading lost or invented."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

from scara_iso import recorder
from scara_iso.base.errors import UsageError
from scara_iso.base.files import Disk
from scara_iso.commands.operator import keyboard
from scara_iso.commands.operator.guide import (
    Terminal,
    ask_metadata,
    guide,
    with_bench,
    without_questions,
)
from scara_iso.commands.operator.recording import (
    Prepared,
    RecordOptions,
    check_place,
    each_part,
    prepare,
    record_prepared,
    remark,
)
from scara_iso.commands.operator.screen import make_screen, write_line
from scara_iso.commands.operator.watching import Announced
from scara_iso.commands.shared import options as opt
from scara_iso.commands.shared.output import say
from scara_iso.rawfile import History
from scara_iso.run import Run
from scara_iso.tables import read_table
from scara_iso.testfolder import read_folder

_SHOWN = 5


def record(
    table: str | Path,
    gauges: Sequence[str],
    *,
    trigger: str,
    cycles: int | None = None,
    pose: str | Sequence[str] | None = None,
    stable: int = 1,
    rearm: float | None = None,
    unit: str | None = None,
    metadata: Mapping[str, str] | None = None,
    resume: bool = False,
    part: str | None = None,
    repeat: str | None = None,
    excel_locale: str | None = None,
    watch: bool = False,
    pause_on_alarm: bool = False,
    operator: recorder.Operator | None = None,
    tell: Callable[[Announced], None] | None = None,
) -> Run:
    """Record indicators into ``table`` and return what is then in it.

    ``table`` may be the folder of a test: the next missing part is recorded or resumed, or
    ``part`` (``P3-v50-l100``); ``repeat`` is the reason for which what is there of it is struck.
    test.toml gives cycles, pose and head then, and `UsageError` says where nothing is missing.
    With ``listen://`` the parts follow that need no other load; what is returned is the last.

    ``gauges`` are ``AXIS=DRIVER@PORT``, ``trigger`` is ``data``, ``timer:SECONDS``, or ``enter``
    with an ``operator`` whose ``poll()`` gives the commands. ``tell`` hears each event, a stored
    reading only once it is safe on the disk. ``stable`` readings in a row must agree; none counts
    within ``rearm`` seconds of the last (0.5; for recorded streams and an ``operator`` 0).
    ``cycles`` are 31 unless given. ``pose`` names the poses of every cycle, in their order:
    ``"P1,P2"`` or a sequence. ``metadata`` goes into the table's head. With ``watch`` ``tell``
    hears after each cycle what the readings so far say together; ``pause_on_alarm`` refuses
    readings from its first alarm on, until the robot's program or the operator goes on. Raises
    `UsageError` for invalid options, `InstrumentError` for a port, `CannotCreateError` and
    `WriteError` for the files.
    """
    asked = {name: one for name, one in locals().items() if name not in ("operator", "tell")}
    given = {"table": Path(table), "gauges": tuple(gauges), "metadata": metadata or {}}
    options = RecordOptions(**asked | given)
    recording = prepare(options)
    if recording is None:
        raise UsageError(
            "nothing is missing",
            where=str(table),
            remedy="to repeat a part give `part=P3-v50-l100` and `repeat='the plunger stuck'`",
        )
    with ExitStack() as stack:
        for one in each_part(recording, stack):
            record_prepared(one, operator or recorder.Unattended(), tell or (lambda _: None))
            last = one.job.table
    return read_table(last)


@opt.takes_options_of(
    record,
    table=opt.argument(
        "Table to write, or a test folder.", "OUT.csv|DIR", Path | None, show_default=False
    ),
    gauges=opt.option(
        "Indicator of an axis: X=opto-rs232@/dev/ttyUSB0; once for each axis. PORT: a device, "
        "socket://HOST:PORT, ble:ADDRESS, replay:FILE, sim: or keyboard:. DRIVER auto tries those "
        "that fit.",
        "--gauge",
        kind=list[str] | None,
        read=tuple,
        metavar="AXIS=DRIVER@PORT",
        autocompletion=lambda: [
            f"{axis}={key}@" for axis in "XYZ" for key in recorder.find_dialects()
        ],
    ),
    trigger=opt.option(
        "When a reading is taken: enter (key or foot switch), data (DATA key), timer:SECONDS, "
        "settled (the dial is at rest), or by the robot: socket://HOST:PORT, line:PORT, "
        "listen://ADDRESS:PORT (served here), replay:FILE (as recorded).",
        kind=str | None,
        metavar="WHEN",
    ),
    cycles=opt.option("Number of cycles, the discarded first included [31].", metavar="N", min=1),
    pose=opt.option("Poses of every cycle, in order.", metavar="P1,P2,..."),
    stable=opt.option("Equal readings in a row that count as one.", metavar="K", min=1, max=50),
    rearm=opt.option(
        "Minimum time between two readings [0.5; keys: 1; recorded streams: 0].",
        metavar="SECONDS",
        min=0,
    ),
    unit=opt.option("Unit of indicators that do not state theirs.", metavar="UNIT"),
    metadata=opt.option(
        'Statement for the head of the table: robot="FUM SCARA".',
        "--meta",
        read=opt.parse_pairs,
        metavar="KEY=VALUE",
    ),
    resume=opt.option("Continue the recording of OUT.csv."),
    part=opt.option("Part of a test folder: P3-v50-l100 [the next one].", metavar="PART"),
    repeat=opt.option("Reason to record --part again; what is there is struck.", metavar="REASON"),
    rebuild=opt.option(
        "Raw file whose table is made; nothing is recorded.", metavar="OUT.raw.jsonl"
    ),
    bench=opt.option(
        "File of gauges, where no --gauge is given [bench.toml beside OUT.csv].",
        metavar="FILE.toml",
        show_default=False,
    ),
    watch=opt.option(
        "Report after each cycle whether more than scatter acts.",
        "--watch/--no-watch",
        kind=bool | None,
        show_default=False,
    ),
    pause_on_alarm=opt.option("Pause at the watch's first alarm."),
    quiet=opt.option("No tones."),
    json=opt.option("JSON lines on standard output; also without a terminal."),
)
def record_command(
    asked: opt.Asked[Run],
    *,
    meta_file: Path | None = None,
    rebuild: Path | None = None,
    bench: Path | None = None,
    watch: bool | None = None,
    quiet: bool = False,
    json: bool = False,
) -> None:
    """Record indicators into a table for analyze; every stored reading is safe on the disk.

    Without OUT.csv it asks for what it needs.

    Example: scara-iso record run.csv --gauge X=opto-rs232@/dev/ttyUSB0 --trigger data

    Options of an indicator follow its driver: "X=mitutoyo-mux?unit=mm&channel=1@COM3".
    They are unit, channel, baud, bits, parity, stop, request and, for generic, pattern.
    """
    terminal = Terminal(json=json, quiet=quiet)
    if rebuild is not None:
        given = {**asked.stated(), "meta-file": meta_file, "bench": bench, "watch": watch}
        left = {name for name, one in given.items() if one not in (None, [])} - {"excel-locale"}
        if left:
            what = f"nothing is recorded with --rebuild, and --{', --'.join(sorted(left))} is given"
            raise UsageError(what, remedy="leave out either")
        _rebuild(terminal, rebuild, asked["table"], asked["excel_locale"])
        return
    given = asked.options("watch")
    given["metadata"] = opt.pairs_in(meta_file) | given.get("metadata", {})
    options = RecordOptions(
        **given,
        watch=terminal.shown if watch is None else watch,
        usual_trigger="enter" if terminal.guided else None,
        keys=sys.stdin.isatty(),
        tell=remark,
        confirm=terminal.confirm,
    )
    if options.table is not None or not terminal.guided:
        if options.table is not None:
            check_place(options.table, resume=options.resume)
        options = with_bench(options, bench)
        _record(terminal, options, _prepared(terminal, options))
        return
    _record_guided(terminal, guide(options, bench), asked.stated())


def _rebuild(terminal: Terminal, raw: Path, table: Path | None, excel_locale: str | None) -> None:
    """Write the table of a raw file, and say how far it goes."""
    written, history = recorder.rebuild(raw, table, disk=Disk(), excel_locale=excel_locale)
    _tell_damage(history)
    cycles, planned = history.cycles, int(history.header["cycles"])
    done = recorder.Done(cycles, planned, str(written), str(raw))
    terminal.tell(done, f"{written}: {cycles} of {planned} cycles")


def _record_guided(
    terminal: Terminal, options: RecordOptions, stated: Mapping[str, object]
) -> None:
    """Record what the guide asked for, and say the line that does the same without questions."""
    recording = _prepared(terminal, options)
    metadata = options.metadata if recording is None else recording.job.metadata
    try:
        _record(terminal, options, recording)
    except KeyboardInterrupt:
        sys.stdout.write("\n")  # below ^C
        raise
    finally:
        line = without_questions(replace(options, metadata=metadata), stated)
        say(f"The same without questions: {line}", aside=False)


def _prepared(terminal: Terminal, options: RecordOptions) -> Prepared | None:
    """Return what is to be recorded, once the head of its table was asked for."""
    recording = prepare(options)
    if recording is None:
        return None
    job = recording.job
    if recording.earlier is not None:
        _tell_damage(recording.earlier)
    known = options.resume or options.remembered or job.metadata
    if terminal.guided and job.plan.trigger == "enter" and not known:
        job = replace(job, metadata=ask_metadata(job.gauges))
    return replace(recording, job=job)


def _record(terminal: Terminal, options: RecordOptions, first: Prepared | None) -> None:
    """Record as a user of the command asks for it, whatever standard output is."""
    if first is None:
        folder = options.table or Path()
        faulty = [state.part.name for state in read_folder(folder).parts if state.why]
        said = f"faulty: {', '.join(faulty)}" if faulty else "every part is recorded"
        notice = recorder.Noticed("", f"nothing is missing: {said}")
        terminal.tell(notice, f"{folder}: nothing is missing, {said}")
        return
    with ExitStack() as stack:
        for one in each_part(first, stack):
            _run_at(terminal, one)


def _run_at(terminal: Terminal, recording: Prepared) -> None:
    with ExitStack() as stack:
        operator = keyboard.choose_operator(recording.job, stack, shown=terminal.shown)
        typed = operator.typed if isinstance(operator, keyboard.Typist) else None
        tell: Callable[[Announced], None] = write_line
        if terminal.shown:
            screen = make_screen(recording, operator, quiet=terminal.quiet)
            operator, tell = stack.enter_context(screen), screen.tell
        record_prepared(recording, operator, tell, typed=typed, attended=terminal.guided)


def _tell_damage(history: History) -> None:
    for line in history.doubts:
        remark(line)
    if history.damaged:
        lines = ", ".join(map(str, history.damaged[:_SHOWN]))
        remark(f"{history.source}: {len(history.damaged)} torn or damaged, left out: line {lines}")
