"""What the words and numbers of a file mean: the grammar of a number, the sheet words.toml, keys.

``float`` takes ``nan``, ``inf``, ``1_0`` and Arabic digits and knows no decimal comma. Here a
number is an optional sign (``+``, ``-``, U+2212 or U+2013), ASCII digits with at most one decimal
mark, an optional exponent, and an optional unit behind it.

A statement that could change a figure is used, or refused with what to write; it is never passed
over. A key speaks of the readings where a stem of a subject stands alone or in the company of words
of readings, axes and gauges: ``tool offset`` and ``gear_ratio`` name another thing. Some stems can
hardly mean anything else and need no company; only a word of the robot or of its surroundings makes
them another thing's.
"""

from __future__ import annotations

import re
import tomllib
import unicodedata
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property, lru_cache
from itertools import chain
from pathlib import Path
from typing import NamedTuple, TypeVar

import numpy as np

from scara_iso.run import AXES, FloatArray

BLANKS = " \t\u00a0\u2007\u2009\u202f"
"""Blanks that surround a number: space, tab, the non-breaking ones, figure and thin space."""
MINUS = "\u2212"


class Mark(Enum):
    """The decimal mark that a number, or a column of them, was written with."""

    NONE = "none"
    POINT = "a decimal point"
    COMMA = "a decimal comma"
    EITHER = "a comma that is a decimal or a thousands mark"
    BOTH = "a comma and a point in one number"


@dataclass(frozen=True, slots=True)
class CellNumber:
    """A cell's value, how its decimal mark was written, and the text of the unit behind it."""

    value: float
    mark: Mark
    unit: str


_CELL = re.compile(
    r"([+-]?)([0-9.,]*[0-9][.,]?)([eE][+-]?[0-9]+)?"
    rf"[{BLANKS}]*([^0-9{BLANKS}\s.,+=()-][^0-9=]{{0,19}})?"
)
_MINUSES = str.maketrans({MINUS: "-", "\u2013": "-"})
"""The signs of a negative number besides ``-``: the minus of Unicode, and the dash of a text."""
_IN_GROUPS = re.compile(
    r"[+-]?[1-9][0-9]{0,2}(?:([\u00a0\u202f\u2009])[0-9]{3})(?:\1[0-9]{3})*(?![0-9])"
)
_ONE_MARK = re.compile(r"[0-9]*\.?[0-9]*")
_GROUP_COMMA = re.compile(r"[1-9][0-9]{0,2},[0-9]{3}")
_GROUPED = {
    ".": r"[1-9][0-9]{0,2}(?:,[0-9]{3})+(?:\.[0-9]*)?",
    ",": r"[1-9][0-9]{0,2}(?:\.[0-9]{3})+(?:,[0-9]*)?",
}
_PLAIN_BYTES = b"0123456789+-.eE \n"


def parse_cell(text: str, decimal: str | None = None) -> CellNumber | None:
    """Return the number that ``text`` spells, or None where it spells none.

    With ``decimal`` None a lone mark is taken as the decimal mark and its ambiguity reported in
    `CellNumber.mark`; thousands groups are read only when ``decimal`` says which mark is which. The
    value may be infinite (``1e400``): the caller checks. A number with both marks has value 0.
    """
    match = _CELL.fullmatch(_plain(text))
    if match is None:
        return None
    sign, digits, exponent, unit = match.groups("")
    mark = _mark_of(digits)
    if decimal is None:
        plain = "0" if mark is Mark.BOTH else digits.replace(",", ".")
    else:
        plain = _with_stated_mark(digits, decimal)
    if not _ONE_MARK.fullmatch(plain):
        return None
    return CellNumber(float(sign + plain + exponent), mark, unit.strip(BLANKS))


def _plain(text: str) -> str:
    """Return a cell with plain signs, its thousands without the blanks that split no table."""
    text = text.strip(BLANKS).translate(_MINUSES)
    grouped = _IN_GROUPS.match(text)
    return text if grouped is None else text.replace(grouped[1], "", grouped[0].count(grouped[1]))


def _mark_of(digits: str) -> Mark:
    point = "." in digits
    if "," not in digits:
        return Mark.POINT if point else Mark.NONE
    grouped = _GROUP_COMMA.fullmatch(digits) is not None
    return Mark.BOTH if point else Mark.EITHER if grouped else Mark.COMMA


