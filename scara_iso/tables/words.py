"""What the words of a file mean: the sheet words.toml, and what a key or a heading speaks of.

A statement that could change a figure is used, or refused with what to write; it is never passed
over. A key speaks of the readings where a stem of a subject stands alone or in the company of words
of readings, axes and gauges: ``tool offset`` and ``gear_ratio`` name another thing. Some stems can
hardly mean anything else and need no company; only a word of the robot or of its surroundings makes
them another thing's.
"""

from __future__ import annotations

import math
import re
import tomllib
import unicodedata
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import Enum
from functools import lru_cache
from itertools import chain
from pathlib import Path
from typing import TypeVar

from scara_iso.run import AXES
from scara_iso.tables.numbers import BLANKS

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


def any_of(words: Iterable[str]) -> str:
    """Return a pattern of any of the words; a star is any ending, a blank any of blank and _."""
    parts = (re.escape(word).replace(r"\*", r"\w*").replace(r"\ ", "[ _]") for word in words)
    return f"(?:{'|'.join(parts)})"


def _whole(words: Iterable[str]) -> re.Pattern[str]:
    return re.compile(rf"(?<![^\W_]){any_of(words)}(?![^\W_])")


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


_LIMIT = _whole(WORDS["limit"]["name"])


def names_a_limit(key: str) -> bool:
    """Say whether a key is that of a limit: ``Grenzwert RP``."""
    return _LIMIT.search(key.lower()) is not None and not is_of_another(key)


def is_free_key(written: str, key: str) -> bool:
    """Say whether a key may be of anything, by all that is known of its words."""
    named = key in (*WORDS["remark"]["free"], *WORDS["remark"]["numbered"], *WORDS["head"])
    known = named or topic_of(written) or names_a_limit(key)
    return not (known or is_of_another(written) or numbers_a_thing(written))


def says_nothing(text: str) -> bool:
    """Say whether a value states that there is nothing: 0, none, nein, no."""
    return not text.strip() or text.strip().casefold().rstrip(".") in WORDS["value"]["nothing"]


class Subject(Enum):
    """What changes a figure; of two in one key the first counts."""

    UNCERTAINTY = "an uncertainty"
    EXCLUDED = "excluded readings"
    SCALE = "a factor of readings"
    UNIT = "a unit"
    ZERO = "a zero"
    SIDE = "a side"


@dataclass(frozen=True, slots=True)
class Topic:
    """What a key speaks of, and the axes that it names."""

    subject: Subject
    axes: tuple[str, ...] = ()


def _folded(room: str, name: str) -> tuple[str, ...]:
    return tuple(map(fold, WORDS[room].get(name, ())))


_OWN_STEMS = {one: found for one in Subject if (found := _folded("stem", one.name.lower()))}
"""Stems that need no company."""
_OTHERS, _OF_READINGS = _folded("other_stem", "another"), _folded("other_stem", "reading")
_STEMS: dict[str, Subject | None] = {
    **dict.fromkeys((*_OF_READINGS, *_folded("other_stem", "company"))),
    **{stem: one for one in Subject for stem in _folded("weak_stem", one.name.lower())},
    **{stem: one for one, stems in _OWN_STEMS.items() for stem in stems},
}
_ENDINGS = frozenset(_folded("other_stem", "ending"))
_SHORTEST, _LONGEST_WORD = 3, 40
"""Letters of a stem that others, or an ending, may follow; and of a word that is looked at."""
_LENGTHS = frozenset(["mm", "um", "micron", "mikron", "inch", "zoll"])
_ANGLES = ("angl", "winkel", "angul", "angol")
_NO_WORD = re.compile(r"\S*(?://|www\.)\S*|\bk[0-9]+", re.IGNORECASE)
"""An address, or the k-th of some things: the coverage factor is k alone."""


def _words_of(text: str) -> list[str]:
    return re.findall(r"[^\W\d_]+", fold(text))


