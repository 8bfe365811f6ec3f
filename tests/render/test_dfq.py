"""AQDEF of a gauge study.

Fields of a value: value, attribute, time, event, batch, nest, operator.
"""

import pytest

import scara_iso


@pytest.mark.parametrize(
    ("columns", "batch", "operator"),
    [
        ("X", None, None),
        ("part,X", ["a", "b", "c", "d", "e"], "0"),
        ("part,operator,X", ["a", "b", "c", "d", "e"], None),
    ],
)
def test_a_value_names_part_and_operator_where_they_are_known(columns, batch, operator, tmp_path):
    rows, by = [], []
    for k in range(60):
        cells = {"part": "abcde"[k % 5], "operator": ("An", "Bo")[k // 5 % 2]}
        by.append("12"[k // 5 % 2])
        rows.append(",".join([*(cells[c] for c in columns.split(",")[:-1]), f"{5 + k % 7 / 1000}"]))
    text = "\n".join(["# unit: mm", "# resolution: 0.001", columns, *rows])
    out = tmp_path / "study.dfq"
    scara_iso.gauge_study(text.encode(), tolerance=0.1, to=out)
    values = [line.split("\x14") for line in out.read_text("cp1252").splitlines() if line[0] == "5"]
    assert [float(fields[0]) for fields in values] == [5 + k % 7 / 1000 for k in range(60)]
    if batch is None:
        assert all(len(fields) < 4 for fields in values)
        return
    assert [fields[4] for fields in values] == batch * 12
    assert [fields[6] for fields in values] == ([operator] * 60 if operator else by)
