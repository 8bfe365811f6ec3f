"""The results of the public functions: what each field means, and how they show themselves."""

import ast
import inspect
import re
from pathlib import Path

import pytest

import scara_iso

ROOT = Path(scara_iso.__file__).parent
SOURCES = {path: ast.parse(path.read_text(encoding="utf-8")) for path in ROOT.rglob("*.py")}


def is_dataclass(node):
    return any("dataclass" in ast.unparse(decorator) for decorator in node.decorator_list)


DATACLASSES = {
    node.name: node
    for tree in SOURCES.values()
    for node in tree.body
    if isinstance(node, ast.ClassDef) and is_dataclass(node)
}


def fields_of(node):
    """Return the name, annotation and docstring of each field of a dataclass."""
    after = {id(a): b for a, b in zip(node.body, node.body[1:], strict=False)}
    for line in node.body:
        if not isinstance(line, ast.AnnAssign) or "ClassVar" in ast.unparse(line.annotation):
            continue
        below = after.get(id(line))
        said = isinstance(below, ast.Expr) and isinstance(below.value, ast.Constant)
        yield line.target.id, ast.unparse(line.annotation), below.value.value if said else None


ALIASES = {
    ast.unparse(node.targets[0])
    for tree in SOURCES.values()
    for node in tree.body
    if isinstance(node, ast.Assign)
}
"""Other names for a type, which a dataclass elsewhere may have too."""


def named_in(annotation):
    return {*re.findall(r"\w+", annotation)} & {*DATACLASSES} - ALIASES


def reachable():
    """Return the results of the public functions and the public classes, and all they hold."""
    public = [getattr(scara_iso, name) for name in scara_iso.__all__]
    functions = [ast.unparse(ast.parse(inspect.signature(one).return_annotation))
                 for one in public if inspect.isfunction(one)]  # fmt: skip
    todo = {one.__name__ for one in public if inspect.isclass(one)} & {*DATACLASSES}
    todo = todo.union(*map(named_in, functions))
    found = set()
    while todo - found:
        name = (todo - found).pop()
        found.add(name)
        todo = todo.union(*(named_in(kind) for _, kind, _ in fields_of(DATACLASSES[name])))
    return sorted(found)


def test_results_are_reached():
    assert {"Analysis", "Estimate", "GearFound", "Contrast", "PlannedPose"} <= {*reachable()}


@pytest.mark.parametrize("name", reachable())
def test_every_field_of_a_result_says_what_it_is(name):
    node = DATACLASSES[name]
    page = ast.get_docstring(node) or ""
    silent = [f for f, _, said in fields_of(node) if not said and f"``{f}``" not in page]
    assert not silent
