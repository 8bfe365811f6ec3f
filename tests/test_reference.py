"""docs/reference/ is what docs/generate.py makes of the code."""

import runpy
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[1] / "docs"
MADE = runpy.run_path(str(DOCS / "generate.py"))["reference"]()


@pytest.mark.parametrize("name", MADE)
def test_a_page_is_up_to_date(name):
    text = (DOCS / "reference" / name).read_text(encoding="utf-8")
    assert text == MADE[name], "run: python docs/generate.py"


def test_there_is_no_other_page():
    assert {path.name for path in (DOCS / "reference").iterdir()} == set(MADE)
