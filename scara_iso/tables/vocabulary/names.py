"""What a column's name says: axis, cycle, pose, time, covariate or comment, and its unit.

The columns of a table side by side. The pose that a title, a heading or a line names.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from datetime import datetime
from enum import Enum
from functools import lru_cache
from itertools import zip_longest
from typing import NamedTuple

from scara_iso.base.moments import in_iso, is_moment
from scara_iso.base.quantities import Dimension, Unit, find_unit
from scara_iso.run import (
    POSE_NAMES,
    UNITS,
    RecordedCondition,
    find_condition,
    read_direction,
    unit_in_heading,
    unit_of_condition,
)
from scara_iso.tables.vocabulary.words import (
    BLANKS,
    FORMULA,
    LONGEST_LINE,
    LONGEST_NAME,
    WORDS,
    Pattern,
    clean,
    is_of_another,
    names_a_footer,
    parse_cell,
    quoted,
    spelt,
)

COLUMNS = 10_000
"""Columns that a table may have."""


class Kind(Enum):
    """What a column holds."""

    AXIS = "axis"
    COMMAND = "command coordinate"
    CYCLE = "cycle"
    POSE = "pose"
    TIMESTAMP = "timestamp"
    APPROACH = "approach"
    DIRECTION = "direction of approach"
    OPEN = "what its first cell says"
    COVARIATE = "covariate"
    COMMENT = "comment"
    LABEL = "label"
    NAMELESS = "no name"


class Column(NamedTuple):
    """A column: its kind, its name in the `Run`, the unit its name states, its field from 0."""

    kind: Kind
    name: str
    unit: str = ""
    position: int = 0
    condition: RecordedCondition | None = None
    """What a covariate records, where its name or its unit says so."""
    heading: str = ""
    """What the header says of it."""

    @property
    def called(self) -> str:
        """What a message calls it."""
        return f"column {self.position + 1} {quoted(self.heading)}"


class Layout(NamedTuple):
    """The columns of a table, the line of its header, and the line that data begin on."""

    columns: tuple[Column, ...]
    header_line: int
    data_line: int
    sure: bool
    """Whether a row of numbers follows the header."""
    known: int
    """Columns that are more than a covariate, or rows that fit named ones: the most is meant."""
    words_below: bool = False
    """Whether a row of words follows it: a heading of two rows."""
    worded: str = ""
    """The word that stands with each axis and is in no list."""

    @property
    def width(self) -> int:
        """Number of fields of a row."""
        return len(self.columns)

    def of(self, *kinds: Kind) -> list[Column]:
        """Return the columns of the given kinds."""
        return [c for c in self.columns if c.kind in kinds]


_AXES = {"x": "X", "y": "Y", "z": "Z", "theta": "theta", "θ": "theta", "ϑ": "theta"}
_AXIS_WORD = Pattern(
    r"<axis.in_front>\.?[ _-]+"
    r"|(?:axis|achse)[ _-]*|(?:[dδ∆]|偏差|误差|读数|測定値)(?=(?:[xyz]|theta)$)"
    r"|[ _-]*(?:axis|achse|軸|轴|坐标|座標)$|[ _-]+<axis.behind>$"
)
"""Words that stand with an axis. ``X_Value`` is the abscissa of LabVIEW's files, no reading."""
_INSTRUMENT = Pattern(r"<axis.instrument> ?[0-9]{0,3} ?[\[(]([^\[\]()]*)[\])]", "axis.instrument")
_FOOTNOTE = re.compile(r" ?(?:[\u00b9\u00b2\u00b3]\)|\*{1,3}\)?|†)$")
_COMMAND = r"(?i)command[ _]([^ _].*)"
_CYCLE_PROPER = ("cycle", "zyklus")
DATES, _TIMES, _STAMPS = (WORDS["column"][name] for name in ("date", "time", "timestamp"))
CLOCKS = frozenset((*_TIMES, *_STAMPS))
"""Names of a column that may hold times of day, as `plain_key` gives them."""
_KINDS = {
    name: kind
    for kind, names in {
        Kind.CYCLE: WORDS["column"]["cycle"],
        Kind.POSE: (*POSE_NAMES, *WORDS["pose"]["name"]),
        Kind.APPROACH: WORDS["column"]["approach"],
        Kind.TIMESTAMP: _STAMPS,
        Kind.OPEN: (*DATES, *_TIMES),
        Kind.COMMENT: WORDS["column"]["comment"],
    }.items()
    for name in names
}
COVARIATES = frozenset({"time_s", "temperature_C", "payload_kg", "speed"})
"""Covariates that have a meaning, so their cells must be numbers."""
_SPLITS = (
    re.compile(r"(.*?) ?[\[({<]([^\[\](){}<>]*)[\])}>]"),
    re.compile(r"(.+?) ?(?:/|,| in |[\[(])(.+)"),
    re.compile(r"(.+?)[_ ](.+)"),
)


