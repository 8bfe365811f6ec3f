"""What is to be recorded, as the user writes it: gauges, metadata, poses, trigger, cycles.

A gauge is ``AXIS=DRIVER[?OPTIONS]@PORT``; a trigger is what makes a reading be taken. Both are
remembered for the next recording in ``bench.toml``.
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, TypeAlias
from urllib.parse import quote, unquote

from scara_iso import tables
from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.files import is_file, read_file, read_toml, write_file
from scara_iso.base.quantities import parse_number, parse_unit
from scara_iso.rawfile import SCHEMA, History, Tour, wrong_sizes
from scara_iso.recorder.indicators import KEYBOARD, WHOLE, Dialect, find_dialect, find_dialects
from scara_iso.recorder.indicators.generic import make_generic
from scara_iso.recorder.ports.listening import LISTEN, listen_address
from scara_iso.recorder.ports.port import (
    Port,
    check_address,
    is_device,
    number_option,
    port_kind,
    split_options,
)
from scara_iso.run import AXES

OPTIONS = {
    "unit": "unit of the display, such as mm or inch",
    "channel": "channel of a multiplexer",
    "baud": "9600",
    "bits": "7 or 8 data bits",
    "parity": "N, E or O",
    "stop": "1 or 2 stop bits",
    "request": r"bytes that ask for a reading, such as ?\r",
    "pattern": "regular expression with the groups value and unit (driver generic only)",
}
"""Options behind a driver, written as in a URL: ``X=mitutoyo-mux?unit=mm&channel=1@COM3``."""
AUTO = "auto"
"""The driver of a gauge whose dialect is to be found."""

_SIMPLE = "X=opto-rs232@/dev/ttyUSB0"
_EXAMPLE = f'{_SIMPLE} or "X=mitutoyo-mux?unit=mm&channel=1@COM3"'
_AXES = {name.lower(): name for name in AXES}
_LONGEST = 50_000
_DIVISION = 0.02  # of a unit so small whole numbers are readings [mm or deg]
_TABLE_KEY = re.compile(
    r"(unit|resolution)(_.*)?|first_cycle_discarded|axes_recorded"
    r"|simulated|cycles_planned|record_.*|recorded|doubts|indicator"
)
METADATA_KEY = re.compile(r"[^\W\d_][\w -]{0,60}")


@dataclass(frozen=True, slots=True)
class GaugeSpec:
    """One indicator: its axis, how it speaks, its port, and the unit that the user states."""

    text: str
    """As the user wrote it, its unit included wherever that was stated."""
    axis: str
    dialect: Dialect
    address: str
    unit: str | None


def parse_gauge(text: str, *, unit: str | None = None) -> GaugeSpec:
    """Return the gauge that ``text`` spells; ``unit`` holds where its options name none.

    Raises `UsageError` for an unknown axis, driver, option or unit.
    """
    name, equals, rest = text.partition("=")
    driver, at, address = rest.partition("@")
    axis = _AXES.get(name.strip().lower())
    if not (equals and at and address.strip()) or axis is None:
        alone = rest if axis and not at else ""
        auto = f"write {axis or 'X'}=auto@{alone or 'PORT'} to have the driver found, or {_EXAMPLE}"
        is_driver = alone.partition("?")[0] in find_dialects()
        raise UsageError(
            f"`gauge={text}`: not AXIS=DRIVER@PORT" if axis else f"no axis {name.strip()!r}",
            remedy=f"write {axis}={alone}@PORT, as {_EXAMPLE}"
            if is_driver
            else f"{auto}; axes: {', '.join(AXES)}",
        )
    key, options = split_options(driver, OPTIONS)
    _check_keyboard(key.strip(), address.strip())
    stated = options.get("unit", unit)
    if "unit" not in options and stated is not None:
        driver += f"{'&' if options else '?'}unit={quote(stated)}"
    size = None if stated is None else parse_unit(stated)
    whole = key.strip() == KEYBOARD.key and size is not None and size.to_base(1.0) <= _DIVISION
    return GaugeSpec(
        text=f"{axis}={driver}@{address}",
        axis=axis,
        dialect=WHOLE if whole else _dialect(key.strip(), options),
        address=address.strip(),
        unit=None if size is None else size.name,
    )


def parse_gauges(texts: Iterable[str], *, unit: str | None = None) -> tuple[GaugeSpec, ...]:
    """Return the gauges, one an axis; `UsageError` otherwise, or where there is none."""
    gauges = tuple(parse_gauge(text, unit=unit) for text in texts)
    axes = [gauge.axis for gauge in gauges]
    twice = sorted({axis for axis in axes if axes.count(axis) > 1})
    if sum(port_kind(gauge.address) == "keyboard" for gauge in gauges) > 1:
        raise UsageError("two gauges on one keyboard", remedy="type the readings of one axis")
    if not gauges or twice:
        raise UsageError(
            f"two gauges for {', '.join(twice)}" if twice else "no indicator is named",
            remedy=f"give `gauge={_SIMPLE}`, once for each axis",
        )
    return gauges


def _check_keyboard(key: str, address: str) -> None:
    """Raise `UsageError` where one of port and driver is the keyboard, and the other a cable's."""
    if is_device(address) and (port_kind(address) == "keyboard") != (key == KEYBOARD.key):
        raise UsageError(
            f"{key}@{address}: the keyboard has its own driver", remedy="write X=keyboard@keyboard:"
        )


