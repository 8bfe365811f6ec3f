"""What rows of a table state, in lines, cells or words: used, or refused, or noted."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice, pairwise
from typing import NamedTuple

from scara_iso.tables.grid import Faults, Row, is_comment, is_rule
from scara_iso.tables.vocabulary.names import (
    holds_readings,
    is_in_no_unit_of_readings,
    pose_alone,
    read_unit,
    standard_uncertainty,
)
from scara_iso.tables.vocabulary.sentences import (
    NUMBER,
    affirms,
    denies,
    moves_readings,
    says_nothing,
    says_that_all_count,
    speaks_of_scale,
)
from scara_iso.tables.vocabulary.words import (
    AN_AXIS_IN_A_KEY,
    AXES_IN_KEYS,
    LONGEST_LINE,
    RESOLUTION,
    WORDS,
    Pattern,
    Subject,
    clean,
    in_english,
    is_of_axes,
    is_of_corrections,
    names_a_limit,
    parse_cell,
    quoted,
    quoted_whole,
    topic_of,
)

AN_AXIS = re.compile(rf"(?<![^\W_]){AN_AXIS_IN_A_KEY}(?![^\W_])")


class Statement(NamedTuple):
    """The value of a ``key: value`` line, and the line."""

    value: str
    line: int


class KeyValue(NamedTuple):
    """A statement as a row has it: its key as `normal_key` has it, its value, the key's words."""

    key: str
    value: str
    written: str


def is_plain(stated: KeyValue) -> bool:
    """Say whether a statement is the program's own, in words that say nothing else."""
    return _OWN_WORD.fullmatch(f"{stated.key} {stated.value}") is not None


_FACTOR = (
    rf"(?i)\W*x? ?{NUMBER}(?: ?[:/x×·*^]{{1,2}} ?[-−+⁻]?[0-9.,⁰¹²³⁴⁵⁶⁷⁸⁹]{{1,20}}){{0,2}} ?"
    r"([^\W\d].{0,24})?"
)
_FREE_NUMBER = r"(?<![\w.,-])[0-9]+(?:[.,][0-9]+)?(?:(?![\w-])|(?=[a-zµμ°]))"
_DATE = r"[0-9]{1,4}[-./][0-9]{1,2}[-./][0-9]{1,4}"
_OF_ONE = r"(?i)(?:x ?)?1(?:[.,]0*)?(?: ?[:/] ?1)?|100 ?%"
_LEAVE_AXIS = "remove the columns that do not count, and leave this out"
_LEAVE_SCALES = "state the factor in the unit, as '# unit: 0.01 mm', and leave this out"
_REMEDIES = {
    Subject.UNCERTAINTY: "write the standard uncertainty (U divided by its coverage factor k, a "
    "limit of error divided by 1.73) as '# indicator_uncertainty: 0.002 mm', and leave this out",
    Subject.EXCLUDED: "remove the rows that do not count, say `allow_gaps=`, and leave this out; a "
    "first cycle that was discarded is '# first_cycle_discarded: true'",
    Subject.SCALE: _LEAVE_SCALES,
    Subject.UNIT: "write the unit as '# unit: mm', of one axis as '# unit_X: um', and leave "
    "this out",
    Subject.ZERO: "write readings from which the zero is taken, and leave this out",
}
REMARKED = "remarked"
"""Key of what another table said of rows that count: this one was made of it."""
_UNDERSTOOD = frozenset({"first_cycle_discarded", "dial_zero", "parts_struck", REMARKED})
"""Keys of the program whose words are a subject's."""
RECORDER = "record_"
"""How the recorder's own remarks begin: struck readings are in its raw file, and in no row."""
_FEW_WORDS = 3  # around a value, that say nothing else: ``values in 1/1000 mm``


