"""Programs that make a robot pace a test over its line; one language a file, found by listing.

A program moves to taught points by their names, never to coordinates: to the pose ``P1`` by way of
its approach point ``appro_P1``. A module of this folder holds a constant ``LANGUAGE``.
"""

from __future__ import annotations

import hashlib
import ipaddress
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from importlib import import_module
from pkgutil import iter_modules
from types import MappingProxyType

from scara_iso.base.errors import UsageError

SILENCE_S = 30
"""Without an answer for so long the robot stops [s]."""
CONNECT_S = 30
"""So long a program tries to reach the recorder [s]."""
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,15}")
_SERIAL = "serial"


def program_id(poses: Sequence[str], cycles: int, part: str = "") -> str:
    """Return what tells a program of other poses, another order or other cycles from this one."""
    stated = f"{part}|{','.join(poses)}|{cycles}"
    return hashlib.sha256(stated.encode()).hexdigest()[:8]


@dataclass(frozen=True, slots=True)
class ProgramPart:
    """What one HELLO announces: every cycle visits ``poses`` in their order.

    ``speed`` is in per cent of the rated one.
    """

    program: str
    poses: tuple[str, ...]
    cycles: int
    speed: float

    @property
    def hello(self) -> str:
        """The line that announces it."""
        return f"HELLO program={self.program} poses={len(self.poses)} cycles={self.cycles}"

    @property
    def title(self) -> str:
        """What it is, in words."""
        return f"{self.cycles} cycles at {' '.join(self.poses)}, {self.speed:g} % of rated velocity"


@dataclass(frozen=True, slots=True)
class Served:
    """Where the recorder listens for the robot."""

    host: str
    port: int

    def __str__(self) -> str:
        return f"{self.host}:{self.port}"


@dataclass(frozen=True, slots=True)
class ProgramPlan:
    """A program called ``name``; ``line`` is None for a serial line (9600 baud, 8N1).

    Raises `UsageError` for a name that is no identifier of at most 16 letters and digits: names
    come from files, and stand in the program as they are.
    """

    name: str
    parts: tuple[ProgramPart, ...]
    dwell_s: float
    line: Served | None
    version: str
    both_sides: bool = False
    """Whether the poses are approached by way of two points by turns."""
    attended: bool = True
    """Whether a person moves the dials between two parts at other poses."""

    def __post_init__(self) -> None:
        for name in (self.name, *self.poses):
            if not _NAME.fullmatch(name):
                raise UsageError(
                    f"{name!r} cannot stand in a robot's program",
                    remedy="take letters, digits and _, a letter first, at most 16: P1",
                )
        if len({name.upper() for name in (self.name, *self.poses)}) <= len(self.poses):
            raise UsageError(
                f"{self.name}: program and poses have the same name", remedy="rename one of them"
            )

    @property
    def poses(self) -> tuple[str, ...]:
        """Every pose once, in the order of visiting."""
        return tuple(dict.fromkeys(pose for part in self.parts for pose in part.poses))

    def approaches(self, pose: str) -> tuple[str, ...]:
        """Return the approach points of a pose: one, or two that take turns."""
        return (f"appro_{pose}", f"appro2_{pose}")[: 1 + self.both_sides]

    @property
    def points(self) -> tuple[str, ...]:
        """The points to be taught."""
        return tuple(one for pose in self.poses for one in (*self.approaches(pose), pose))

    def head(self, points: str) -> list[str]:
        """Return the words on top of every program; ``points`` says how points are taught."""
        line = "the serial line, 9600 8N1" if self.line is None else str(self.line)
        return [
            f"ISO 9283 test, written by scara-iso {self.version}: {self._tests()}.",
            "NEVER RUN ON A CONTROLLER. Read it, then run it first at 10 % speed in manual mode.",
            f"Teach before: {points}",
            *(f"  {' '.join(self.points[at : at + 6])}" for at in range(0, len(self.points), 6)),
            f"Each visit: approach point, pose, {self.dwell_s:g} s at rest, then a line to {line}.",
            f"NO, or {SILENCE_S} s without an answer, stops the robot with a message. Started",
            "again it goes on behind the last cycle that is stored.",
            self._dials(),
            *(["Odd cycles come by way of appro_, even ones of appro2_."] * self.both_sides),
        ]

    def _dials(self) -> str:
        if self.attended and len(self.parts) > 1:
            return "Between two poses it waits for a person, who moves the dials."
        return "The dials must reach every pose without being moved: the arm carries them."

    def waits_before(self, part: ProgramPart) -> bool:
        """Return whether a person moves the dials before a part: it is at other poses."""
        at = self.parts.index(part)
        return self.attended and at > 0 and self.parts[at - 1].poses != part.poses

    def _tests(self) -> str:
        return " ".join(part.program for part in self.parts)


