"""What a page shows is what its commands write; every link of every page leads somewhere."""

import doctest
import re
import shutil

import pytest
from console import BLOCK, ROOT, WIDTH, alike, played, renewed

PAGES = sorted(
    path for path in ROOT.rglob("*.md")
    if not any(part.startswith(".") for part in path.relative_to(ROOT).parts)
)  # fmt: skip
PLAYED = [
    page if page == ROOT / "README.md" else pytest.param(page, marks=pytest.mark.slow)
    for page in PAGES if BLOCK.search(page.read_text(encoding="utf-8"))
]  # fmt: skip
NOTEBOOK = re.compile(r"(?<=^```pycon\n).*?(?=^```)", re.MULTILINE | re.DOTALL)
FENCED = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)


def named(path):
    return str(path.relative_to(ROOT))


@pytest.mark.parametrize("path", PLAYED, ids=named)
def test_the_commands_of_a_page_write_what_it_shows(path, tmp_path, monkeypatch):
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", WIDTH)
    page = path.read_text(encoding="utf-8")
    assert played(page).splitlines() == page.splitlines()


def test_lines_left_out_are_no_other_lines():
    assert alike("a\n...\nc\n", "a\nb\nb\nc\n")
    assert alike("a\n...\nc\n", "a\nc\n")
    assert not alike("a\n...\nc\n", "a\nb\nd\n")
    assert not alike("a\nc\n", "a\nb\nc\n")


def test_what_is_left_out_stays_left_out_in_the_page_of_today():
    assert renewed("a 1\n...\nc 1\n...\n", "a 2\nb\nc 2\nd\n") == "a 2\n...\nc 2\n...\n"
    assert renewed("a 1\n", "a 2\nb\n") == "a 2\nb\n"


@pytest.mark.parametrize(
    "path", [p for p in PAGES if NOTEBOOK.search(p.read_text("utf-8"))], ids=named
)
def test_a_page_s_python_says_what_it_shows(path, tmp_path, monkeypatch):
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    monkeypatch.chdir(tmp_path)
    session = "\n".join(NOTEBOOK.findall(path.read_text(encoding="utf-8")))
    played = doctest.DocTestParser().get_doctest(session, {}, path.name, str(path), 0)
    failed, tried = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE).run(played)
    assert tried
    assert not failed


def links(path):
    text = FENCED.sub("", path.read_text(encoding="utf-8"))
    return re.findall(r"\]\((?!https?:|mailto:)([^)\s]+)\)", text)


def anchors(path):
    """Return the anchors of a page's headings, as the repository's web page forms them."""
    text = FENCED.sub("", path.read_text(encoding="utf-8"))
    headings = re.findall(r"^#+ +(.*?) *$", text, flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading).lower().replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("path", [p for p in PAGES if p.name != "CHANGELOG.md"], ids=named)
def test_every_link_leads_somewhere(path):
    for link in links(path):
        name, _, anchor = link.partition("#")
        target = (path.parent / name).resolve() if name else path
        assert target.exists(), link
        assert not anchor or anchor in anchors(target), link


def test_every_page_of_docs_is_found_from_its_index():
    docs, seen, ahead = ROOT / "docs", set(), [ROOT / "docs" / "README.md"]
    while ahead:
        page = ahead.pop()
        seen.add(page)
        targets = {(page.parent / link.partition("#")[0]).resolve() for link in links(page)}
        ahead += [t for t in targets - seen if t.suffix == ".md" and t.is_relative_to(docs)]
    assert {page for page in PAGES if page.is_relative_to(docs)} <= seen
