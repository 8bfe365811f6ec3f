"""What a table states: the fields of a report, what else was read of it, and what was not used.

The fields are from its ``# key: value`` lines. ISO/IEC 17025:2017, 7.8.2.1: laboratory, customer,
item, method, dates, who is answerable; the conditions are those of ISO 9283 clause 6. What nobody
stated is named in one line.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

from scara_iso.base.quantities import Dimension
from scara_iso.iso9283 import Cycles
from scara_iso.reporting.shared.blocks import Columns, Facts, Report, Section, Table, Text
from scara_iso.reporting.shared.digits import NOT_STATED, Cell, Number
from scara_iso.run import Run, TableField
from scara_iso.tables import length_in_mm, names_a_limit, quoted_whole

METHOD = (
    "ISO 9283:1998, 7.2.1 and 7.2.2; RP of one axis and of the plane also by Mousavi et al., "
    "Repeatability Analysis of a SCARA Robot with Planetary Gearbox, eq. 2-6 and 23"
)

_PEOPLE: Mapping[str, tuple[str, ...]] = {
    "laboratory": ("laboratory", "lab"),
    "address": ("laboratory_address", "address"),
    "place of the test": ("location", "place", "site"),
    "customer": ("customer", "client"),
    "customer's contact": ("customer_contact", "customer_address", "contact"),
    "external providers": ("external_provider", "external_providers", "subcontractor"),
}
_ITEM: Mapping[str, tuple[str, ...]] = {
    "item": ("robot", "item"),
    "serial number": ("serial_number", "robot_serial_number"),
    "condition of the item": ("item_condition", "condition"),
    "item received": ("date_received", "received"),
    "sampling": ("sampling", "sampling_plan"),
    "date of the test": ("date", "test_date", "recorded", "started", "日期"),
    "date of issue": ("date_issued", "issued"),
    "operator": ("operator", "technician"),
    "authorized by": ("authorized_by", "approved_by"),
}
_RATED_VELOCITY = ("rated_velocity", "rated_speed", "rated_velocity_mm_s", "rated_speed_mm_s")
_CONDITIONS: Mapping[str, tuple[str, ...]] = {
    "ambient temperature": ("temperature", "temperature_c", "ambient_temperature"),
    "humidity": ("humidity", "humidity_percent", "relative_humidity"),
    "payload": ("payload", "load", "payload_kg", "load_kg", "payload_percent", "load_percent"),
    "rated load": ("rated_payload", "rated_load", "rated_payload_kg", "rated_load_kg"),
    "velocity": ("velocity", "speed", "velocity_mm_s", "speed_mm_s", "velocity_percent"),
    "rated velocity": _RATED_VELOCITY,
    "dwell": ("dwell", "dwell_s", "dwell_time", "dwell_time_s"),
}
_INSTRUMENT: Mapping[str, tuple[str, ...]] = {
    "instrument": ("indicator", "instrument", "dial"),
    "instrument's serial number": ("indicator_serial_number", "indicator_serial"),
    "calibration date": ("calibration_date", "calibrated"),
    "calibration due": ("calibration_due", "calibration_valid_until", "next_calibration"),
    "calibration certificate": ("calibration_certificate", "certificate", "calibration"),
}
FIELDS: Mapping[str, tuple[str, ...]] = {
    "report number": ("report_number", "report"),
    "method": ("method",),
    **_PEOPLE,
    **_ITEM,
    **_CONDITIONS,
    **_INSTRUMENT,
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
_AT_A_GLANCE = ("velocity", "payload", "ambient temperature")
_ACTED_ON = """
    ambient_temperature_c approached_from axes_recorded characteristics covariates
    cycles_planned dial_zero doubts first_cycle first_cycle_discarded instrument_of_the_test
    last_row other_tests_missing part parts_missing parts_struck pose settling_time
    settling_time_s simulated
    stream visit_rule
    stabilisation_time stabilisation_time_s stabilization_time stabilization_time_s
    temperature_limits temperature_limits_c test theta_radius_mm timestamp_start visits_per_block
    warm_up warm_up_min warm_up_time
