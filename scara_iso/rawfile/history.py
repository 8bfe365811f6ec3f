"""What a raw file says was recorded: the readings of each axis, what was struck out and noted.

The table of every recording is made here, after a clean end as after a crash.
"""

from __future__ import annotations

import re
from collections import Counter, deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from decimal import Decimal
from itertools import count
from pathlib import Path
from typing import NamedTuple

import numpy as np

from scara_iso.base.errors import DataError, Fault
from scara_iso.base.quantities import Dimension, find_unit, parse_number
from scara_iso.rawfile.integrity import FIRST, SCHEMA, Record, read_records
from scara_iso.rawfile.records import LineDoubts, Timeline, Tour, sizes_of_axis
from scara_iso.run import SEPARATOR, Axis, Origin, Run

VOIDABLE = 100
"""How many readings back an operator may void."""


class ShownReading(NamedTuple):
    """A stored reading: in mm or degrees, and as the indicator showed it with its unit."""

    value: float
    text: str
    unit: str


class AxisReadings:
    """Readings of one axis by visit."""

    def __init__(self, dialect: str = "") -> None:
        self.dialect = dialect
        self.shown: dict[int, ShownReading] = {}
        """In the order in which they came."""
        self.dimension: Dimension | None = None

    def put(self, visit: int, text: str, unit: str) -> None:
        """Take a reading; `ValueError` says what is wrong with it."""
        size = find_unit(unit)
        if size is None:
            raise ValueError(f"unknown unit {unit!r}")
        if self.dimension not in (None, size.dimension):
            raise ValueError(f"{unit} after {self.dimension.value}")
        if parse_number(text) is None:
            raise ValueError(f"{text[:40]!r} is not a reading")
        if visit in self.shown:
            raise ValueError("stored twice")
        self.shown[visit] = ShownReading(size.read(text), text, unit)
        self.dimension = size.dimension

    @property
    def resolution(self) -> float:
        """The coarsest that is shown: never states more than every reading holds [mm or deg]."""
        texts = [one.text for one in self.shown.values()]
        if self.dialect == "keyboard" and all("." in t and t.endswith("0") for t in texts):
            return 0.0  # a 0 that is typed behind every reading is no division
        formats = {(len(one.text.partition(".")[2]), one.unit) for one in self.shown.values()}
        units = ((find_unit(unit), Decimal(1).scaleb(-places)) for places, unit in formats)
        return max((unit.to_base(float(count)) for unit, count in units if unit), default=0.0)

    @property
    def unit(self) -> str | None:
        """What the indicator showed last."""
        return next(reversed(self.shown.values())).unit if self.shown else None

    def axis(self, name: str, visits: Iterable[int], metadata: Mapping[str, str]) -> Axis:
        """Return the readings of ``visits``, with what ``metadata`` states of the axis."""
        dimension = self.dimension or Dimension.LENGTH
        values = np.array([self.shown[visit].value for visit in visits])
        sizes = sizes_of_axis(metadata, name, dimension)
        return Axis(name, values, dimension, self.resolution or None, *sizes)


_MOST = 99
"""Remarks that are written out; of those beyond only the number is stated."""
_SHOWN = 10
_CHANNEL = re.compile(r"[?&]channel=([^&@]*)")
_SEED = re.compile(r"&seed=[^&\s]*|(?<=\?)seed=[^&\s]*&?")
_DAMAGED = (ValueError, KeyError, TypeError, ArithmeticError, AttributeError)
"""What a record raises whose values are of another kind or size."""
THEN = ", then "
"""Between the identities of one axis' gauges, in a header of several sessions."""
_GAUGE_KEYS = ("spec", "dialect", "line", "identity", "unit", "unit_from", "simulated")
_MAX_CYCLES = 10_000_000


