"""``scara-iso record``: serial indicators to a table, no reading lost or invented."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from scara_iso.cli.options import ExcelLocale

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
        "settled (the dial came to rest), or the robot's line: socket://HOST:PORT, line:PORT.",
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
    from scara_iso.cli.record_options import RecordOptions
    from scara_iso.cli.recording import rebuild_table, record_as_asked

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
        from scara_iso.cli.guide import record_guided

        record_guided(options)
    else:
        record_as_asked(options)
