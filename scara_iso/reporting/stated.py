"""The fields that a test report has to state, from the ``# key: value`` lines of the table.

ISO/IEC 17025:2017, 7.8.2.1: laboratory, customer, item, method, dates, who is answerable; the
conditions are those of ISO 9283 clause 6. What nobody stated is named in one line.

How a report came to be, so that it can be made again.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated

from scara_iso.base.quantities import Dimension
from scara_iso.iso9283 import Cycles
from scara_iso.reporting.blocks import NOT_STATED, Block, Facts, Text
from scara_iso.run import Origin, Run


@dataclass(frozen=True, slots=True)
class InputFile:
    """A file that the report was made of, and the SHA-256 of its bytes in hex."""

    role: str
    """What it is to the report, such as ``table`` or ``model``."""
    name: str
    """Path or name of the file."""
    sha256: Annotated[str, ("pattern", "^[0-9a-f]{64}$")]
    """SHA-256 of its bytes, in hex."""


@dataclass(frozen=True, slots=True)
class Restated:
    """What was stated for the report and not in the table; ``before`` is what it overrides."""

    key: str
    """Name of the field."""
    text: str
    """What it was given."""
    before: str | None
    """What the table stated; null for nothing."""

    def __str__(self) -> str:
        instead = "" if self.before is None else f" (in place of {self.before})"
        return f"{self.key}: {self.text}{instead}"


@dataclass(frozen=True, slots=True)
class Provenance:
    """Files, program and command of a report, and what was stated for it alone."""

    files: tuple[InputFile, ...]
    """What the report was made of."""
    version: str
    """Of this program."""
    command: str
    """The call that made the report."""
    restated: tuple[Restated, ...] = ()
    """Fields that the call stated or overrode."""


def provenance(made: Provenance, origin: Origin) -> Iterator[Block]:
    """Yield what a report is made from, and how its table was understood."""
    rows = [
        row
        for file in made.files
        for row in ((file.role, file.name), (f"SHA-256 of the {file.role}", file.sha256))
    ]
    rows += [("program", f"scara-iso {made.version}"), ("command", made.command)]
    rows += [("stated for the report", str(one)) for one in made.restated]
    if origin.understood:
        rows.append(("the table was read as", origin.understood))
    yield Facts(tuple(rows))
    yield from (Text(note, "quiet") for note in origin.notes)


METHOD = (
    "ISO 9283:1998, 7.2.1 and 7.2.2; RP of one axis and of the plane also by Mousavi et al., "
    "Repeatability Analysis of a SCARA Robot with Planetary Gearbox, eq. 2-6 and 23"
)

FIELDS: Mapping[str, tuple[str, ...]] = {
    "report number": ("report_number", "report"),
    "laboratory": ("laboratory", "lab"),
    "address": ("laboratory_address", "address"),
    "place of the test": ("location", "place", "site"),
    "customer": ("customer", "client"),
    "customer's contact": ("customer_contact", "customer_address", "contact"),
    "item": ("robot", "item"),
    "serial number": ("serial_number", "robot_serial_number"),
    "method": ("method",),
    "condition of the item": ("item_condition", "condition"),
    "item received": ("date_received", "received"),
    "date of the test": ("date", "test_date", "recorded", "started"),
    "date of issue": ("date_issued", "issued"),
    "sampling": ("sampling", "sampling_plan"),
    "external providers": ("external_provider", "external_providers", "subcontractor"),
    "operator": ("operator", "technician"),
    "authorized by": ("authorized_by", "approved_by"),
    "ambient temperature": ("temperature", "temperature_c", "ambient_temperature"),
    "humidity": ("humidity", "humidity_percent", "relative_humidity"),
    "payload": ("payload", "load", "payload_kg", "load_kg", "payload_percent", "load_percent"),
    "rated load": ("rated_payload", "rated_load", "rated_payload_kg", "rated_load_kg"),
    "velocity": ("velocity", "speed", "velocity_mm_s", "speed_mm_s", "velocity_percent"),
    "rated velocity": (
        "rated_velocity",
        "rated_speed",
        "rated_velocity_mm_s",
        "rated_speed_mm_s",
    ),
    "dwell": ("dwell", "dwell_s", "dwell_time", "dwell_time_s"),
    "instrument": ("indicator", "instrument", "dial"),
    "instrument's serial number": ("indicator_serial_number", "indicator_serial"),
    "calibration date": ("calibration_date", "calibrated"),
    "calibration due": ("calibration_due", "calibration_valid_until", "next_calibration"),
    "calibration certificate": ("calibration_certificate", "certificate", "calibration"),
}
"""Each field and the keys that may state it, the first of them found taken."""


WHERE_IT_APPLIES = {
    "condition of the item",
    "item received",
    "sampling",
    "external providers",
    "method",
}
"""Fields that 17025 asks for only where they matter: not missed where nobody stated them."""

_PEOPLE = (
    "laboratory",
    "address",
    "place of the test",
    "customer",
    "customer's contact",
    "external providers",
)
_ITEM = (
    "item",
    "serial number",
    "condition of the item",
    "item received",
    "sampling",
    "date of the test",
    "date of issue",
    "operator",
    "authorized by",
)
_AT_A_GLANCE = ("velocity", "payload", "ambient temperature")
_CONDITIONS = (
    "ambient temperature",
    "humidity",
    "payload",
    "rated load",
    "velocity",
    "rated velocity",
    "dwell",
)
_INSTRUMENT = (
    "instrument",
    "instrument's serial number",
    "calibration date",
    "calibration due",
    "calibration certificate",
)
_ACTED_ON = """
    ambient_temperature_c approached_from axes_recorded characteristics covariates
    cycles_planned dial_zero doubts first_cycle first_cycle_discarded instrument_of_the_test
    last_row part parts_missing parts_struck pose settling_time settling_time_s simulated
    stabilisation_time stabilisation_time_s stabilization_time stabilization_time_s
    temperature_limits temperature_limits_c test theta_radius_mm timestamp_start visits_per_block
    warm_up warm_up_min warm_up_time
