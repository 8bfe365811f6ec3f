"""Which condition of a test a column records, and what makes its numbers seconds, °C or kg of it.

The clock is ``time_s``, and effects of a temperature are per °C: a column of minutes or of °F would
else give a time constant, or a coefficient, that is silently another.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass

from scara_iso.base.errors import DataError
from scara_iso.base.quantities import Dimension, Number
from scara_iso.run.axis import FloatArray


@dataclass(frozen=True, slots=True)
class RecordedCondition:
    """A recorded condition: its name in a run, which ends in its unit there, and its scale."""

    name: str
    numerator: float = 1.0
    denominator: float = 1.0
    zero: float = 0.0
    """What the column shows at zero s, °C or kg."""
    sure: bool = True
    """Whether the name says so whatever other columns there are."""

    @property
    def converts(self) -> bool:
        """Whether the column is in another unit than the run."""
        return (self.numerator, self.denominator, self.zero) != (1, 1, 0)

    def to_base(self, values: Number) -> Number:
        """Return numbers of the column, a value or an array of any shape, in the run's unit."""
        return (values - self.zero) * self.numerator / self.denominator


_TIME = {"s": (1, 1), "ms": (1, 1000), "min": (60, 1), "h": (3600, 1)}
_MASS = {"kg": (1, 1), "g": (1, 1000), "lb": (0.45359237, 1)}
_TEMPERATURE = {"c": (1, 1, 0), "f": (5, 9, 32), "k": (1, 1, 273.15)}
_SPELLED = {
    spelt: unit
    for unit, names in {
        "s": "sec,secs,second,seconds,sek,sekunde,sekunden",
        "ms": "millisecond,milliseconds,msec,millisekunden",
        "min": "mins,minute,minutes,minuten",
        "h": "hr,hrs,hour,hours,std,stunde,stunden",
        "c": "degc,deg c,grad c,celsius,deg celsius,grad celsius",
        "f": "degf,deg f,grad f,fahrenheit,deg fahrenheit",
        "k": "kelvin",
        "g": "gram,grams,gramm",
        "lb": "lbs,pounds",
    }.items()
    for spelt in names.split(",")
}
_CLOCK_NAMES = ("time", "t", "zeit")
_CLOCK_LIKE = ("elapsed", "elapsed time", "time elapsed", "time since start", "zeit seit start")
_LOAD_LIKE = ("load", "last", "nutzlast", "belastung", "zuladung", "carico", "carga")
_AIR = ("ambient temperature", "raumtemperatur", "lufttemperatur", "umgebungstemperatur")
_ROOM = ("t", "temp", *_AIR)
_WARM = re.compile(r"(?:temp|temperature?)(?: .+)?|.*temperature?", re.ASCII)


UNITS = frozenset([*_TIME, *_MASS, *_TEMPERATURE, "n", "kn", "nm", "mm", "um", "bar", "v", "a"])
"""Units of conditions, in the spelling that `unit_of_condition` returns."""
_PARTS = (
    re.compile(r"(.*?) ?[\[({<]([^\[\](){}<>]*)[\])}>]"),
    re.compile(r"(.+?) ?(?:/|,| in )(.+)"),
    re.compile(r"(.+)_(.+)"),
)


def unit_of_condition(text: str) -> str:
    """Return a unit in lower case, without its degree sign, and minutes as min."""
    unit = text.replace("°", "").strip(" -.").lower()
    return _SPELLED.get(unit, unit)


def unit_in_heading(heading: str) -> str:
    """Return the unit of a condition that a heading states, as it stands there; "" for none."""
    parted = (match for parts in _PARTS if (match := parts.fullmatch(heading)))
    return next((match[2] for match in parted if unit_of_condition(match[2]) in UNITS), "")


def find_condition(heading: str, unit_below: str = "") -> RecordedCondition | None:
    """Return the condition that a column records by its heading, or by that and a unit below it.

    ``Zeit [min]`` is ``time_s``, ``temperature_base_F`` is ``temperature_base_C``; None for another
    quantity or unit.
    """
    unit = unit_in_heading(heading)
    if unit:
        return _of_stem(heading.rpartition(unit)[0].rstrip(" _/,([{<").removesuffix(" in"), unit)
    stem, _, word = heading.rpartition(" ")
    return _of_stem(heading, unit_below) or _of_stem(stem, word)


def _of_stem(stem: str, unit: str) -> RecordedCondition | None:
    unit = unit_of_condition(unit)
    name = " ".join(stem.replace("_", " ").lower().rstrip(". :").split())
    if unit in _TIME and name in (*_CLOCK_NAMES, *_CLOCK_LIKE):
        return RecordedCondition("time_s", *_TIME[unit], sure=unit == "s" and name in _CLOCK_NAMES)
    if unit in _MASS and name in ("payload", *_LOAD_LIKE):
        return RecordedCondition(
            "payload_kg", *_MASS[unit], sure=unit == "kg" and name == "payload"
        )
    if unit in _TEMPERATURE and name in ("temperature", "temperatur", *_ROOM):
        sure = name not in _ROOM
        return RecordedCondition("temperature_C", *_TEMPERATURE[unit], sure=sure)
    if unit in ("f", "k") and _WARM.fullmatch(name):
        return RecordedCondition(f"{stem.strip()}_C", *_TEMPERATURE[unit])
    return None


def of_base_units(
    columns: Mapping[str, FloatArray],
) -> dict[str, FloatArray]:
    """Return columns by name, each of shape (rows,), those in another unit than a run's converted.

    Raises `DataError` where two would be the same column then.
    """
    found: dict[str, FloatArray] = {}
    for name, values in columns.items():
        condition = find_condition(name)
        if condition is None or not condition.converts:
            condition = RecordedCondition(name)
        elif condition.name in columns or condition.name in found:
            what = f"column {name!r} is {condition.name} too"
            raise DataError(what, where="data frame", remedy="keep one of them")
        found[condition.name] = condition.to_base(values)
    return found


_TRANSIENT = re.compile(r"stabilisation_\w+_s|overshoot_\w+_(mm|deg)")


def stabilisation_column(axis: str) -> str:
    """Return the name of the column that holds the stabilisation times of an axis [s]."""
    return f"stabilisation_{axis}_s"


def overshoot_column(axis: str, dimension: Dimension) -> str:
    """Return the name of the column that holds the overshoots of an axis [mm or deg]."""
    return f"overshoot_{axis}_{dimension.value}"


def is_transient(name: str) -> bool:
    """Return whether a column is a figure of the arrivals: no condition, and so no cause."""
    return _TRANSIENT.fullmatch(name) is not None