def names_and_units(text: str) -> Iterator[tuple[str, str]]:
    """Yield each name and unit that a heading may be: ``x [um]``, ``x in um``, ``x_um``.

    What stands in brackets may be no unit.
    """
    yield text, ""
    for pattern in _SPLITS:
        match = pattern.fullmatch(text)
        if match and (pattern is _SPLITS[0] or read_unit(match[2])):
            yield match[1], match[2].strip()


def unit_in_brackets(text: str) -> str:
    """Return the unit in brackets behind a name, as it stands there; nothing without one."""
    match = _SPLITS[0].fullmatch(clean(text)) if len(text) <= LONGEST_NAME else None
    return match[2].strip() if match and read_unit(match[2]) else ""


@lru_cache(maxsize=256)
def read_unit(text: str) -> Unit | None:
    """Return the unit that a file spells, also ``0,01 mm`` and ``mm x 10^-2``, or None."""
    if len(text) > _LONGEST_UNIT:
        return None
    text = _RAISED.sub(lambda raised: f"^{raised[0].translate(_SUPERSCRIPT)}", clean(text))
    power = _POWER.fullmatch(text)
    if power:
        text = f"1e{power[2] or power[3]} {power[1] or power[4]}"
    text = _FOREIGN.get(text.lower(), text)
    text = re.sub(r"^(\D+) ?/ ?1(0+)$", r"1/1\2 \1", text)
    text = re.sub(r"^1/1(0+) ?", lambda m: f"0.{m[1][1:]}1 ", text).replace(",", ".")
    return find_unit(text)


def standard_uncertainty(text: str) -> str:
    """Return what to write of an expanded uncertainty, where it and its factor k are sure."""
    factor, size = re.search(r"\bk ?= ?([1-3](?:[.,][0-9]{1,2})?)(?!\d)", text), _SIZE.search(text)
    unit = read_unit(size[0]) if size and not _GROUPED.search(size[0]) else None
    if factor is None or unit is None:
        return ""
    value = unit.to_base(1.0) / float(factor[1].replace(",", "."))
    return f"write '# indicator_uncertainty: {value:.3g} {unit.base_name}'"


_SIZE = re.compile(r"(?<![\w.,])[0-9]+(?:[.,][0-9]+)? ?(?:mm|[uµμ]m)\b")
_GROUPED = re.compile(r"^[1-9][0-9]{0,2},[0-9]{3}\b")


def names_another_unit(text: str, units: Iterable[Unit]) -> bool:
    """Say whether words name a unit in which no axis of its kind is: ``dial in inch mode``.

    A whole number in front of it makes it the size of a thing: ``a 12 inch wafer``.
    """
    found = (read_unit(word) for word in _A_WORD.findall(text[:LONGEST_LINE]))
    own = {part for one in units for part in (one.dimension, *one.name.split())}
    return any(one and one.dimension in own and one.name not in own for one in found)


_A_WORD = re.compile(r"(?<![\w.,])(?<![0-9][ -])(?!(?i:in)\b)[^\W\d_]{2,}(?![^\W_])")
_LONGEST_UNIT = 40
_FOREIGN = {name: unit for unit, names in WORDS["unit"].items() for name in names}
_SUPERSCRIPT = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹−", "-0123456789-")
_RAISED = re.compile("[⁻⁰¹²³⁴⁵⁶⁷⁸⁹−]+")
_POWER = re.compile(
    r"(\D+?) ?[x×·*] ?10(?:\^|(?=-))(-?\d)|10(?:\^|(?=-))(-\d) ?[x×·*]? ?(\D+)", re.ASCII
)


def read_name(text: str, unit_below: str = "") -> Column:
    """Return the column that a header cell names; ``unit_below`` is its cell of a unit row."""
    name = clean(text)
    found = Column(Kind.NAMELESS, "", unit_below)
    if name:
        found = axis_column(name, unit_below) or _other_column(name, unit_below)
    return found._replace(heading=text)


