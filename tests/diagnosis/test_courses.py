"""What no effect explains: its course in words."""

import json
from pathlib import Path

import numpy as np
import pytest

from scara_iso.commands import main
from scara_iso.diagnosis.readings import in_words

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


def test_it_is_told(capsys):
    assert main(["diagnose", TABLE, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["verdict"] == "unexplained"
    x, _ = document["courses"]
    assert x["words"] == "rises in the first 7 cycles, falls until cycle 22, then rises"
    assert x.keys() == {"axis", "words"}
    assert main(["diagnose", TABLE]) == 0
    assert "X rises in the first 7 cycles" in capsys.readouterr().out
    assert main(["diagnose", TABLE.replace("unexplained", "scatter"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["courses"] == []
