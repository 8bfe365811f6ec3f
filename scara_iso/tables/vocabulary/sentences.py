"""What sentences say of readings: which cycles count, how large readings are, what moves them."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Callable, Collection, Container
from itertools import chain

from scara_iso.run import AXES
from scara_iso.tables.vocabulary.words import (
    LONGEST_LINE,
    LONGEST_NAME,
    OF_READINGS,
    OWN_STEMS,
    SHORTEST_STEM,
    WORDS,
    Pattern,
    Subject,
    any_begins,
    clean,
    fold,
    is_of_another,
    spelt,
    stems_in,
    stems_of,
    topic_of,
    whole_words,
    words_of,
)

_UNCOUNTED = Pattern(
    r"\b<remark.denied>\b.{0,12}\b<remark.counted>\b"
    r"|n.t (?:count|use)|\bzähl\w* nicht|\b<remark.begun>",
    "remark.counted",
    "remark.begun",
)
_CLAUSES = rf"(?i)[,;!()–]|\.(?= )|(?<!\S){spelt('remark.joint')}(?!\S)"
_STRUCK_ALONE = Pattern(r"\*|<remark.alone>")


def affirms(written: str) -> bool:
    """Say whether a key names what counts, as ``valid`` does."""
    words = words_of(written)
    denied = any(word in ("not", "non", "no", "nicht", "pas") for word in words)
    return any_begins(words, ("valid", "gultig")) and not denied


def unknown_words(text: str) -> list[str]:
    """Return the words of three letters or more that no stem of the readings explains."""
    return [w for w in words_of(text) if stems_in(w) is None and (len(w) > 2 or not w.isascii())]


def denies(text: str) -> bool:
    """Say whether words deny that something counts: ``not counted``, ``nicht gewertet``."""
    return _UNCOUNTED.search(text.lower()) is not None


def strikes_its_row(remark: str) -> bool:
    """Say whether a remark, or a clause of it, says of its row that it does not count."""
    if denies(remark) or _STRUCK_ALONE.fullmatch(remark.lower()):
        return True
    for clause in chain([remark], re.split(_CLAUSES, remark)):
        for part in textwrap.wrap(clause, LONGEST_NAME):
            topic = topic_of(part)
            if topic and topic.subject is Subject.EXCLUDED and not affirms(part):
                return True
        if len(clause.strip()) > 1 and _STRUCK_ALONE.fullmatch(clause.strip().lower()):
            return True
    return False


_CYCLES = "(?:<remark.cycle>|<remark.reading>)"
_NUMBER_OF_ONE = r"\.? ?(?:1\b\W*(?:\w{1,3} )?)?([2-9]|[1-9][0-9]{1,2})\b"
_A_CYCLE = Pattern(rf"\b(?:{_CYCLES}|<column.cycle>){_NUMBER_OF_ONE}")
_SOME_CYCLES = Pattern(
    rf"\b(?:{_CYCLES}{_NUMBER_OF_ONE}"
    rf"|([2-9]|[1-9][0-9]{{1,2}}) ?(?:\.|st|nd|rd|th|e|ème|[ºª°]) {_CYCLES}\b"
    rf"|<remark.several> (?!1 )\w+ {_CYCLES}\b"
    r"|<remark.visits> ([2-9]|[1-9][0-9]{1,2}) ?:)",
    "remark.cycle",
    "remark.reading",
    "remark.visits",
)
"""Cycles 7-9, the 7th cycle, the first two cycles, visit 7: and what of it."""
_OF_CYCLES = Pattern(rf"\b(?:{_CYCLES}|<column.cycle>|<remark.visits>|<remark.several> [0-9]+)\b")
_A_POSE = Pattern(r"\b(?:<pose.name>[ _.-]?p?|p)[0-9]+\b")
_COUNTS = Pattern(r"\b<remark.counted>\b", "remark.counted")
_FIRST_DISCARDED = Pattern(
    rf"\b(?:<line.first>(?: {_CYCLES})?|1\. ?{_CYCLES}|(?:{_CYCLES}|run|lauf) 1)\b(?! [2-9])"
    r"[^0-9]{0,20}\b<line.discarded>"
)
_FIRST_GONE = Pattern(
    rf"\b(?:<line.first>|<line.warm_up>) ?(?:{_CYCLES}|run|lauf)\b"
    r"(?:(?!\b<remark.denied>\b).){0,30}\b<line.gone>"
    r"|\b<line.already> (?:<line.gone>|<line.discarded>|gestrich)"
    r"|<line.first_go>(?:(?![未没]).){0,12}<line.taken>(?!.*ない)",
    "line.first",
    "line.warm_up",
    "line.already",
    "line.first_go",
)


def speaks_of_cycles(text: str, rows: float = math.inf) -> bool:
    """Say whether words speak of some of the cycles of ``rows`` rows, but for the first.

    The number of all of them speaks of none, but where the words say that it does not count.
    """
    low = text[:LONGEST_LINE].lower()
    struck = strikes_its_row(text) and _A_CYCLE.search(low) is not None
    if struck or _says_what_counts(low):
        return True
    found = (next((int(n) for n in one.groups() if n), 0) for one in _SOME_CYCLES.finditer(low))
    return any(number < rows for number in found)


def counts_some_cycles(text: str, sizes: Collection[int]) -> bool:
    """Say whether words count cycles, or name one of those of a pose, ``sizes`` are how many.

    All of them, and all but the first, are what a test has.
    """
    text = clean(text[:LONGEST_LINE])
    counts = {int(one[1]) for one in _COUNT_OF_CYCLES.finditer(text.lower())}
    numbers = {int(one[1] or one[2]) for one in _ONE_VISIT.finditer(text)}
    usual = {size - k for size in sizes for k in (0, 1)}
    most = max(sizes)
    return any(n < most for n in counts - usual) or any(n <= most for n in numbers)


_COUNT_OF_CYCLES = Pattern(
    r"(?<![\w.,:/-])([2-9]|[1-9][0-9]{1,3}) <remark.cycle>\b"
    r"(?! ?(?:/|a|an|je|pro|per|par|por|al)\b)",
    "remark.cycle",
)
_ONE_VISIT = Pattern(
    r"(?i:\b<remark.one_cycle>)"
    r"\.? ([2-9]|[1-9][0-9]{1,2}),? (?!of\b|von\b|de\b|di\b)[^\W\d_A-Z]"
    r"|(?i:\b<remark.visits>) ([2-9]|[1-9][0-9]{1,2}),? [^\W\d_A-Z]{4}",
    "remark.one_cycle",
    "remark.visits",
)
"""The number of a cycle and what of it: ``Zyklus 31 geschätzt``; a name has a capital letter."""


def may_be_of_readings(text: str, sentence: float) -> bool:
    """Say whether a clause names readings, zero, dial or fixture, and says what is not understood.

    That is a word in small letters that is neither a stem of readings nor a usual word of forms.
    A clause of a ``sentence``, of so many words, may be of readings if it names nothing at all.
    """
    clauses = re.split(_CLAUSES, text[:LONGEST_LINE].strip("# "))
    return any(_is_not_understood(clause, sentence) for clause in clauses)


def _is_not_understood(clause: str, sentence: float) -> bool:
    left = without_explained(clause)
    of_readings = {*OF_READINGS, *stems_of("weak_stem", "zero")}
    stems = {stem for word in words_of(left) for stem in stems_in(word) or ()}
    named = not stems.isdisjoint(of_readings) or _SETUP.search(fold(left))
    if is_of_another(left) or not (named or _may_say(clause, sentence)):
        return False
    small = [w for w in re.findall(r"(?<![\w'’])[^\W\d_]{3,}", left) if not w[0].isupper()]
    return any(not _KNOWN.fullmatch(word) for word in unknown_words(" ".join(small)))


def _may_say(clause: str, words: float) -> bool:
    """Say whether a clause has so many words, small letters, and no date or number to be named by.

    Where blanks part no words, and no letter is small, letters of grammar show a sentence.
    """
    grammar = any("ぁ" <= letter <= "ん" for letter in clause)
    parted = len(re.findall(r"(?<!\S)[^\W\d_]{2,}(?:-[^\W\d_]+)?(?!\S)", clause))
    found = len(clause) // _LONG_WITHOUT_BLANKS if grammar else parted
    if found < words or _DATED_OR_NUMBERED.search(clause):
        return False
    return grammar or any(map(str.islower, clause))


_SETUP = Pattern(r"\b<line.setup>\b")
_KNOWN = Pattern("<line.setup>|<line.usual>|<line.first>|<remark.several>")
_LONG_WITHOUT_BLANKS = 3
"""Letters of a word in a script that parts none by blanks."""
_SIZE_IN_NUMBERS = Pattern(
    r"[0-9] ?%|\b[0-9] ?: ?[0-9]+\b|\b[0-9]+ ?: ?1\b"
    r"|\b[0-9]+(?:[.,][0-9]+)?-? ?(?:x|×|fach\w*|times|mal|fois|volte|veces|vezes)\b"
    r"|[0-9] ?(?:°(?! ?c)|deg\b|degrees|grad\b|degrés|gradi|grados)"
)
_SIZE_IN_WORDS = Pattern(r"\b<remark.size>\b", "remark.size")
_SMOOTHED = Pattern(
    r"<remark.smooth>"
    r"|\b<remark.mean>(?: [^\W\d]+){0,2} (?!1\b)[0-9]{1,3}(?![.,:/%\w]| ?<remark.unit>\b)",
    "remark.smooth",
    "remark.mean",
)
"""Values that are means of others: ``moving average``, ``mean of 3 readings``; or chosen."""


def speaks_of_size(text: str) -> bool:
    """Say whether words of an axis or of readings may say that they are larger, turned or means."""
    low = text[:LONGEST_LINE].lower()
    named = _speaks_of_readings(low) or _VALUES.search(fold(low))
    of_readings = named and not is_of_another(low)
    sized = of_readings and (_SIZE_IN_WORDS.search(low) or _SIZE_IN_NUMBERS.search(low))
    return bool(sized or _SMOOTHED.search(low))


_VALUES = Pattern(r"\b<line.values>")
_LONG_STEMS = tuple(stem for stem in OF_READINGS if len(stem) >= SHORTEST_STEM)


def _speaks_of_readings(text: str) -> bool:
    known = (*map(str.lower, AXES), *OF_READINGS)
    return any(w in known or w.startswith(_LONG_STEMS) for w in words_of(text))


def _says_what_counts(low: str) -> bool:
    """Say whether words say that something counts or not, and name cycles, readings, or how many.

    That the first cycle is discarded is no news, nor that nothing is.
    """
    outliers = any_begins(words_of(low), OWN_STEMS[Subject.EXCLUDED])
    parts = {part for word in words_of(low) for part in stems_in(word) or ()}
    excludes = outliers or not parts.isdisjoint(_EXCLUDING)
    denied, counts = denies(low), _COUNTS.search(low) is not None
    if not (excludes or denied or counts):
        return False
    if _FIRST_DISCARDED.search(fold(low)) or says_that_all_count(low):
        return False
    of_a_pose, of_cycles = (one.search(low) is not None for one in (_A_POSE, _OF_CYCLES))
    if denied and (of_a_pose or of_cycles):
        return True
    if denied or is_of_another(low):
        return not is_of_another(low) and _VALUES.search(fold(low)) is not None
    some = not parts.isdisjoint(map(str.lower, AXES)) or of_a_pose
    some = some or _SOME.search(low) is not None
    some = some and not (affirms(low) and _may_be_a_certificate(low))
    return outliers or (counts and of_cycles) or (excludes and (some or of_cycles))


def _may_be_a_certificate(low: str) -> bool:
    """Say whether what is valid may be another thing: ``Dial X: Mitutoyo, valid until 2027``."""
    others = (w for w in words_of(low) if not {*_EXCLUDING}.intersection(stems_in(w) or ()))
    unknown = any(len(w) > len("but") for w in unknown_words(low))
    return unknown and _VALUES.search(fold(" ".join(others))) is None


_EXCLUDING = stems_of("weak_stem", "excluded")
_SOME = Pattern(r"\b(?:<remark.several>|<remark.whole>)\b")
_NONE, _ALL = whole_words("remark.none"), whole_words("value.all")
_A_CYCLE_WORD = Pattern(r"\b<remark.cycle>\b", "remark.cycle")


def says_that_all_count(text: str) -> bool:
    """Say whether words say that nothing is left out: ``no outliers removed``, ``all valid``."""
    low = clean(text).lower()
    if unknown_words(low) or re.search("[0-9]", low) or _A_CYCLE_WORD.search(low):
        return False
    if affirms(low) or _COUNTS.search(low):
        excluded = any_begins(words_of(low), OWN_STEMS[Subject.EXCLUDED])
        all_of_them = _ALL.match(low) is not None
        return all_of_them and not excluded and not _NONE.search(low)
    return _NONE.match(low) is not None


NUMBER = r"[-+±−]?[0-9]+(?:[.,][0-9]+)?(?:e[-+]?[0-9]+)?"
_POWER = Pattern(
    r"(?:mal|times|[x×·*]) ?10 ?(?:\^ ?[({]?|\*\* ?|e|(?=[-−⁻⁰¹²³⁴⁵⁶⁷⁸⁹]))[-−+⁻]?[0-9⁰¹²³⁴⁵⁶⁷⁸⁹]",
    "10",
)
_FRACTION = Pattern(
    r"(?<![0-9] )(?<![0-9])\b<line.part>(?: \w{1,5}){0,2} ?-?<line.length>\b", "line.part"
)
_IN_PARTS = Pattern(
    r"\W*<line.part>\W*"
    r"|.*\b(?:in|en|einheit|unit|unite|unita|unidad):? (?:<line.part>\b|1/10+)"
    r"(?!0| ?(?:s\b|sec|sek)).*"
    r"|.*\b(?:in|en) <line.step>.*"
)
_ALONE = Pattern(
    rf"\W*(?:[x×·*] ?{NUMBER}(?: ?[a-zµμ]+)?|(?:in )?mm ?/ ?10+|1e-?[0-9] ?[a-zµμ]+"
    r"|1/10+ ?[a-zµμ]*)[^\w:=]*",
    *("x", "×", "·", "*", "10", "1e"),
)
"""A line that is nothing but a factor, or a part of a unit."""
_ONE_COUNT = Pattern(
    r"(?:^\W*|[,;:(] ?)<line.one> <line.count>(?: \w+)? ?"
    rf"(?:[=:,;≙≈]|<line.equals>)+ ?(?!1 ?mm){NUMBER}",
    "line.count",
)
"""What one step of a display is, in a text whose words blanks part."""
_TIMES = Pattern(
    r"(?<!\w)<line.values> ?(?:[x×·*]|mal|times|fois) ?[0-9]*[.,]?[0-9]+"
    r"|= ?<line.values> ?[-+/÷] ?[0-9]"
    r"|\b<line.by> 10+ (?:zu )?<line.divided>|\bdivid\w* <line.by> 10+\b",
    "line.values",
    "line.by",
)
_CORRECTION = Pattern(
    r"\b(?:<line.taken_off>|<line.too> <line.much>)", "line.taken_off", "line.too"
)
_OTHER_SIDE = Pattern(r"\b<line.other_side>", "line.other_side")
_WORD_AND_NUMBER, _NUMBER_AND_WORD = (
    Pattern(pattern, *OWN_STEMS[Subject.SCALE])
    for pattern in (
        rf"([^\W\d_]+)(?: (?:by|of|is|with|mit|um|par|per|por|di|de|von|=))? {NUMBER}(?![\w-])",
        r"(?<!\w)(?<!\d[.,])[0-9]+(?:[.,][0-9]+)? (?:zu )?([^\W\d_]+)",
    )
)
_SUPERSCRIPT_SIGN = str.maketrans({"⁻": "-"})


def speaks_of_scale(text: str) -> bool:
    """Say whether a line of text states a factor of all values: ``mm x 10^-2``, ``values x 0.01``.

    A size in front of which a number stands, as ``2 hundredths of a mm``, is none.
    """
    text = text[:LONGEST_LINE]
    low = fold(clean(text.translate(_SUPERSCRIPT_SIGN)))
    if _FRACTION.search(low):
        return True
    if not re.search("[0-9]", low):
        return False
    if (
        _POWER.search(clean(text).lower())
        or _ALONE.fullmatch(low)
        or _ONE_COUNT.search(re.sub(r"[\s_-]+", " ", low))
    ):
        return True
    stems = OWN_STEMS[Subject.SCALE]
    found = chain(_WORD_AND_NUMBER.finditer(low), _NUMBER_AND_WORD.finditer(low))
    named = (one[1] for one in found)
    return _TIMES.search(low) is not None or any_begins(named, stems)


def in_parts_of_a_unit(text: str) -> bool:
    """Say whether a line may state the unit, of which it names a part: ``Werte in Hundertstel``."""
    return _IN_PARTS.fullmatch(fold(text[:LONGEST_LINE])) is not None


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


SENTENCE = 3
"""Words of a value that may say something of the readings."""


def axes_in_words(text: str) -> set[str]:
    """Return each axis that is a word of its own, with no coordinate behind it.

    Letters of a script that parts no words by blanks may be beside it.
    """
    apart = ("|" if "\u2e80" <= c <= "\uffff" and not c.isdecimal() else c for c in text)
    found = re.findall(r"(?<![\w.-])([XYZ]|theta)(?![\w.]| ?[=:]| ?[-+]?\d)", "".join(apart))
    return set(found)


_EQUAL_AXES = Pattern(
    r"(?<!\w)([XYZ]) ?(?:=|->|→|<line.equals>) ?[-+−]?(?:[^\W\d]+[ -]){0,2}(?!\1)[XYZ](?!\w)"
)


def equates_axes(text: str) -> bool:
    """Say whether words say of one axis that it is another: ``X is robot Y``."""
    return _EQUAL_AXES.search(text[:LONGEST_LINE]) is not None


def names_one_of(axes: Container[str], text: str) -> bool:
    """Say whether a sentence names one of the axes, in words of which something is not known."""
    words = len(text.strip("# ").split()) if " " in text else len(text) // 2
    named = words >= SENTENCE and any(axis in axes for axis in axes_in_words(text))
    return named and bool(unknown_words(text)) and not is_of_another(text)


_MONTH = "<remark.month>[a-zäéû]*"
_DATES_AND_NUMBERS = (
    r"(?i)\b(?:iso|din|en|vdi|jis|gb|nist)\b[ :/-]*[a-z/]*[ -]*[0-9][a-z0-9:./-]*"
    r"(?:,? [^\W\d]+\.? ?[1-9][0-9]?(?:\.[1-9][0-9]?)+(?![.,]?[0-9]))?"
    r"|[0-9]+(?:[-/:][0-9]{1,9}){1,4}|[0-9]+(?:\.[0-9]{1,9}){2,4}"
    r"|[0-9]+(?: / | [a-z]{1,3} )[0-9]+"
    r"|第 ?[0-9]+ ?[号號]|[0-9]{1,4}[年月] ?[0-9]{1,2}(?:月 ?[0-9]{1,2})?日?|\b(?:19|20)[0-9]{2}\b"
    rf"|\b{_MONTH}[. ]+[0-9]{{1,2}}\b|[0-9]{{1,2}}[. ]+{_MONTH}"
    r"|[a-z#][a-z_/.#-]*[0-9][a-z0-9./-]*|[0-9][0-9./]*-[a-z0-9./-]+"
    r"|<remark.numbered>[ .:_-]*(?:[a-z]{1,3} )?[0-9][a-z0-9.,/-]*(?: [a-z]{1,3} [0-9]+)?"
    r"|\S*(?:\\|://)\S*"
)
_DATED_OR_NUMBERED = Pattern(_DATES_AND_NUMBERS)
_EXPLAINED = Pattern(
    rf"{_DATES_AND_NUMBERS}|(?<![a-z0-9.,])[-+]?[0-9]+(?:[.,][0-9]+)? ?"
    r"(?:[%°℃'\"]|<remark.unit>(?![^\W_]))|[0-9]+ <remark.places>"
)
"""A standard and its clause, date, time, page, path, name or size, the number of a machine."""
_LABEL = Pattern(r"(?:[^\W\d_]+\W+){0,2}[0-9]+\W*")
"""A name with its number, and nothing behind: ``After service 2``."""
_OPEN = Pattern(r"(?<![\d.,])([0-9]+(?:[.,][0-9]+)?)(?![\d])")
_PART_OF_A_LENGTH = Pattern(r"(?i)(?<![\d.,/])(?:1/10+|0[.,]0*1) ?(?:mm|millim|inch|zoll)")
_LENGTH = r"(?<![\w.,/])[0-9]+[.,][0-9]+ ?[^\W\d_]+(?!\w)"
_RATIO = Pattern(
    r"(?<![\w.,:/=-])(?![0-9]{1,2}:[0-5][0-9](?!\d)|1 ?: ?1(?![\d.,]))"
    r"[0-9]{1,2}(?:[.,][0-9]+)? ?: ?[0-9]{1,2}(?:[.,][0-9]+)?(?![\w:]|[.,]\d)"
)


def without_explained(text: str) -> str:
    """Return a text without the numbers and names that change no reading."""
    return _EXPLAINED.sub(" ", text)


def holds_an_open_ratio(text: str) -> bool:
    """Say whether words hold a ratio such as 2:1 that is no time, drawing's or gear's."""
    return _RATIO.search(clean(text[:LONGEST_LINE])) is not None and not is_of_another(text)


def holds_an_open_number(text: str, rows: int, is_step: Callable[[str], bool]) -> bool:
    """Say whether words hold a number that nothing explains: a cycle, or a factor; no step."""
    low = clean(text[:LONGEST_LINE]).strip("# ")
    low = re.sub(_LENGTH, lambda one: " " if is_step(one[0]) else one[0], low)
    if _PART_OF_A_LENGTH.search(low):
        return True
    if _A_CYCLE_WORD.search(low.lower()):  # `speaks_of_cycles` knows these words
        return False
    parts = re.split(r"[;()]|,(?!\d)", without_explained(low))
    open_ones = (part for part in parts if not _LABEL.fullmatch(part.strip()))
    found = [one[1].replace(",", ".") for part in open_ones for one in _OPEN.finditer(part)]
    return any("." in number or 1 < int(number) < rows for number in found)


def says_nothing(text: str) -> bool:
    """Say whether a value states that there is nothing: 0, none, nein, no."""
    return not text.strip() or text.strip().casefold().rstrip(".") in WORDS["value"]["nothing"]
