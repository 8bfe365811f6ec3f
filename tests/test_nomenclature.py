"""The glossary has every term that `explain` knows; the page of equations every figure's symbol."""

from pathlib import Path

import pytest

from scara_iso.reporting.explain import WORDS

GLOSSARY = Path(__file__).parents[1] / "docs" / "reference" / "glossary.md"


@pytest.mark.parametrize("names", WORDS)
def test_every_term_of_the_screens_is_in_the_glossary(names):
    assert f"**{', '.join(names)}**" in GLOSSARY.read_text(encoding="utf-8")
