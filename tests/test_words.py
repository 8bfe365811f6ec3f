"""Private words stay out of identifiers: a reader of the field does not know them."""

import ast
import re
from collections import Counter
from pathlib import Path

import scara_iso

ROOT = Path(scara_iso.__file__).parent
PRIVATE = {
    "beside", "foretold", "forgive", "heard", "held", "hidden", "joined", "killed", "meant",
    "nobody", "said", "several", "standing", "told",
}  # fmt: skip
TERMS = {"held_out"}
"""Terms of the field that hold such a word."""
ALLOWED = {
    "base": 9,
    "commands": 22,
    "comparison": 13,
    "diagnosis": 53,
    "effects": 4,
    "fleets": 4,
    "gauge": 7,
    "iso9283": 29,
    "rawfile": 4,
    "recorder": 27,
    "reporting": 1,
    "robot": 1,
    "run": 5,
    "signals": 7,
    "tables": 39,
    "testfolder": 14,
}
"""How many a room still has. These numbers only go down; a room without one has none."""


def names_given(tree):
    """Yield the names that a module defines: functions, classes, parameters, variables."""
    for node in ast.walk(tree):
        match node:
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name) | ast.arg(arg=name):
                yield name
            case ast.Name(id=name, ctx=ast.Store()):
                yield name


def words_of(name):
    for term in TERMS:
        name = name.lower().replace(term, "") if term in name.lower() else name
    return {word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+", name)}


def private_names():
    for path in sorted(ROOT.rglob("*.py")):
        room = path.relative_to(ROOT).parts[0]
        for name in names_given(ast.parse(path.read_text(encoding="utf-8"))):
            if words_of(name) & PRIVATE:
                yield room, name


def test_no_room_gives_more_private_names_than_it_may():
    found = list(private_names())
    counts = Counter(room for room, _ in found)
    more = {room: [name for at, name in found if at == room]
            for room, count in counts.items() if count > ALLOWED.get(room, 0)}  # fmt: skip
    assert more == {}


def test_an_allowance_is_no_more_than_is_there():
    counts = Counter(room for room, _ in private_names())
    assert {room: counts[room] for room in ALLOWED} == ALLOWED


def test_a_private_word_is_seen_wherever_it_stands():
    tree = ast.parse("def read_beside(held, *, told=0):\n    _SAID = held_out = told\n")
    assert [name for name in names_given(tree) if words_of(name) & PRIVATE] == [
        "read_beside", "held", "told", "_SAID",
    ]  # fmt: skip