def count_decimals(text: str) -> int | None:
    """Return the digits behind a number's decimal mark; None with an exponent, or for no number."""
    match = _CELL.fullmatch(_plain(text))
    if match is None or match[3]:
        return None
    return len(match[2].replace(",", ".").partition(".")[2])


def _with_stated_mark(digits: str, decimal: str) -> str:
    other = "," if decimal == "." else "."
    if other in digits:
        if not re.fullmatch(_GROUPED[decimal], digits):
            return "?"
        digits = digits.replace(other, "")
    return digits.replace(decimal, ".")


def cut_unit(cells: Sequence[str]) -> tuple[Sequence[str], str]:
    """Return cells without the unit that stands behind each of them, and that unit.

    The cells as they are and "" where they do not all end in the unit of the first.
    """
    first = parse_cell(cells[0]) if cells else None
    unit = first.unit if first else ""
    if not unit or set(unit) & set(".,") or not all(cell.endswith(unit) for cell in cells):
        return cells, ""
    return [cell.removesuffix(unit).rstrip(BLANKS) for cell in cells], unit


def parse_clean(cells: Sequence[str], decimal: str | None) -> tuple[FloatArray, Mark] | None:
    """Return the values, shape (cells,), of a column of plain finite numbers, or None.

    The quick way for what most files hold: over the characters ``0-9 + - . e E`` the grammar of
    ``float`` and that of `parse_cell` are the same. None means: go cell by cell.
    """
    joined = "\n".join(cells)
    comma, point = "," in joined, "." in joined
    if (comma and (point or decimal == ".")) or (point and decimal == ","):
        return None
    if comma:
        joined = joined.replace(",", ".")
    if not joined.isascii() or joined.encode().translate(None, _PLAIN_BYTES):
        return None
    try:
        plain = joined.split("\n") if comma else cells
        values = np.fromiter(map(float, plain), np.float64, len(plain))
    except ValueError:
        return None
    if not np.isfinite(values).all():
        return None
    if comma:
        sure = any("," in c and not _GROUP_COMMA.fullmatch(c.strip(" +-")) for c in cells)
        return values, Mark.COMMA if sure else Mark.EITHER
    return values, Mark.POINT if point else Mark.NONE


FORMULA = "=+-@\uff1d\uff0b\uff0d\uff20"
"""What a formula begins with, the second four in the width of East Asian letters."""
LONGEST_NAME = 80
"""Characters of the longest name of an axis; a longer one is a covariate's."""
LONGEST_LINE = 400
WORDS = {
    room: {name: tuple(" ".join(text.split()).split(", ")) for name, text in names.items()}
    for room, names in tomllib.loads(
        Path(__file__).with_name("words.toml").read_text("utf-8")  # resources start slower
    ).items()
}
"""The sheet: words by what they mean, by where they stand."""
_PLAIN = str.maketrans(
    {**dict.fromkeys(BLANKS, " "), **{chr(0xFEE0 + k): chr(k) for k in range(33, 127)}}
)
_Value = TypeVar("_Value")
_FOLDED = str.maketrans({"ß": "ss", "ø": "o", "θ": "theta", "ϑ": "theta"})


def clean(text: str) -> str:
    """Return ``text`` on one line, its blanks plain and single, full-width marks as ASCII."""
    return " ".join(text.translate(_PLAIN).split())


def fold(text: str) -> str:
    """Return a text in small letters without accents; German ``ue`` is as ``ü``."""
    plain = unicodedata.normalize("NFKD", text.casefold().translate(_FOLDED))
    plain = "".join(c for c in plain if not unicodedata.combining(c))
    return re.sub("([aou])e", r"\1", plain)


@lru_cache(maxsize=256)
def _listed(name: str) -> tuple[str, ...]:
    """Return the words that the sheet has by a name such as ``dial.name``; of lines folded."""
    room, _, of = name.partition(".")
    return tuple(map(fold, WORDS[room][of])) if room == "line" else WORDS[room][of]