def read_head(rows: Iterable[Row], faults: Faults) -> tuple[dict[str, Statement], list[str]]:
    """Return the statements of a head by key, and a note for each line of free text.

    Keys are in lower case with underscores for blanks, those of German forms in English; values
    are kept as written. What would change a figure and is not understood is a fault.
    """
    statements: dict[str, Statement] = {}
    steps: list[tuple[KeyValue, Row]] = []
    notes: list[str] = []
    for row in rows:
        found = refuse_unused(row, faults)
        if not found and (pose := pose_alone(row.text)):
            found = [KeyValue("pose", pose, row.text)]
        for key, value, _ in found:
            before = statements.setdefault(key, Statement(value, row.line))
            if before.value != value:
                said = f"{quoted(before.value)} in {faults.place(before.line)}"
                what = f"{key} is {quoted(value)} here and {said}"
                faults.add(what, row.line, remedy="leave one of them")
        own = [step for one in found if (step := _step_of_dial(one))]
        steps += [(step, row) for step in own]
        notes += _unused(row, [*found, *own], faults)
    for (key, value, _), row in steps:
        stated = statements.setdefault(key, Statement(value, row.line)).value
        if not _is_same_size(stated, value):
            notes.append(_not_the_resolution(row, faults.row))
    return in_english(statements), notes


def _unused(row: Row, found: Sequence[KeyValue], faults: Faults) -> Iterator[str]:
    """Yield a note where a row states nothing, or no resolution beside the words of one."""
    text = row.text.strip("# ")
    if not found and text and not is_rule(text):
        if holds_readings(row.cells) and not is_comment(row.text):
            faults.add(
                "numbers before the header: two tables in one file?",
                row.line,
                remedy="leave one table in the file, with one header",
            )
        else:
            yield f"{faults.place(row.line)}: {quoted_whole(row.text)} not used"
    elif found and not is_comment(row.text) and (left := _left_of(row, found)):
        yield f"{faults.place(row.line)}: {quoted_whole(', '.join(left))} not used"
    if any(one.key.startswith(RESOLUTION) for one in found):
        return
    alone = any(_RESOLUTION.fullmatch(clean(cell).lower()) for cell in row.cells)
    if alone or _IN_WORDS.search(row.text):
        yield _not_the_resolution(row, faults.row)


def _left_of(row: Row, found: Sequence[KeyValue]) -> list[str]:
    stated = [(clean(one.written), clean(one.value)) for one in found]
    return [
        cell
        for cell in filter(None, map(clean, row.cells))
        if not any(
            cell.strip(":= ") == key
            or cell in value
            or (key in cell and value.startswith(cell.partition(key)[2].strip(":= ")))
            or (value in cell and len(cell.replace(value, "").split()) <= _FEW_WORDS)
            for key, value in stated
        )
    ]


def _not_the_resolution(row: Row, called: str) -> str:
    named = next((m.groups()[-1] for m in _IN_WORDS.finditer(row.text)), "")
    size = named if read_unit(named.replace(",", ".")) else "0.001 mm"
    return (
        f"{called} {row.line}: the resolution in {quoted(row.text)} not used; if it is the dial's, "
        f"write it above the header as 'resolution: {size}'"
    )


def refuse_below(row: Row, faults: Faults) -> list[KeyValue]:
    """Return what a row under the header states; of the axes, or of readings, it is a fault."""
    stated = refuse_unused(row, faults)
    if any(is_of_axes(one.key) for one in stated):
        what = f"{quoted(row.text)} under the header"
        faults.add(what, row.line, remedy="write this line above the header")
    return stated


def refuse_unused(row: Row, faults: Faults) -> list[KeyValue]:
    """Return what a row states; what would change a figure and is not understood is a fault.

    Such a statement is never passed over; every other key is the report's.
    """
    found = read_statements(row)
    stated = list(dict.fromkeys([*found, *_whole_statement(row.text)]))
    used = [one for one in stated if is_of_axes(one.key) or is_of_corrections(one.key)]
    before = faults.total
    wrong = [refusal_of(*one, row.text) for one in stated if one not in used]
    for remedy, what in {one[1]: one[0] for one in reversed(wrong) if one}.items():
        faults.add(what, row.line, remedy=remedy)
    of = {axis for one in used if (axis := one.key.rpartition("_")[2]) in AXES_IN_KEYS}
    if of and len(of) == len(used) and not set(AN_AXIS.findall(row.text.lower())) <= of:
        what = f"{quoted(row.text)}: which of it is of which axis?"
        faults.add(what, row.line, remedy="state it of each, as '# unit_X: um', and leave this out")
    if not used and faults.total == before and speaks_of_scale(row.text):
        what = f"{quoted(row.text)}, and readings are multiplied by no factor"
        faults.add(what, row.line, remedy=_LEAVE_SCALES)
    elif not any(map(is_plain, stated)) and (remedy := moves_readings(row.text)):
        faults.add(
            f"{quoted(row.text)}, which is not acted on in these words", row.line, remedy=remedy
        )
    return found


