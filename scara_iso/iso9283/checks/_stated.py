"""Conditions in a table's ``key: value`` lines, read strictly: an unclear one is not a quantity."""

import re
from collections.abc import Collection, Iterator, Mapping
from datetime import date, datetime
from pathlib import PurePath
from typing import NamedTuple

import numpy as np

from scara_iso.base.moments import in_iso
from scara_iso.iso9283.core.results import Finding, Findings
from scara_iso.run import SEPARATOR, Run
from scara_iso.tables import in_english

Units = Mapping[str, float]
"""Spellings of a unit and its size in the first of them."""

PERCENT = {"%": 1.0, "% of rated": 1.0, "percent": 1.0}
MASS = {"kg": 1.0, "g": 1e-3}
SPEED = {"mm/s": 1.0, "m/s": 1000.0}
SECONDS = {"s": 1.0, "sec": 1.0, "ms": 1e-3, "min": 60.0}
CELSIUS = {"c": 1.0, "°c": 1.0, "degc": 1.0}
LOAD = {"payload", "load", "payload_kg", "load_kg", "payload_percent", "load_percent"}
VELOCITY = {"velocity", "speed", "velocity_mm_s", "speed_mm_s", "velocity_percent"}
TEST_DATES = {"date", "test_date", "recorded", "started", "timestamp_start", "日期"}

_NUMBER = r"[+-]?\d+(?:\.\d+|,\d{1,2}(?!\d))?"  # 2,0 is a decimal comma, 1,500 may be either
_PLAIN = re.compile(rf"({_NUMBER})\s*(\D*)")
_OF_A_POSE = re.compile(r"([^:;]{1,40}): (.+)")
_BRACKETED = re.compile(r"(.*?)\s*\(([^()]*)\)")
_ABOUT = re.compile(rf"({_NUMBER})\s*(?:±|\+/-)\s*({_NUMBER})\s*(\D*)")
_BETWEEN = re.compile(rf"({_NUMBER})\s*(?:\.\.|to|-)\s*({_NUMBER})\s*(\D*)")
_DAY_IN_NAME = re.compile(r"(?<![0-9])[0-9]{4}-[0-9]{2}-[0-9]{2}(?![0-9])")
_SHOWN = 30
_HELD = "ISO 9283 6.2, 6.3: conditions are held constant"
_OFTEN = 3  # times that each value of a setting is there
_EXACT = 1.0  # per cent: weights are stated in two digits, controllers are set in whole ones


class Stated(NamedTuple):
    """A line that states a condition."""

    key: str
    text: str

    def __str__(self) -> str:
        """Return the line as it may be quoted."""
        return f"{self.key} {self.text if len(self.text) <= _SHOWN else self.text[:_SHOWN] + '…'}"

    def value(self, units: Units) -> float | None:
        """Return the number in the first of ``units``; None where it is not clearly one.

        The unit stands behind the number or at the end of the key (``payload_kg``). Of
        ``2 kg (100 % of rated)`` each part may be asked for.
        """
        bracketed = _BRACKETED.fullmatch(self.text)
        for part in bracketed.groups() if bracketed else (self.text,):
            found = _PLAIN.fullmatch(part.strip().lower())
            if found and (size := self._size(found[2], units)) is not None:
                return _float(found[1]) * size
        return None

    def ends(self, units: Units) -> tuple[float, float] | None:
        """Return the least and the largest value of ``18 .. 22 C``, ``20 ± 2 C`` or ``20 C``."""
        for pattern in (_ABOUT, _BETWEEN):
            found = pattern.fullmatch(self.text.lower())
            if found and (size := self._size(found[3], units)) is not None:
                a, b = _float(found[1]) * size, _float(found[2]) * size
                low, high = (a - b, a + b) if pattern is _ABOUT else (a, b)
                return (low, high) if low <= high else None
        single = self.value(units)
        return None if single is None else (single, single)

    def day(self) -> date | None:
        """Return the day of what `parse_moment` reads."""
        moment = parse_moment(self.text)
        return None if moment is None else moment.date()

    def unclear(self, code: str, kind: str, example: str) -> Finding:
        """Return a warning that this is no time, mass or the like, and how to write one."""
        what = f"{self}: no {kind} that can be compared"
        return Finding(code, "warning", what, advice=f"write {example}")

    def _size(self, unit: str, units: Units) -> float | None:
        spelled = unit.strip()
        if not spelled:
            key = self.key.lower().partition("[")[0]
            spelled = next((name for name in units if key.endswith(_of_key(name))), "")
        return units.get(spelled)


