"""`.html`, `.md` and `.pdf` reports of a hostile table: their text is text."""

import re
from html.parser import HTMLParser

import pytest
from hostile import TEXTS, table
from markdown_it import MarkdownIt

from scara_iso import read_table
from scara_iso.commands import main
from scara_iso.render.formats import md
from scara_iso.reporting import LEVELS
from scara_iso.reporting.shared.blocks import Document, Notice, Section, Table, Text
from scara_iso.reporting.shared.digits import printable

NAME = "<b onclick=x>[red]$x$ `a` \u202e.xlsx"
PLAIN = {"h1", "h2", "p", "strong", "code", "table", "thead", "tbody", "tr", "th", "td"}
PAGE = PLAIN | {
    "html", "head", "meta", "title", "style", "body", "main", "section", "div", "b",
    "figure", "figcaption", "small", "span", "h3", "dl", "dt", "dd",
}  # fmt: skip


class Page(HTMLParser):
    """What is in a page: elements, attributes and text outside its pictures."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.attributes, self.texts, self.code = set(), {}, [], []
        self._within = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        if tag != "meta":
            self._within.append(tag)
        if "svg" not in self._within:
            self.tags.add(tag)
        for name, value in attrs:
            self.attributes.setdefault(name, set()).add(value)

    def handle_endtag(self, tag):
        while self._within and self._within.pop() != tag:
            pass

    def handle_data(self, data):
        if "style" not in self._within:
            (self.code if self._within[-1:] == ["code"] else self.texts).append(data)

    @property
    def text(self):
        return squeezed("".join(self.texts))


def squeezed(text):
    return " ".join(text.split())


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Return the run of a hostile table, and a function that writes its report."""
    source = table(tmp_path_factory.mktemp("page") / NAME, poses=["<b>[red]", "| P2 |"])

    def write(kind):
        out = source.with_name(f"out.{kind}")
        assert main(["report", str(source), "--cycles", "4", "-o", str(out)]) == 0
        return out.read_bytes()

    return read_table(source), write


def stated(run):
    texts = (*run.metadata.values(), *run.covariates, *run.pose.tolist(), NAME)
    return {squeezed(printable(text)) for text in texts}


def test_html_holds_our_elements_and_every_text(made):
    run, write = made
    page = write("html").decode()
    assert not [c for c in set(page) if not c.isprintable() and c != "\n"]
    found = Page(page)
    assert found.tags - {"svg"} <= PAGE
    assert not [name for name in found.attributes if name.startswith("on")]
    for name in ("href", "xlink:href", "src"):
        assert all(link.startswith("#") for link in found.attributes.get(name, ()))
    assert [text for text in stated(run) if text not in found.text] == []


def rendered(markdown):
    return MarkdownIt("commonmark", {"html": True}).enable(["table", "strikethrough"]).render(
        markdown
    )  # fmt: skip


def test_markdown_holds_our_elements_and_every_text(made):
    run, write = made
    source = write("md").decode()
    assert not [c for c in set(source) if not c.isprintable() and c != "\n"]
    found = Page(rendered(source))
    assert found.tags <= PLAIN
    assert set("".join(found.code)) <= set(LEVELS)
    assert [text for text in stated(run) if text not in found.text] == []


@pytest.mark.parametrize("text", TEXTS, ids=lambda text: ascii(text)[:24])
def test_markdown_says_a_text_wherever_it_stands(text):
    blocks = (Text(text), Text(text, "strong"), Table((text, "b"), ((text, text),), text),
              Notice("info", text, text, text))  # fmt: skip
    source = md.render(Document(text, (Section(text, blocks),), None)).decode()
    assert not re.search(r"(?i)<|\$|://|www\.|@", source)
    page = rendered(source)
    assert set(re.findall(r"<(\w+)", page)) == PLAIN - {"code"}
    assert page.count("<tr>") == 2
    assert page.count("<td") == 2
    assert Page(page).text.count(squeezed(printable(text))) >= 10


@pytest.mark.slow
def test_pdf_holds_no_action_link_or_script(made):
    pytest.importorskip("weasyprint", exc_type=(ImportError, OSError))
    _, write = made
    data = write("pdf")
    assert data.startswith(b"%PDF")
    objects = re.sub(rb"stream.*?endstream", b"", data, flags=re.DOTALL)
    assert not re.findall(rb"/(?:URI|JavaScript|JS|Launch|AA|Annots|EmbeddedFile)\b", objects)