def _step_of_dial(stated: KeyValue) -> KeyValue | None:
    """Return the resolution that a statement about the dial holds: ``Messuhr: Mahr 0,001 mm``.

    That is the only size with a unit, small enough for a step, beside which no word speaks of
    another size, such as its range.
    """
    dial = _DIAL_KEY.fullmatch(stated.key)
    parts = re.split(r"[;|()]|,(?!\d)", stated.value[:LONGEST_LINE]) if dial else []
    found = ((size, part) for part in parts for size in _QUANTITY.finditer(part) if _is_step(size))
    sizes = {clean(size[1]) for size, part in found if not OTHER_SIZE.search(part)}
    others = {*AN_AXIS.findall(stated.value.lower())} - {dial and dial[1]}
    if dial is None or len(sizes) != 1 or others:
        return None
    key = f"{RESOLUTION}_{dial[1]}" if dial[1] else RESOLUTION
    size = sizes.pop()
    unit = read_unit(size) if "/" in size else None
    return KeyValue(key, f"{unit.to_base(1.0)} {unit.base_name}" if unit else size, stated.written)


def _is_step(size: re.Match[str]) -> bool:
    unit = read_unit(f"{size[1].replace(',', '.')}")
    return unit is not None and unit.numerator / unit.denominator <= _LARGEST_STEP


def _is_same_size(one: str, other: str) -> bool:
    a, b = parse_cell(one), parse_cell(other)
    if a is None or b is None or a.value != b.value:
        return False
    return not a.unit or not b.unit or read_unit(a.unit) == read_unit(b.unit)


_KEY = re.compile(r"#?\s*[^\W\d_][^:=]{0,40}[:=]?")
_FIRST = r"(?:[0-9]{1,2}\. ?)?[^\W\d_][^:=]{0,40}"
_BARE_KEY = re.compile(rf"{_FIRST}[:=]")
_MARK = re.compile(r"(?!(?:(?<=\W\d)|(?<=\W\d\d)|(?<=\W\d{4}))[:：]\d|(?<=\d ): \d{1,2}\W*$)[:=：]")
"""What parts a key from its value: no colon between two numbers, as ``2:1`` and ``14:30`` have."""
_IN_A_CELL = re.compile(rf"({_FIRST}?) ?{_MARK.pattern}(?![\\/]) ?(.*)")
"""A key and its value in one cell: no time of day, no path and no address."""
_LONGEST_KEY = 61
_MOST_MARKS = 3
_DECIMAL = re.compile("[0-9],[0-9]")
_WIDE = re.compile(r"\s{2,}|\t")