def _dialect(key: str, options: Mapping[str, str]) -> Dialect:
    pattern = options.get("pattern")
    if pattern is not None and key != "generic":
        raise UsageError(f"{key} takes no pattern=", remedy="use the driver generic")
    dialect = make_generic(pattern) if pattern is not None else find_dialect(key)
    dialect = dialect.configure(
        baud=_whole(options, "baud"),
        data_bits=_whole(options, "bits"),
        parity=options.get("parity", "").upper() or None,
        stop_bits=_whole(options, "stop"),
        channel=options.get("channel"),
    )
    if "request" in options:
        dialect = replace(dialect, request_template=_bytes(options["request"]), request_line=None)
    return dialect


def _whole(options: Mapping[str, str], key: str) -> int | None:
    text = options.get(key)
    if text is None:
        return None
    if not (text.isascii() and text.isdigit() and len(text) < 9):
        raise UsageError(
            f"{key}={text} is not a whole number", remedy=f"write {key} as digits only"
        )
    return int(text)


def _bytes(text: str) -> bytes:
    try:
        return text.encode("ascii").decode("unicode_escape").encode("latin-1")
    except UnicodeError as error:
        raise UsageError(f"request={text}: {error}", remedy=r"write \r, \n, \x02") from error


def check_metadata(found: Mapping[str, str]) -> dict[str, str]:
    """Return ``found``; `UsageError` for too much, or a key that is none or the recorder's."""
    wrong = [key for key in found if not METADATA_KEY.fullmatch(key)]
    taken = [key for key in found if _TABLE_KEY.fullmatch(tables.normal_key(key))]
    if wrong or taken:
        raise UsageError(
            f"metadata {(wrong + taken)[0]!r}: "
            + ("not a key" if wrong else "the recorder states this itself"),
            remedy="use keys such as robot, payload, velocity, temperature, operator",
        )
    if sizes := wrong_sizes(found):
        raise UsageError(
            f"metadata {sizes[0]!r}: {found[sizes[0]]!r} is not a plain number above 0",
            remedy="in mm, of an angle in degrees: indicator_uncertainty=0.0005",
        )
    if sum(len(key) + len(value) for key, value in found.items()) > _LONGEST:
        raise UsageError(f"metadata of more than {_LONGEST} characters", remedy="shorten it")
    return dict(found)


_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_ .+-]{0,30}")
_MOST = 100


