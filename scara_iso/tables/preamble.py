"""What stands above the header: statements, as ``# key: value`` or in cells, and free text.

A form above a header of known names: which row the header is, and what stands above it. The
machine that wrote a log, which names itself in it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice, pairwise
from typing import NamedTuple, TypeVar

from scara_iso.run import AXES
from scara_iso.tables.columns import Cell
from scara_iso.tables.faults import Faults, names_a_footer, quoted
from scara_iso.tables.layout import HEAD, is_comment, is_rule
from scara_iso.tables.names import clean, read_unit
from scara_iso.tables.numbers import BLANKS, parse_cell
from scara_iso.tables.subjects import Subject, refusal, topic_of
from scara_iso.tables.text import Row

_Value = TypeVar("_Value")
_ABOVE_COLUMNS = {"samples", "x0", "delta_x", "x-axis", "date", "time", "channels"}
_KEY = re.compile(r"#?\s*[^\W\d_][^:=]{0,40}[:=]?")
_FIRST = r"(?:[0-9]{1,2}\. ?)?[^\W\d_][^:=]{0,40}"
_BARE_KEY = re.compile(rf"{_FIRST}[:=]")
_IN_A_CELL = re.compile(rf"({_FIRST}?) ?(?!(?<=\d):\d)[:=](?![\\/]) ?(.*)")
"""A key and its value in one cell: no time of day, no path and no address."""
_LONGEST_KEY = 61
_MOST_MARKS = 3
_PARTED = re.compile("[0-9]+,[0-9]")
_WIDE = re.compile(r"\s{2,}|\t")


@dataclass(frozen=True, slots=True)
class Statement:
    """The value of a ``key: value`` line, and the line."""

    value: str
    line: int


class KeyValue(NamedTuple):
    """A statement as a row has it: its key as `normal_key` has it, its value, the key's words."""

    key: str
    value: str
    written: str


def read_preamble(
    rows: Sequence[Row], header_line: int, faults: Faults
) -> tuple[dict[str, Statement], list[str]]:
    """Return the statements before the header by key, and a note for each line of free text.

    Keys are in lower case with underscores for blanks, those of German forms in English; values
    are kept as written.
    """
    statements: dict[str, Statement] = {}
    notes: list[str] = []
    for row in rows:
        if row.line >= header_line:
            break
        found = read_statements(row)
        for key, value, _ in found:
            _add(statements, key, value, row.line, faults)
        if not found and _is_free(row):
            if not _is_labelled(row) and sum(parse_cell(c) is not None for c in row.cells) > 1:
                faults.add(
                    "numbers before the header: two tables in one file?",
                    row.line,
                    remedy="leave one table in the file, with one header",
                )
            else:
                notes.append(f"{faults.row} {row.line}: {quoted(row.text)} not used")
        if _speaks_of_it(row) and not any(one.key.startswith(RESOLUTION) for one in found):
            notes.append(
                f"{faults.row} {row.line}: the resolution in {quoted(row.text)} not used; if it is "
                "the dial's, write it above the header as 'resolution: 0.001 mm'"
            )
    return in_english(statements), notes


def in_english(stated: Mapping[str, _Value]) -> dict[str, _Value]:
    """Return statements by the keys that a report asks for; the second of one keeps its own."""
    found: dict[str, _Value] = {}
    for key, value in stated.items():
        english = _GERMAN.get(key.rstrip("."), key)
        found[key if english in stated or english in found else english] = value
    return found


def _speaks_of_it(row: Row) -> bool:
    """Say whether a row holds a resolution, be it within other words or cells."""
    alone = any(_RESOLUTION.fullmatch(clean(cell).lower()) for cell in row.cells)
    return alone or _IN_WORDS.search(row.text) is not None


def _is_free(row: Row) -> bool:
    return bool(row.text) and not row.text.startswith("#") and not is_rule(row.text)


def _is_labelled(row: Row) -> bool:
    """Say whether a row is a label's, as ``USL, 0.1, 0.1`` or LabVIEW's ``Samples`` above a table.

    Such a row says something of the columns and is no reading.
    """
    first = clean(row.cells[0])
    return names_a_footer(first) or first.rstrip(":").lower() in _ABOVE_COLUMNS