def read_statements(row: Row) -> list[KeyValue]:
    """Return each statement of a row.

    That is a ``# key: value`` line, a row of two such cells, or several statements beside each
    other: ``Date: | 2026-03-01 | | Tested by: | Smith``. Without a mark, what would change a figure
    is one too: ``scale | 0.01 | mm``.
    """
    cells = [text for text in map(clean, row.cells) if text]
    two = len({*cells}) == len(cells) == 2 and not _are_one_number(cells, row.text)
    another = two and (_BARE_KEY.fullmatch(cells[1]) or _own_size(cells[1]))
    if two and _KEY.fullmatch(cells[0]) and not another:
        return [_normal(cells[0].strip("#:= "), cells[1])]
    words = " ".join(cells) == clean(row.text)
    if not is_comment(row.text):
        found = _beside_each_other(_WIDE.split(row.text) if words else cells, row.text)
        if len(found) > 1 or (len(cells) > 1 and not words):
            in_cells = (_normal(k, v) for k, v in pairwise(cells) if _matters(k, v))
            return found or list(in_cells)
    if whole := _whole_statement(row.text):
        own, *more = re.split(r";|,(?!\d)", whole[0].value[:LONGEST_LINE])
        if is_of_axes(whole[0].key):
            sizes = [size for part in more if (size := _own_size(part.strip()))]
            apart = [whole[0]._replace(value=own), *(_normal(*size) for size in sizes)]
            return apart if sizes and len(sizes) == len(more) else whole
        free = whole[0].key != REMARKED and topic_of(whole[0].written) is None
        parts = [own, *more] if free else []
        inner = (one for part in parts for one in (*_whole_statement(part), *_in_words(part)))
        used = list(filter(_is_of_readings, inner))
        if of := AN_AXIS.search(whole[0].key):
            used = [o._replace(key=f"unit_{of[1]}") if o.key == "unit" else o for o in used]
        return used if used and not more else [*whole, *used]
    return _in_words(row.text.lstrip("# "))


def _in_words(text: str) -> list[KeyValue]:
    """Return what a text without a mark states, be it a line or a remark: ``Y in 1/100 mm``."""
    text = clean(text)
    text = text[1:].removesuffix(")") if text.startswith("(") else text
    if size := _own_size(text):
        return [_normal(*size)]
    if (of := _A_LIMIT.fullmatch(text)) and names_a_limit(key := f"{of[1]} {of[3]}".strip()):
        return [_normal(key, of[2])]
    bare = _BARE.fullmatch(text)
    return [_normal(bare[1], bare[2])] if bare and _matters(bare[1], bare[2]) else []


def _is_of_readings(stated: KeyValue) -> bool:
    """Say whether a part of a remark is a factor, a unit, or an uncertainty with its unit."""
    found = topic_of(stated.written)
    if found is None and AN_AXIS.search(stated.key) and read_unit(stated.value):
        return True
    if found is None or found.subject is not Subject.UNCERTAINTY:
        return found is not None and found.subject in (Subject.SCALE, Subject.UNIT)
    return any(
        read_unit(size[1].lstrip("0123456789., ")) for size in _QUANTITY.finditer(stated.value)
    )


def _whole_statement(text: str) -> list[KeyValue]:
    """Return what a line states whose key is all in front of its first mark; else nothing."""
    mark = _end_of_key(text := text.lstrip("# "))
    key = text[: mark.start()].rstrip() if mark else ""
    if mark and len(key) <= _LONGEST_KEY and key[:1].isalpha():
        return [_normal(key, text[mark.end() :].strip())]
    return []


def _end_of_key(text: str) -> re.Match[str] | None:
    """Return the mark behind a key: not within brackets, as in ``U(k=2): 0.004``, nor a ratio."""
    marks = list(islice(_MARK.finditer(text), _MOST_MARKS))
    outside = (m for m in marks if text.count("(", 0, m.start()) == text.count(")", 0, m.start()))
    is_whole = text.count("(") == text.count(")")
    return next(outside, None if is_whole else next(iter(marks), None))


def _matters(key: str, value: str) -> bool:
    """Say whether a key without a mark states what would change a figure; an axis' ratio may."""
    if _RESOLUTION.fullmatch(key.lower()):
        return (number := parse_cell(value)) is not None and read_unit(number.unit) is not None
    found = topic_of(key)
    no_unit = found and found.subject is Subject.UNIT and read_unit(value) is None
    if found is None or no_unit or (found.axes and ":" in value):
        return False
    return refusal_of(key, value, key) is not None


def _beside_each_other(cells: Sequence[str], text: str) -> list[KeyValue]:
    """Return the statements of cells; what follows a key up to the next is its value.

    A key has a colon, or is a resolution's. Words in front of the first are a title; numbers there
    make it no row of statements.
    """
    found: list[tuple[str, list[str]]] = []
    for cell in cells:
        colon = _IN_A_CELL.fullmatch(cell)
        if size := _own_size(cell):
            found.append((size[0], [size[1]]))
        elif colon:
            found.append((colon[1], [colon[2]] if colon[2] else []))
        elif _RESOLUTION.fullmatch(cell.lower()):
            found.append((cell, []))
        elif found:
            found[-1][1].append(cell)
        elif parse_cell(cell):
            return []
    stated = [(key, _as_one(values, text)) for key, values in found]
    if not all(parse_cell(value) for key, value in stated if key in cells):
        return []  # no number, or several: of which column?
    return [_normal(key, value) for key, value in stated]


