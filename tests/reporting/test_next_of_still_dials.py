"""A dial that shows one reading all the time is no report to sign."""

import pytest

from scara_iso.commands import main

ROWS = "".join(f"{k},0.400\n" for k in range(1, 32))
MOVES = "".join(f"{k},0.40{k % 7}\n" for k in range(1, 32))


@pytest.mark.parametrize("limit", [(), ("--limit", "0.02")])
def test_all_readings_alike_are_no_report_to_sign(tmp_path, monkeypatch, capsys, limit):
    monkeypatch.chdir(tmp_path)
    table = tmp_path / "still.csv"
    table.write_text(f"# unit: mm\n# resolution: 0.001\ncycle,X\n{ROWS}")
    assert main(["analyze", table.name, *limit]) == 0
    out = capsys.readouterr().out
    assert "Next: scara-iso explain no-scatter   a dial that stands still proves nothing" in out
    assert "to sign" not in out


def test_a_dial_that_moves_is_signed(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    table = tmp_path / "moves.csv"
    table.write_text(f"# unit: mm\n# resolution: 0.001\ncycle,X\n{MOVES}")
    assert main(["analyze", table.name, "--limit", "0.02"]) == 0
    assert "the report to sign" in " ".join(capsys.readouterr().out.split())
