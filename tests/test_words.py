"""Private words stay out of identifiers: a reader of the field does not know them."""

import ast
import re
from collections import Counter
from functools import cache

import pytest
from source import PACKAGE, PATHS, nodes_of, tree_of

PRIVATE = {
    "beside", "foretold", "forgive", "heard", "held", "hidden", "joined", "killed", "meant",
    "nobody", "said", "several", "standing", "told",
}  # fmt: skip
TERMS = {"held_out"}
"""Terms of the field that hold such a word."""
ALLOWED = {
    "base": 4,
    "commands": 16,
    "comparison": 10,
    "diagnosis": 31,
    "effects": 4,
    "fleets": 3,
    "gauge": 7,
    "iso9283": 27,
    "rawfile": 4,
    "recorder": 24,
    "reporting": 1,
    "robot": 1,
    "run": 5,
    "signals": 5,
    "tables": 27,
    "testfolder": 12,
}
"""How many a room still has. These numbers only go down; a room without one has none."""


def names_given(nodes):
    """Yield the names that a module defines: functions, classes, parameters, variables."""
    for node in nodes:
        match node:
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name) | ast.arg(arg=name):
                yield name
            case ast.Name(id=name, ctx=ast.Store()):
                yield name


@cache
def words_of(name):
    for term in TERMS:
        name = name.lower().replace(term, "") if term in name.lower() else name
    return {word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+", name)}


@cache
def private_names():
    return [
        (path.relative_to(PACKAGE).parts[0], name)
        for path in PATHS
        for name in names_given(nodes_of(path))
        if words_of(name) & PRIVATE
    ]


def test_no_room_gives_more_private_names_than_it_may():
    found = private_names()
    counts = Counter(room for room, _ in found)
    more = {room: [name for at, name in found if at == room]
            for room, count in counts.items() if count > ALLOWED.get(room, 0)}  # fmt: skip
    assert more == {}


def test_an_allowance_is_no_more_than_is_there():
    counts = Counter(room for room, _ in private_names())
    assert {room: counts[room] for room in ALLOWED} == ALLOWED


def test_a_private_word_is_seen_wherever_it_stands():
    nodes = ast.walk(ast.parse("def read_beside(held, *, told=0):\n    _SAID = held_out = told\n"))
    assert [name for name in names_given(nodes) if words_of(name) & PRIVATE] == [
        "read_beside", "held", "told", "_SAID",
    ]  # fmt: skip


ODD = re.compile(
    r"(?<!there )\b(is|are) (no|none|said)\b(?! (more|longer|model)\b)|\bof no (name|kind)\b|"
    r"\bgone on\b|\b(go|goes) on with\b|"
    r"\bmay be met\b|\bis not met\b|\bif repeated\b(?!,)|\bfor(e)?tell|\bforetold\b|\bwould do\b|"
    r"\bnobody\b|\bgraver\b|(?<!\|\\)\+/-|\bdocs/",
    re.IGNORECASE,
)
"""Phrases that a reader stumbles over, and pages that an installed program does not have."""


def texts_of(tree):
    """Yield what a module may show: its strings, without docstrings."""
    docs = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docs:
            yield node.value


def test_no_screen_page_or_refusal_holds_an_odd_phrase():
    odd = {
        (path.relative_to(PACKAGE).as_posix(), found[0])
        for path in PATHS
        for text in texts_of(tree_of(path))
        if (found := ODD.search(text))
    }
    assert odd == set()


@pytest.mark.parametrize("text", ["a step that is no step", "+0.03 +/- 0.01", "see docs/a.md"])
def test_an_odd_phrase_is_seen(text):
    assert ODD.search(text)