def is_axis(text: str) -> bool:
    """Say whether a header cell names an axis: much faster than to read what else it names."""
    found = axis_column(clean(text), "")
    return found is not None and found.kind is Kind.AXIS


def axes_in(text: str) -> set[str]:
    """Return the axes whose letter stands apart from other letters: ``P1X``, ``X/Y [mm]``."""
    found = re.findall(r"(?<![^\W\d_])(?:x|y|z|theta)(?![^\W\d_])", text[:LONGEST_NAME].lower())
    return {_AXES[axis] for axis in found}


def axis_column(text: str, unit_below: str) -> Column | None:
    """Return the axis, or command coordinate of one, that a header cell names, or None."""
    if len(text) > LONGEST_NAME:
        return None
    command = re.fullmatch(_COMMAND, text)
    commanded = axis_column(command[1], unit_below) if command else None
    if commanded and commanded.kind is Kind.AXIS:
        return commanded._replace(kind=Kind.COMMAND)
    found = ((_axis(name.lower()), unit) for name, unit in names_and_units(text))
    axis, unit = next((one for one in found if one[0]), (None, ""))
    differ = read_unit(unit) != read_unit(unit_below)
    return Column(Kind.AXIS, axis, _one_of(unit, unit_below, differ=differ)) if axis else None


def _axis(name: str) -> str | None:
    """Return the axis that a name without its unit means: ``x``, ``messwert x``, ``dial 1 (x)``."""
    name = _FOOTNOTE.sub("", name)
    instrument = _INSTRUMENT.fullmatch(name)
    return _AXES.get(_AXIS_WORD.sub("", instrument[1] if instrument else name, count=1))


def _one_of(unit: str, below: str, *, differ: bool) -> str:
    """Return the unit of name and unit row; both, which no unit is called, where they differ."""
    return f"{unit} over {below}" if unit and below and differ else unit or below


def _other_column(text: str, unit_below: str) -> Column:
    match = _SPLITS[0].fullmatch(text)
    stem, unit = (match[1], match[2]) if match else (text, "")
    unit = (unit or unit_below).strip(" -")
    own, of_row = unit_in_heading(text), unit_of_condition(unit_below)
    stated = _one_of(own, unit_below, differ=of_row in UNITS and unit_of_condition(own) != of_row)
    condition = find_condition(text, unit_below)
    if condition and condition.sure:
        return Column(Kind.COVARIATE, condition.name, stated, condition=condition)
    kind = _KINDS.get(plain_key(stem))
    if kind is None or (kind is Kind.OPEN and unit and ":" not in unit):
        name = "speed" if text.lower() == "speed" else text
        name = re.sub(rf"^'(?=['{re.escape(FORMULA)}])", "", name)
        return Column(Kind.COVARIATE, name, stated)
    return Column(kind, kind.value)


def plain_key(name: str) -> str:
    """Return a name in lower case, without what stands in brackets, blanks for its points."""
    match = _SPLITS[0].fullmatch(name)
    return re.sub(r"[ ._:-]+", " ", (match[1] if match else name).lower()).strip()


def read_names(cells: Sequence[str], units: Sequence[str] = ()) -> list[Column]:
    """Return the columns of a header.

    Of two counters the one called cycle numbers the cycles; of two names of poses, the one called
    pose is it.
    """
    columns = [
        read_name(cell, unit)._replace(position=k)
        for k, (cell, unit) in enumerate(zip_longest(cells, units, fillvalue=""))
    ]
    names = [clean(cell) for cell in cells]
    proper = {
        Kind.CYCLE: [k for k, name in enumerate(names) if name.lower() in _CYCLE_PROPER],
        Kind.POSE: [k for k, name in enumerate(names) if name.lower().startswith("pose")],
    }
    for kind, called in proper.items():
        found = {c.position for c in columns if c.kind is kind}
        for k in found.difference(called) if len(found.intersection(called)) == 1 else ():
            other = Kind.COVARIATE if kind is Kind.CYCLE else Kind.OPEN
            columns[k] = columns[k]._replace(kind=other, name=names[k])
    return columns