class History:
    """The readings, what the sessions' headers say, and the troubles of one raw file."""

    def __init__(self, source: str) -> None:
        self.source = source
        self.header: Record = {}
        self.first_header: Record = {}
        """As it stands in the file, without what later sessions say."""
        self.tour = Tour()
        self.columns: dict[str, AxisReadings] = {}
        self.times: dict[int, float] = {}
        """Of the latest reading of each visit, since the first session began [s]."""
        self.covariates: dict[str, dict[int, float]] = {}
        """What a robot stated of each visit, by name."""
        self.troubles: Counter[str] = Counter()
        self.latest: deque[tuple[int, str]] = deque(maxlen=VOIDABLE)
        self.damaged: list[int] = []
        self.faults: list[Fault] = []
        self.timeline = Timeline()
        self._remarks: list[tuple[str, str]] = []
        """Struck readings with their reasons, notes, changes and where it was resumed, in order."""
        self._is_resumed = False
        """Whether no reading was stored yet since another session began."""
        self._gauges: dict[str, str] = {}
        self._read_by: dict[str, str] = {}
        """The gauge of each axis: that of the latest session, and that of the latest reading."""
        self._line = LineDoubts()
        self.pauses: list[int] = []  # how many cycles were complete at each
        self.previous = FIRST
        """Checksum of the last whole line."""
        self.has_table = False
        """Whether the last session that ended in good order left a table, and so a manifest."""
        self._chained = False
        self._broken: list[int] = []
        self._harmed: list[int] = []
        """Behind the last line, where that was changed: no next one names it."""
        self._inherited: list[str] = []

    def take(self, line: int, record: Record | None) -> None:
        """Take the next line of the file."""
        self._harmed = [line + 1] if record == {} else []
        if not record:
            self.damaged.append(line)
            return
        if not self._follows(line, record):
            self._broken.append(line)
        self.previous, self._chained = record["crc"], "prev" in record
        try:
            self.timeline.at(record)
            self._take(record)
        except _DAMAGED as error:
            self.faults.append(Fault(f"{record.get('event')}: {error}", line))

    def _follows(self, line: int, record: Record) -> bool:
        """Say whether nothing was changed before a line: it names the whole one that is there.

        Lines of older versions name none; a crash tears only what stands before a new session.
        """
        if "prev" in record or self._chained:
            return bool(record.get("prev") == self.previous)
        return self.damaged[-1:] != [line - 1] or record["event"] == "session"

    @property
    def doubts(self) -> tuple[str, ...]:
        """What is known to have been changed after it was recorded, a line each."""
        name = Path(self.source).name
        broken = [*self._broken, *self._harmed]
        places = ", ".join(map(str, broken[:_SHOWN])) + (", .." if len(broken) > _SHOWN else "")
        found = [f"{name}: lines were changed or taken away before line {places}"] if places else []
        return tuple(dict.fromkeys((*self._inherited, *found)))

    def inherit(self, doubts: Iterable[str]) -> None:
        """Take what was found beside the file: it goes on into all that is made of it."""
        self._inherited += doubts

    def _take(self, record: Record) -> None:
        self._line.take(record)
        self._take_remark(record)
        match record:
            case {"event": "session"}:
                self._begin(record)
            case {"event": "stored", "cycle": int(cycle)}:
                self._put(self._visit(cycle, record), record)
            case {"event": "covariates", "cycle": int(cycle)}:
                self._put_covariates(self._visit(cycle, record), record["values"])
            case {"event": "void", "cycle": int(cycle), "axes": [*axes]}:
                visit = self.tour.visit(cycle, record.get("pose"))
                self.strike(visit, axes)
                self.pauses = [min(before, cycle - 1) for before in self.pauses]
            case {"event": "continued"}:
                self.pauses.append(self.cycles)
            case {"event": "end"}:
                self.has_table = bool(self.complete_visits())
            case {"event": "fault" | "garbage" | "timeout" | "refused" as event}:
                self.troubles[event] += 1

    def _take_remark(self, record: Record) -> None:
        match record:
            case {"event": "void", "cycle": int(cycle), "axes": [*axes], "reason": str(reason)}:
                visit = self.tour.visit(cycle, record.get("pose"))
                texts = (f"{axis} {self.columns[axis].shown[visit].text}" for axis in sorted(axes))
                struck = f"{self.tour.name(visit)}, {', '.join(texts)}: {reason}"
                self._remarks.append(("struck", struck))
            case {"event": "note", "text": str(text)}:
                self._remarks.append(("note", text))
            case {"event": "changed", "axis": str(axis), "message": str(message)}:
                self._remarks.append(("changed", f"{axis}: {message}"))

    def _visit(self, cycle: int, record: Record) -> int:
        if not 0 < cycle <= _MAX_CYCLES // len(self.tour):
            raise ValueError(f"cycle {cycle}")
        return self.tour.visit(cycle, record.get("pose"))

    def _put_covariates(self, visit: int, values: Mapping[str, str]) -> None:
        """Take what was stated of a visit, in place of what was stated of it before."""
        numbers = {name: parse_number(text) for name, text in values.items()}
        stated = {name: value for name, value in numbers.items() if value is not None}
        if wrong := numbers.keys() - stated.keys():
            raise ValueError(f"{min(wrong)} is not a number")
        for column in self.covariates.values():
            column.pop(visit, None)
        for name, value in stated.items():
            self.covariates.setdefault(name, {})[visit] = value

    def _put(self, visit: int, record: Record) -> None:
        axis = str(record["axis"])
        self.columns[axis].put(visit, record["text"], record["unit"])
        if self._is_resumed:
            self._remarks.append(("resumed", f"before {self.tour.name(visit)}"))
            self._is_resumed = False
        before, now = self._read_by.get(axis), self._gauges[axis]
        if before not in (None, now):
            self._remarks.append(("changed", f"{axis} was read by {before}, then by {now}"))
        self._read_by[axis] = now
        self.times[visit] = self.timeline.start + record["at"]
        self.latest.append((visit, axis))

    def strike(self, visit: int, axes: Iterable[str]) -> None:
        """Take readings of a visit out of the table."""
        for axis in axes:
            self.columns[axis].shown.pop(visit, None)
            self.latest.remove((visit, axis))
            self.troubles["voided"] += 1

    def _begin(self, record: Record) -> None:
        if record["schema"] != SCHEMA:
            raise ValueError(f"schema {record['schema']!r} is not {SCHEMA}")
        _check_header(record)
        self._inherited += map(str, record.get("doubts", ()))
        if not self.header:
            each = record["gauges"].items()
            self.columns = {
                str(axis): AxisReadings(str(gauge.get("dialect", ""))) for axis, gauge in each
            }
            self.tour = Tour(tuple(map(str, record.get("poses", ()))))
            self.first_header = record
        else:
            self._remarks += [("changed", text) for text in _stated_anew(self.header, record)]
        self._gauges |= {str(axis): _gauge(gauge) for axis, gauge in record["gauges"].items()}
        self._is_resumed = self.header != {}
        self.header = _merged(self.header, record) if self.header else record

    @property
    def visit(self) -> int:
        """The first visit that is not complete, from 1."""
        done = set(self.complete_visits())
        return next(visit for visit in count(1) if visit not in done)

    def present(self, visit: int) -> frozenset[str]:
        """Return the axes that have a reading of the visit."""
        return frozenset(axis for axis, column in self.columns.items() if visit in column.shown)

    def complete_visits(self) -> list[int]:
        """Return the visits of which every axis has a reading, in their order."""
        each = [column.shown.keys() for column in self.columns.values()]
        return sorted(set(each[0]).intersection(*each)) if each else []

    @property
    def is_complete(self) -> bool:
        """Whether as many cycles are complete as the last session planned."""
        return len(self.complete_visits()) == int(self.header["cycles"]) * len(self.tour)

    @property
    def cycles(self) -> int:
        """How many cycles are complete at every pose."""
        return len(self.complete_visits()) // len(self.tour)

    def readings(self) -> dict[str, dict[int, float]]:
        """Return the readings by axis and visit [mm or deg]."""
        return {
            axis: {visit: column.shown[visit].value for visit in sorted(column.shown)}
            for axis, column in self.columns.items()
        }

    def check(self) -> None:
        """Raise `DataError` where the file is not a recording, or contradicts itself."""
        if not self.header and not self.faults:
            copied = "no line is whole: were its line ends changed, in a copy made as text?"
            self.faults.append(Fault(copied if self.damaged else "no session was recorded", 1))
        if self.faults:
            raise DataError(
                "is not a recording that a table can be made of",
                where=self.source,
                remedy="the file was changed after it was recorded; look at these lines",
                faults=self.faults[:_SHOWN],
            )

    def run(self) -> Run:
        """Return the complete visits; raises as `check` does."""
        self.check()
        visits = self.complete_visits()
        if not visits:
            raise DataError(
                "no cycle is complete",
                where=self.source,
                remedy="continue the recording until every gauge has a whole cycle",
            )
        times = np.array([self.times[visit] for visit in visits])
        counted = "visits" if self.tour.poses else "cycles"
        turn, place = np.divmod(np.array(visits) - 1, len(self.tour))
        return Run(
            cycle=turn + 1,
            pose=np.array(self.tour.poses)[place] if self.tour.poses else None,
            axes={
                name: column.axis(name, visits, self.header["metadata"])
                for name, column in self.columns.items()
            },
            covariates={
                "time_s": np.round(times, 3),
                **{
                    name: np.array([column[visit] for visit in visits])
                    for name, column in self.covariates.items()
                    if column.keys() >= set(visits)
                },
            },
            metadata=self._metadata(visits),
            origin=Origin(source=self.source, understood=f"{len(visits)} {counted} recorded"),
        )

    def _gaps(self, visits: Sequence[int]) -> Iterator[str]:
        """Yield the covariates that are not stated of every visit: a table has no such column."""
        for name, column in self.covariates.items():
            if (stated := len(column.keys() & set(visits))) < len(visits):
                yield f"{name} in {stated} of {len(visits)} visits"

    def _metadata(self, visits: Sequence[int]) -> dict[str, str]:
        """Return the table's head; what there is nothing to say of is left out."""
        wall, gauges = self.header.get("wall"), self.header["gauges"]
        before = {
            "doubts": SEPARATOR.join(self.doubts),
            "recorded": f"{str(wall)[:19]}Z" if wall else "",
        }
        more = len(self._remarks) - _MOST
        after = {
            "first_cycle_discarded": "false",
            "axes_recorded": "together" * (len(gauges) > 1),
            "indicator": " | ".join(f"{axis} {_indicator(g)}" for axis, g in gauges.items()),
            "simulated": " ".join(axis for axis, gauge in gauges.items() if gauge["simulated"]),
            "cycles_planned": "" if self.is_complete else str(self.header["cycles"]),
            "record_clock": "; ".join(self.timeline.jumps),
            "record_columns_with_gaps": SEPARATOR.join(self._gaps(visits)),
            **dict(self._line.metadata()),
            **{
                f"record_{k + 1:02d}_{kind}": x for k, (kind, x) in enumerate(self._remarks[:_MOST])
            },
            "record_more_remarks": str(more) if more > 0 else "",
            **{f"record_{kind}": str(n) for kind, n in sorted(self.troubles.items())},
        }
        own = {str(key): str(text) for key, text in self.header["metadata"].items()}
        known = {key: text for key, text in before.items() if text}
        return known | own | {key: text for key, text in after.items() if text}


