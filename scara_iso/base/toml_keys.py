"""The values of a TOML file by key, every fault named by its key."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from scara_iso.base.errors import Fault


class KeyFaults(list[Fault]):
    """Faults of one file, each named by its key."""

    def add(self, key: str, message: str) -> None:
        """Add a fault."""
        self.append(Fault(f"{key}: {message}"))


def section(document: Mapping[str, Any], key: str, faults: KeyFaults) -> dict[str, Any]:
    """Return the section ``key``, empty where it is missing or none."""
    found = document.get(key, {})
    if isinstance(found, dict):
        return found
    faults.add(key, "is not a section")
    return {}


def number_at(table: Mapping[str, Any], key: str, where: str, faults: KeyFaults) -> float | None:
    """Return a number; None where it is missing or none."""
    value = table.get(key)
    if value is None:
        return None
    if not is_number(value):
        faults.add(f"{where}.{key}", f"{repr(value)[:40]} is not a finite number")
        return None
    return float(value)


def pair(table: Mapping[str, Any], key: str, where: str, faults: KeyFaults) -> tuple[float, float]:
    """Return a list of two numbers, zeros for what is none."""
    value = table[key]
    if isinstance(value, list) and len(value) == 2:
        both = [number_at({key: part}, key, where, faults) for part in value]
        return (both[0] or 0.0, both[1] or 0.0)
    faults.add(f"{where}.{key}", f"{repr(value)[:40]} is not a pair of numbers")
    return (0.0, 0.0)


def only(table: Mapping[str, Any], known: set[str], where: str, faults: KeyFaults) -> None:
    """Add a fault for each key that is not known."""
    for key in table:
        if key not in known:
            faults.add(f"{where}.{key}", f"no such key; known are {', '.join(sorted(known))}")


def is_number(value: object) -> bool:
    """Return whether a value is a finite number that a float holds."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) < 1e300
