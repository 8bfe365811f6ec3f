"""How large a table may be: columns, poses side by side, footers, rows."""

import pytest

from scara_iso.base.errors import DataError
from scara_iso.tables import assemble, read_table
from scara_iso.tables.shapes import BESIDE
from scara_iso.tables.vocabulary.names import COLUMNS

MM = "# unit: mm\n"
FEET = ("Mean", "Min", "Max", "Range")


def wide(columns, footers=(), cycles=31, separator=","):
    """Return a table with X in the middle, Y last, and 0.1 in every other field."""
    names = ["cycle", *(f"c{k}" for k in range(columns - 1))]
    names[columns // 2], names[-1] = "X", "Y"
    first = [*range(1, cycles + 1), *footers]
    rows = [[str(one), *["0.1"] * (columns - 2), "0.2"] for one in first]
    return (MM + "".join(separator.join(row) + "\n" for row in [names, *rows])).encode()


def poses(count, axes=("X",), cycles=31):
    """Return a table of poses side by side; the readings of the k-th are k + 0.5."""
    names = [f"P{k} {axis}" for k in range(1, count + 1) for axis in axes]
    row = [str(k + 0.5) for k in range(1, count + 1) for _ in axes]
    rows = [[str(cycle), *row] for cycle in range(1, cycles + 1)]
    return MM + "\n".join(map(",".join, [["cycle", *names], *rows])) + "\n"


@pytest.mark.slow
def test_ten_thousand_columns_find_x_and_y_above_their_footers():
    run = read_table(wide(COLUMNS, FEET, cycles=5))
    assert (list(run.axes), len(run)) == (["X", "Y"], 5)
    assert {*run.axes["X"].readings.tolist()} == {0.1}
    assert {*run.axes["Y"].readings.tolist()} == {0.2}
    assert len(run.covariates) == COLUMNS - 3
    assert len(run.origin.notes) == len(FEET)


@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_more_columns_are_refused_before_any_is_read(monkeypatch, separator):
    monkeypatch.setattr("scara_iso.tables.read.find_layout", lambda _rows: None)
    with pytest.raises(DataError, match=f"has {COLUMNS + 1} fields, more than {COLUMNS}") as caught:
        read_table(wide(COLUMNS + 1, cycles=2, separator=separator))
    assert "leave the columns" in caught.value.remedy


def test_a_text_of_many_commas_above_other_columns_is_no_row_that_is_too_wide():
    text = f"# remark: {'a,' * (COLUMNS + 1)}\n{MM}cycle;X\n1;0.1\n2;0.2\n"
    assert read_table(text.encode()).axes["X"].readings.tolist() == [0.1, 0.2]


def test_poses_side_by_side_each_have_their_own_readings():
    run = read_table(
        poses(90, ("X", "Y", "Z", "theta"), cycles=7).replace("theta", "theta [mm]").encode()
    )
    found = {pose: {*run.axes["Y"].readings[rows].tolist()} for pose, rows in run.rows_by_pose()}
    assert found == {f"P{k}": {k + 0.5} for k in range(1, 91)}


@pytest.mark.parametrize("above", [False, True])
def test_too_many_poses_side_by_side_are_refused(above):
    text = poses(BESIDE + 1, cycles=2)
    if above:
        named = ",".join(f"P{k}" for k in range(1, BESIDE + 2))
        text = text.replace("cycle,", f",{named}\ncycle,").replace(" X", "")
        head = text.splitlines()
        head[2] = ",".join(["cycle", *["X"] * (BESIDE + 1)])
        text = "\n".join(head) + "\n"
    with pytest.raises(DataError, match=f"{BESIDE + 1} poses side by side") as caught:
        read_table(text.encode())
    assert "with a column 'pose'" in caught.value.remedy


def test_a_separator_behind_every_row_makes_no_row_strange():
    rows = "".join(f"{k},0.{k % 7},\n" for k in range(1, 20_001))
    assert len(read_table(f"{MM}cycle,X\n{rows}".encode())) == 20_000


def test_a_table_of_many_rows_says_what_to_use(monkeypatch):
    data = f"{MM}cycle,X\n1,0.1\n2,0.2\n3,0.1\n".encode()
    assert not read_table(data).origin.notes
    monkeypatch.setattr(assemble, "_MANY", 2)
    (note,) = read_table(data).origin.notes
    assert note.startswith("3 rows: ")
    assert "fleet" in note
    assert "visits" in note


def test_numbers_beyond_all_floats_are_refused_without_a_warning_of_numpy():
    with pytest.raises(DataError, match="no header"):
        read_table((",".join(["9" * 400] * 5) + "\n").encode() * 6)