def read_statement(row: Row) -> KeyValue | None:
    """Return the first statement of a row, or None."""
    return next(iter(read_statements(row)), None)


def read_statements(row: Row) -> list[KeyValue]:
    """Return each statement of a row.

    That is a ``# key: value`` line, a row of two such cells, or several statements beside each
    other: ``Date: | 2026-03-01 | | Tested by: | Smith``. Without a mark, what would change a figure
    is one too: ``scale | 0.01 | mm``.
    """
    cells = [text for text in map(clean, row.cells) if text]
    if len(cells) == 2 and _KEY.fullmatch(cells[0]) and not _begins_another(cells[1]):
        return [_normal(cells[0].strip("#:= "), cells[1])]
    words = " ".join(cells) == clean(row.text)
    pieces = _WIDE.split(row.text) if words else cells
    found = [] if is_comment(row.text) else _beside_each_other(pieces, row.text)
    if len(found) > 1 or (len(cells) > 1 and not words and not is_comment(row.text)):
        return found or _in_cells(cells)
    if whole := whole_statement(row.text):
        return whole
    text = clean(row.text.lstrip("# "))
    if size := _own_size(text):
        return [_normal(*size)]
    bare = _BARE.fullmatch(text)
    return [_normal(bare[1], bare[2])] if bare and _matters(bare[1], bare[2]) else []


def whole_statement(text: str) -> list[KeyValue]:
    """Return what a line states whose key is all in front of its first mark; else nothing."""
    mark = _end_of_key(text := text.lstrip("# "))
    key = text[: mark.start()].rstrip() if mark else ""
    if mark and len(key) <= _LONGEST_KEY and key[:1].isalpha():
        return [_normal(key, text[mark.end() :].strip())]
    return []


def _end_of_key(text: str) -> re.Match[str] | None:
    """Return the mark behind a key: not within brackets, as in ``U(k=2): 0.004``."""
    marks = list(islice(re.finditer("[:=：]", text), _MOST_MARKS))
    outside = (m for m in marks if text.count("(", 0, m.start()) == text.count(")", 0, m.start()))
    return next(outside, next(iter(marks), None))


def _in_cells(cells: Sequence[str]) -> list[KeyValue]:
    """Return what cells beside each other state that would change a figure."""
    return [_normal(key, value) for key, value in pairwise(cells) if _matters(key, value)]


def _matters(key: str, value: str) -> bool:
    found = topic_of(key)
    if found is None or (found.subject is Subject.UNIT and read_unit(value) is None):
        return False
    return refusal(key, key, value) is not None


def _begins_another(cell: str) -> bool:
    return _BARE_KEY.fullmatch(cell) is not None or _own_size(cell) is not None


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
    resolutions = [value for key, value in stated if key in cells]
    if not all(map(parse_cell, resolutions)):  # no number, or several: of which column?
        return []
    return [_normal(key, value) for key, value in stated]


