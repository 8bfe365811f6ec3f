"""A robot's history: what of its tables is quoted."""

import pytest

import scara_iso


@pytest.mark.parametrize("remarked", [1, 3, 4, 6])
def test_three_remarks_of_a_table_are_quoted_and_the_others_counted(remarked, tmp_path):
    tables = []
    for month in (1, 2):
        remarks = ["", *(f"bumped {k}" for k in range(2, remarked + 2)), *[""] * (30 - remarked)]
        rows = "".join(
            f"{k},{0.1 + k % (6 + month) / 1000:.3f},{remark}\n"
            for k, remark in enumerate(remarks, 1)
        )
        head = f"# robot: A\n# serial_number: 1\n# date: 2026-0{month}-01\n# unit: mm\n"
        tables.append(tmp_path / f"{month}.csv")
        tables[-1].write_text(f"{head}cycle,X,remark\n{rows}")
    (first, second) = [n for n in scara_iso.history(tables).notes if "remarked, and counted" in n]
    for note in (first, second):
        assert sum(f"bumped {k}" in note for k in range(2, remarked + 2)) == min(remarked, 3)
        assert note.endswith(f" and {remarked - 3} more") is (remarked > 3)
