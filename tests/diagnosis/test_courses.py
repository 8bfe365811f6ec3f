"""What no effect explains: its course in words, and a formula that foretells unseen cycles."""

import json
from pathlib import Path

import numpy as np
import pytest

from scara_iso.commands import main
from scara_iso.diagnosis.unexplained.course_formula import formula_for
from scara_iso.diagnosis.unexplained.course_words import in_words, levels_in_words
from scara_iso.effects import parse_formula

TABLE = str(Path(__file__).parents[2] / "examples" / "unexplained.csv")
J = np.arange(30)
CYCLE = J + 2
BUMP = (
    "stays level in the first 10 cycles, rises until cycle 17, falls until cycle 24, then stays "
    "level"
)


@pytest.mark.parametrize(
    ("course", "said"),
    [
        (np.abs(J - 12), "falls in the first 13 cycles, then rises"),
        (-J, "falls all the time"),
        (np.maximum(J - 15, 0), "stays level in the first 18 cycles, then rises"),
        (12 * np.exp(-0.5 * ((J - 15) / 3) ** 2), BUMP),
        (5 * np.sin(J * 2 * np.pi / 8), "goes up and down, 8 times in 30 cycles"),
        (0 * J, ""),
    ],
)  # fmt: skip
def test_a_course_in_words(course, said):
    assert in_words(course, CYCLE) == said


def test_levels_in_words():
    behind = (J[:, np.newaxis] >= [6, 14, 24]).astype(float)
    y = behind @ [0.02, -0.05, 0.036] + 0.002 * np.random.default_rng(1).normal(size=30)
    said = levels_in_words(y - y.mean(), behind, CYCLE)
    assert (
        said
        == "has 4 levels: +0.02 from cycle 8 on, -0.05 from cycle 16 on, +0.034 from cycle 26 on"
    )
    scatter = np.random.default_rng(2).normal(size=30)
    assert levels_in_words(scatter, behind, CYCLE) == ""
    assert levels_in_words(scatter, behind[:, :0], CYCLE) == ""


@pytest.mark.parametrize(
    "course",
    [
        np.abs(J - 12) / 3,
        6 * np.exp(-J / 15) * np.sin(J * 2 * np.pi / 12),
        4.0 * (J > 9) - 5 * (J > 19),
    ],
)
def test_a_formula_is_what_it_says(course):
    rng = np.random.default_rng(2)
    y = course + rng.normal(size=30)
    found = formula_for(y, CYCLE, rng)
    assert found is not None
    again = parse_formula(found.text).value({"k": CYCLE.astype(float)})
    left = float(np.sqrt(((y - again) ** 2).mean()))
    assert left < 0.75 * y.std()
    assert left < found.held_out_rms < found.alone_rms
    assert found.alone_rms == pytest.approx(y.std() * 30 / 29, rel=0.05)
    fresh = course + rng.normal(size=(200, 30))
    unseen = float(np.sqrt(((fresh - again) ** 2).mean()))
    assert unseen < found.alone_rms


@pytest.mark.slow
def test_scatter_alone_has_no_formula():
    rng = np.random.default_rng(7)
    offered = [formula_for(np.round(rng.normal(size=30)), CYCLE, rng) for _ in range(20)]
    assert sum(one is not None for one in offered) <= 3  # at 5 %; more than 3 in 1 of 60


def test_it_is_told(capsys):
    assert main(["diagnose", TABLE, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["verdict"] == "unexplained"
    x, _ = document["courses"]
    assert x["words"] == "rises in the first 7 cycles, falls until cycle 22, then rises"
    assert x["held_out_rms"]["with_formula"] < 0.8 * x["held_out_rms"]["without"]
    parse_formula(x["formula"])
    assert main(["diagnose", TABLE]) == 0
    assert "X rises in the first 7 cycles" in capsys.readouterr().out
    assert main(["diagnose", TABLE, "--full"]) == 0
    assert "X goes about like" in capsys.readouterr().out
    assert main(["diagnose", TABLE.replace("unexplained", "scatter"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["courses"] == []