class ShareOfRated(NamedTuple):
    """A condition that the standard wants at a share of the rated one; see `other_load`."""

    code: str
    name: str
    keys: Collection[str]
    """Of the lines that state it."""
    rated: Collection[str]
    """Of the line that states the rated one."""
    columns: Collection[str]
    units: Units
    shares: Collection[float]
    """Per cent of the rated one that are the standard's."""
    rule: str
    is_no: str
    """What an unclear line does not state."""
    example: str

    def findings(self, run: Run) -> Findings:
        """Yield a warning for another share, and for a column that changes during the test."""
        full_line = first(run, self.rated)
        full = None if full_line is None else full_line.value(self.units)
        unclear = [] if full_line is None or full else [full_line]
        for line in stated(run.metadata, self.keys):
            yield from self._other_share(line, full)
            if line.value(self.units) is None and line.value(PERCENT) is None:
                unclear.append(line)
        for name, values in run.covariates.items():
            plain = name.partition(" [")[0].partition(" (")[0].lower()
            in_unit = name.rstrip("]) ").endswith(tuple(u for u in self.units if "/" in u))
            setting = in_unit and _OFTEN * len({*values}) <= len(values)  # no other thing is in it
            if not setting and {*self.columns}.isdisjoint([name, *in_english({plain: plain})]):
                continue
            if np.ptp(values) > 0:
                said = f"{name} goes from {values.min():g} to {values.max():g} during the test"
                yield Finding(self.code, "warning", said, advice="a table for each", rule=_HELD)
            else:
                yield from self._other_share(Stated(name, f"{values[0]:g}"), full)
        yield from (line.unclear(self.code, self.is_no, self.example) for line in unclear)

    def _other_share(self, line: Stated, full: float | None) -> Findings:
        """Yield a warning for another share: by the size where both are known, else as stated."""
        size, share = line.value(self.units), line.value(PERCENT)
        if size is not None and full:
            share = 100 * size / full
        if share is not None and all(abs(share - one) > _EXACT for one in self.shares):
            said = f"{line} is {share:.3g} % of the rated {self.name}"
            yield Finding(self.code, "warning", said, rule=self.rule)


def parse_moment(text: str) -> datetime | None:
    """Return ``2026-05-12``, or as clear a date, also with a time, as local time; else None."""
    try:
        return datetime.fromisoformat(in_iso(text.strip())).replace(tzinfo=None)
    except ValueError:
        return None


def stated(head: Mapping[str, str], keys: Collection[str]) -> Iterator[Stated]:
    """Yield the lines of a table's head that have one of the keys and say something.

    A key may be that of one pose, ``temperature[P3]``; so is each part of a text that is stated by
    pose, ``P1: 20 C; P2: 26 C``.
    """
    for key, text in head.items():
        if key.strip().lower().partition("[")[0] in keys and is_said(text):
            parts = [_OF_A_POSE.fullmatch(part) for part in text.strip().split("; ")]
            named = [part for part in parts if part is not None]
            if len(named) == len(parts):
                yield from (Stated(f"{key}[{part[1]}]", part[2]) for part in named)
            else:
                yield Stated(key, text.strip())


def is_said(text: str) -> bool:
    """Return whether a line says something: neither nothing nor that it is not stated."""
    return text.strip().lower() not in ("", "not stated")


def first(run: Run, keys: Collection[str]) -> Stated | None:
    """Return the first of those lines."""
    return next(stated(run.metadata, keys), None)


def noted(run: Run, key: str) -> Iterator[str]:
    """Yield each of the remarks that recorder or test folder left under a key."""
    lines = run.metadata.get(key, "").split(SEPARATOR)
    yield from (line.strip() for line in lines if line.strip())


def noted_of_axes(run: Run, key: str) -> Iterator[tuple[str, str]]:
    """Yield the axis of each of these remarks, and what is said of it."""
    for line in noted(run, key):
        axis, colon, said = line.partition(": ")
        if colon:
            yield axis.strip(), said.strip()


def moment_of_test(run: Run) -> datetime | None:
    """Return date (and time, where it is stated) of a test.

    From ``# date`` and the like, or the first of a column `timestamp`; None where neither is there
    or it is no date.
    """
    line = first(run, TEST_DATES)
    return None if line is None else parse_moment(line.text)


def zoned_moment_of_test(run: Run) -> datetime | None:
    """Return the same with its time zone, None where none is stated."""
    line = first(run, TEST_DATES)
    try:
        found = None if line is None else datetime.fromisoformat(line.text.strip())
    except ValueError:
        return None
    return found if found is not None and found.tzinfo is not None else None


def moment_in_name(run: Run) -> datetime | None:
    """Return the one day that the name of a table's file spells, where the table states none."""
    return None if first(run, TEST_DATES) is not None else day_in_name(run.origin.source)


def day_in_name(path: str) -> datetime | None:
    """Return the one day that the name of a file spells; None for none, or for several."""
    found = set(_DAY_IN_NAME.findall(PurePath(path).name))
    return parse_moment(found.pop()) if len(found) == 1 else None


def _of_key(unit: str) -> str:
    return "_" + {"%": "percent", "mm/s": "mm_s", "m/s": "m_s"}.get(unit, unit)


def _float(text: str) -> float:
    return float(text.replace(",", "."))