@dataclass(frozen=True, slots=True)
class Language:
    """A language of robots; ``write`` gives the texts of the files that have these ``endings``.

    The first of them is the program itself. ``serial`` says whether it can speak on a serial line.
    """

    key: str
    endings: tuple[str, ...]
    controllers: str
    talks_by: str
    write: Callable[[ProgramPlan], tuple[str, ...]]
    serial: bool = False


def find_languages() -> Mapping[str, Language]:
    """Return every language by its key."""
    names = sorted(m.name for m in iter_modules(__path__) if not m.name.startswith("_"))
    found = [import_module(f"{__name__}.{name}").LANGUAGE for name in names]
    return MappingProxyType({one.key: one for one in found})


def find_language(key: str) -> Language:
    """Return the language called ``key``; `UsageError` names the known ones otherwise."""
    known = find_languages()
    if key.lower() not in known:
        close = get_close_matches(key.lower(), known, n=1)
        raise UsageError(
            f"unknown language {key!r}",
            remedy=(f"did you mean {close[0]}? " if close else "") + f"known: {', '.join(known)}",
        )
    return known[key.lower()]


def parse_served(text: str, language: Language) -> Served | None:
    """Return where the recorder listens, None for a serial line; `UsageError` for another text.

    A host is an IPv4 address: not every controller knows names.
    """
    if text == _SERIAL and language.serial:
        return None
    host, _, port = text.rpartition(":")
    try:
        address = str(ipaddress.IPv4Address(host))
    except ValueError:
        address = ""
    if not address or not (port.isascii() and port.isdigit() and 0 < int(port[:6]) < 65536):
        known = "no serial line in" if text == _SERIAL else f"{text!r} is no address for"
        raise UsageError(
            f"{known} a {language.key} program",
            remedy="give the address of the recorder on the robot's network: "
            "`line=192.168.1.10:5000`" + ", or `line=serial`" * language.serial,
        )
    return Served(address, int(port))


def write_program(language: Language, plan: ProgramPlan) -> dict[str, str]:
    """Return the files of a program by their names."""
    texts = language.write(plan)
    return {f"{plan.name}{end}": text for end, text in zip(language.endings, texts, strict=True)}


def commented(lines: Sequence[str], mark: str, indent: str = "") -> str:
    """Return lines as comments."""
    return "\n".join(f"{indent}{mark} {line}" for line in lines)


def visits(
    part: ProgramPart,
    plan: ProgramPlan,
    visit: Callable[[str, str, str], Iterable[str]],
    by_turns: tuple[str, str, str],
) -> Iterator[str]:
    """Yield a cycle: ``visit`` gives the lines of a pose, an approach point and what AT adds.

    ``by_turns`` parts odd cycles from even ones, where they come from two sides: if, else, end.
    """
    *heads, end = by_turns
    added = (" approach=+1", " approach=-1") if plan.both_sides else ("",)
    for pose in part.poses:
        ways = zip(plan.approaches(pose), added, strict=True)
        turns = [visit(pose, point, words) for point, words in ways]
        if len(turns) == 1:
            yield from turns[0]
            continue
        for head, lines in zip(heads, turns, strict=True):
            yield from (head, *(f"  {line}" for line in lines))
        yield end
