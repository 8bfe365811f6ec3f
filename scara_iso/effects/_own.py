"""A user's own effects: a name, parameters with ranges, and a formula, from a TOML file.

    [[effect]]
    name = "belt_creep"
    formula = "size * log(1 + t / tau)"
    [effect.parameters]
    tau = { from = 20, to = 600, unit = "s" }

``k`` is the number of the cycle, ``t`` the time since the first one in seconds (from ``time_s``);
what else is no parameter is a recorded column. The readings of each axis move in
proportion to ``size``, which every axis has for itself: it stands in the formula or before it.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from scara_iso.base.files import KeyFaults, is_number, only, section
from scara_iso.effects._effect import KnownCourse, as_column
from scara_iso.effects._formula import (
    FUNCTIONS,
    NUMBER,
    SIZE_NAME,
    Formula,
    FormulaError,
    Unit,
    parse_formula,
    said_of,
    spelled,
    times,
    unit_in,
    unit_of_column,
)
from scara_iso.effects._parts import CLOCK, Conditions, Grid, Parameter, Values
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
            found[name] = Given(low, high, step and float(step), unit, entry.get("meaning", ""))
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
        faults.add(f"{where}.unit", 'is not a unit such as "s", "1/°C" or "kg*m^2"')
    if not isinstance(texts["meaning"], str):
        faults.add(f"{where}.meaning", "is not text")
    if not wrong and "value" not in entry:
        _check_range(entry, where, faults)
    return unit


def _check_range(entry: Mapping[str, Any], where: str, faults: KeyFaults) -> None:
    width, step = entry["to"] - entry["from"], entry.get("step")
    if width <= 0:
        faults.add(where, f"from {entry['from']:g} to {entry['to']:g} is not a range")
    elif step is not None and not (is_number(step) and 0 < step <= width):
        faults.add(f"{where}.step", "must be positive and within the range")


_NAME = re.compile(r"[a-z][a-z0-9_]{0,39}")
_CYCLE, _TIME = "k", "t"
_TAKEN = {_CYCLE, _TIME, SIZE_NAME, "name", "joint", *FUNCTIONS}
_MOST_EFFECTS, _MOST_FORMS = 20, 400
_CAUSE = "what the formula of your own effect stands for: "
_CONFIRM = (
    "change what you think is the cause, on purpose: the course must change as the formula says"
)
_TEXTS = ("formula", "cause", "confirm_by")


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class OwnEffect(KnownCourse):
    """A known course that a user's file defines; ``definition`` is what stands there."""

    definition: Mapping[str, Any]


def own_effects(
    entries: object, where: str, taken: Collection[str], faults: KeyFaults
) -> Iterator[OwnEffect]:
    """Yield the effects of a list of tables; what is wrong with one goes to ``faults``.

    ``where`` is the list's key, ``taken`` the names that other effects have.
    """
    if not isinstance(entries, list):
        faults.add(where, f"write each effect as [[{where}]]")
        return
    if len(entries) > _MOST_EFFECTS:
        faults.add(where, f"{len(entries)} effects; at most {_MOST_EFFECTS} are tried")
        return
    known = set(taken)
    for i, entry in enumerate(entries, 1):
        if not isinstance(entry, dict):
            faults.add(f"{where} {i}", f"write each effect as [[{where}]]")
            continue
        found = len(faults)
        effect = _own_effect(entry, f"{where} {i}", known, faults)
        known.add(str(entry.get("name")))
        if effect is not None and len(faults) == found:
            yield effect


def _own_effect(
    entry: Mapping[str, Any], where: str, taken: Collection[str], faults: KeyFaults
) -> OwnEffect | None:
    only(entry, {"name", "parameters", *_TEXTS}, where, faults)
    name = entry.get("name")
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        faults.add(f"{where}.name", "give one of small letters, digits and _, such as belt_creep")
    elif name in taken:
        faults.add(f"{where}.name", f"another effect is called {name}")
    faults_of_texts = [key for key in _TEXTS if not isinstance(entry.get(key, ""), str)]
    for key in faults_of_texts:
        faults.add(f"{where}.{key}", "is not text")
    table = section(entry, "parameters", faults)
    given = given_parameters(table, f"{where}.parameters", _TAKEN, faults)
    _check_number_of_forms(given, where, faults)
    formula = _formula(entry, {*table}, where, faults)
    if formula is None or faults_of_texts or len(given) < len(table):
        return None
    unit = _unit_of_size(formula, given, where, faults)
    return None if unit is None else _built(str(name), entry, formula, given, unit)