def _as_one(values: Sequence[str], text: str) -> str:
    """Return cells as one value: words with commas, a number and its unit with a blank.

    A decimal comma of the row's ``text`` has parted no cells.
    """
    if _are_one_number(values, text):
        return ",".join(values)
    number_and_unit = len(values) == 2 and parse_cell(values[0]) and read_unit(values[1])
    return (" " if number_and_unit else ", ").join(values)


def _are_one_number(cells: Sequence[str], text: str) -> bool:
    whole = ",".join(cells)
    return len(cells) == 2 and whole in text and bool(_DECIMAL.match(whole, len(cells[0]) - 1))


def _own_size(text: str) -> tuple[str, str] | None:
    """Return key and value that are all of a text without a colon, as ``Unit mm``.

    A number without a unit is a resolution's where it has decimals.
    """
    if word := _OWN_WORD.fullmatch(text):
        return word[1], word[2]
    values = _UNIT_OF_VALUES.fullmatch(text)
    if values and read_unit(values[1]):
        return "unit", values[1]
    size = _SIZE.fullmatch(text)
    number = parse_cell(size[3]) if size else None
    if size is None or number is None:
        return None
    sure = read_unit(number.unit) if number.unit else number.value % 1
    return (size[1], size[3]) if sure else None


def _normal(key: str, value: str) -> KeyValue:
    """Return a statement with its key as `normal_key`, a unit in it behind its value.

    ``Resolution [mm]: 0.001`` is ``resolution: 0.001 mm``; likewise ``Payload [kg]: 2``. A date of
    a workbook has no time.
    """
    split = _UNIT_IN_KEY.fullmatch(key)
    number = parse_cell(value)
    if split and number and not number.unit:
        stem, unit = normal_key(split[1]), split[2]
        if unit.lower() in _OF_CONDITIONS or (stem.startswith(RESOLUTION) and read_unit(unit)):
            return KeyValue(stem, f"{value} {unit}", key)
    return KeyValue(normal_key(key), value.removesuffix("T00:00:00"), key)


def normal_key(key: str) -> str:
    """Return a metadata key in lower case, with underscores for blanks, its name the known one."""
    key = re.sub(r"\s+", "_", key.strip().lower())
    if is_of_axes(key):
        return key
    if found := _SIZE_KEY.fullmatch(key):
        return f"{RESOLUTION}_{found[1]}" if found[1] else RESOLUTION
    unit = topic_of(key)
    if unit is None or unit.subject is not Subject.UNIT or len(unit.axes) > 1:
        return key
    return "_".join(("unit", *map(str.lower, unit.axes)))


def refusal_of(key: str, value: str, written: str, line: str = "") -> tuple[str, str] | None:
    """Return what is wrong with a statement that changes a figure and is not understood.

    Beside it is what to write; None for any other statement. It is quoted as the ``line`` has it.
    """
    if key in _UNDERSTOOD or key.startswith(RECORDER):
        return None
    found, text = topic_of(written), clean(value[:LONGEST_LINE])
    subject = found.subject if found else Subject.EXCLUDED
    if found is None and re.search(r"\bk ?= ?[1-3]\b", text):  # a coverage factor, in any language
        subject = Subject.UNCERTAINTY
    elif found is None and not (denies(written) and re.search(_FREE_NUMBER, text)):
        return None
    if subject not in _REMEDIES or not _acts(subject, written, text):
        return None
    what = "which is not understood"
    what = "and readings are multiplied by no factor" if subject is Subject.SCALE else what
    words = f"{clean(written)} {text}"
    stated = words if words in clean(line) else f"{clean(written)}: {text}"
    if subject is Subject.UNCERTAINTY and (standard := standard_uncertainty(words)):
        return f"{quoted(stated)}, which is not understood", f"{standard} (U/k), and leave this out"
    of_axis = subject is Subject.EXCLUDED and found and found.axes and not re.search("[0-9]", text)
    return f"{quoted(stated)}, {what}", _LEAVE_AXIS if of_axis else _REMEDIES[subject]


