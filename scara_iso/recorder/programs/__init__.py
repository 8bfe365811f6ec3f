"""Programs that make a robot pace a test over its line; one template a language, found by listing.

A program moves to taught points by their names, never to coordinates: to the pose ``P1`` by way of
its approach point ``appro_P1``. A template of this folder sets ``controllers``, ``talks_by`` and,
where it can speak on a serial line, ``serial``; its ``files`` are macros by the file's ending, the
program first. It is given a `ProgramPlan`, which holds no text but checked names.
"""

from __future__ import annotations

import hashlib
import ipaddress
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path
from types import MappingProxyType
from typing import Annotated

from scara_iso.base.errors import UsageError
from scara_iso.base.published import INTERNAL, Count, published

_WAITS = {"SILENCE_S": 30, "CONNECT_S": 30, "TRY_S": 2}
"""How long a program awaits an answer, tries to reach the recorder, and tries once [s]."""
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,15}")
_SERIAL = "serial"


def program_id(poses: Sequence[str], cycles: int, part: str = "") -> str:
    """Return what tells a program of other poses, another order or other cycles from this one."""
    stated = f"{part}|{','.join(poses)}|{cycles}"
    return hashlib.sha256(stated.encode()).hexdigest()[:8]


@dataclass(frozen=True, slots=True)
class ProgramPart:
    """What the robot announces by one HELLO."""

    program: str
    """Its hash of part, poses, order and cycles, which `record` compares."""
    poses: tuple[str, ...]
    """That every cycle visits, in their order."""
    cycles: Count
    """How many, the first included."""
    speed: Annotated[float, ("unit", "%")]
    """Of the rated velocity."""

    @property
    def hello(self) -> str:
        """The line that announces it."""
        return f"HELLO program={self.program} poses={len(self.poses)} cycles={self.cycles}"

    @property
    def title(self) -> str:
        """What it is, in words."""
        return f"{self.cycles} cycles at {' '.join(self.poses)}, {self.percent} % of rated velocity"

    @property
    def percent(self) -> str:
        """The speed as a number."""
        return f"{self.speed:g}"

    @property
    def whole_percent(self) -> int:
        """The speed where a language takes whole numbers from 1 on."""
        return max(1, round(self.speed))


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
    def dwell(self) -> str:
        """The dwell as a number [s]."""
        return f"{self.dwell_s:g}"

    @property
    def poses(self) -> tuple[str, ...]:
        """Every pose once, in the order of visiting."""
        return tuple(dict.fromkeys(pose for part in self.parts for pose in part.poses))

    @property
    def points(self) -> tuple[str, ...]:
        """The points to be taught: each pose behind its approach point, or its two."""
        ways = ("appro_", "appro2_", "") if self.both_sides else ("appro_", "")
        return tuple(f"{way}{pose}" for pose in self.poses for way in ways)

    def waits_before(self, part: ProgramPart) -> bool:
        """Return whether a person moves the dials before a part: it is at other poses."""
        at = self.parts.index(part)
        return self.attended and at > 0 and self.parts[at - 1].poses != part.poses


@dataclass(frozen=True, slots=True)
class Language:
    """A language of robots."""

    key: str = field(metadata=published("language"))
    """Its key."""
    controllers: str
    """That understand it."""
    talks_by: str
    """The instructions by which it speaks with the recorder."""
    files: Mapping[str, Callable[[ProgramPlan], str]] = field(metadata=INTERNAL)
    """What writes a program, by the endings of its files, the program itself first."""
    serial: bool = False
    """Whether it can speak on a serial line too."""

    @property
    def endings(self) -> tuple[str, ...]:
        """Those of the files, the program's first."""
        return tuple(self.files)


def find_languages() -> Mapping[str, Language]:
    """Return every language by its key."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined  # noqa: PLC0415 - here only

    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=False,  # noqa: S701 - no page: programs, of names that the plan has checked
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals |= _WAITS
    names = environment.list_templates(filter_func=lambda name: name[:1] != "_" and ".j2" in name)
    found = {}
    for name in names:
        key, stated = name.removesuffix(".j2"), vars(environment.get_template(name).module)
        serial = bool(stated.get("serial"))
        found[key] = Language(
            key, stated["controllers"], stated["talks_by"], stated["files"], serial
        )
    return MappingProxyType(found)


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
        known = "no serial line in" if text == _SERIAL else f"{text!r} is not an address for"
        raise UsageError(
            f"{known} a {language.key} program",
            remedy="give the address of the recorder on the robot's network: "
            "`line=192.168.1.10:5000`" + ", or `line=serial`" * language.serial,
        )
    return Served(address, int(port))


def write_program(language: Language, plan: ProgramPlan) -> dict[str, str]:
    """Return the files of a program by their names."""
    return {f"{plan.name}{end}": str(write(plan)) for end, write in language.files.items()}