def parse_poses(poses: str | Sequence[str]) -> tuple[str, ...]:
    """Return the poses of ``P1,P2,P3`` or of a sequence; `UsageError` for what is not a name."""
    names = [n.strip() for n in (poses.split(",") if isinstance(poses, str) else poses)]
    wrong = [name for name in names if not _NAME.fullmatch(name)]
    if wrong or len({name.casefold() for name in names}) < len(names):
        what = f"{wrong[0]!r} is not the name of a pose" if wrong else "a pose is named twice"
        raise UsageError(
            f"`pose={','.join(names)}`: {what}",
            remedy="name each pose of a cycle once, in their order: `pose=P1,P2,P3,P4,P5`",
        )
    if len(names) > _MOST:
        raise UsageError(f"{len(names)} poses, more than {_MOST}", remedy="record them in parts")
    return tuple(names)


_SETTLED = {
    "rest": "seconds that the dial must stand still, default 1",
    "within": "divisions between which it may flicker meanwhile, default 1",
    "away": "mm or degrees that it must have moved away before, default 0.5",
}


@dataclass(frozen=True, slots=True)
class Timer:
    """Every ``seconds`` [s], the first at once."""

    seconds: float

    def __str__(self) -> str:
        return f"timer:{self.seconds:g}"


@dataclass(frozen=True, slots=True)
class Settled:
    """The dial itself came to rest; the rule is that of `visits.AtRest`.

    ``rest`` [s] within ``within`` divisions, after it was more than ``away`` [mm or deg] from the
    visit before.
    """

    rest: float = 1.0
    within: float = 1.0
    away: float = 0.5

    def __str__(self) -> str:
        return f"settled?rest={self.rest:g}&within={self.within:g}&away={self.away:g}"


_LINES = ("socket://", LISTEN, "replay:")
"""Beginnings of the addresses that are triggers as they stand."""


@dataclass(frozen=True, slots=True)
class RobotLine:
    """The robot says when, on a line of its own: ``AT P3``."""

    address: str
    line: Port | None = field(default=None, compare=False, repr=False)
    """Where it is open already, and stays so for the next recording."""
    heard: deque[str] = field(default_factory=deque, compare=False, repr=False)
    """Lines that were said and not answered yet."""

    def __str__(self) -> str:
        return self.address if self.address.startswith(_LINES) else f"line:{self.address}"


Trigger: TypeAlias = Literal["enter", "data"] | Timer | Settled | RobotLine
"""``enter`` is a key of the operator, or a foot switch; ``data`` the indicator's DATA key."""


@dataclass(frozen=True, slots=True)
class RecordingPlan:
    """``stable`` equal readings in a row make a reading that was asked for.

    A reading that comes by itself, or a key pressed, within ``rearm_s`` [s] of the one before is
    not taken: a key that bounced or was held down, or an instrument that sent twice. Every one of
    ``cycles`` goes to the poses of ``tour``.
    """

    trigger: Trigger
    cycles: int = 31
    stable: int = 1
    rearm_s: float = 0.5
    tour: Tour = field(default_factory=Tour)

    @property
    def visits(self) -> int:
        """How many visits of a pose the whole test has."""
        return self.cycles * len(self.tour)


@dataclass(frozen=True, slots=True)
class Job:
    """What to record into ``table``; ``resume`` goes on with what is there.

    ``excel_locale`` spells the table for a spreadsheet; None goes on as before.
    """

    table: Path
    gauges: tuple[GaugeSpec, ...]
    plan: RecordingPlan
    metadata: Mapping[str, str] = field(default_factory=dict)
    resume: bool = False
    excel_locale: str | None = None
    program: str | None = None
    """What a robot's HELLO has to state; None where poses and cycles say it."""
    recorded: Mapping[str, int] = field(default_factory=dict)
    """Programs of which everything is on the disk, with the number of their cycles."""

    @property
    def all_count(self) -> bool:
        """Whether the head states that every cycle counts, or that it is a drift test."""
        stated = {key: str(self.metadata.get(key, "")).lower() for key in ("first_cycle", "test")}
        return stated["first_cycle"] == "counts" or stated["test"] == "drift"


_GAUGE = dict.fromkeys(("spec", "dialect", "line", "identity", "unit", "unit_from"), "")
_ROWS = 3