def _acts(subject: Subject, written: str, text: str) -> bool:
    low, nothing = text.casefold(), says_nothing(text)
    if subject is Subject.EXCLUDED:
        no_news = low in ("", *WORDS["value"]["all"]) if affirms(written) else nothing
        no_news = no_news or says_that_all_count(f"{written} {text}")
        return not no_news and not re.fullmatch(_DATE, low)
    if nothing or subject is Subject.UNIT:
        return not nothing
    if subject is Subject.SCALE and speaks_of_scale(text):
        return True
    number = parse_cell(text)
    acts = {
        Subject.UNCERTAINTY: re.search(_FREE_NUMBER, low) is not None,
        Subject.ZERO: number is not None and number.value != 0,
        Subject.SCALE: bool(re.fullmatch(_FACTOR, low)) and not re.fullmatch(_OF_ONE, low),
    }
    return acts.get(subject, False) and not is_in_no_unit_of_readings(low)


_DIAL_KEY = Pattern(rf"<dial.name>(?:_{AN_AXIS_IN_A_KEY})?", "dial.name")
OTHER_SIZE = Pattern(r"(?i)(?<![^\W_])<dial.other_size>|±")
_QUANTITY = re.compile(r"(?<![\w.,/-])((?:1/)?[0-9]+(?:[.,][0-9]+)? ?[^\W\d_]+)(?![\w/])")
_LARGEST_STEP = 0.1  # mm or degrees: what is larger is a range
_SIZES = "dial.resolution"
_SIZE_NAME = (
    rf"(?:<dial.name>[ _])?<{_SIZES}>(?:(?:[ _](?:der|of|of[ _]the))?[ _]<dial.name>)?"
    rf"(?:[ _]{AN_AXIS_IN_A_KEY})?"
)
"""What people call a dial's resolution, in lower case; an axis may follow."""
_SIZE_VALUE = r"[0-9]+(?:[.,][0-9]+)? ?[^\W\d]"
_SIZE_KEY = Pattern(_SIZE_NAME, _SIZES)
_RESOLUTION = Pattern(rf"{_SIZE_NAME}(?: ?[\[(][^\[\]()]+[\])])?", _SIZES)
_SIZE = Pattern(f"(?i)({_SIZE_NAME}) ({_SIZE_VALUE}*)", _SIZES)
_IN_WORDS = Pattern(f"(?i)({_SIZE_NAME})[ ,;:=]*({_SIZE_VALUE}+)", _SIZES)
_OWN_WORD = Pattern(
    "(?i)(first_cycle_discarded|first_cycle|dial_zero) (true|false|yes|no|counts|command)"
)
_UNIT_OF_VALUES = Pattern(
    r"(?i)(?:all |alle )?(?:mess|ist)?(?:werte?|readings?|values|measurements|daten|data|maße)"
    r"(?: are| sind)?(?: in |: in | ?[\[(]| / )([^\[\]()]{1,12})[\])]?",
    *("wert", "reading", "values", "measurements", "daten", "data", "maße"),
)
_BARE = re.compile(r"(\D{1,40}?) ?(?:[0-9]*%)? ((?:[^\W\d]|[µμ°\"'])\S{0,11}|[-+±x×]{0,2}[0-9].*)")
_A_LIMIT = re.compile(r"(\D{0,40}?) ?([0-9]+(?:[.,][0-9]+)? ?(?:mm|[uµμ]m)) ?(\D{0,40})")
_OF_CONDITIONS = frozenset({"kg", "g", "mm/s", "m/s", "%", "°c", "c"})
_UNIT_IN_KEY = re.compile(r"(.+?) ?(?:[\[(]|/ ?|,? in )([^\[\]()]+)[\])]?")
