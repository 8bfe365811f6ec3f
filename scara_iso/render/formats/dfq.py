"""Readings in AQDEF, the Q-DAS ASCII transfer format: what quality systems of plants take in.

A characteristic for each pose and axis, or for each dial of a gauge study; a line for each cycle
or reading, with value (K0001), attribute (K0002), date (K0004) and, in a study of parts, part
(K0006) and operator (K0008). The fields as the transfer format V12 and its tables of contents name
them. Written in Windows-1252, which is what its readers take a file for; in UTF-8 with its mark
where a name has other letters.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence, Set
from datetime import datetime, timedelta

import numpy as np

from scara_iso.base.errors import UsageError
from scara_iso.gauge import AxisStudy, Crossed, GaugeStudy, TypeOne
from scara_iso.iso9283 import Analysis
from scara_iso.reporting import Document, Dossier, printable, stated_field
from scara_iso.run import Axis, Run

_VALID, _NOT_COUNTED, _NO_VALUE = 0, 255, 256
"""K0002: 255 is not evaluated, 256 is no reading at all."""
_FIELD, _CHARACTERISTIC = "\x14", "\x0f"
_STUDIES = {"type-1": 1, "type-2": 2, "type-3": 3, "stability": 93, "linearity": 94}
"""K2202."""
_STUDY_OF_GAUGE = 30
"""K1015: analysis of a measuring system."""
_LONGEST = 255

_Keys = Mapping[str, str | float | int | None]
_Value = Sequence[str]
"""The fields of one value, K0001, K0002, K0004 and so on; trailing ones may be left out."""


def render(document: Document) -> bytes:
    """Return the readings of a test or of a gauge study; `UsageError` for anything else."""
    match document.source:
        case Dossier():
            lines = list(_test(document.source.analysis))
        case GaugeStudy():
            lines = list(_study(document.source))
        case _:
            raise UsageError(
                f"{document.title}: only a test or a gauge study is written as AQDEF",
                remedy="let the name end in .html, .md or .csv",
            )
    text = "".join(f"{line}\r\n" for line in lines)
    try:
        return text.encode("cp1252")
    except UnicodeEncodeError:
        return text.encode("utf-8-sig")


def _test(analysis: Analysis) -> Iterator[str]:
    run = analysis.run
    poses = list(run.rows_by_pose())
    named = [(label, axis) for label, _ in poses for axis in run.axes.values()]
    item = stated_field(run, "item")
    yield f"K0100 {len(named)}"
    number = stated_field(run, "serial number") or item or "robot"
    yield from _keys({"K1001": number, "K1002": item or "robot"})
    for k, (label, axis) in enumerate(named, 1):
        name = axis.name if label is None else f"{label} {axis.name}"
        yield from _keys(_characteristic(k, name, axis.unit, axis.resolution), k)
        if run.dial_zero_is_command:
            yield from _keys({"K2101": run.command_of(axis.name, label)}, k)
    counted = {row for pose in analysis.poses for row in pose.rows.tolist()}
    for visit in range(max(len(rows) for _, rows in poses)):
        rows = [int(rows[visit]) if visit < len(rows) else None for _, rows in poses]
        yield _line(
            [_of_row(run, axis, row, counted) for row in rows for axis in run.axes.values()]
        )


def _of_row(run: Run, axis: Axis, row: int | None, counted: Set[int]) -> _Value:
    if row is None:
        return ("0", str(_NO_VALUE))
    date = ""
    if "time_s" in run.covariates and "timestamp_start" in run.metadata:
        seconds = float(run.covariates["time_s"][row])
        date = _date(run.metadata["timestamp_start"], seconds)
    attribute = _VALID if row in counted else _NOT_COUNTED
    return (_number(float(axis.readings[row])), str(attribute), date)


def _study(found: GaugeStudy) -> Iterator[str]:
    stated = found.statements
    yield f"K0100 {len(found.axes)}"
    name = stated.get("indicator") or "dial"
    number = stated.get("indicator_serial_number") or stated.get("indicator_serial") or name
    yield from _keys({"K1001": number, "K1002": name, "K1015": _STUDY_OF_GAUGE})
    studies = list(found.axes.values())
    for k, study in enumerate(studies, 1):
        dial = study.readings
        yield from _keys(_characteristic(k, dial.axis, dial.unit, dial.resolution), k)
        yield from _keys(_of_study(study), k)
    operators = list(dict.fromkeys(studies[0].readings.operator or ()))
    for k, name in enumerate(operators, 1):
        yield from _keys({"K4092": k, "K4093": name}, k)
    for row in range(len(studies[0].readings.values)):
        yield _line([_of_reading(study, row, operators) for study in studies])


def _of_study(study: AxisStudy) -> _Keys:
    """Return what describes a study; the tolerance lies evenly about the reference.

    A study knows its width only, and that of a type 1 study is to have the part at its middle.
    """
    figures, dial, width = study.figures, study.readings, study.tolerance
    found: dict[str, str | float | int | None] = {"K2202": _STUDIES[study.kind.value]}
    alike = dial.reference is not None and np.ptp(dial.reference) == 0
    middle = float(dial.reference[0]) if alike and dial.reference is not None else None
    if middle is not None:
        found |= {"K2101": middle, "K2213": middle}
    if width is not None:
        centre = middle or 0.0
        found |= {"K2110": centre - width / 2, "K2111": centre + width / 2}
    if isinstance(figures, TypeOne):
        found |= {"K2221": figures.n, "K2225": figures.Cg, "K2226": figures.Cgk}
    elif isinstance(figures, Crossed):
        found |= {"K2205": len(figures.parts), "K2220": max(len(figures.operators), 1)}
        found |= {"K2221": figures.trials}
    return found


def _of_reading(study: AxisStudy, row: int, operators: Sequence[str]) -> _Value:
    dial = study.readings
    date = _date(dial.time[row]) if dial.time else ""
    value = (_number(float(dial.values[row])), str(_VALID), date)
    part = (dial.part or dial.session or ("",) * (row + 1))[row]
    operator = str(operators.index(dial.operator[row]) + 1) if dial.operator else ""
    if not part and not operator:
        return value
    return (*value, "", _text(part), "0", operator or "0")


def _characteristic(k: int, name: str, unit: str, resolution: float | None) -> _Keys:
    return {"K2001": k, "K2002": name, "K2004": 0, "K2142": unit, "K2404": resolution}


def _keys(fields: _Keys, of: int | None = None) -> Iterator[str]:
    behind = "" if of is None else f"/{of}"
    for key, value in fields.items():
        if value is not None and value != "":
            text = _number(value) if isinstance(value, float) else _text(str(value))
            yield f"{key}{behind} {text}"


def _line(values: Sequence[_Value]) -> str:
    return _CHARACTERISTIC.join(_FIELD.join(value).rstrip(_FIELD) for value in values)


def _number(value: float) -> str:
    return str(np.format_float_positional(value, trim="-"))


def _text(text: str) -> str:
    """Return text on one line; no letter of a file is a separator in it."""
    return printable(text)[:_LONGEST]


def _date(time: str, seconds: float = 0.0) -> str:
    """Return day.month.year/time of an ISO 8601 time; nothing where the table has another."""
    try:
        at = datetime.fromisoformat(time) + timedelta(seconds=seconds)
    except (ValueError, OverflowError):
        return ""
    return at.strftime("%d.%m.%Y/%H:%M:%S")
