"""Which statements of a table act on its figures, and what to write in place of one."""

from __future__ import annotations

import re

from scara_iso.tables.faults import quoted
from scara_iso.tables.names import read_unit
from scara_iso.tables.numbers import parse_cell
from scara_iso.tables.words import (
    LONGEST_LINE,
    NUMBER,
    WORDS,
    Subject,
    affirms,
    clean,
    denies,
    says_nothing,
    speaks_of_scale,
    topic_of,
)

_FACTOR = re.compile(
    rf"\W*x? ?{NUMBER}(?: ?[:/x×·*^]{{1,2}} ?[-−+⁻]?[0-9.,⁰¹²³⁴⁵⁶⁷⁸⁹]{{1,20}}){{0,2}} ?"
    r"([^\W\d].{0,24})?",
    re.IGNORECASE,
)
_FREE_NUMBER = re.compile(r"(?<![\w.,-])[0-9]+(?:[.,][0-9]+)?(?:(?![\w-])|(?=[a-zµμ°]))")
_DATE = re.compile(r"[0-9]{1,4}[-./][0-9]{1,2}[-./][0-9]{1,4}")
_OF_ONE = re.compile(r"(?:x ?)?1(?:[.,]0*)?(?: ?[:/] ?1)?|100 ?%", re.IGNORECASE)
LEAVE_SCALES = "state the factor in the unit, as '# unit: 0.01 mm', and leave this out"
_REMEDIES = {
    Subject.UNCERTAINTY: "write the standard uncertainty, which is U divided by its coverage "
    "factor k, as '# indicator_uncertainty: 0.002 mm', and leave this out",
    Subject.EXCLUDED: "remove the rows that do not count, say `allow_gaps=`, and leave this out; a "
    "first cycle that was discarded is '# first_cycle_discarded: true'",
    Subject.SCALE: LEAVE_SCALES,
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


def refusal_of(key: str, written: str, value: str) -> tuple[str, str] | None:
    """Return what is wrong with a statement that changes a figure and is not understood.

    Beside it is what to write; None for any other statement.
    """
    if key in _UNDERSTOOD or key.startswith(RECORDER):
        return None
    found, text = topic_of(written), clean(value[:LONGEST_LINE])
    subject = found.subject if found else Subject.EXCLUDED
    if found is None and not (denies(written) and _FREE_NUMBER.search(text)):
        return None
    if subject not in _REMEDIES or not _acts(subject, written, text):
        return None
    unused = "and readings are multiplied by no factor"
    what = unused if subject is Subject.SCALE else "which is not understood"
    return f"{quoted(f'{clean(written)}: {text}')}, {what}", _REMEDIES[subject]


def _acts(subject: Subject, written: str, text: str) -> bool:
    """Say whether a value could change a figure."""
    low, counts = text.casefold(), subject is Subject.EXCLUDED and affirms(written)
    if subject is Subject.EXCLUDED:
        all_count = counts and low in WORDS["value"]["all"]
        return (
            bool(low)
            and not (_DATE.fullmatch(low) or all_count)
            and (counts or not says_nothing(low))
        )
    if says_nothing(low) or subject is Subject.UNIT:
        return subject is Subject.UNIT and not says_nothing(low)
    if subject is Subject.SCALE and speaks_of_scale(text):
        return True
    number = parse_cell(text)
    acts = {
        Subject.UNCERTAINTY: _FREE_NUMBER.search(low) is not None,
        Subject.ZERO: number is not None and number.value != 0,
        Subject.SCALE: _FACTOR.fullmatch(low) is not None and not _OF_ONE.fullmatch(low),
    }
    return acts.get(subject, False) and not _of_another(low)


def _of_another(text: str) -> bool:
    """Say whether a number has a unit of no reading: V, kg, °C, s."""
    number = parse_cell(text)
    unit = number.unit if number else ""
    return bool(unit) and unit != "%" and read_unit(unit) is None and len(unit.split()) == 1