@lru_cache(maxsize=1024)
def topic_of(text: str) -> Topic | None:
    """Return what a key or heading speaks of, None where it is of another thing, or of none."""
    if len(text) > LONGEST_NAME:
        return None
    words = _words_of(_NO_WORD.sub(" ", text).replace("/", " per "))
    parts = {word: _parts(word) for word in words}
    known = {stem for found in parts.values() for stem in found or ()}
    subjects = {subject for stem in known if (subject := _STEMS[stem])}
    if ("per" in known and not _LENGTHS & known) or text.lower() in WORDS["footer"]["any"]:
        subjects -= {Subject.SCALE}
    if words and words[-1] in ("in", "en") and None not in parts.values():
        subjects.add(Subject.UNIT)
    if others := tuple(word for word, found in parts.items() if found is None):
        subjects = {one for one, stems in _OWN_STEMS.items() if any(_begin(words, stems))}
        if any(_begin(others, _OTHERS)):
            return None
    subject = next((one for one in Subject if one in subjects), None)
    named = [axis for axis in AXES if axis.lower() in {*words, *known}]
    if known.intersection(_ANGLES) and "theta" not in named:
        named.append("theta")
    return Topic(subject, tuple(named)) if subject else None


def _begin(words: Iterable[str], stems: tuple[str, ...]) -> Iterable[bool]:
    return (word.startswith(stems) for word in words)


@lru_cache(maxsize=4096)
def _parts(word: str) -> tuple[str, ...] | None:
    """Return the stems that make up a word with their endings, None where some of it is unknown.

    A stem of three letters or more may be followed by an axis, an ending, or another stem.
    """
    if word in _STEMS:
        return (word,)
    for end in range(min(len(word), _LONGEST_WORD), _SHORTEST - 1, -1):
        stem, rest = word[:end], word[end:]
        if stem not in _STEMS or len(word) > _LONGEST_WORD:
            continue
        if rest in _ENDINGS:
            return (stem,)
        if rest in ("x", "y", "z"):
            return (stem, rest)
        for cut in range(len(rest) - _SHORTEST + 1):
            more = _parts(rest[cut:]) if not cut or rest[:cut] in _ENDINGS else None
            if more is not None:
                return (stem, *more)
    return None


def is_of_another(written: str) -> bool:
    """Say whether a key names the robot, its conditions or its surroundings."""
    return any(_begin(_words_of(written), _OTHERS))


def affirms(written: str) -> bool:
    """Say whether a key names what counts, as ``valid`` does."""
    words = _words_of(written)
    denied = any(word in ("not", "non", "no", "nicht", "pas") for word in words)
    return any(_begin(words, ("valid", "gultig"))) and not denied


def unknown_words(text: str) -> list[str]:
    """Return the words of three letters or more that no stem of the readings explains."""
    return [w for w in _words_of(text) if _parts(w) is None and (len(w) > 2 or not w.isascii())]


def names_an_instrument(heading: str) -> bool:
    """Say whether a heading is a reading's and names no axis: ``dial``, ``Messwert``."""
    parts = list(map(_parts, _words_of(heading))) if len(heading) <= LONGEST_NAME else []
    known = [stem for found in parts for stem in found or ()]
    return bool(parts) and None not in parts and {*known} <= {*_OF_READINGS}


def numbers_a_thing(heading: str) -> bool:
    """Say whether a heading is that of numbers of robots or dials: ``robot``, ``Serial no``."""
    return _NUMBERED.fullmatch(clean(heading).lower()) is not None


