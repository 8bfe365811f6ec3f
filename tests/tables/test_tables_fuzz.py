"""Any bytes give a run or an error of the house; a damaged table never gives another number."""

from budget import examples
from hypothesis import given, strategies as st
from spelling import Spelling, Table, lines, spell
from test_tables_spellings import assert_same

from scara_iso.base.errors import ScaraIsoError
from scara_iso.tables import read_table

PIECES = st.sampled_from(
    ["cycle", "X", "Y_mm", "theta", "pose", ",", ";", "\t", "  ", "\n", "\r\n", '"', "#", ":", "=",
     "unit", "mm", " um", "0.1", "1,234", "0,5", "-", "1e5", "Mean", "nan", "\u2212", "\u00a0", "€",
     "\x00", "sep=;", "# unit: mm\n", "cycle,X\n", "1,0.1\n", "[", "]", "'", "timestamp", "9" * 400,
     "2024-05-13T14:03:22", "e", "resolution: ", "°", "(", ")", "1e99 mm"]
)  # fmt: skip


def read_or_refuse(data, **options):
    try:
        return read_table(data, **options)
    except ScaraIsoError:
        return None


@examples(200)
@given(st.binary(max_size=200))
def test_arbitrary_bytes_give_a_run_or_an_error_of_the_house(data):
    read_or_refuse(data)


@examples(300)
@given(
    st.lists(PIECES, max_size=40).map("".join),
    st.sampled_from(["utf-8", "utf-16", "cp1252"]),
    st.sampled_from([None, ",", "."]),
)
def test_arbitrary_words_of_tables_do_too(text, encoding, decimal):
    read_or_refuse(text.encode(encoding, "replace"), unit="mm", decimal=decimal)
    read_or_refuse(b"# unit: mm\ncycle,X\n1,0.5\n" + text.encode(), decimal=decimal)


TABLE = Table(
    {
        "X": [441, 445, 437, 440, 449, 442, 443],
        "Y": [3189, 3193, 3185, 3189, 3190, 3191, 3189],
    },
    {"speed": ["250"] * 7},
)
CANONICAL = Spelling()
SEMICOLON = Spelling(delimiter=";", mark=",")
TEXTS = {s.delimiter: "\n".join(lines(TABLE, s)) + "\n" for s in (CANONICAL, SEMICOLON)}
JUNK = st.text(
    st.characters(exclude_characters="0123456789", exclude_categories=("Cs",)),
    min_size=1,
    max_size=4,
)


def unharmed_or_refused(text):
    """The true rows are read, whole or none; what is left out is left out with a note."""
    run = read_or_refuse(text.encode())
    if run is None:
        return
    expected = {axis: TABLE.readings(axis, "mm") for axis in TABLE.axes}
    for k, cycle in enumerate(run.cycle.tolist()):
        for axis in run.axes:
            got, true = run.axes[axis].readings[k], expected[axis][cycle - 1]
            assert abs(got - true) <= 4e-16 * abs(true)
    lost = set(range(1, TABLE.rows + 1)) - set(run.cycle.tolist())
    assert not lost or run.origin.notes


@examples(300)
@given(st.sampled_from(sorted(TEXTS)), st.integers(0, 400), JUNK)
def test_junk_put_anywhere_changes_no_number(delimiter, place, junk):
    text = TEXTS[delimiter]
    start = text.index("cycle")
    place = start + place % (len(text) - start)
    # A sign, a mark or an exponent inside a number makes another number that no reader can tell.
    if not set(junk) & set("+-\u2212.,eE"):
        unharmed_or_refused(text[:place] + junk + text[place:])


@examples(200)
@given(st.sampled_from(sorted(TEXTS)), st.integers(0, 400))
def test_a_lost_separator_mark_or_line_end_changes_no_number(delimiter, which):
    text = TEXTS[delimiter]
    start = text.index("\n", text.index("cycle")) + 1
    places = [k for k in range(start, len(text) - 1) if not text[k].isdigit()]
    place = places[which % len(places)]
    mark = "," if delimiter == ";" else "."
    if text[place] != mark:  # without its mark a number is another one
        unharmed_or_refused(text[:place] + text[place + 1 :])
    other = {",": ".", ".": ","}.get(text[place], ";")
    if text[place] == mark:
        unharmed_or_refused(text[:place] + other + text[place + 1 :])


@examples(100)
@given(
    st.sampled_from(sorted(TEXTS)),
    st.integers(0, 6),
    st.sampled_from(["", ";;;", "# break", "Mean;1;1;1", "Kommentar: Pause", "\t"]),
)
def test_a_line_put_in_changes_no_number(delimiter, row, line):
    rows = TEXTS[delimiter].split("\n")
    at = next(k for k, text in enumerate(rows) if text.startswith("cycle")) + 1 + row
    unharmed_or_refused("\n".join([*rows[:at], line, *rows[at:]]))


@examples(60)
@given(st.integers(0, 10**4), st.integers(0, 255))
def test_a_damaged_byte_of_utf_16_is_a_run_or_an_error_of_the_house(place, byte):
    data = bytearray(spell(TABLE, Spelling(delimiter=";", mark=",", encoding="utf-16")))
    data[place % len(data)] = byte
    read_or_refuse(bytes(data))


def test_the_tables_of_this_test_are_read_unharmed():
    for text in TEXTS.values():
        assert_same(read_table(text.encode()), TABLE)
