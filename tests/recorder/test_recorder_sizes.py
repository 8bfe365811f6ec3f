"""What is stated of an indicator while recording reaches the figures, or is refused."""

import pytest

from scara_iso import analyze, read_table
from scara_iso.commands import main

GAUGES = ["--gauge", "X=opto-rs232@sim:?pace=0", "--gauge", "Y=opto-rs232@sim:?pace=0"]


def record(path, *meta):
    options = [word for text in meta for word in ("--meta", text)]
    return main(["record", str(path), *GAUGES, "--trigger", "timer:1", "--json", *options])


def test_uncertainty_and_command_become_part_of_their_axis(tmp_path, capsys):
    stated = ["indicator uncertainty=0.0005", "indicator_uncertainty_Y=0.0008", "command_X=0.8"]
    assert record(tmp_path / "run.csv", *stated) == 0
    run = read_table(tmp_path / "run.csv")
    assert {n: axis.uncertainty for n, axis in run.axes.items()} == {"X": 0.0005, "Y": 0.0008}
    assert {n: axis.command for n, axis in run.axes.items()} == {"X": 0.8, "Y": None}
    figures = analyze(run).poses[0].axes["X"]
    assert figures.uncertainty == pytest.approx((0.0005**2 + 0.001**2 / 12) ** 0.5)


@pytest.mark.parametrize("text", ["0.5 um", "nan", "1_0", "", "0,0005", "-0.001", "0", "1e99"])
def test_what_is_no_number_is_refused_before_anything_is_recorded(tmp_path, capsys, text):
    assert record(tmp_path / "run.csv", f"indicator_uncertainty={text}") == 2
    assert "plain number" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