_MARKED = _whole(WORDS["heading"]["marked"])
"""A column that marks some rows, where it has two values and one of them is rare."""
_PLAIN_WORDS = {
    plain: _whole(WORDS["heading"][plain]) for plain in ("valid", "excluded", "side", "zero")
}
_NUMBER = any_of(WORDS["heading"]["number"])
_NUMBERED = re.compile(
    rf"(?:{_NUMBER}[ _.]+(?:de |di )?)?{any_of(WORDS['heading']['numbered'])}"
    rf"(?:[ _.-]{{0,3}}{_NUMBER}){{0,3}}[ _.]*[0-9]?"
)
"""A column that numbers what is tested, or with what."""
_COMMANDED = _whole(WORDS["heading"]["commanded"])
"""What with an axis is a zero that its readings may be from."""
_TAKEN_OFF = re.compile(
    rf"(?:x|y|z|theta)[ _]?[0o]|(?:.*[ _])?{any_of(WORDS['heading']['correction'])}"
    r"(?:[ _](?:x|y|z|theta))?"
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
    if _TAKEN_OFF.fullmatch(low):
        return Subject.ZERO
    if _MARKED.search(low):
        return Subject.EXCLUDED
    topic = topic_of(plain_heading(heading))
    if topic is None and (topic := topic_of(_COMMANDED.sub("zero", low))):
        topic = topic if topic.axes else None
    return topic.subject if topic and len(heading) > 1 else None


_DENIED = any_of(WORDS["remark"]["denied"])
_UNCOUNTED = re.compile(
    rf"\b{_DENIED}\b.{{0,12}}\b{any_of(WORDS['remark']['counted'])}\b"
    rf"|n.t (?:count|use)|\bzähl\w* nicht|\b{any_of(WORDS['remark']['begun'])}"
)
_STRUCK_ALONE = re.compile(rf"\*|{any_of(WORDS['remark']['alone'])}")


def denies(text: str) -> bool:
    """Say whether words deny that something counts: ``not counted``, ``nicht gewertet``."""
    return _UNCOUNTED.search(text.lower()) is not None


def strikes_its_row(remark: str) -> bool:
    """Say whether a remark says of its row that it does not count."""
    topic = topic_of(remark)
    excluded = topic is not None and topic.subject is Subject.EXCLUDED and not affirms(remark)
    return excluded or denies(remark) or _STRUCK_ALONE.fullmatch(remark.lower()) is not None


_LINE = {name: any_of(map(fold, words)) for name, words in WORDS["line"].items()}
OF_CYCLES = any_of(WORDS["remark"]["cycle"])
_OF_CYCLES = any_of((*WORDS["remark"]["cycle"], *WORDS["remark"]["reading"]))
_A_CYCLE = re.compile(
    rf"\b(?:{_OF_CYCLES}|{any_of(WORDS['column']['cycle'])})\.? ?(?:1\b\W*(?:\w{{1,3}} )?)?"
    r"([2-9]|[1-9][0-9]{1,2})\b"
)
_SOME_CYCLES = re.compile(
    rf"\b(?:{_OF_CYCLES}\.? ?(?:1\b\W*(?:\w{{1,3}} )?)?([2-9]|[1-9][0-9]{{1,2}})\b"
    rf"|([2-9]|[1-9][0-9]{{1,2}}) ?(?:\.|st|nd|rd|th|e|ème|[ºª°]) {_OF_CYCLES}\b"
    rf"|{any_of(WORDS['remark']['several'])} (?!1 )\w+ {_OF_CYCLES}\b"
    rf"|{any_of(WORDS['remark']['visits'])} ([2-9]|[1-9][0-9]{{1,2}}) ?:)"
)
"""Cycles 7-9, the 7th cycle, the first two cycles, visit 7: and what of it."""
_CYCLES = re.compile(
    rf"\b(?:{_OF_CYCLES}|{any_of(WORDS['column']['cycle'])}|{any_of(WORDS['remark']['visits'])}"
    rf"|{any_of(WORDS['remark']['several'])} [0-9]+)\b"
)
_A_POSE = re.compile(rf"\b(?:{any_of(WORDS['pose']['name'])}[ _.-]?p?|p)[0-9]+\b")
_COUNTS = re.compile(rf"\b{any_of(WORDS['remark']['counted'])}\b")
_FIRST = rf"(?:{_LINE['first']}(?: {_OF_CYCLES})?|1\. ?{_OF_CYCLES}|(?:{_OF_CYCLES}|run|lauf) 1)"
_FIRST_DISCARDED = re.compile(rf"\b{_FIRST}\b(?! [2-9])[^0-9]{{0,20}}\b{_LINE['discarded']}")
_FIRST_GONE = re.compile(
    rf"\b(?:{_LINE['first']}|{_LINE['warm_up']}) ?(?:{_OF_CYCLES}|run|lauf)\b"
    rf"(?:(?!\b{_DENIED}\b).){{0,30}}\b{_LINE['gone']}"
    rf"|\b{_LINE['already']} (?:{_LINE['gone']}|{_LINE['discarded']}|gestrich)"
    rf"|{_LINE['first_go']}(?:(?![未没]).){{0,12}}{_LINE['taken']}(?!.*ない)"
)


def speaks_of_cycles(text: str, rows: float = math.inf) -> bool:
    """Say whether words speak of some of the cycles of ``rows`` rows, but for the first.

    The number of all of them speaks of none, but where the words say that it does not count.
    """
    low = text[:LONGEST_LINE].lower()
    struck = _A_CYCLE.search(low) is not None and strikes_its_row(text)
    if struck or _says_what_counts(low):
        return True
    found = (next((int(n) for n in one.groups() if n), 0) for one in _SOME_CYCLES.finditer(low))
    return any(number < rows for number in found)


_OF_SIZE = re.compile(
    r"[0-9] ?%|\b[0-9] ?: ?[0-9]+\b|\b[0-9]+ ?: ?1\b"
    r"|\b[0-9]+(?:[.,][0-9]+)?-? ?(?:x|×|fach\w*|times|mal|fois|volte|veces|vezes)\b"
    r"|[0-9] ?(?:°(?! ?c)|deg\b|degrees|grad\b|degrés|gradi|grados)"
    rf"|\b{any_of(WORDS['remark']['size'])}\b"
)


_SMOOTHED = re.compile(
    rf"{any_of(WORDS['remark']['smooth'])}|\b{any_of(WORDS['remark']['mean'])}"
    rf"(?: [^\W\d]+){{0,2}} (?!1\b)[0-9]{{1,3}}(?![.,:/%\w]| ?{any_of(WORDS['remark']['unit'])}\b)"
)
"""Values that are means of others: ``moving average``, ``mean of 3 readings``; or chosen."""


def speaks_of_size(text: str) -> bool:
    """Say whether words of an axis or of readings may say that they are larger, turned or means."""
    low = text[:LONGEST_LINE].lower()
    of_readings = _speaks_of_readings(low) and not is_of_another(low)
    return bool((of_readings and _OF_SIZE.search(low)) or _SMOOTHED.search(low))


_VALUES = re.compile(rf"\b{_LINE['values']}")
_LONG_STEMS = tuple(stem for stem in _OF_READINGS if len(stem) >= _SHORTEST)


def _speaks_of_readings(text: str) -> bool:
    known = (*map(str.lower, AXES), *_OF_READINGS)
    return any(w in known or w.startswith(_LONG_STEMS) for w in _words_of(text))


def _says_what_counts(low: str) -> bool:
    """Say whether words say that something counts or not, and name cycles, readings, or how many.

    That the first cycle is discarded is no news, nor that nothing is.
    """
    outliers = any(_begin(_words_of(low), _OWN_STEMS[Subject.EXCLUDED]))
    parts = {part for word in _words_of(low) for part in _parts(word) or ()}
    of_an_axis = not parts.isdisjoint(map(str.lower, AXES))
    excludes = outliers or not parts.isdisjoint(_EXCLUDING)
    if _FIRST_DISCARDED.search(fold(low)) or says_that_all_count(low):
        return False
    of_a_pose, of_cycles = (one.search(low) is not None for one in (_A_POSE, _CYCLES))
    if denies(low) and (of_a_pose or of_cycles):
        return True
    if is_of_another(low) or denies(low):
        return not is_of_another(low) and _VALUES.search(fold(low)) is not None
    counts = _COUNTS.search(low) is not None
    some = of_an_axis or of_a_pose or _SOME.search(low) is not None
    some = some and not (affirms(low) and _may_be_a_certificate(low))
    return outliers or (counts and of_cycles) or (excludes and (some or of_cycles))


def _may_be_a_certificate(low: str) -> bool:
    """Say whether what is valid may be another thing: ``Dial X: Mitutoyo, valid until 2027``."""
    others = (w for w in _words_of(low) if not {*_EXCLUDING}.intersection(_parts(w) or ()))
    unknown = any(len(w) > len("but") for w in unknown_words(low))
    return unknown and _VALUES.search(fold(" ".join(others))) is None


_EXCLUDING = _folded("weak_stem", "excluded")
_SOME = re.compile(rf"\b{any_of((*WORDS['remark']['several'], *WORDS['remark']['whole']))}\b")
_NONE, _ALL = (_whole(words) for words in (WORDS["remark"]["none"], WORDS["value"]["all"]))


def says_that_all_count(text: str) -> bool:
    """Say whether words say that nothing is left out: ``no outliers removed``, ``all valid``."""
    low = clean(text).lower()
    if unknown_words(low) or re.search(rf"[0-9]|\b{OF_CYCLES}\b", low):
        return False
    if affirms(low) or _COUNTS.search(low):
        excluded = any(_begin(_words_of(low), _OWN_STEMS[Subject.EXCLUDED]))
        return not excluded and not _NONE.search(low) and _ALL.match(low) is not None
    return _NONE.match(low) is not None


NUMBER = r"[-+±−]?[0-9]+(?:[.,][0-9]+)?(?:e[-+]?[0-9]+)?"
_POWER = re.compile(
    r"(?:mal|times|[x×·*]) ?10 ?(?:\^ ?[({]?|\*\* ?|e|(?=[-−⁻⁰¹²³⁴⁵⁶⁷⁸⁹]))[-−+⁻]?[0-9⁰¹²³⁴⁵⁶⁷⁸⁹]"
)
_PARTS = _LINE["part"]
_FRACTION = re.compile(
    rf"(?<![0-9] )(?<![0-9])\b{_PARTS}(?: \w{{1,5}}){{0,2}} ?-?{_LINE['length']}\b"
)
_IN_PARTS = (
    rf"\W*{_PARTS}\W*"
    rf"|.*\b(?:in|en|einheit|unit|unite|unita|unidad):? (?:{_PARTS}\b|1/10+)"
    r"(?!0| ?(?:s\b|sec|sek)).*"
    rf"|.*\b(?:in|en) {_LINE['step']}.*"
)
_ALONE = re.compile(
    rf"\W*(?:[x×·*] ?{NUMBER}(?: ?[a-zµμ]+)?|(?:in )?mm ?/ ?10+|1e-?[0-9] ?[a-zµμ]+"
    r"|1/10+ ?[a-zµμ]*)[^\w:=]*"
)
"""A line that is nothing but a factor, or a part of a unit."""
_ONE_COUNT = re.compile(
    rf"(?:^\W*|[,;:(] ?){_LINE['one']} {_LINE['count']}(?: \w+)? ?"
    rf"(?:[=:,;≙≈]|{_LINE['equals']})+ ?(?!1 ?mm){NUMBER}"
)
"""What one step of a display is, in a text whose words blanks part."""
_TIMES = re.compile(
    rf"(?<!\w){_LINE['values']} ?(?:[x×·*]|mal|times|fois) ?[0-9]*[.,]?[0-9]+"
    rf"|\b{_LINE['by']} 10+ (?:zu )?{_LINE['divided']}|\bdivid\w* {_LINE['by']} 10+\b"
)
_CORRECTION = re.compile(rf"\b(?:{_LINE['taken_off']}|{_LINE['too']} {_LINE['much']})")
_OTHER_SIDE = re.compile(rf"\b{_LINE['other_side']}")
_WORD_AND_NUMBER = re.compile(
    rf"([^\W\d_]+)(?: (?:by|of|is|with|mit|um|par|per|por|di|de|von|=))? {NUMBER}(?![\w-])"
)
_NUMBER_AND_WORD = re.compile(r"(?<!\w)(?<!\d[.,])[0-9]+(?:[.,][0-9]+)? (?:zu )?([^\W\d_]+)")
_SUPERSCRIPT_SIGN = str.maketrans({"⁻": "-"})


def speaks_of_scale(text: str) -> bool:
    """Say whether a line of text states a factor of all values: ``mm x 10^-2``, ``values x 0.01``.

    A size in front of which a number stands, as ``2 hundredths of a mm``, is none.
    """
    text = text[:LONGEST_LINE]
    low = fold(clean(text.translate(_SUPERSCRIPT_SIGN)))
    if _POWER.search(clean(text).lower()) or _FRACTION.search(low):
        return True
    if _ALONE.fullmatch(low) or _ONE_COUNT.search(re.sub(r"[\s_-]+", " ", low)):
        return True
    stems = _OWN_STEMS[Subject.SCALE]
    found = chain(_WORD_AND_NUMBER.finditer(low), _NUMBER_AND_WORD.finditer(low))
    named = (one[1] for one in found)
    return _TIMES.search(low) is not None or any(_begin(named, stems))


def in_parts_of_a_unit(text: str) -> bool:
    """Say whether a line may state the unit, of which it names a part: ``Werte in Hundertstel``."""
    return re.fullmatch(_IN_PARTS, fold(text[:LONGEST_LINE])) is not None


def moves_readings(text: str) -> str:
    """Return what to do about a line that corrects readings, or takes them from two sides.

    Nothing where it speaks of something else than readings: ``2 degrees too warm``.
    """
    low = fold(text[:LONGEST_LINE])
    if _OTHER_SIDE.search(low):
        return "state the side of each row in a column approach (+1, -1), and leave this out"
    if _FIRST_GONE.search(low):
        return "say '# first_cycle_discarded: true' if it is not in the table, and leave this out"
    is_sized = re.search(r"(?<!\w)[0-9]", low) is not None and not is_of_another(text)
    if is_sized and _speaks_of_readings(text) and _CORRECTION.search(low):
        return "write readings that are right, and leave this out"
    return ""