def spelt(name: str) -> str:
    """Return a pattern of any of the words; a star is any ending, a blank any of blank and _."""
    words = map(re.escape, _listed(name))
    return f"(?:{'|'.join(words)})".replace(r"\*", r"\w*").replace(r"\ ", "[ _]")


class Pattern:
    """A pattern that is made when it is first asked; ``<dial.name>`` in it is any of those words.

    Where it always has one of the ``needed`` words, only texts with one ask it, which are few.
    """

    def __init__(self, template: str, *needed: str) -> None:
        self._template, self._needed = template, needed

    @cached_property
    def _pattern(self) -> re.Pattern[str]:
        return re.compile(re.sub(r"<(\w+\.\w+)>", lambda one: spelt(one[1]), self._template))

    @cached_property
    def _words(self) -> tuple[str, ...]:
        found = chain(*(_listed(one) if "." in one else (one,) for one in self._needed))
        return tuple(word.split()[0].strip("*") for word in found)

    def _asked(self, text: str) -> re.Pattern[str]:
        low = text.lower() if self._needed else ""
        return self._pattern if not self._needed or any(w in low for w in self._words) else _NEVER

    def finditer(self, text: str) -> Iterator[re.Match[str]]:
        """Return each place where a text has it."""
        return self._asked(text).finditer(text)

    def search(self, text: str) -> re.Match[str] | None:
        """Return the first place where a text has it."""
        return self._asked(text).search(text)

    def match(self, text: str) -> re.Match[str] | None:
        """Return how a text begins with it."""
        return self._asked(text).match(text)

    def fullmatch(self, text: str) -> re.Match[str] | None:
        """Return how it is all of a text."""
        return self._asked(text).fullmatch(text)

    def sub(self, other: str, text: str, count: int = 0) -> str:
        """Return a text with another in its places."""
        return self._asked(text).sub(other, text, count)


_NEVER = re.compile("(?!)")


def whole_words(name: str) -> Pattern:
    """Return the pattern of the sheet's words by a name, where no letter is beside them."""
    return Pattern(rf"(?<![^\W_])<{name}>(?![^\W_])", name)


_WORD = re.compile(r"[^\W_]+[\u0304\u0305]?")


def names_a_footer(label: str, *, short: bool = False) -> bool:
    """Return whether a label begins as a footer's; ``short``: also as ``s`` or ``n``."""
    words = _WORD.findall(label.lower())[:2]
    known = WORDS["footer"]["any"]
    return bool(words) and (
        words[0] in known
        or " ".join(words) in known
        or (short and words[0] in WORDS["footer"]["short"])
    )


_GERMAN = {german: english for english, names in WORDS["head"].items() for german in names}
_A_DATE = re.compile(r"[0-9][-/.][0-9]{1,2}[-/.][0-9]")


def in_english(stated: Mapping[str, _Value]) -> dict[str, _Value]:
    """Return statements by the keys that a report asks for; the second of one keeps its own."""
    found: dict[str, _Value] = {}
    for key, value in stated.items():
        plain = key != "data" or _A_DATE.search(str(value))  # in English data are readings
        english = _GERMAN.get(key.rstrip("."), key) if plain else key
        found[key if english in stated or english in found else english] = value
    return found


_LIMIT = whole_words("limit.name")


def names_a_limit(key: str) -> bool:
    """Say whether a key is that of a limit: ``Grenzwert RP``."""
    return _LIMIT.search(key.lower()) is not None and not is_of_another(key)


class Subject(Enum):
    """What changes a figure; of two in one key the first counts."""

    UNCERTAINTY = "an uncertainty"
    EXCLUDED = "excluded readings"
    SCALE = "a factor of readings"
    UNIT = "a unit"
    ZERO = "a zero"
    SIDE = "a side"


class Topic(NamedTuple):
    """What a key speaks of, and the axes that it names."""

    subject: Subject
    axes: tuple[str, ...] = ()


def stems_of(room: str, name: str) -> tuple[str, ...]:
    """Return the stems of the sheet by their name, folded."""
    return tuple(map(fold, WORDS[room].get(name, ())))