def settle(column: Column, first: str) -> Column:
    """Return what a column that is left open is, by its first cell: numbers, stamps or a note.

    A covariate without a unit has the one behind its first number.
    """
    if column.kind is Kind.APPROACH:
        labelled = read_direction(first) is not None
        return column._replace(kind=Kind.DIRECTION if labelled else Kind.COVARIATE)
    number = parse_cell(first)
    if number is not None and column.kind is Kind.COVARIATE and not column.condition:
        return column._replace(unit=column.unit or number.unit)
    if column.kind not in (Kind.OPEN, Kind.TIMESTAMP):
        return column
    if number is not None:
        return column._replace(kind=Kind.COVARIATE, name=clean(column.heading), unit=number.unit)
    sure = column.kind is Kind.TIMESTAMP and not re.match("[0-9]{1,2}:", first.strip(BLANKS))
    kind = Kind.TIMESTAMP if sure or read_timestamp(first) else Kind.COMMENT
    return column._replace(kind=kind, name=clean(column.heading))


def with_likely(columns: Sequence[Column]) -> tuple[Column, ...]:
    """Return the columns with a name like ``Temp (C)`` as what it means, where no other is that."""
    likely = {
        k: condition
        for k, c in enumerate(columns)
        if c.kind is Kind.COVARIATE and c.condition is None
        if (condition := find_condition(clean(c.heading), c.unit))
    }
    others = ("time_s" if c.kind is Kind.TIMESTAMP else c.name for c in columns)
    found = Counter([*others, *(one.name for one in likely.values())])
    sure = {k: one for k, one in likely.items() if found[one.name] == 1}
    return tuple(
        c._replace(name=sure[k].name, condition=sure[k]) if k in sure else c
        for k, c in enumerate(columns)
    )


def read_timestamp(text: str) -> datetime | None:
    """Return the instant of a date and time, ISO 8601 or as clear, or None."""
    text = in_iso(text.strip(BLANKS))
    try:
        return datetime.fromisoformat(text) if text.isascii() and len(text) > 10 else None
    except ValueError:
        return None


_NUMBERED = rf"(?:{spelt('pose.name')}[ _.-]?p?|p)[ _.-]?0*([1-9][0-9]{{0,2}})"
_BRACKETS = re.compile(r"[(\[][^()\[\]]*[)\]]\s*$")
_POSE = re.compile(rf"(?<![a-z0-9]){_NUMBERED}(?![a-z0-9])")
_LINE = re.compile(r"#?\s*(?:pose|point|punkt)\s*[:=]\s*(\S.{0,30})", re.IGNORECASE)
_NAMED_POSE = re.compile(_NUMBERED, re.IGNORECASE)
_APART = rf"[\[(](x|y|z|theta|{_NUMBERED})[\])]"
_BETWEEN = r"((?:[^\w\])]|_)*)"
_BEFORE = rf"{_NUMBERED}{_BETWEEN}(\S.*)"
_BEHIND = rf"(\S.*?){_BETWEEN}{_NUMBERED}( ?[\[(/,].*|[ _][^\W\d_]+)?"


def pose_in(title: str) -> str | None:
    """Return the pose that a name such as ``run_P3`` or ``Pose 3`` holds, None without one."""
    found = set(_POSE.findall(title.lower()))
    return f"P{found.pop()}" if len(found) == 1 else None


_A_NAME = rf"(?:{spelt('pose.name')}[ _.-]?)?p?"
_UP_TO = r" ?(?:[-–…~→>]+|,? ?\.{2,3},?|to|thru|through|bis|à|al?|au) ?"


def names_some(text: str, poses: Sequence[str]) -> bool:
    """Say whether words name some of these poses, and not all (as ``P1 to P5``)."""
    if not poses:
        return False
    low = text.lower()
    words = {*re.findall(r"[^\W_]{2,}", low), *(f"p{number}" for number in _POSE.findall(low))}
    known = [f"p{pose}" if pose.isdecimal() else pose.lower() for pose in poses]
    first, last = (rf"{_A_NAME}{re.escape(end.lstrip('p'))}" for end in (known[0], known[-1]))
    all_of = "|".join(_UP_TO.join(ends) for ends in ((first, last), (last, first)))
    return 0 < len(words.intersection(known)) < len(known) and not re.search(all_of, low)


def pose_alone(text: str) -> str | None:
    """Return the pose of a line or cell that says nothing else: ``P3``, ``Pose 3``, ``pose: A``.

    What stands in brackets behind it, such as its coordinates, is not read.
    """
    text = _BRACKETS.sub("", text).strip(" \t*=-_:")
    stated = _LINE.fullmatch(text)
    whole = _POSE.fullmatch(text.lower())
    return stated[1].strip() if stated else f"P{whole[1]}" if whole else None


