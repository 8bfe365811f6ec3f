"""The site keeps its budget of words, and its navigation has every page once."""

import re
import runpy
import tomllib
from pathlib import Path

DOCS = Path(__file__).parents[1] / "docs"
WORDS = runpy.run_path(str(DOCS / "words.py"))
NAV = tomllib.loads((DOCS.parent / "zensical.toml").read_text(encoding="utf-8"))["project"]["nav"]


def paths(items):
    for item in items:
        for target in item.values():
            yield from [target] if isinstance(target, str) else paths(target)


def test_what_counts_as_a_word():
    assert WORDS["words"]("| RP | 0.014 mm |\n──── a_b [c](d.md)") == 5


def test_the_site_has_at_most_forty_thousand_words():
    found = WORDS["counted"]()
    made = {page: count for page, count in found.items() if page.startswith("reference/")}
    assert sum(found.values()) <= WORDS["BUDGET"]
    assert sum(made.values()) - made["reference/glossary.md"] <= WORDS["GENERATED"]


def test_the_navigation_has_every_page_once():
    there = [page.relative_to(DOCS).as_posix() for page in DOCS.rglob("*.md")]
    assert sorted(paths(NAV)) == sorted(there)


def test_no_page_loads_a_picture_from_outside():
    for page in DOCS.rglob("*.md"):
        assert not re.search(r"!\[[^\]]*\]\(https?:", page.read_text(encoding="utf-8")), page


def test_equations_are_numbered_and_each_has_its_module():
    page = (DOCS / "equations.md").read_text(encoding="utf-8")
    heads = re.findall(r"^\*\*\((\d+)\)\*\* .+ · `([a-z0-9_.]+)`$", page, flags=re.MULTILINE)
    assert [int(number) for number, _ in heads] == list(range(1, page.count("<math") + 1))
    source = DOCS.parent / "scara_iso"
    gone = [at for _, at in heads if not (source / f"{at.replace('.', '/')}.py").exists()]
    assert gone == []
