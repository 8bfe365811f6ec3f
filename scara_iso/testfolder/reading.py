"""test.toml to a `WholeTest`; each key that is not known, or not of its kind, is a fault."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar, get_type_hints

from scara_iso.base.errors import DataError, NoInputError
from scara_iso.base.files import KeyFaults, is_file, read_toml, section
from scara_iso.base.quantities import Dimension
from scara_iso.iso9283 import DecisionRule
from scara_iso.run import AXES
from scara_iso.testfolder.keys import POSE_NAME, Reader, limit_of, reader_of, word_of
from scara_iso.testfolder.place import FILE
from scara_iso.testfolder.whole_test import (
    DISCARDED,
    PUSH,
    SECTIONS,
    SECTIONS_OF,
    DriftTest,
    Instrument,
    PushTest,
    Struck,
    WholeTest,
)

EVERY_LENGTH = "every_length"
_Section = TypeVar("_Section")
_LIMITS = {"decision": word_of(*(rule.value for rule in DecisionRule))}
_KNOWN = sorted({*SECTIONS, *SECTIONS_OF, "drift", "limits", "push", "struck"})


def read_test(folder: Path) -> WholeTest:
    """Return what the test.toml of a folder says.

    Raises `NoInputError` where there is none and `DataError` with every fault, each named by its
    key.
    """
    path = folder / FILE
    if not is_file(path):
        raise NoInputError(
            f"is not the folder of a test: it has no {FILE}",
            where=str(folder),
            remedy=f"make it one: scara-iso test new {folder} `model=MODEL.toml`",
        )
    faults = KeyFaults()
    found = parse_test(read_toml(path), faults)
    _refuse(faults, path, f"is not a test: {len(faults)} fault{'s' if len(faults) > 1 else ''}")
    return found


def read_instruments(path: Path) -> dict[str, Instrument]:
    """Return the sections ``[instrument.X]`` of a TOML file by axis, none where it has none.

    Raises as `read_test`.
    """
    faults = KeyFaults()
    found = _named(Instrument, read_toml(path), "instrument", faults)
    _check_instruments(found, faults)
    _refuse(faults, path, "[instrument] cannot be taken")
    return found


def _refuse(faults: KeyFaults, path: Path, what: str) -> None:
    if faults:
        raise DataError(what, where=str(path), remedy="correct these keys", faults=faults)


def parse_test(document: Mapping[str, Any], faults: KeyFaults) -> WholeTest:
    """Return what a document says; what is wrong with it goes to ``faults``."""
    for key in sorted(document.keys() - set(_KNOWN)):
        faults.add(key, f"no such section; known are {', '.join(_KNOWN)}")
    values: dict[str, Any] = {
        field: _build(kind, section(document, key, faults), key, faults)
        for key, (field, kind) in SECTIONS.items()
    }
    for key, (field, kind) in SECTIONS_OF.items():
        values[field] = _named(kind, document, key, faults)
    if "drift" in document:
        values["drift"] = _build(DriftTest, section(document, "drift", faults), "drift", faults)
    limits = _read(
        section(document, "limits", faults),
        lambda key: _LIMITS.get(key, limit_of),
        "limits",
        faults,
    )
    if "decision" in limits:
        values["decision"] = limits.pop("decision")
    test = WholeTest(
        **values,
        limits={"" if key == EVERY_LENGTH else key: one for key, one in limits.items()},
        pushes=dict(_pushes(document, faults)),
        struck=tuple(_struck(document.get("struck", []), faults)),
    )
    _check_together(test, faults)
    return test


def _build(
    kind: Callable[..., _Section], table: Mapping[str, Any], where: str, faults: KeyFaults
) -> _Section:
    """Return a section of its dataclass; keys that are wrong keep their defaults."""
    hints = get_type_hints(kind, include_extras=True)
    for key in (key for key in table if key not in hints):
        faults.add(f"{where}.{key}", f"no such key; known are {', '.join(hints)}")
    known = {key: value for key, value in table.items() if key in hints}
    return kind(**_read(known, lambda key: reader_of(hints[key]), where, faults))


def _read(
    table: Mapping[str, Any], reader: Callable[[str], Reader], where: str, faults: KeyFaults
) -> dict[str, Any]:
    """Return what the keys of a section hold; one that is wrong is left out."""
    values = {}
    for key, value in table.items():
        try:
            values[key] = reader(key)(value)
        except ValueError as error:
            faults.add(f"{where}.{key}", f"{repr(value)[:40]} is {error}")
    return values


def _named(
    kind: Callable[..., _Section], document: Mapping[str, Any], key: str, faults: KeyFaults
) -> dict[str, _Section]:
    found = {}
    table = section(document, key, faults)
    for name in table:
        where = f"{key}.{name}"
        if key == "instrument" and name not in AXES:
            faults.add(where, f"no such axis: {', '.join(AXES)}")
        elif not POSE_NAME.fullmatch(name):
            faults.add(where, "is named by letters and digits, such as P1")
        else:
            found[name] = _build(kind, section(table, name, faults), where, faults)
    return found


def _pushes(document: Mapping[str, Any], faults: KeyFaults) -> Iterator[tuple[str, PushTest]]:
    """Yield the push tests by the names of their parts: of ``[push]``, or of ``[push.joint_1]``."""
    table = section(document, PUSH, faults)
    if table and all(isinstance(value, dict) for key, value in table.items() if key != "limits"):
        found = _named(PushTest, document, PUSH, faults)
        yield from ((f"{PUSH}-{name}", one) for name, one in found.items())
    elif PUSH in document:
        yield PUSH, _build(PushTest, table, PUSH, faults)


def _struck(entries: object, faults: KeyFaults) -> Iterator[Struck]:
    if not isinstance(entries, list):
        faults.add("struck", "write each one as [[struck]]")
        return
    for number, entry in enumerate(entries, 1):
        where = f"struck {number}"
        if not isinstance(entry, dict) or {"recording", "reason"} - set(entry):
            faults.add(where, "give recording and reason")
        else:
            yield _build(Struck, {"recording": "", "reason": "", **entry}, where, faults)


def _check_together(test: WholeTest, faults: KeyFaults) -> None:
    if not test.poses:
        faults.add("pose", "missing: one section for each pose, such as [pose.P1]")
    for where, values in (("velocities", test.schedule.velocities), ("loads", test.schedule.loads)):
        if not values or len(set(values)) < len(values):
            faults.add(f"test.{where}", "give one or more, each once")
    _check_instruments(test.instruments, faults)
    if test.drift is not None and test.drift.pose not in test.poses:
        faults.add("drift.pose", f"no such pose: {', '.join(test.poses)}")
    if test.schedule.first_cycle == DISCARDED and test.schedule.cycles < 3:
        faults.add("test.cycles", "two or more have to count beside the first")


def _check_instruments(instruments: Mapping[str, Instrument], faults: KeyFaults) -> None:
    for axis, instrument in instruments.items():
        for said in instrument.corrects.faults(Dimension.LENGTH):  # of theta: as it is read
            faults.add(f"instrument.{axis}", said)