def read_history(path: Path) -> History:
    """Read a raw file; `NoInputError` where that is not possible. Damaged lines are noted."""
    history = History(str(path))
    for line, record in read_records(path):
        history.take(line, record)
    return history


def _check_header(record: Record) -> None:
    """Raise one of the errors of a record that lacks what the table needs."""
    _ = int(record["cycles"]), dict(record["metadata"]), str(record["trigger"])
    for gauge in record["gauges"].values():
        _ = [gauge[key] for key in _GAUGE_KEYS]


def _merged(first: Record, later: Record) -> Record:
    gauges = {axis: dict(gauge) for axis, gauge in first["gauges"].items()}
    for axis, gauge in later["gauges"].items():
        known = gauges.setdefault(axis, dict(gauge))
        if gauge["identity"] not in known["identity"].split(THEN):
            known["identity"] += THEN + gauge["identity"]
        known["simulated"] |= gauge["simulated"]
    metadata = first["metadata"] | later["metadata"]
    locale = later.get("excel_locale") or first.get("excel_locale")
    same = {**first, "cycles": later["cycles"], "excel_locale": locale}
    return {**same, "metadata": metadata, "gauges": gauges}


def _stated_anew(header: Record, later: Record) -> Iterator[str]:
    """Yield what a later session states in place of what was stated before."""
    before, now = header["metadata"], later["metadata"]
    for key in sorted(before.keys() & now.keys()):
        if before[key] != now[key]:
            yield f"{key}: {now[key]}, stated before as {before[key]}"
    if header["cycles"] != later["cycles"]:
        yield f"planned: {later['cycles']} cycles, before {header['cycles']}"


def _indicator(gauge: Record) -> str:
    unit = f"; {gauge['unit']} as {gauge['unit_from']} states" if gauge["unit"] else ""
    return f"{gauge['dialect']} {gauge['line']} at {_identity(gauge)}{unit}"


def _gauge(gauge: Record) -> str:
    """Return what tells a gauge from another: driver, channel and port."""
    channel = _CHANNEL.search(gauge["spec"])
    of_channel = f" channel {channel[1]}" if channel else ""
    return f"{gauge['dialect']}{of_channel} at {_identity(gauge)}"


def _identity(gauge: Record) -> str:
    if not gauge["simulated"]:
        return str(gauge["identity"])
    plain = _SEED.sub("", gauge["identity"]).replace("sim:? ", "sim: ")  # a seed is no identity
    return THEN.join(dict.fromkeys(plain.split(THEN)))