def _as_one(values: Sequence[str], text: str) -> str:
    """Return cells as one value: words with commas, a number and its unit with a blank.

    A decimal comma of the row's ``text`` has parted no cells.
    """
    if len(values) == 2 and _PARTED.match(whole := ",".join(values)) and whole in text:
        return whole
    number_and_unit = len(values) == 2 and parse_cell(values[0]) and read_unit(values[1])
    return (" " if number_and_unit else ", ").join(values)


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

    ``Resolution [mm]: 0.001`` is ``resolution: 0.001 mm``; likewise ``Payload [kg]: 2``.
    """
    split = _UNIT_IN_KEY.fullmatch(key)
    number = parse_cell(value)
    if split and number and not number.unit:
        stem, unit = normal_key(split[1]), split[2]
        if unit.lower() in _OF_CONDITIONS or (stem.startswith(RESOLUTION) and read_unit(unit)):
            return KeyValue(stem, f"{value} {unit}", key)
    return KeyValue(normal_key(key), value, key)


RESOLUTION = "resolution"
_DIALS = "messuhr(?:en)?|dial|gauge|indicator"
_NAMES = {
    RESOLUTION: rf"(?:(?:{_DIALS})[ _])?(?:resolution|auflösung|skalenteilung(?:swert)?"
    r"|teilungswert|ziffernschritt(?:wert)?|scale[ _]division|graduation|resolución"
    rf"|résolution|risoluzione|分辨率|分辨力|分度值)"
    rf"(?:(?:[ _](?:der|of|of[ _]the))?[ _](?:{_DIALS}))?",
}
"""What people call a statement that the axes hold, in lower case; an axis may follow."""
_GERMAN = {
    "roboter": "robot",
    "prüfling": "item",
    "prüfgegenstand": "item",
    "hersteller": "manufacturer",
    "seriennummer": "serial_number",
    "seriennr": "serial_number",
    "serien-nr": "serial_number",
    "datum": "date",
    "prüfdatum": "test_date",
    "messdatum": "test_date",
    "prüfer": "operator",
    "bediener": "technician",
    "labor": "laboratory",
    "prüflabor": "laboratory",
    "prüfort": "location",
    "messort": "place",
    "kunde": "client",
    "auftraggeber": "customer",
    "nutzlast": "payload",
    "traglast": "rated_payload",
    "nennlast": "rated_payload",
    "geschwindigkeit": "velocity",
    "temperatur": "temperature",
    "nenngeschwindigkeit": "rated_velocity",
    "raumtemperatur": "ambient_temperature",
    "umgebungstemperatur": "ambient_temperature",
    "luftfeuchte": "humidity",
    "luftfeuchtigkeit": "humidity",
    "messuhr": "dial",
    "messmittel": "instrument",
    "messgerät": "instrument",
    "kalibrierdatum": "calibration_date",
    "kalibriert_am": "calibration_date",
    "kalibriert_bis": "calibration_due",
    "kalibrierschein": "calibration_certificate",
    "toleranz": "tolerance",
    "referenz": "reference",
    "referenzwert": "reference",
}
"""Keys that a report asks for, as German forms call them."""
_OF_AXIS = rf"(?:[ _]({'|'.join(AXES).lower()}))?"
_KEYS = {key: re.compile(f"(?:{names}){_OF_AXIS}") for key, names in _NAMES.items()}
_RESOLUTION = re.compile(rf"{_KEYS[RESOLUTION].pattern}(?: ?[\[(][^\[\]()]+[\])])?")
_NAMED = f"((?:{_NAMES[RESOLUTION]}){_OF_AXIS})"
_VALUE = r"([0-9]+(?:[.,][0-9]+)? ?[^\W\d]+)"
_SIZE = re.compile(f"{_NAMED} {_VALUE.replace('+)', '*)')}", re.IGNORECASE)
_OWN_WORD = re.compile(
    "(first_cycle_discarded|first_cycle|dial_zero) (true|false|yes|no|counts|command)",
    re.IGNORECASE,
)
_UNIT_OF_VALUES = re.compile(
    r"(?:all |alle )?(?:mess|ist)?(?:werte?|readings?|values|measurements|daten|data|maße)"
    r"(?: are| sind)?(?: in |: in | ?[\[(]| / )([^\[\]()]{1,12})[\])]?",
    re.IGNORECASE,
)
_BARE = re.compile(r"(\D{1,40}?) ?(?:[0-9]*%)? ((?:[^\W\d]|[µμ°\"'])\S{0,11}|[-+±x×]{0,2}[0-9].*)")
_IN_WORDS = re.compile(f"{_NAMED}[ ,;:=]*{_VALUE}", re.IGNORECASE)
_OF_CONDITIONS = frozenset({"kg", "g", "mm/s", "m/s", "%", "°c", "c"})
_UNIT_IN_KEY = re.compile(r"(.+?) ?(?:[\[(]|/ ?|,? in )([^\[\]()]+)[\])]?")


def normal_key(key: str) -> str:
    """Return a metadata key in lower case, with underscores for blanks, its name the known one."""
    key = re.sub(r"\s+", "_", key.strip().lower())
    for name, known in _KEYS.items():
        if found := known.fullmatch(key):
            return f"{name}_{found[1]}" if found[1] else name
    unit = topic_of(key)
    if unit is None or unit.subject is not Subject.UNIT or len(unit.axes) > 1:
        return key
    return "_".join(("unit", *map(str.lower, unit.axes)))


def _add(statements: dict[str, Statement], key: str, value: str, line: int, faults: Faults) -> None:
    before = statements.setdefault(key, Statement(value, line))
    if before.value != value:
        said = f"{quoted(before.value)} in {faults.row} {before.line}"
        faults.add(f"{key} is {quoted(value)} here and {said}", line, remedy="leave one of them")


Line = tuple[int, Sequence[Cell]]
"""A row's number and its cells."""


