"""The package's own files as syntax trees, each parsed once."""

import ast
from functools import cache
from pathlib import Path

import scara_iso

PACKAGE = Path(scara_iso.__file__).parent
PATHS = sorted(PACKAGE.rglob("*.py"))


@cache
def tree_of(path):
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def nodes_of(path):
    """Return all nodes of a file: a walk costs as much as parsing."""
    return tuple(ast.walk(tree_of(path)))