OWN_STEMS = {one: found for one in Subject if (found := stems_of("stem", one.name.lower()))}
"""Stems that need no company."""
_OTHERS, OF_READINGS = stems_of("other_stem", "another"), stems_of("other_stem", "reading")
_STEMS: dict[str, Subject | None] = {
    **dict.fromkeys((*OF_READINGS, *stems_of("other_stem", "company"))),
    **{stem: one for one in Subject for stem in stems_of("weak_stem", one.name.lower())},
    **{stem: one for one, stems in OWN_STEMS.items() for stem in stems},
}
_ENDINGS = frozenset(stems_of("other_stem", "ending"))
SHORTEST_STEM, _LONGEST_WORD = 3, 40
"""Letters of a stem that others, or an ending, may follow; and of a word that is looked at."""
_LENGTHS = frozenset(["mm", "um", "micron", "mikron", "inch", "zoll"])
_ANGLES = ("angl", "winkel", "angul", "angol")
_NO_WORD = r"(?i)\S*(?://|www\.)\S*|\bk[0-9]+"
"""An address, or the k-th of some things: the coverage factor is k alone."""


def words_of(text: str) -> list[str]:
    """Return the words of letters in a text, folded."""
    return re.findall(r"[^\W\d_]+", fold(text))


@lru_cache(maxsize=1024)
def topic_of(text: str) -> Topic | None:
    """Return what a key or heading speaks of, None where it is of another thing, or of none."""
    if len(text) > LONGEST_NAME:
        return None
    words = words_of(re.sub(_NO_WORD, " ", text).replace("/", " per "))
    parts = {word: stems_in(word) for word in words}
    known = {stem for found in parts.values() for stem in found or ()}
    subjects = {subject for stem in known if (subject := _STEMS[stem])}
    if ("per" in known and not _LENGTHS & known) or text.lower() in WORDS["footer"]["any"]:
        subjects -= {Subject.SCALE}
    if words[1:] and words[-1] in ("in", "en") and None not in parts.values():
        subjects.add(Subject.UNIT)
    if others := tuple(word for word, found in parts.items() if found is None):
        subjects = {one for one, stems in OWN_STEMS.items() if any_begins(words, stems)}
        if any_begins(others, _OTHERS):
            return None
    subject = next((one for one in Subject if one in subjects), None)
    named = [axis for axis in AXES if axis.lower() in {*words, *known}]
    if known.intersection(_ANGLES) and "theta" not in named:
        named.append("theta")
    return Topic(subject, tuple(named)) if subject else None


def any_begins(words: Iterable[str], stems: tuple[str, ...]) -> bool:
    """Say whether one of the words begins with one of the stems."""
    return any(word.startswith(stems) for word in words)


@lru_cache(maxsize=4096)
def stems_in(word: str) -> tuple[str, ...] | None:
    """Return the stems that make up a word with their endings, None where some of it is unknown.

    A stem of three letters or more may be followed by an axis, an ending, or another stem.
    """
    if word in _STEMS:
        return (word,)
    for end in range(min(len(word), _LONGEST_WORD), SHORTEST_STEM - 1, -1):
        stem, rest = word[:end], word[end:]
        if stem not in _STEMS or len(word) > _LONGEST_WORD:
            continue
        if rest in _ENDINGS:
            return (stem,)
        if rest in ("x", "y", "z"):
            return (stem, rest)
        for cut in range(len(rest) - SHORTEST_STEM + 1):
            more = stems_in(rest[cut:]) if not cut or rest[:cut] in _ENDINGS else None
            if more is not None:
                return (stem, *more)
    return None


def is_of_another(written: str) -> bool:
    """Say whether a key names the robot, its conditions or its surroundings."""
    return any_begins(words_of(written), _OTHERS)


def names_an_instrument(heading: str) -> bool:
    """Say whether a heading is a reading's and names no axis: ``dial``, ``Messwert``."""
    parts = list(map(stems_in, words_of(heading))) if len(heading) <= LONGEST_NAME else []
    known = [stem for found in parts for stem in found or ()]
    return bool(parts) and None not in parts and {*known} <= {*OF_READINGS}


def numbers_a_thing(heading: str) -> bool:
    """Say whether a heading is that of numbers of robots or dials: ``robot``, ``Serial no``."""
    return _NUMBERED.fullmatch(clean(heading).lower()) is not None