def refuse_unreadable(job: Job, columns: Iterable[str] = ()) -> None:
    """Raise `UsageError` in the reader's words where it would refuse the table of a job.

    A small one is written and read, with the job's head, its axes, and ``columns`` of a robot.
    """
    small, tour = History(str(job.table)), job.plan.tour
    gauges = {spec.axis: {**_GAUGE, "simulated": False} for spec in job.gauges}
    head = {"metadata": job.metadata, "poses": tour.poses, "trigger": "", "cycles": _ROWS}
    records = [{"event": "session", "schema": SCHEMA, "gauges": gauges, **head}]
    for visit in range(1, _ROWS * len(tour) + 1):
        for spec in job.gauges:
            unit = spec.unit or ("deg" if spec.axis == "theta" else "mm")
            shown = {"axis": spec.axis, "text": f"0.{visit:03}", "unit": unit, "at": visit}
            records.append({"event": "stored", **tour.state(visit), **shown})
        values = dict.fromkeys(columns, f"20.{visit}")
        records.append({"event": "covariates", **tour.state(visit), "values": values})
    for line, record in enumerate(records, 1):
        small.take(line, {"t": 0.0, "crc": "", **record})
    try:
        tables.read_table(tables.write_table(small.run()).encode("utf-8", "backslashreplace"))
    except DataError as error:
        what = "; ".join(fault.message for fault in error.faults) or error.what
        where = f"{job.table}, as it would be"
        raise UsageError(what, where=where, remedy=error.remedy) from error


_SHORTEST_TIMER_S = 0.001


def parse_trigger(text: str) -> Trigger:
    """Return the trigger that ``text`` spells.

    ``enter``, ``data``, ``timer:SECONDS``, ``settled`` with its options, ``socket://HOST:PORT``,
    ``listen://ADDRESS:PORT``, ``line:PORT``, or ``replay:FILE`` for the robot of a raw file.
    """
    if text.startswith((*_LINES, "line:")) and text != "line:":
        if text.startswith(LISTEN):
            listen_address(text)
        return RobotLine(text.removeprefix("line:"))
    if text.partition("?")[0] == "settled":
        return _settled(text)
    match text.split(":"):
        case ["enter"]:
            return "enter"
        case ["data"]:
            return "data"
        case ["timer", seconds] if _SHORTEST_TIMER_S <= (parse_number(seconds) or 0.0) <= 86400:
            return Timer(float(seconds))
    raise UsageError(
        f"unknown trigger {text!r}",
        remedy="use `trigger=enter`, `trigger=data`, `trigger=timer:SECONDS`, `trigger=settled`, "
        "or the robot's line: `trigger=listen://ADDRESS:PORT`, `trigger=socket://HOST:PORT`, "
        "`trigger=line:PORT`, or `trigger=replay:FILE`",
    )


def _settled(text: str) -> Settled:
    _, options = split_options(text, _SETTLED)
    values = {key: number_option(options, key, 0.0) for key in options}
    wrong = [key for key, value in values.items() if value <= 0]
    if wrong:
        raise UsageError(
            f"{text!r}: {wrong[0]} is not above zero",
            remedy=f"write a number above zero, as {wrong[0]}=1",
        )
    return Settled(**values)


BENCH_FILE = "bench.toml"
_HEAD = """\
# The indicators of this bench, for scara-iso record. Edit it freely.
# AXIS = "DRIVER?OPTIONS@PORT", as on the command line.
"""
_REMEDY = 'write a section [gauges] with lines such as X = "opto-rs232@/dev/ttyUSB0"'
_PLAIN = frozenset({"unit", "channel", "baud", "bits", "parity", "stop"})
"""Options that change nothing of what is sent to a port."""


