"""What a session says as it goes, a line of JSON each, and what its operator says."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal, Protocol, TypeAlias, get_args

from scara_iso.base.published import INTERNAL, Count
from scara_iso.run import AXES, AxisKey

ProblemKind: TypeAlias = Literal["fault", "garbage", "timeout", "unsettled", "changed", "place"]
"""Why there is no reading."""


@dataclass(frozen=True, slots=True)
class _Line:
    event: str
    """What happens."""


@dataclass(frozen=True, slots=True)
class Started(_Line):
    """The session begins, or goes on, with ``cycle``."""

    event: Literal["started"] = field(default_factory=lambda: "started", init=False, repr=False)
    gauges: Mapping[AxisKey, str]
    """What is on each axis."""
    cycle: Count
    """The first that is recorded."""
    cycles: Count
    """How many are planned."""
    trigger: str
    """What takes a reading."""
    pose: str | None = None
    """The first one, where the poses have names."""
    poses: tuple[str, ...] | None = None
    """Those that every cycle visits, in their order."""


@dataclass(frozen=True, slots=True)
class Waiting(_Line):
    """Readings of ``cycle`` are awaited."""

    event: Literal["waiting"] = field(default_factory=lambda: "waiting", init=False, repr=False)
    cycle: Count
    """Its number."""
    missing: tuple[AxisKey, ...]
    """Axes that have no reading yet."""
    pose: str | None = None
    """Where the poses have names."""


@dataclass(frozen=True, slots=True)
class Stored(_Line):
    """A reading is safely on disk."""

    event: Literal["stored"] = field(default_factory=lambda: "stored", init=False, repr=False)
    cycle: Count
    """Its number."""
    axis: AxisKey
    """Of the indicator."""
    value: float
    """In mm or degrees, as in the table."""
    text: str = field(metadata=INTERNAL)
    """As the indicator showed it."""
    unit: str = field(metadata=INTERNAL)
    """That of the display."""
    pose: str | None = None
    """Where the poses have names."""


@dataclass(frozen=True, slots=True)
class CycleDone(_Line):
    """Every axis of the cycle is stored."""

    event: Literal["cycle"] = field(default_factory=lambda: "cycle", init=False, repr=False)
    cycle: Count
    """Its number."""
    discarded: bool
    """Whether `analyze` leaves it out."""
    pose: str | None = None
    """Where the poses have names."""


@dataclass(frozen=True, slots=True)
class Gross(_Line):
    """A stored reading lies far from those before."""

    event: Literal["gross"] = field(default_factory=lambda: "gross", init=False, repr=False)
    cycle: Count
    """Its number."""
    axis: AxisKey
    """Of the indicator."""
    value: float
    """In mm or degrees, as in the table."""
    distance: float
    """From those before, in mm or degrees."""
    message: str
    """What is far from what, and what to do."""
    pose: str | None = None
    """Where the poses have names."""


@dataclass(frozen=True, slots=True)
class Refused(_Line):
    """A valid reading that was not taken, and why."""

    event: Literal["refused"] = field(default_factory=lambda: "refused", init=False, repr=False)
    axis: AxisKey
    """Of the indicator."""
    text: str
    """As it was sent."""
    reason: str
    """Why it was not taken."""


@dataclass(frozen=True, slots=True)
class Problem:
    """No reading, and why: a fault, garbage, no answer, a value that does not settle."""

    event: ProblemKind
    """`changed`: unit, resolution or zero of the display; `place`: where the arm stands in a tour
    is not known."""
    axis: AxisKey
    """Of the indicator."""
    message: str
    """Why there is none."""


@dataclass(frozen=True, slots=True)
class Noticed(_Line):
    """Something was said that is neither a reading nor a fault."""

    event: Literal["notice"] = field(default_factory=lambda: "notice", init=False, repr=False)
    axis: Annotated[str, ("enum", (*AXES, ""))]
    """Of the indicator that said it; empty where the session did."""
    message: str
    """What was said."""


@dataclass(frozen=True, slots=True)
class Voided(_Line):
    """Stored readings were struck out: kept in the raw file, not in the table."""

    event: Literal["voided"] = field(default_factory=lambda: "voided", init=False, repr=False)
    cycle: Count
    """Its number."""
    axes: tuple[AxisKey, ...]
    """Whose readings."""
    reason: str
    """As the operator says it."""
    pose: str | None = None
    """Where the poses have names."""


@dataclass(frozen=True, slots=True)
class Noted(_Line):
    """A remark went into the raw file."""

    event: Literal["note"] = field(default_factory=lambda: "note", init=False, repr=False)
    text: str
    """The remark."""


@dataclass(frozen=True, slots=True)
class Paused(_Line):
    """Readings are or are no longer refused."""

    event: Literal["paused"] = field(default_factory=lambda: "paused", init=False, repr=False)
    on: bool
    """Whether they are."""
    reason: str | None = None
    """Why, where nobody asked for it."""


@dataclass(frozen=True, slots=True)
class Done(_Line):
    """The files are written."""

    event: Literal["done"] = field(default_factory=lambda: "done", init=False, repr=False)
    cycles: Count
    """How many are in the table."""
    planned: Count
    """How many were to be."""
    table: str
    """Its file."""
    raw: str
    """File of all that was received."""


Said: TypeAlias = (
    Started
    | Waiting
    | Stored
    | Gross
    | CycleDone
    | Refused
    | Problem
    | Noticed
    | Voided
    | Noted
    | Paused
    | Done
)
PUBLISHED = get_args(Said)
"""The lines that ``record`` writes as JSON."""


def when_started(act: Callable[[int], str], tell: Callable[[Any], None]) -> Callable[[Any], None]:
    """Return a listener that hands on; ``act`` is called as a session begins with a cycle.

    What it returns is a notice behind the begin.
    """

    def listener(said: object) -> None:
        noticed = act(said.cycle) if isinstance(said, Started) else None
        tell(said)
        if noticed is not None:
            tell(Noticed("", noticed))

    return listener


@dataclass(frozen=True, slots=True)
class Take:
    """Take a reading of every gauge now."""


@dataclass(frozen=True, slots=True)
class Void:
    """Strike out what was stored last."""

    reason: str


@dataclass(frozen=True, slots=True)
class Note:
    """Write a remark into the raw file."""

    text: str


@dataclass(frozen=True, slots=True)
class Pause:
    """Refuse readings until the next one of these."""

    reason: str | None = None
    """Why, where it is not the operator who pauses."""


@dataclass(frozen=True, slots=True)
class Quit:
    """End the session; what is stored stays."""


Command: TypeAlias = Take | Void | Note | Pause | Quit


class Operator(Protocol):
    """Gives the commands: a keyboard, a foot switch that types Enter, lines of standard input."""

    def poll(self) -> Command | None:
        """Return the next command if one was given; never waits."""


class Unattended:
    """An operator who gives no command."""

    def poll(self) -> Command | None:
        """Return None."""
        return None
