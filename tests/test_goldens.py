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


@pytest.mark.parametrize(
    ("said", "kept"),
    [
        ("-1.3877787807814457e-18", "0.0"),
        ("1.3877787807814457e-18", "0.0"),
        ("-1e-18", "0.0"),
        ("-0.0", "0.0"),
        ("-0.000", "-0.000"),
        ("0.30000000000000004", "0.3"),
        ("-0.0036923076923076923", "-0.003692307692"),
        ("0.020", "0.020"),
        ("1.5e-07", "1.5e-07"),
        ("12345678901234567890", "12345678901234567890"),
    ],
)
def test_a_golden_number_is_the_same_on_any_processor(said, kept):
    assert goldens.NUMBER.sub(goldens.ten_digits, said) == kept


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
