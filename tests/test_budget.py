"""The lines of each package stay within what pyproject.toml gives it: [tool.scara_iso.budget]."""

import tomllib
from collections import Counter
from pathlib import Path

import scara_iso

ROOT = Path(scara_iso.__file__).parent
BUDGET = tomllib.loads((ROOT.parent / "pyproject.toml").read_text("utf-8"))
BUDGET = BUDGET["tool"]["scara_iso"]["budget"]


def lines_by_room():
    counts = Counter()
    for path in (*ROOT.rglob("*.py"), *ROOT.rglob("*.pyi")):
        room = path.relative_to(ROOT).parts[0]
        counts[room.partition(".")[0]] += len(path.read_text("utf-8").splitlines())
    return counts


def test_no_package_has_more_lines_than_its_budget():
    """A change that needs more raises its line in the same commit, and says there what for."""
    more = {room: count for room, count in lines_by_room().items() if count > BUDGET.get(room, 0)}
    assert more == {}


def test_every_line_of_the_budget_is_of_a_package():
    assert BUDGET.keys() == lines_by_room().keys()
