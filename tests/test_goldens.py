"""What the commands say and write is what the golden files hold.

Wanted changes are written by ``python tests/goldens.py`` and read in the difference.
"""

import math
import re

import goldens
import pytest

NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
CLOSE = {"rel_tol": 1e-6, "abs_tol": 1e-9}  # other processors round sums otherwise


def words(text):
    """Return the lines of a text with a mark for each number, and the numbers."""
    return NUMBER.sub("0", text).splitlines(), [float(word) for word in NUMBER.findall(text)]


def test_each_golden_file_has_its_commands():
    assert {path.stem for path in goldens.GOLDEN.iterdir()} == set(goldens.cases())


DIAGNOSES = re.compile("(effect|diagnose|report)_(?!fum)")  # those of the paper's table are quick
CASES = [
    pytest.param(name, marks=[pytest.mark.slow] if DIAGNOSES.match(name) else [])
    for name in goldens.cases()
]


@pytest.mark.parametrize("name", CASES)
def test_commands_do_what_they_did(name):
    golden = (goldens.GOLDEN / f"{name}.txt").read_text(encoding="utf-8")
    today = goldens.played(goldens.cases()[name])
    if today != golden:
        (lines, numbers), (wanted, expected) = words(today), words(golden)
        assert lines == wanted
        far = [
            (now, then)
            for now, then in zip(numbers, expected, strict=True)
            if not math.isclose(now, then, **CLOSE)
        ]
        assert far == []
