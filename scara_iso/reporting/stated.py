"""The fields that a test report has to state, from the ``# key: value`` lines of the table.

ISO/IEC 17025:2017, 7.8.2.1: laboratory, customer, item, method, dates, who is answerable; the
conditions are those of ISO 9283 clause 6. What nobody stated is printed as such.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from scara_iso.iso9283 import Cycles
from scara_iso.quantities import Dimension
from scara_iso.reporting.blocks import Table
from scara_iso.run import Run

NOT_STATED = "not stated"
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
    "item": ("robot", "item"),
    "serial number": ("serial_number", "robot_serial_number"),
    "method": ("method",),
    "condition of the item": ("item_condition", "condition"),
    "item received": ("date_received", "received"),
    "date of the test": ("date", "test_date", "recorded", "started"),
    "date of issue": ("date_issued", "issued"),
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


def head(run: Run, cycles: Cycles) -> Table:
    """Return the head of a report: every field, then what else the table states."""
    stated = {key.lower(): text for key, text in run.metadata.items() if text.strip()}
    rows = [(name, _stated(name, stated, run)) for name in FIELDS]
    used = {key for keys in FIELDS.values() for key in keys}
    rows += [(axis, said) for axis, said in _dials(run)]
    rows.append(("cycles", _counted(cycles)))
    rows += [(key.replace("_", " "), text) for key, text in stated.items() if key not in used]
    return Table(("field", "stated"), tuple(rows), verbatim=True)


def _counted(cycles: Cycles) -> str:
    said = f"{cycles.read} read at each pose, {cycles.used} of them count"
    if cycles.all_count:
        return f"{said}; none was discarded"
    extra = cycles.discarded[0] if cycles.discarded else None
    return f"{said}; the extra cycle {extra} is discarded" if extra is not None else said


def _stated(name: str, stated: Mapping[str, str], run: Run) -> str:
    found = [stated[key] for key in FIELDS[name] if key in stated]
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
        said = [f"{k} {NOT_STATED if v is None else f'{v:g} {axis.unit}'}" for k, v in parts]
        kind = "an angle" if axis.dimension is Dimension.ANGLE else "a length"
        yield f"indicator of {axis.name}", f"{', '.join(said)}; {kind} in {axis.unit}"
