"""The parameters of a user's own effect: a range and the values to try in it, or one value."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from scara_iso.base.toml_keys import KeyFaults, is_number, only
from scara_iso.effects._parameter import Grid
from scara_iso.effects._units import Unit, unit_in
from scara_iso.run import FloatArray

_COUNTS = {1: 24, 2: 9, 3: 5}
"""Values that are tried of each parameter, by how many have a range: neighbouring courses are
alike, and the likeliest is refined between them."""
_TOO_MANY = 1000
_WIDE, _FINER = 3.0, 9


@dataclass(frozen=True, slots=True)
class Given:
    """One parameter; with a range of no width it is a constant of the formula."""

    low: float
    high: float
    step: float | None
    unit: Unit
    meaning: str

    @property
    def searched(self) -> bool:
        """Whether it has a range."""
        return self.low < self.high

    def count(self, others: int) -> int:
        """Return how many values are tried where so many ranges without a step share the forms."""
        if self.step is not None:
            return int((self.high - self.low) / self.step * (1 + 1e-9)) + 1
        return _COUNTS.get(others, _TOO_MANY)

    def grid(self, count: int) -> Grid:
        """Return the values to try: in a constant ratio over a wide positive range."""
        if self.step is not None:
            return Grid.exact(self.low + self.step * np.arange(count))
        wide = self.low > 0 and self.high / self.low > _WIDE
        values = (np.geomspace if wide else np.linspace)(self.low, self.high, count)

        def near(value: float) -> FloatArray:
            i = int(np.argmin(np.abs(values - value)))
            ends = values[max(i - 1, 0)], values[min(i + 1, count - 1)]
            return np.asarray(np.linspace(*ends, 2 * _FINER + 1)[1:-1])

        return Grid(values.tolist(), near=near)


def given_parameters(
    table: Mapping[str, Any], where: str, taken: Collection[str], faults: KeyFaults
) -> dict[str, Given]:
    """Return the parameters of a table, without those that are wrong, which go to ``faults``.

    ``taken`` are names that mean something else.
    """
    found = {}
    for name, entry in table.items():
        place, before = f"{where}.{name}", len(faults)
        if name in taken or not name.isidentifier():
            faults.add(place, "has another meaning; call the parameter otherwise")
        if not isinstance(entry, dict):
            faults.add(place, "give { from = .., to = .., unit = .. } or { value = .., unit = .. }")
            continue
        unit = _checked(entry, place, faults)
        if unit is not None and len(faults) == before:
            ends = ("value", "value") if "value" in entry else ("from", "to")
            low, high = (float(entry[key]) for key in ends)
            step = entry.get("step")
            found[name] = Given(
                low,
                high,
                None if step is None else float(step),
                unit,
                entry.get("meaning", ""),
            )
    return found


def _checked(entry: Mapping[str, Any], where: str, faults: KeyFaults) -> Unit | None:
    """Return the unit of a parameter; what is wrong with it goes to ``faults``."""
    numbers = ["value"] if "value" in entry else ["from", "to"]
    steps = [] if "value" in entry else ["step"]
    only(entry, {*numbers, *steps, "unit", "meaning"}, where, faults)
    texts = {key: entry.get(key, "") for key in ("unit", "meaning")}
    unit = unit_in(texts["unit"]) if isinstance(texts["unit"], str) else None
    wrong = [key for key in numbers if not is_number(entry.get(key))]
    for key in wrong:
        faults.add(f"{where}.{key}", "give a finite number")
    if unit is None:
        faults.add(f"{where}.unit", 'is no unit such as "s", "1/°C" or "kg*m^2"')
    if not isinstance(texts["meaning"], str):
        faults.add(f"{where}.meaning", "is no text")
    if not wrong and "value" not in entry:
        _check_range(entry, where, faults)
    return unit


def _check_range(entry: Mapping[str, Any], where: str, faults: KeyFaults) -> None:
    width, step = entry["to"] - entry["from"], entry.get("step")
    if width <= 0:
        faults.add(where, f"from {entry['from']:g} to {entry['to']:g} is no range")
    elif step is not None and not (is_number(step) and 0 < step <= width):
        faults.add(f"{where}.step", "must be positive and within the range")