def pose_and_name(heading: str) -> tuple[str, str] | None:
    """Return pose and name in a heading: ``P1 X [mm]``; of an axis also ``P1X``, ``XP1``."""
    if len(heading) > LONGEST_NAME or not _NAMED_POSE.search(heading):
        return None
    text = clean(re.sub(_APART, r" \1 ", clean(heading), flags=re.IGNORECASE))
    found, behind = (re.fullmatch(p, text, re.IGNORECASE) for p in (_BEFORE, _BEHIND))
    if found:
        pose, between, name = found.groups()
    elif behind:
        name, between, pose = behind[1] + (behind[4] or ""), behind[2], behind[3]
    else:
        return None
    return (f"P{pose}", name) if between or is_axis(name) else None


_COUNTED = re.compile(r"([^\d#]*)([0-9]{1,9})(\D.*)?")


def count_in_words(text: str) -> tuple[str, tuple[str, str]]:
    """Return the number of ``3.``, ``M03`` or ``3/31``, no size, date or pose; and its words."""
    text = text.strip(BLANKS)
    found, number = _COUNTED.fullmatch(text), parse_cell(text.removesuffix("."))
    other = number and (number.unit.isascii() if number.unit else not text.strip(".").isdigit())
    if found is None or other or pose_alone(text) or is_moment(text):
        return "", ("", "")
    return found[2], (found[1], found[3] or "")


_ABOVE_COLUMNS = {"samples", "x0", "delta_x", "x-axis", "date", "time", "channels"}


def holds_readings(cells: Sequence[str]) -> bool:
    """Say whether a row has several numbers and no label, as ``USL, 0.1, 0.1`` has one.

    LabVIEW writes ``Samples`` and the like above a table.
    """
    first = clean(cells[0])
    labelled = names_a_footer(first) or first.rstrip(":").lower() in _ABOVE_COLUMNS
    return not labelled and sum(parse_cell(c) is not None for c in cells) > 1


def header_cells(cells: Sequence[str]) -> list[str]:
    """Return the cells of a row as header names, a leading ``#`` removed."""
    names = [clean(cell) for cell in cells[: filled_width(cells)]]
    if names and re.match(r"# ?\w", names[0]):
        names[0] = names[0].lstrip("# ")
    return names


def names_an_axis(cells: Sequence[str]) -> bool:
    """Return whether a row is a header: one of its cells names an axis, and none is a number."""
    if not cells or re.match(r"#?\s*[^\W\d_][^:=,;]*[:=]", cells[0]):
        return False
    names = header_cells(cells[: COLUMNS + 1])
    if any(len(name) > LONGEST_NAME or parse_cell(name) for name in names):
        return False
    return any(is_axis(name) for name in names)


def filled_width(cells: Sequence[str]) -> int:
    """Return the number of cells up to the last that is filled."""
    return max((k + 1 for k, cell in enumerate(cells) if clean(cell)), default=0)


def length_in_mm(text: str) -> float | None:
    """Return the length that a text is: one number with its unit, as ``<= 20 um``; else None."""
    number = parse_cell(text.lstrip("<≤=± "))
    unit = read_unit(number.unit) if number and number.unit else None
    is_length = unit is not None and unit.dimension is Dimension.LENGTH
    return unit.to_base(number.value) if number and unit and is_length else None


_IN_UNIT = re.compile(
    r"\b(?:in|en)[: ]+((?:(?:0[.,]|1/)[0-9]+ ?)?[^\W\d_]{1,12})\W*$", re.IGNORECASE
)


def length_in_words(text: str) -> Unit | None:
    """Return the unit of length that a line of readings ends in: ``all cotes in mil``."""
    ending = _IN_UNIT.search(text[:LONGEST_LINE])
    unit = read_unit(ending[1]) if ending and not is_of_another(text) else None
    return unit if unit and unit.dimension is Dimension.LENGTH else None


def is_in_no_unit_of_readings(text: str) -> bool:
    """Say whether a number has a unit of no reading: V, kg, °C, s."""
    number = parse_cell(text)
    unit = number.unit if number else ""
    return bool(unit) and unit != "%" and read_unit(unit) is None and len(unit.split()) == 1