def find_header(rows: Sequence[Line], count: Callable[[Sequence[Cell]], int]) -> int:
    """Return the place of the header among rows that are not blank.

    It is the row without a number of which most cells are known, by ``count``, and a row with a
    number follows; of several the last, as ``Operator, Anna`` may stand above. Else the first.
    """
    rows = rows[:HEAD]
    found = [
        (count(cells), k)
        for k, (_, cells) in enumerate(rows)
        if not is_comment_row(cells) and not _has_number(cells) and _numbers_follow(rows[k + 1 :])
    ]
    known, place = max(found, default=(0, 0))
    if not known:
        return next((k for k, (_, cells) in enumerate(rows) if not is_comment_row(cells)), 0)
    return next(k for k, (_, cells) in enumerate(rows) if [*cells] == [*rows[place][1]])


def count_known(rows: Sequence[Line], count: Callable[[Sequence[Cell]], int]) -> int:
    """Return how many cells of the header are known."""
    return count(rows[find_header(rows, count)][1]) if rows else 0


def form_rows(rows: Iterable[Line]) -> list[Row]:
    """Return rows of cells as a form's rows of text."""
    texts = [
        (line, [c if isinstance(c, str) else f"{c:.15g}" for c in cells]) for line, cells in rows
    ]
    return [
        Row(k, cells, ", ".join(c.strip() for c in cells if c.strip()), k) for k, cells in texts
    ]


def is_comment_row(cells: Sequence[Cell]) -> bool:
    """Return whether a row begins with ``#``."""
    first = cells[0] if cells else ""
    return isinstance(first, str) and is_comment(first.strip(BLANKS))


def _has_number(cells: Sequence[Cell]) -> bool:
    return any(isinstance(cell, float) or parse_cell(cell) is not None for cell in cells)


def _numbers_follow(rows: Sequence[Line]) -> bool:
    following = (cells for _, cells in rows if not is_comment_row(cells))
    return _has_number(next(following, []))


MACHINE_UNIT = "mm"
"""Of every length in the log of a machine that tests its own probe."""


@dataclass(frozen=True, slots=True)
class Machine:
    """What wrote a log; ``deviation`` is the standard deviation that the log states, with ``line``.

    Both are None and 0 where it states none.
    """

    name: str
    deviation: str | None = None
    line: int = 0

    @property
    def notes(self) -> list[str]:
        """What was understood of it, in words."""
        found = [f"a log of {self.name}: lengths in {MACHINE_UNIT}"]
        if self.deviation is not None:
            found.append(
                f"line {self.line}: its standard deviation {self.deviation} {MACHINE_UNIT} "
                "divides by n, not by n - 1, and is not taken"
            )
        return found


# Klipper's docs/G-Codes.md, [probe]; Marlin's gcode/calibrate/M48. Both divide by n.
_SIGNATURES = {
    "Klipper PROBE_ACCURACY": (
        re.compile(r"PROBE_ACCURACY at X:[-0-9.]+ Y:[-0-9.]+ Z:[-0-9.]+"),
        re.compile(r"probe accuracy results:.*standard deviation ([0-9.]{1,20})\s*$"),
    ),
    "Marlin M48": (
        re.compile(r"M48 Z-Probe Repeatability Test"),
        re.compile(r"Standard Deviation: ([0-9.]{1,20})\s*$"),
    ),
}


def find_machine(lines: Sequence[str]) -> Machine | None:
    """Return the machine that names itself in a log, None where none or more than one does."""
    found = [
        (name, own)
        for name, (signature, own) in _SIGNATURES.items()
        if any(signature.search(line) for line in lines)
    ]
    if len(found) != 1:
        return None
    name, own = found[0]
    said = [(match[1], k) for k, line in enumerate(lines, 1) if (match := own.search(line))]
    return Machine(name, *said[0]) if said else Machine(name)