_MARKED = whole_words("heading.marked")
"""A column that marks some rows, where it has two values and one of them is rare."""
_PLAIN_WORDS = {one: whole_words(f"heading.{one}") for one in ("valid", "excluded", "side", "zero")}
_NUMBERED = Pattern(
    r"(?:<heading.number>[ _.]+(?:de |di )?)?<heading.numbered>"
    r"(?:[ _.-]{0,3}<heading.number>){0,3}[ _.]*[0-9]?",
    "heading.numbered",
)
"""A column that numbers what is tested, or with what."""
_COMMANDED = whole_words("heading.commanded")
"""What with an axis is a zero that its readings may be from."""
_UNIT_BEHIND = r" ?[\[(][^\[\]()]*[\])]$"
_TAKEN_OFF = Pattern(
    r"(?:x|y|z|theta)[ _]?[0o]|(?:.*[ _])?<heading.correction>(?:[ _](?:x|y|z|theta))?"
)
"""What may have been taken from readings, or is still to be, where it changes."""


def plain_heading(heading: str) -> str:
    """Return a heading with the plain word for a side, a zero, and what counts or does not."""
    heading = heading.lower()
    for plain, words in _PLAIN_WORDS.items():
        heading = words.sub(plain, heading)
    return heading


def subject_of_heading(heading: str) -> Subject | None:
    """Return what of the readings a column is by its heading, None where it is another thing."""
    low = heading.lower()
    if _TAKEN_OFF.fullmatch(re.sub(_UNIT_BEHIND, "", low)):
        return Subject.ZERO
    if _MARKED.search(low):
        return Subject.EXCLUDED
    topic = topic_of(plain_heading(heading))
    if topic is None and (topic := topic_of(_COMMANDED.sub("zero", low))):
        topic = topic if topic.axes else None
    return topic.subject if topic and len(heading) > 1 else None


_SHOWN, _WHOLE = 30, 2000


def quoted(text: str) -> str:
    """Return ``text`` quoted, escaped and cut for a message."""
    return repr(text if len(text) <= _SHOWN else text[:_SHOWN] + "…")


def quoted_whole(text: str) -> str:
    """Return words of the user quoted and escaped, to their end."""
    half = _WHOLE // 2
    return repr(text if len(text) <= _WHOLE else f"{text[:half]}…{text[-half:]}")


def listed(items: Iterable[str]) -> str:
    """Return ``a, b and c``."""
    *head, last = items
    return f"{', '.join(head)} and {last}" if head else last


RESOLUTION, UNCERTAINTY = "resolution", "indicator_uncertainty"
OF_AXES = ("unit", RESOLUTION, UNCERTAINTY)
"""Keys that the axes of a `Run` hold, alone or with ``_X`` and the like behind."""
COMMAND = "command"  # pose: with ``_X`` and the like behind, and ``[P3]`` for one of several
AXES_IN_KEYS = tuple(map(str.lower, AXES))
AN_AXIS_IN_A_KEY = f"({'|'.join(AXES_IN_KEYS)})"
OF_A_POSE = re.compile(rf"{COMMAND}_{AN_AXIS_IN_A_KEY}\[([^\[\]]+)\]")
_OF_AN_AXIS = re.compile(
    rf"(?:{'|'.join(OF_AXES)})(?:_{AN_AXIS_IN_A_KEY})?|{COMMAND}_{AN_AXIS_IN_A_KEY}|{OF_A_POSE.pattern}"
)


def is_of_axes(key: str) -> bool:
    """Return whether a statement is about the axes and so is held by them."""
    return _OF_AN_AXIS.fullmatch(key) is not None


CORRECTION_KEYS = {
    "correction": "points",
    "correction_zero": "zero",
    "correction_uncertainty": "uncertainty",
    "alignment": "alignment_deg",
    "alignment_uncertainty": "alignment_u_deg",
}
"""Keys of what corrects an axis, with ``_X`` and the like behind, and what of it they state."""
OF_A_CORRECTION = re.compile(rf"(?i)({'|'.join(CORRECTION_KEYS)})_({'|'.join(AXES)})")


def is_of_corrections(key: str) -> bool:
    """Return whether a statement corrects the readings of an axis."""
    return OF_A_CORRECTION.fullmatch(key) is not None