"""
"""Keys beside `FIELDS` on which a figure, a check or a command acts."""
_OF_THE_PROGRAM = ("command_", "commanded_pose", "corrected_", "record_", "stream_")
_NAMED_ALONE = {"reference", "source", "title"}
_A_SENTENCE = 2
"""Words of a value that is quoted: it may say something of the readings."""
_OF_A_POSE = re.compile(r"(\w+)\[(.+)\]")
_IN_CYCLES = ("first_cycle_discarded", "first_cycle")
_REMARK = re.compile(r"record_\d+_(struck|changed|resumed|note)")


def head(run: Run, cycles: Cycles) -> Facts:
    """Return all that is stated: every field, then what else the table states."""
    rows = [(name, stated_field(run, name) or NOT_STATED) for name in FIELDS]
    others = ((_words(key), text) for key, text in _others(run))
    return Facts((*rows, *_dials(run), ("cycles", _counted(cycles)), *others))


def parties(run: Run) -> tuple[Facts, Facts]:
    """Return who tested for whom, and what was tested, when, by whom, and how."""
    item = _facts(run, _ITEM, "Item and test")
    checks = "; ".join(f"{name} {text}" for name, text in _facts(run, _AT_A_GLANCE, "").rows)
    rows = (*item.rows, *([("conditions", checks)] if checks else []))
    return _facts(run, _PEOPLE, "Laboratory and customer"), replace(item, rows=rows)


def conditions(run: Run, cycles: Cycles) -> tuple[Facts, Facts]:
    """Return the conditions and the instruments, as far as they are stated."""
    checks, used = _facts(run, _CONDITIONS, "Conditions"), _facts(run, _INSTRUMENT, "Instruments")
    others = [
        (_words(key), text)
        for key, text in _others(run)
        if not _REMARK.fullmatch(key) and key not in _IN_CYCLES
    ]
    rows = (*checks.rows, ("cycles", _counted(cycles)), *others)
    return replace(checks, rows=rows), replace(used, rows=(*used.rows, *_dials(run)))


def stated_field(run: Run, name: str) -> str:
    """Return what is stated of a field of `FIELDS`, at some poses too; empty where nothing is."""
    stated, keys = _by_key(run), FIELDS[name]
    found = [stated[key] for key in keys if key in stated]
    of_poses = ((_OF_A_POSE.fullmatch(key), text) for key, text in stated.items())
    found += [f"{of[2].upper()}: {text}" for of, text in of_poses if of and of[1] in keys]
    if name == "method":
        return "; ".join([METHOD, *found])
    if measured := [column for column in run.covariates if column.lower() in keys]:
        values = run.covariates[measured[0]]
        found.append(f"{values.min():g} .. {values.max():g} ({measured[0]}, by cycle)")
    return "; ".join(dict.fromkeys(found))


def not_stated(run: Run) -> list[str]:
    """Return the fields that nobody stated, but for those that matter only sometimes."""
    return [name for name in FIELDS if name not in WHERE_IT_APPLIES and not stated_field(run, name)]


def left_unused(run: Run, limits: Iterable[float] = ()) -> tuple[str, ...]:
    """Return a line for what is stated, and one for each other thing that was not used.

    The fields of the report are printed on it; so is what is named here. A size is quoted: it may
    be a limit, and is one of the ``limits`` [mm] that figures are held against.
    """
    used = {key for key, _, size in stated_limits(run) if is_one_of(limits, size)}
    unused = {_words(key): text for key, text in _unused(run).items() if key not in used}
    sizes = [f"{name} {text}" for name, text in unused.items() if length_in_mm(text) is not None]
    named = [
        f"{name} {quoted_whole(text)}" if len(text.split()) >= _A_SENTENCE else name
        for name, text in unused.items()
        if length_in_mm(text) is None
    ]
    stated = [f"stated and not used: {', '.join(named)}"] if named else []
    if sizes:
        stated.insert(0, f"stated and not used, nor a limit: {', '.join(sizes)}")
    return (*stated, *run.origin.notes)


def is_one_of(limits: Iterable[float], size: float) -> bool:
    """Say whether a size is one of the limits, but for the rounding of units."""
    return any(math.isclose(size, limit) for limit in limits)


def stated_limits(run: Run) -> Iterator[tuple[str, str, float]]:
    """Yield each limit that the table states: its key, its words and its size [mm]."""
    for key, text in _unused(run).items():
        size = length_in_mm(bare := text.rpartition("=")[2]) or length_in_mm(f"{bare} mm")
        if size and names_a_limit(key):
            yield key, f"{_words(key)} {text}", size


def _unused(run: Run) -> dict[str, str]:
    known = _NAMED_ALONE.union(_ACTED_ON.split())
    others = {key.partition("[")[0]: text for key, text in _others(run)}
    return {
        key: text
        for key, text in sorted(others.items())
        if key not in known and not key.startswith(_OF_THE_PROGRAM)
    }


def remarks(run: Run) -> tuple[tuple[str, str], ...]:
    """Return what the recording says was struck, changed or noted: kind and text, in order."""
    found = ((_REMARK.fullmatch(key), text) for key, text in sorted(_by_key(run).items()))
    return tuple((match[1], text) for match, text in found if match)


def _by_key(run: Run) -> dict[str, str]:
    return {key.lower(): text for key, text in run.metadata.items() if text.strip()}


def _others(run: Run) -> list[tuple[str, str]]:
    used = {key for keys in FIELDS.values() for key in keys}
    return [(key, text) for key, text in _by_key(run).items() if key.partition("[")[0] not in used]


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
    return f"{text}; cycle {cycles.discarded[0]} is discarded" if cycles.discarded else text


def _dials(run: Run) -> Iterator[tuple[str, str]]:
    for axis in run.axes.values():
        parts = (("resolution", axis.resolution), ("standard uncertainty", axis.uncertainty))
        lines = [f"{k} {NOT_STATED if v is None else f'{v:g} {axis.unit}'}" for k, v in parts]
        kind = "an angle" if axis.dimension is Dimension.ANGLE else "a length"
        yield f"indicator of {axis.name}", f"{', '.join(lines)}; {kind} in {axis.unit}"


def table_report(run: Run) -> Report:
    """Return what was understood of the table, or of the tables, that ``run`` was read from."""
    origin = run.origin
    stated = [
        (f"{key}_{name}", f"{size:g} {axis.unit}")
        for name, axis in run.axes.items()
        for key, size in (
            ("resolution", axis.resolution),
            ("indicator_uncertainty", axis.uncertainty),
        )
        if size
    ]
    header = f", by the header of {origin.row_name} {origin.header_line}"
    left_out = left_unused(run) or ("nothing: every row under the header is a reading",)
    return (
        Section("", (Text(f"read: {origin.source}", "strong"), Text(origin.understood))),
        Section("stated in the file", (Facts((*stated, *run.metadata.items())),)),
        Section(f"fields{header if origin.header_line else ''}", (_fields(run),)),
        Section("left out, and remarks", tuple(map(Text, left_out))),
    )


def _fields(run: Run) -> Table:
    row = run.origin.row_name
    lines = "" if run.lines is None else f" ({row} {run.lines[0]}, {row} {run.lines[-1]})"
    columns: Columns[tuple[int, TableField]] = {
        "field": lambda one: str(one[0]),
        "header": lambda one: one[1].header or "(none)",
        "taken for": lambda one: (
            f"{one[1].kind} {one[1].name}"
            if one[1].name and one[1].kind != "covariate"
            else one[1].kind
        ),
        "in": lambda one: one[1].unit,
        "first": lambda one: _reading(one[1], run, 0),
        "last": lambda one: _reading(one[1], run, -1),
    }
    note = f"first and last row{lines}: readings in mm, or degrees"
    return Table.of(enumerate(run.origin.fields, start=1), columns, note)


def _reading(one: TableField, run: Run, k: int) -> Cell:
    if one.kind == "axis":
        return Number(float(run.axes[one.name].readings[k]), ".9g")
    labels = {"cycle": run.cycle, "pose": run.pose, "direction of approach": run.direction}
    found = labels.get(one.kind, run.covariates.get(one.name))
    return "" if found is None else str(found[k])
