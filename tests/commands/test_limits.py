"""A limit has a unit, in every command that takes one, and decides alike in each."""

import json
import math
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import scara_iso
from scara_iso.base.errors import UsageError
from scara_iso.base.quantities import size_in

EXAMPLES = Path(__file__).parents[2] / "examples"
BEFORE, AFTER = EXAMPLES / "before_repair.csv", EXAMPLES / "after_repair.csv"


def table(path, unit="um", *, shift=0.0, head=()):
    """Write cycles that scatter by 2 divisions of 1 um."""
    scale = {"um": 1, "mm": 1e-3}[unit]
    X = np.random.default_rng(3).integers(-4, 5, 31) + shift
    rows = (f"{k},{scale * x:g}" for k, x in enumerate(X, 1))
    path.write_text("\n".join([f"# unit: {unit}", *head, "cycle,X", *rows, ""]), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("text", "unit", "size"),
    [
        ("20um", "mm", 0.02), ("20 µm", "mm", 0.02), ("0.02mm", "mm", 0.02), ("1in", "mm", 25.4),
        ("3arcmin", "deg", 0.05), ("0.05 deg", "arcmin", 3.0), ("1.2 arcmin", "arcmin", 1.2),
        ("5 mm/100N", "mm/100 N", 5.0), ("2 s", "s", 2.0), ("20um", "deg", None),
        ("20", "mm", None), ("3 furlong", "mm", None), ("2 s", "mm", None),
    ],
)  # fmt: skip
def test_a_size_in_the_unit_of_a_figure(text, unit, size):
    assert size_in(text, unit) == (size if size is None else pytest.approx(size, rel=1e-15))


@pytest.mark.parametrize(
    "command",
    [("analyze",), ("report", "-o", "r.md"), ("history",), ("compare",), ("compare", "--full")],
)
def test_a_bare_limit_of_a_table_in_another_unit_is_asked_back(
    call, tmp_path, monkeypatch, command
):
    monkeypatch.chdir(tmp_path)
    first = table(tmp_path / "2024-01-01.csv")
    tables = [first, table(tmp_path / "2024-01-02.csv", shift=1)][: 1 + (command[0] == "compare")]
    code, out, err = call(command[0], *tables, *command[1:], "--limit", "X=10")
    assert (code, out) == (2, "")
    assert "10 mm or 10 um?" in err
    assert "write --limit X=10mm or --limit X=10um" in err
    for limit, expected in {"X=4um": 1, "X=0.03mm": 0}.items():
        assert call(command[0], *tables, *command[1:], "--limit", limit)[0] == expected


def test_hundredths_of_a_millimetre_are_millimetres(call):
    """Table I is in 0.01 mm: what else than mm a limit could be in is not to be asked."""
    code, out, _ = call("analyze", EXAMPLES / "fum_scara_table1.csv", "--limit", "Z=0.04")
    assert (code, "limit 0.04 mm" in out) == (0, True)


@pytest.mark.parametrize("limits", ["20um", {"X": "20um"}, {"X": "0.02 mm"}])
def test_the_library_takes_a_unit(tmp_path, limits):
    path = table(tmp_path / "t.csv")
    (check,) = scara_iso.analyze(path, limits=limits).limits
    assert check.limit == 0.02
    with pytest.raises(UsageError, match="20 mm or 20 um"):
        scara_iso.analyze(path, limits=20)
    with pytest.raises(UsageError, match="this figure is in mm"):
        scara_iso.analyze(path, limits={"X": "2deg"})
    run = scara_iso.Run.from_frame(pd.DataFrame({"X": np.arange(31) % 5}), unit="um")
    with pytest.raises(UsageError, match="20 mm or 20 um"):
        scara_iso.analyze(run, limits=20)


def test_a_limit_with_a_unit_can_be_read_two_ways_too(call, tmp_path):
    code, _, err = call("analyze", table(tmp_path / "t.csv"), "--limit", "1,234um")
    assert (code, "write 1.234um or 1234um" in err) == (2, True)
    assert call("analyze", tmp_path / "t.csv", "--limit", "20,5um")[0] == 0


def test_a_comparison_decides_each_table_as_analyze_does(call):
    for limit in ("XY=0.02", "XY=0.05", "XY=0.005", "XY_eq23=0.02"):
        codes = [call("analyze", path, "--limit", limit)[0] for path in (BEFORE, AFTER)]
        code, out, _ = call("compare", BEFORE, AFTER, "--limit", limit)
        assert code == max(codes)
        assert f"limit {limit.partition('=')[2]} mm" in " ".join(out.split())
    document = json.loads(call("compare", BEFORE, AFTER, "--limit", "XY=0.02", "--json")[1])
    found = [document["before"], *(pair["after"] for pair in document["pairs"])]
    assert [one["limits"][0]["verdict"] for one in found] == ["not-provable", "pass"]


def test_a_history_follows_the_paper_s_figure_by_its_name(call):
    last = sorted((EXAMPLES / "months").glob("2*.csv"))[-1]
    code, out, _ = call("history", EXAMPLES / "months", "--limit", "XY_eq23=0.03", "--json")
    (found,) = (one for one in json.loads(out)["figures"] if one["figure"] == "XY_eq23")
    assert code == call("analyze", last, "--limit", "XY_eq23=0.03")[0]
    axes = scara_iso.analyze(last).poses[0].axes
    RP = math.hypot(axes["X"].RP, axes["Y"].RP)
    assert found["tests"][-1]["value"] == pytest.approx(RP)
    both = call("history", EXAMPLES / "months", "--limit", "XY=0.03", "--json")[1]
    assert "XY_eq23" not in both


@pytest.mark.parametrize(("head", "band"), [((), "not known"), (["# resolution: 1"], "± 0.000577")])
def test_the_guard_band_is_twice_the_indicators_uncertainty(call, tmp_path, head, band):
    path = table(tmp_path / "t.csv", head=head)
    out = call("analyze", path, "--limit", "X=9um", "--decision", "simple", "--full")[1]
    (row,) = [line for line in out.splitlines() if line.endswith("pass") and "0.009 mm " in line]
    assert band in row


def test_the_file_of_a_test_takes_a_unit(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert call("test", "new", "T", "--poses", "P1")[0] == 0
    stated = Path("T/test.toml").read_text("utf-8")
    for limit, code in {'X = "20um"': 0, 'X = "3um"': 1}.items():
        text = stated.replace("[limits]", f"[limits]\n{limit}", 1)
        assert text != stated
        Path("T/test.toml").write_text(text, encoding="utf-8")
        shutil.copy(table(tmp_path / "t.csv", head=["# pose: P1"]), Path("T/P1-v100-l100.csv"))
        assert call("analyze", "T")[0] == code