"""
"""Keys beside `FIELDS` on which a figure, a check or a command acts."""
_OF_THE_PROGRAM = ("command_", "corrected_", "record_", "stream_")
_REMARKS = {"comment", "note", "notes", "reference", "remark", "remarks", "source", "title"}
_OF_A_POSE = re.compile(r"(\w+)\[(.+)\]")
_IN_CYCLES = ("first_cycle_discarded", "first_cycle")
_REMARK = re.compile(r"record_\d+_(struck|changed|note)")


def head(run: Run, cycles: Cycles) -> Facts:
    """Return all that is stated: every field, then what else the table states."""
    stated = _by_key(run)
    rows = [(name, _stated(name, stated, run)) for name in FIELDS]
    others = ((_words(key), text) for key, text in _others(stated))
    return Facts((*rows, *_dials(run), ("cycles", _counted(cycles)), *others))


def parties(run: Run) -> tuple[Facts, Facts]:
    """Return who tested for whom, and what was tested, when, by whom, and how."""
    item = _facts(run, _ITEM, "Item and test")
    checks = "; ".join(f"{name} {text}" for name, text in _facts(run, _AT_A_GLANCE, "").rows)
    rows = (*item.rows, *([("conditions", checks)] if checks else []))
    return _facts(run, _PEOPLE, "Laboratory and customer"), replace(item, rows=rows)


def conditions(run: Run, cycles: Cycles) -> tuple[Facts, Facts]:
    """Return the conditions and the instruments, as far as they are stated."""
    checks = _facts(run, _CONDITIONS, "Conditions")
    others = [
        (key, text)
        for key, text in _others(_by_key(run))
        if not _REMARK.fullmatch(key) and key not in _IN_CYCLES
    ]
    parts = (*checks.rows, ("cycles", _counted(cycles)), *((_words(k), v) for k, v in others))
    used = _facts(run, _INSTRUMENT, "Instruments")
    return replace(checks, rows=parts), replace(used, rows=(*used.rows, *_dials(run)))


def method(run: Run) -> str:
    """Return the method, and what the table adds to it."""
    return _stated("method", _by_key(run), run)


def stated_field(run: Run, name: str) -> str:
    """Return what is stated of a field of `FIELDS`; empty where nothing is."""
    text = _stated(name, _by_key(run), run)
    return "" if text == NOT_STATED else text


def not_stated(run: Run) -> list[str]:
    """Return the fields that nobody stated, but for those that matter only sometimes."""
    return [name for name in FIELDS if name not in WHERE_IT_APPLIES and not stated_field(run, name)]


def not_used(run: Run) -> str | None:
    """Return the line that names what the table states and nothing acts on; None if there is none.

    The fields of the report are printed on it; so is what is named here.
    """
    known = _REMARKS.union(_ACTED_ON.split())
    keys = {key.partition("[")[0] for key, _ in _others(_by_key(run))} - known
    named = sorted(_words(key) for key in keys if not key.startswith(_OF_THE_PROGRAM))
    return f"stated and not used: {', '.join(named)}" if named else None


def remarks(run: Run) -> tuple[tuple[str, str], ...]:
    """Return what the recording says was struck, changed or noted: kind and text, in order."""
    found = ((_REMARK.fullmatch(key), text) for key, text in sorted(_by_key(run).items()))
    return tuple((match[1], text) for match, text in found if match)


def _by_key(run: Run) -> dict[str, str]:
    return {key.lower(): text for key, text in run.metadata.items() if text.strip()}


def _others(stated: Mapping[str, str]) -> list[tuple[str, str]]:
    used = {key for keys in FIELDS.values() for key in keys}
    return [(key, text) for key, text in stated.items() if key.partition("[")[0] not in used]


def _of_poses(keys: Sequence[str], stated: Mapping[str, str]) -> list[str]:
    """Return what only some poses state, or each in its own way: ``key[p1]``."""
    found = ((_OF_A_POSE.fullmatch(key), text) for key, text in stated.items())
    return [f"{m[2].upper()}: {text}" for m, text in found if m and m[1] in keys]


def _facts(run: Run, names: Iterable[str], heading: str) -> Facts:
    return Facts(
        tuple((name, text) for name in names if (text := stated_field(run, name))), heading
    )


def _words(key: str) -> str:
    name, _, pose = key.removesuffix("]").partition("[")
    return f"{name.replace('_', ' ')}{f' at {pose.upper()}' if pose else ''}"


def _counted(cycles: Cycles) -> str:
    text = f"{cycles.read} read at each pose, {cycles.used} of them count"
    if cycles.all_count:
        return f"{text}; none was discarded"
    extra = cycles.discarded[0] if cycles.discarded else None
    return f"{text}; the extra cycle {extra} is discarded" if extra is not None else text


def _stated(name: str, stated: Mapping[str, str], run: Run) -> str:
    found = [stated[key] for key in FIELDS[name] if key in stated]
    found += _of_poses(FIELDS[name], stated)
    measured = [column for column in run.covariates if column.lower() in FIELDS[name]]
    if name == "method":
        return "; ".join([METHOD, *found])
    if measured:
        values = run.covariates[measured[0]]
        found.append(f"{values.min():g} .. {values.max():g} ({measured[0]}, by cycle)")
    return "; ".join(dict.fromkeys(found)) or NOT_STATED


def _dials(run: Run) -> Iterator[tuple[str, str]]:
    for axis in run.axes.values():
        parts = (("resolution", axis.resolution), ("standard uncertainty", axis.uncertainty))
        lines = [f"{k} {NOT_STATED if v is None else f'{v:g} {axis.unit}'}" for k, v in parts]
        kind = "an angle" if axis.dimension is Dimension.ANGLE else "a length"
        yield f"indicator of {axis.name}", f"{', '.join(lines)}; {kind} in {axis.unit}"
