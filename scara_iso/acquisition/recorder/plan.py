"""What is to be recorded: table, gauges, number of cycles, and what makes a reading be taken."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeAlias

from scara_iso.acquisition.recorder.spec import GaugeSpec
from scara_iso.acquisition.recorder.tour import ONE_POSE, Tour
from scara_iso.errors import UsageError


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


Trigger: TypeAlias = Enter | Listen | Timer


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


def parse_trigger(text: str) -> Trigger:
    """Return the trigger that ``text`` spells: ``enter``, ``data`` or ``timer:SECONDS``."""
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
        remedy="use `trigger=enter`, `trigger=data` or `trigger=timer:SECONDS`",
    )
