"""What a session says as it goes, and what its operator says to it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Literal, Protocol, TypeAlias

ProblemKind: TypeAlias = Literal["fault", "garbage", "timeout", "unsettled", "changed", "place"]
"""Why there is no reading."""


@dataclass(frozen=True, slots=True)
class Started:
    """The session begins, or goes on, with ``cycle``; ``gauges`` says what is on each axis.

    Here and below, ``pose`` is None where the poses have no names.
    """

    gauges: Mapping[str, str]
    cycle: int
    cycles: int
    trigger: str
    pose: str | None = None
    poses: tuple[str, ...] | None = None


@dataclass(frozen=True, slots=True)
class Waiting:
    """Readings of ``cycle`` are awaited, from the axes that ``missing`` names."""

    cycle: int
    missing: tuple[str, ...]
    pose: str | None = None


@dataclass(frozen=True, slots=True)
class Stored:
    """A reading is safely on disk; ``value`` is in mm or degrees, as in the table.

    ``text`` and ``unit`` are what the indicator showed.
    """

    cycle: int
    axis: str
    value: float
    text: str
    unit: str
    pose: str | None = None


@dataclass(frozen=True, slots=True)
class CycleDone:
    """Every axis of the cycle (at ``pose``) is stored.

    ``discarded`` for the one that `analyze` leaves out.
    """

    cycle: int
    discarded: bool
    pose: str | None = None


@dataclass(frozen=True, slots=True)
class Gross:
    """A stored reading lies far from those before; ``value`` and ``distance`` in mm or degrees."""

    cycle: int
    axis: str
    value: float
    distance: float
    message: str
    pose: str | None = None


LATE = "late, or not asked for"
UNASKED = "not asked for"
UNIT_ASKED = "the unit was asked for"
SECOND = "a second answer to one request"
TWICE = "sent twice"
"""Why a frame is refused that no request called for, and no visit."""


@dataclass(frozen=True, slots=True)
class Refused:
    """A valid reading that was not taken, and why."""

    axis: str
    text: str
    reason: str


@dataclass(frozen=True, slots=True)
class Problem:
    """No reading: a fault, garbage, no answer, a value that does not settle, a changed display."""

    axis: str
    kind: ProblemKind
    message: str


@dataclass(frozen=True, slots=True)
class Noticed:
    """The instrument said something that is neither a reading nor a fault."""

    axis: str
    message: str


@dataclass(frozen=True, slots=True)
class Voided:
    """Stored readings were struck out: kept in the raw file, not in the table."""

    cycle: int
    axes: tuple[str, ...]
    reason: str
    pose: str | None = None


@dataclass(frozen=True, slots=True)
class Noted:
    """A remark went into the raw file."""

    text: str


@dataclass(frozen=True, slots=True)
class Paused:
    """Readings are (``on``) or are no longer refused."""

    on: bool


@dataclass(frozen=True, slots=True)
class NextWay:
    """A way to tell rivals apart: so many more ``cycles``, after a ``pause`` or without.

    ``right`` is the chance that the likeliest name is right then.
    """

    pause: bool
    cycles: int
    right: float


@dataclass(frozen=True, slots=True)
class Watched:
    """What all readings up to ``cycle`` say together: ``structure`` at an alarm.

    Then ``effect`` is the likeliest one so far, ``since`` the cycle from which it acts, ``share``
    its probability, and ``rivals`` the others that are likely, with theirs. ``next`` are ways to
    tell these apart, the best one first.
    """

    cycle: int
    evidence: float
    says: Literal["structure", "nothing yet"]
    effect: str | None = None
    since: int | None = None
    share: float | None = None
    rivals: Mapping[str, float] | None = None
    next: tuple[NextWay, ...] | None = None


@dataclass(frozen=True, slots=True)
class Done:
    """The files are written; ``cycles`` of ``planned`` are in the table."""

    cycles: int
    planned: int
    table: str
    raw: str


Said: TypeAlias = (
    Started | Waiting | Stored | Gross | CycleDone | Refused | Problem | Noticed | Voided | Noted
    | Paused | Watched | Done
)  # fmt: skip

_NAMES = {CycleDone: "cycle", Noticed: "notice", Noted: "note", Watched: "watch"}


def as_json(said: Said) -> dict[str, object]:
    """Return the JSON object of one line."""
    match said:
        case Stored(cycle=cycle, axis=axis, value=value, pose=pose):
            found = {"event": "stored", "cycle": cycle, "pose": pose, "axis": axis, "value": value}
        case Problem(axis=axis, kind=kind, message=message):
            found = {"event": kind, "axis": axis, "message": message}
        case _:
            event = _NAMES.get(type(said), type(said).__name__.lower())
            stated = {f.name: _plain(getattr(said, f.name)) for f in fields(said)}
            found = {"event": event, **stated}
    return {key: value for key, value in found.items() if value is not None}


def _plain(value: object) -> object:
    if isinstance(value, tuple):
        return [asdict(one) if isinstance(one, NextWay) else one for one in value]
    return dict(value) if isinstance(value, Mapping) else value


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


@dataclass(frozen=True, slots=True)
class Quit:
    """End the session; what is stored stays."""


Command: TypeAlias = Take | Void | Note | Pause | Quit


class Operator(Protocol):
    """Gives the commands: a keyboard, a foot switch that types Enter, lines of standard input."""

    def poll(self) -> Command | None:
        """Return the next command if one was given; never waits."""
