"""`record`: indicators to a table, no reading lost or invented."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from scara_iso import recorder
from scara_iso.base.errors import UsageError
from scara_iso.commands.options import ExcelLocale
from scara_iso.commands.recording import Nobody
from scara_iso.commands.watching import Watcher
from scara_iso.iso9283 import CYCLES_RUN, past_due
from scara_iso.rawfile import Tour
from scara_iso.recorder import (
    Job,
    Operator,
    RecordingPlan,
    Said,
    SystemDisk,
    check_metadata,
    choose_clock,
    earlier_of,
    is_recorded,
    name_dialects,
    parse_gauges,
    parse_poses,
    parse_trigger,
    when_started,
)
from scara_iso.run import Run
from scara_iso.tables import read_table
from scara_iso.testfolder import Assignment, assign, is_test_folder, read_folder

_REARM_S = 0.5


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
    operator: Operator | None = None,
    tell: Callable[[Said], None] | None = None,
) -> Run:
    """Record indicators into ``table`` and return what is then in it.

    ``table`` may be the folder of a test: the next missing part is recorded, or gone on with, or
    ``part`` (``P3-v50-l100``); ``repeat`` is the reason for which what is there of it is struck.
    test.toml gives cycles, pose and head then, and `UsageError` says where nothing is missing.

    ``gauges`` are ``AXIS=DRIVER@PORT``, ``trigger`` is ``data``, ``timer:SECONDS``, or ``enter``
    with an ``operator`` whose ``poll()`` gives the commands. ``tell`` hears each event, a stored
    reading only once it is safe on the disk. ``stable`` readings in a row must agree; none counts
    within ``rearm`` seconds of the last (0.5, for recorded streams 0). ``cycles`` are 31 unless
    given. ``pose`` names the poses of every cycle, in their order: ``"P1,P2"`` or a sequence.
    ``metadata`` goes into the table's head. With ``watch`` ``tell`` hears after each cycle what the
    readings so far say together. Raises `UsageError` for invalid options,
    `InstrumentError` for a port, `CannotCreateError` and `WriteError` for the files.
    """
    specs = parse_gauges(name_dialects(gauges, lambda _: None), unit=unit)
    recorded = all(is_recorded(spec.address) for spec in specs)
    pause = rearm if rearm is not None else 0.0 if recorded else _REARM_S
    tour = Tour() if pose is None else Tour(parse_poses(pose))
    told = tell or (lambda _: None)
    path, head = Path(table), check_metadata(dict(metadata or {}))
    found = _part(path, [spec.axis for spec in specs], cycles, tour, part, repeat)
    if found is not None:
        told = when_started(partial(found.begin, path), told)
        path, cycles, resume = found.table, found.cycles, found.resume
        head = check_metadata(dict(found.metadata)) | head
    plan = RecordingPlan(parse_trigger(trigger), cycles or CYCLES_RUN, stable, pause, tour)
    job = Job(path, specs, plan, head, resume, excel_locale)
    if watch:
        earlier = earlier_of(path) if resume else None
        told = Watcher(job, earlier, told).told
    recorder.record(
        job,
        disk=SystemDisk(),
        clock=choose_clock(spec.address for spec in specs),
        operator=operator or Nobody(),
        tell=told,
        remarks=past_due,
    )
    return read_table(path)


def _part(
    path: Path,
    axes: Sequence[str],
    cycles: int | None,
    tour: Tour,
    part: str | None,
    repeat: str | None,
) -> Assignment | None:
    """Return the part to record where ``path`` is the folder of a test, else None."""
    if not is_test_folder(path):
        if part is not None or repeat is not None:
            raise UsageError(
                "`part=` and `repeat=` are for the folder of a test",
                where=str(path),
                remedy="leave them out, or name such a folder",
            )
        return None
    if cycles is not None or tour.poses:
        raise UsageError(
            "test.toml says poses and cycles", where=str(path), remedy="leave them out"
        )
    found = assign(read_folder(path), axes, part=part, repeat=repeat)
    if found is None:
        raise UsageError(
            "nothing is missing",
            where=str(path),
            remedy="to repeat a part give `part=P3-v50-l100` and `repeat='the plunger stuck'`",
        )
    return found


_Table = Annotated[
    Path | None,
    typer.Argument(
        metavar="OUT.csv|DIR", help="Table to write, or a test's folder.", show_default=False
    ),
]
_Gauge = Annotated[
    list[str] | None,
    typer.Option(
        metavar="AXIS=DRIVER@PORT",
        help="An indicator, once for each axis: X=opto-rs232@/dev/ttyUSB0. PORT: a device, "
        "a URL such as socket://HOST:PORT, ble:ADDRESS, replay:FILE, sim:, or keyboard:. "
        "DRIVER auto tries those that fit.",
    ),
]
_Trigger = Annotated[
    str | None,
    typer.Option(
        metavar="WHEN",
        help="enter (key or foot switch), data (DATA key), timer:SECONDS, "
        "settled (the dial came to rest), or the robot's line: socket://HOST:PORT, line:PORT, "
        "listen://ADDRESS:PORT.",
    ),
]
_Cycles = Annotated[
    int | None, typer.Option(metavar="N", help="Cycles to record, the first included: 31.", min=1)
]
_Pose = Annotated[
    str | None,
    typer.Option(metavar="P1,P2,...", help="The poses that every cycle visits, in their order."),
]
_Stable = Annotated[
    int,
    typer.Option(metavar="K", help="Ask until K readings in a row are equal.", min=1, max=50),
]
_Rearm = Annotated[
    float | None,
    typer.Option(
        metavar="SECONDS",
        help="Do not take a reading that comes by itself, or a key, so soon after the last: "
        "0.5, keys 1, but 0 for recorded streams and lines of standard input.",
        min=0,
    ),
]
_Unit = Annotated[
    str | None, typer.Option(metavar="UNIT", help="Unit of indicators that do not state theirs.")
]
_Meta = Annotated[
    list[str] | None,
    typer.Option(metavar="KEY=VALUE", help='For the table\'s head: robot="FUM SCARA".'),
]
_MetaFile = Annotated[
    Path | None, typer.Option(metavar="FILE.toml", help="Lines key = value for the table's head.")
]
_Resume = Annotated[bool, typer.Option("--resume", help="Go on with the recording of OUT.csv.")]
_Part = Annotated[
    str | None,
    typer.Option(metavar="PART", help="In a test's folder: P3-v50-l100; else the next one."),
]
_Repeat = Annotated[
    str | None,
    typer.Option(metavar="REASON", help="Record --part anew; what is there is struck, and stays."),
]
_Rebuild = Annotated[
    Path | None, typer.Option(metavar="OUT.raw.jsonl", help="Only make the table of a raw file.")
]
_Bench = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE.toml",
        help="The gauges remembered there, where no --gauge is given: bench.toml beside OUT.csv.",
        show_default=False,
    ),
]
_Watch = Annotated[
    bool | None,
    typer.Option(
        "--watch/--no-watch",
        help="Say at each cycle whether something other than scatter acts; on the screen unless "
        "--no-watch.",
        show_default=False,
    ),
]
_Quiet = Annotated[
    bool, typer.Option("--quiet", help="No tone on stored and on refused; the screen stays.")
]
_Json = Annotated[
    bool,
    typer.Option(
        "--json", help="JSON lines; so too where there is no terminal (> FILE takes them)."
    ),
]


def record_command(
    table: _Table = None,
    *,
    gauge: _Gauge = None,
    trigger: _Trigger = None,
    cycles: _Cycles = None,
    pose: _Pose = None,
    stable: _Stable = 1,
    rearm: _Rearm = None,
    unit: _Unit = None,
    meta: _Meta = None,
    meta_file: _MetaFile = None,
    resume: _Resume = False,
    part: _Part = None,
    repeat: _Repeat = None,
    rebuild: _Rebuild = None,
    excel_locale: ExcelLocale = None,
    bench: _Bench = None,
    watch: _Watch = None,
    quiet: _Quiet = False,
    json: _Json = False,
) -> None:
    """Record indicators into a table for analyze; every stored reading is safe on the disk.

    Without OUT.csv, on a terminal, it asks for what it needs.

    Example: scara-iso record run.csv --gauge X=opto-rs232@/dev/ttyUSB0 --trigger data

    Options of an indicator stand behind its driver: X=mitutoyo-mux?unit=mm&channel=1@COM3.
    They are unit, channel, baud, bits, parity, stop, request and, for generic, pattern.
    """
    from scara_iso.commands.recording import RecordOptions, rebuild_table, record_as_asked

    if rebuild is not None:
        rebuild_table(rebuild, table, excel_locale=excel_locale, json=json)
        return
    options = RecordOptions(
        table=table,
        gauges=tuple(gauge or ()),
        trigger=trigger,
        cycles=cycles,
        pose=pose,
        stable=stable,
        rearm=rearm,
        unit=unit,
        meta=tuple(meta or ()),
        meta_file=meta_file,
        resume=resume,
        part=part,
        repeat=repeat,
        excel_locale=excel_locale,
        json=json,
        bench=bench,
        watch=watch,
        quiet=quiet,
    )
    if table is None and options.guided:
        from scara_iso.commands.guide import record_guided

        record_guided(options)
    else:
        record_as_asked(options)
