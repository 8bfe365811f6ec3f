"""What an indicator showed until now: a display that changed, a reading far from the others.

Values are compared as they were shown, in the unit of the display; no statement about the unit is
needed. Cycle 1 is no measure for the others: `analyze` discards it. Each pose has a level of its
own.
"""

from __future__ import annotations

from collections import deque
from decimal import Decimal
from statistics import median
from typing import ClassVar, Literal

from scara_iso.acquisition.recorder.events import Gross, Stored
from scara_iso.errors import InstrumentError
from scara_iso.quantities import parse_unit

INCH = Decimal("25.4")
_LOOK_BACK = 100
_FEWEST = 4
_LIKE = Decimal("0.1")
"""A step is one of 25.4 within this share: what the arm scatters, and the rounding of inches."""
_COUNTS = 50
"""A level of fewer counts of the last place is near zero: any ratio may come by chance."""
_RANGES = 8
_GROSS_COUNTS = 10


class HaltError(InstrumentError):
    """Recording cannot go on until somebody at the bench puts something right; exit code 69.

    ``question`` is what who sits at the terminal is told to do.
    """

    kind: ClassVar[Literal["changed", "place"]]
    question = "put it right"


class DisplayChangedError(HaltError):
    """The unit, the resolution or the zero of an indicator is not what it was."""

    kind = "changed"


class PlaceLostError(HaltError):
    """A frame was lost or sent twice, and with it the pose at which the arm stands."""

    kind = "place"

    def __init__(self, axis: str, why: str, *, visit: str) -> None:
        super().__init__(
            f"{why}: a frame was lost or sent twice, and where the arm stands is not known",
            where=f"gauge {axis}",
            remedy=f"bring the arm to {visit} and go on with `resume=True`; a robot that says "
            "where it is (`trigger=line:PORT`) loses no place",
        )
        self.question = f"bring the arm to {visit}"


class Shown:
    """The latest readings of one gauge by visit, as text; every cycle visits all ``poses``."""

    def __init__(self, *, fixed_decimals: bool, poses: int = 1) -> None:
        self._fixed = fixed_decimals
        self._poses = poses
        self._texts: deque[tuple[int, str]] = deque(maxlen=_LOOK_BACK * poses)

    def __bool__(self) -> bool:
        return bool(self._texts)

    def put(self, visit: int, text: str) -> None:
        """Take the reading of a visit."""
        self._texts.append((visit, text))

    def void(self, visit: int) -> None:
        """Forget a visit."""
        left = [one for one in self._texts if one[0] != visit]
        self._texts = deque(left, maxlen=self._texts.maxlen)

    def _at_the_pose_of(self, visit: int) -> list[tuple[int, str]]:
        return [one for one in self._texts if (one[0] - visit) % self._poses == 0]

    def changed(self, text: str, visit: int) -> str:
        """Return why unit or resolution of the display seem changed at a visit, or nothing."""
        if not self._texts:
            return ""
        before, now = _decimals(self._texts[-1][1]), _decimals(text)
        if self._fixed and before != now:
            return f"{text} has {now} decimals, the reading before had {before}"
        values = [Decimal(shown) for _, shown in self._at_the_pose_of(visit)]
        if not values:
            return ""
        level, value = median(values), Decimal(text)
        steady = max(values) - min(values) <= abs(level) * 3 * _LIKE
        if not steady:
            return ""
        for name, expected in (("1/25.4", level / INCH), ("25.4", level * INCH)):
            counts = min(abs(level), abs(expected) * INCH).scaleb(before)
            if counts >= _COUNTS and abs(value - expected) <= abs(expected) * _LIKE:
                return f"{text} is {name} of the readings before, as of mm and inch"
        return ""

    def far(self, text: str, visit: int) -> Decimal | None:
        """Return how far a gross reading is from the median of the others, None where it is not."""
        here = self._at_the_pose_of(visit)
        others = [Decimal(shown) for one, shown in here if one > self._poses]
        if len(others) < _FEWEST:
            return None
        count = Decimal(1).scaleb(-_decimals(text))
        limit = max(_RANGES * (max(others) - min(others)), _GROSS_COUNTS * count)
        distance = abs(Decimal(text) - median(others))
        return distance if distance > limit else None


def _decimals(text: str) -> int:
    return len(text.partition(".")[2])


def gross_reading(stored: Stored, distance: Decimal) -> Gross:
    """Return the message about a stored reading so far from the others, in the display's unit."""
    unit = parse_unit(stored.unit)
    at = "" if stored.pose is None else f" at {stored.pose}"
    message = (
        f"{stored.axis} {stored.text} {stored.unit} of cycle {stored.cycle}{at} is "
        f"{distance:.1g} {stored.unit} from the others; v strikes it"
    )
    away = unit.read(str(distance))
    return Gross(stored.cycle, stored.axis, stored.value, away, message, stored.pose)
