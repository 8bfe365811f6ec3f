"""What is to be recorded: table, gauges, number of cycles, and what makes a reading be taken."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeAlias

from scara_iso.acquisition.ports import number_option, split_options
from scara_iso.acquisition.recorder.spec import GaugeSpec
from scara_iso.acquisition.recorder.tour import ONE_POSE, Tour
from scara_iso.errors import UsageError

_SETTLED = {
    "rest": "seconds that the dial must stand still, default 1",
    "within": "divisions between which it may flicker meanwhile, default 1",
    "away": "mm or degrees that it must have moved away before, default 0.5",
}


@dataclass(frozen=True, slots=True)
class Enter:
    """The operator says when, by a key or a foot switch."""

    def __str__(self) -> str:
        return "enter"


@dataclass(frozen=True, slots=True)
class Listen:
    """The indicator sends by itself, at its DATA key."""

    def __str__(self) -> str:
        return "data"


@dataclass(frozen=True, slots=True)
class Timer:
    """Every ``seconds`` [s], the first at once."""

    seconds: float

    def __str__(self) -> str:
        return f"timer:{self.seconds:g}"


@dataclass(frozen=True, slots=True)
class Settled:
    """The dial itself came to rest; the rule is that of `at_rest.AtRest`.

    ``rest`` [s] within ``within`` divisions, after it was more than ``away`` [mm or deg] from the
    visit before.
    """

    rest: float = 1.0
    within: float = 1.0
    away: float = 0.5

    def __str__(self) -> str:
        return f"settled?rest={self.rest:g}&within={self.within:g}&away={self.away:g}"


@dataclass(frozen=True, slots=True)
class RobotLine:
    """The robot says when, on a line of its own: ``AT P3``."""

    address: str

    def __str__(self) -> str:
        return self.address if self.address.startswith("socket://") else f"line:{self.address}"


Trigger: TypeAlias = Enter | Listen | Timer | Settled | RobotLine


@dataclass(frozen=True, slots=True)
class RecordingPlan:
    """``stable`` equal readings in a row make a reading that was asked for.

    A reading that comes by itself, or a key pressed, within ``rearm_s`` [s] of the one before is
    not taken: a key that bounced or was held down, or an instrument that sent twice. Every one of
    ``cycles`` goes to the poses of ``tour``.
    """

    trigger: Trigger
    cycles: int = 31
    stable: int = 1
    rearm_s: float = 0.5
    tour: Tour = ONE_POSE
    all_count: bool = False
    """Whether no first cycle is discarded later, as in a drift test."""

    @property
    def visits(self) -> int:
        """How many visits of a pose the whole test has."""
        return self.cycles * len(self.tour)


@dataclass(frozen=True, slots=True)
class Job:
    """What to record into ``table``; ``resume`` goes on with what is there.

    ``excel_locale`` spells the table for a spreadsheet; None goes on as before.
    """

    table: Path
    gauges: tuple[GaugeSpec, ...]
    plan: RecordingPlan
    metadata: Mapping[str, str] = field(default_factory=dict)
    resume: bool = False
    excel_locale: str | None = None

    @property
    def all_count(self) -> bool:
        """Whether the head states that every cycle counts, or that it is a drift test."""
        stated = {key: str(self.metadata.get(key, "")).lower() for key in ("first_cycle", "test")}
        return stated["first_cycle"] == "counts" or stated["test"] == "drift"


def parse_trigger(text: str) -> Trigger:
    """Return the trigger that ``text`` spells.

    ``enter``, ``data``, ``timer:SECONDS``, ``settled`` with its options, ``socket://HOST:PORT`` or
    ``line:PORT``.
    """
    if text.startswith("socket://") or (text.startswith("line:") and text != "line:"):
        return RobotLine(text.removeprefix("line:"))
    if text.partition("?")[0] == "settled":
        return _settled(text)
    match text.split(":"):
        case ["enter"]:
            return Enter()
        case ["data"]:
            return Listen()
        case ["timer", seconds]:
            try:
                value = float(seconds)
            except ValueError:
                value = 0.0
            if 0 < value <= 86400:
                return Timer(value)
    raise UsageError(
        f"unknown trigger {text!r}",
        remedy="use `trigger=enter`, `trigger=data`, `trigger=timer:SECONDS`, `trigger=settled`, "
        "or the robot's line: `trigger=socket://HOST:PORT`, `trigger=line:PORT`",
    )


def _settled(text: str) -> Settled:
    _, options = split_options(text, _SETTLED)
    values = {key: number_option(options, key, 0.0) for key in options}
    wrong = [key for key, value in values.items() if value <= 0]
    if wrong:
        raise UsageError(
            f"{text!r}: {wrong[0]} is not above zero",
            remedy=f"write a number above zero, as {wrong[0]}=1",
        )
    return Settled(**values)
