"""What other packages bring by an entry point: each kind is met like our own, or named and left."""

import sys

import pytest

from scara_iso import effects
from scara_iso.base.errors import UsageError
from scara_iso.base.plugins import find_modules
from scara_iso.iso9283 import characteristics, checks
from scara_iso.recorder import indicators
from scara_iso.recorder.indicators import Reading, find_dialect, find_dialects

HEAD = """
from dataclasses import replace
from scara_iso.recorder.indicators import find_dialect, make_generic
HOUSE = replace(make_generic(r"(?P<value>.*)"), key="house")
"""


@pytest.fixture
def install(tmp_path, monkeypatch):
    """Return what installs a package of one module under entry-point groups."""
    made = []

    def installed(name, source, *groups):
        (tmp_path / f"{name}.py").write_text(source, encoding="utf-8")
        declared = tmp_path / f"{name}-1.0.dist-info"
        declared.mkdir()
        (declared / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
        lines = [f"[{group}]\n{name} = {name}\n" for group in groups]
        (declared / "entry_points.txt").write_text("".join(lines))
        monkeypatch.syspath_prepend(tmp_path)
        made.append(name)

    yield installed
    for name in made:
        sys.modules.pop(name, None)


def test_a_dialect_of_another_package_is_met_by_its_key(install):
    install("theirs", HEAD + "DIALECT = HOUSE\n", "scara_iso.indicators")
    (event,) = find_dialect("house").parse(b"1.25")
    assert event == Reading("1.25", None, None, None, b"1.25")


def test_a_family_brings_all_its_dialects(install):
    install(
        "family", HEAD + 'DIALECTS = (HOUSE, replace(HOUSE, key="other"))\n', "scara_iso.indicators"
    )
    own = len(find_modules(indicators, "nobody.declares.this"))
    assert own == len(find_modules(indicators, "scara_iso.indicators")) - 1
    assert {"house", "other", "opto-rs232"} <= set(find_dialects())


def test_two_dialects_of_one_key_are_refused(install):
    taken = HEAD + 'DIALECT = replace(HOUSE, key="opto-rs232")\n'
    install("taken", taken, "scara_iso.indicators")
    with pytest.raises(UsageError, match="two dialects are called 'opto-rs232'"):
        find_dialects()


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("DIALECT = 'a name'\n", "TypeError: DIALECT is not a Dialect"),
        ("", "AttributeError"),
        ("raise SystemExit(3)\n", "SystemExit: 3"),
        ("import not_there_at_all\n", "ModuleNotFoundError"),
    ],
)
def test_a_package_that_brings_no_dialect_is_named_and_left_out(install, source, said):
    install("broken", source, "scara_iso.indicators")
    with pytest.warns(UserWarning, match=rf"plugin broken \(broken\) .*left out: {said}"):
        found = find_dialects()
    assert "opto-rs232" in found


@pytest.mark.parametrize(
    ("package", "group"),
    [
        (indicators, "scara_iso.indicators"),
        (effects, "scara_iso.effects"),
        (checks, "scara_iso.checks"),
        (characteristics, "scara_iso.characteristics"),
    ],
)
def test_each_group_is_asked_for_its_own_kind_only(install, package, group):
    """A module under another group's name is never met; under its own it is looked at."""
    groups = {
        "scara_iso.indicators", "scara_iso.effects", "scara_iso.checks",
        "scara_iso.characteristics",
    }  # fmt: skip
    install("elsewhere", "", *sorted(groups - {group}))
    find_modules(package, group)  # warnings are errors here
    install("here", "", group)
    with pytest.warns(UserWarning, match=f"plugin here \\(here\\) of {group} is left out"):
        find_modules(package, group)