def _check_number_of_forms(given: Mapping[str, Given], where: str, faults: KeyFaults) -> None:
    free = [one for one in given.values() if one.searched]
    open_ended = sum(one.step is None for one in free)
    if np.prod([float(one.count(open_ended)) for one in free]) > _MOST_FORMS:
        faults.add(
            f"{where}.parameters",
            f"more than {_MOST_FORMS} courses to try: give three ranges at most, or wider steps",
        )


def _formula(
    entry: Mapping[str, Any], parameters: Collection[str], where: str, faults: KeyFaults
) -> Formula | None:
    text = entry.get("formula")
    if not isinstance(text, str):
        faults.add(f"{where}.formula", 'missing: a text such as "size * exp(-t / tau)"')
        return None
    try:
        formula = parse_formula(text)
        if SIZE_NAME not in formula.names:
            formula = parse_formula(f"{SIZE_NAME} * ({text.strip()})")
    except FormulaError as error:
        faults.add(f"{where}.formula", str(error))
        return None
    for unused in sorted(set(parameters) - formula.names):
        faults.add(f"{where}.parameters.{unused}", "does not stand in the formula")
    if not formula.names - {SIZE_NAME} - set(parameters):
        faults.add(f"{where}.formula", "is the same in every cycle: use k, t or a recorded column")
        return None
    return formula


def _unit_of_size(
    formula: Formula, given: Mapping[str, Given], where: str, faults: KeyFaults
) -> str | None:
    """Return the unit of ``size``: that of a reading over that of what it is multiplied by."""
    units = {name: unit_of_column(name) for name in formula.names}
    units |= {name: one.unit for name, one in given.items()}
    units |= {_CYCLE: NUMBER, _TIME: {"s": 1}, SIZE_NAME: {SIZE_NAME: 1}}  # type: ignore[dict-item]
    try:
        unit = formula.unit(units)
    except FormulaError as error:
        faults.add(f"{where}.formula", str(error))
        return None
    if unit.get(SIZE_NAME) != 1:
        faults.add(
            f"{where}.formula", f"must be in proportion to {SIZE_NAME}, and is {said_of(unit)}"
        )
        return None
    beside = times(unit, {SIZE_NAME: 1}, -1)  # type: ignore[dict-item]
    return "reading" if not beside else f"reading/{_bracketed(spelled(beside))}"


def _bracketed(unit: str) -> str:
    return f"({unit})" if "*" in unit or "/" in unit else unit


def _built(
    name: str, entry: Mapping[str, Any], formula: Formula, given: Mapping[str, Given], unit: str
) -> OwnEffect:
    columns = formula.names - {_CYCLE, _TIME, SIZE_NAME, *given}
    free = {key: one for key, one in given.items() if one.searched}
    shared = sum(one.step is None for one in free.values())
    fixed = {key: one.low for key, one in given.items() if not one.searched}
    return OwnEffect(
        name=name,
        parameters=(
            *(_parameter(key, one, one.count(shared)) for key, one in free.items()),
            Parameter(SIZE_NAME, "A", unit, "how far the readings move where the rest is 1"),
        ),
        needs=(*sorted(columns), *([CLOCK] if _TIME in formula.names else [])),
        cause=entry.get("cause") or _CAUSE + formula.text,
        confirm_by=entry.get("confirm_by") or _CONFIRM,
        columns=partial(_columns, formula, fixed),
        definition=entry,
    )


def _parameter(name: str, given: Given, count: int) -> Parameter:
    grid = given.grid(count)
    unit = spelled(given.unit) if given.unit else ""
    return Parameter(
        name,
        name,
        unit,
        given.meaning or f"{name} of the formula",
        grid=lambda _: grid,
        above=float(np.nextafter(given.low, -np.inf)),
        up_to=given.high,
    )


def _columns(
    formula: Formula, fixed: Mapping[str, float], conditions: Conditions, **parameters: Any
) -> FloatArray:
    known: Values = {**fixed, **parameters, SIZE_NAME: 1.0}
    values: dict[str, FloatArray | float] = {n: np.float64(v) for n, v in known.items()}
    columns = formula.names - {_CYCLE, _TIME, *values}
    values |= {name: conditions.covariates[name] for name in columns}
    values[_CYCLE] = conditions.cycle.astype(np.float64)
    if (seconds := conditions.seconds) is not None:
        values[_TIME] = seconds
    return as_column(np.broadcast_to(formula.value(values), len(conditions)))