@dataclass(frozen=True, slots=True)
class RememberedBench:
    """The gauges as ``AXIS=DRIVER@PORT``, and the trigger where one is remembered."""

    gauges: tuple[str, ...]
    trigger: str | None = None

    def reaches_out(self) -> tuple[str, ...]:
        """Return what does more than ask a device of this machine in its dialect's own words.

        Those are servers, and requests that the file spells: whoever wrote it chose them.
        """
        trigger = () if self.trigger is None else (self.trigger,)
        return tuple(gauge for gauge in self.gauges if _reaches_out(gauge)) + tuple(
            text for text in trigger if isinstance(parse_trigger(text), RobotLine)
        )


def read_bench(path: Path) -> RememberedBench:
    """Return what the file remembers; nothing in it is opened.

    Its sections ``[instrument.X]`` are those of a test.toml, and are not looked at here.
    Raises `NoInputError`, and `DataError` for an unknown key, a gauge that is not valid, or one
    that names a file.
    """
    try:
        bench = _remembered(read_toml(path))
        _check(bench)
    except UsageError as error:
        raise DataError(error.what, where=str(path), remedy=error.remedy) from error
    return bench


def _remembered(found: Mapping[str, object]) -> RememberedBench:
    gauges, trigger = found.get("gauges"), found.get("trigger")
    if unknown := sorted(set(found) - {"gauges", "trigger", "instrument"}):
        remedy = "leave it out, or say it as an option of record"
        raise UsageError(f"unknown: {', '.join(unknown)}", remedy=remedy)
    if not isinstance(gauges, dict) or not isinstance(trigger, str | None):
        raise UsageError("holds something other than gauges and a trigger", remedy=_REMEDY)
    wrong = [axis for axis, text in gauges.items() if not isinstance(text, str)]
    if wrong or not gauges:
        raise UsageError(f"{wrong[0]} is not text" if wrong else "no gauges", remedy=_REMEDY)
    return RememberedBench(tuple(f"{axis}={text}" for axis, text in gauges.items()), trigger)


def write_bench(path: Path, bench: RememberedBench) -> None:
    """Put gauges and trigger into the file, all else kept as it is; raises as `write_file`.

    `DataError` where what is there is no TOML.
    """
    import tomlkit  # noqa: PLC0415 - only where a bench is written

    _check(bench)
    there = is_file(path) and read_toml(path)
    text = read_file(path, 1 << 20).decode("utf-8-sig") if there else _HEAD
    document: Any = tomlkit.parse(text)
    if bench.trigger is None:
        document.pop("trigger", None)
    else:
        document["trigger"] = bench.trigger
    gauges = document.setdefault("gauges", tomlkit.table())
    named = {axis.strip(): rest for axis, _, rest in (one.partition("=") for one in bench.gauges)}
    for axis in gauges.keys() - named.keys():
        del gauges[axis]
    gauges.update(named)
    write_file(path, tomlkit.dumps(document).encode())


def _check(bench: RememberedBench) -> None:
    """Raise `UsageError` for what is not a gauge or trigger, or names a file."""
    if not all(text.isprintable() for text in (*bench.gauges, bench.trigger or "")):
        raise UsageError("characters that no port's name has", remedy=_REMEDY)
    named = [gauge.replace(f"={AUTO}", "=opto-rs232", 1) for gauge in bench.gauges]
    for spec in parse_gauges(named):
        check_address(spec.address)
        kind = port_kind(spec.address)
        if kind == "replay" or (kind == "sim" and "model" in unquote(spec.address)):
            raise UsageError(
                f"{spec.address}: {BENCH_FILE} names no files",
                remedy=f"give it as `gauge={spec.text}`",
            )
    if bench.trigger is not None:
        trigger = parse_trigger(bench.trigger)
        if isinstance(trigger, RobotLine) and not trigger.address.startswith(LISTEN):
            check_address(trigger.address)
            if port_kind(trigger.address) == "replay":
                raise UsageError(f"{trigger}: {BENCH_FILE} names no files", remedy=_REMEDY)


def _reaches_out(gauge: str) -> bool:
    driver, _, address = gauge.partition("=")[2].partition("@")
    head, mark, tail = driver.partition("?")
    names = {pair.partition("=")[0] for pair in tail.split("&")} if mark else set()
    return "://" in address or head.strip() == AUTO or not names <= _PLAIN
