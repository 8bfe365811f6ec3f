"""The self test: green as installed, red when one constant is not what it was."""

import dataclasses
import io
import json
import math
import tomllib
from contextlib import redirect_stdout
from pathlib import Path

import numpy as np
import pytest
from oracles import effect_tables, vectors as oracle
from scipy import constants

import scara_iso
from scara_iso.base import quantities
from scara_iso.commands import main, selftest as suite
from scara_iso.commands.selftest import validate
from scara_iso.iso9283 import pushed_joint
from scara_iso.iso9283.characteristics import drp, rd
from scara_iso.iso9283.core import cycles, figures, statistics
from scara_iso.recorder import indicators
from scara_iso.robot import two_inertia

ROOT = Path(__file__).parents[2]


def red(*groups):
    """Return the names of the references of some groups that are not met."""
    checks = list(validate({group: suite.GROUPS[group] for group in groups}))
    assert checks
    return [check.name for check in checks if not check.passed]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Return what the command says and writes, as installed."""
    page, out = tmp_path_factory.mktemp("selftest") / "record.html", io.StringIO()
    with redirect_stdout(out):
        code = main(["selftest", "--json", "--report", str(page)])
    return code, json.loads(out.getvalue()), page.read_text(encoding="utf-8")


@pytest.mark.slow
def test_as_installed_every_reference_is_met(whole):
    code, found, page = whole
    assert (code, found["verdict"], found["differing"]) == (0, "pass", [])
    assert {check["group"] for check in found["checks"]} == {*suite.GROUPS}
    assert "PASS: all" in page
    assert "validated by: name, signature" in page
    for name in (*found["versions"], *found["hashes"].values(), found["platform"]):
        assert name in page


@pytest.mark.slow
def test_the_versions_are_of_what_the_program_stands_on(whole):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    names = {text.split(">")[0] for text in project["dependencies"]}
    assert set(whole[1]["versions"]) == {"Python", *names}
    assert whole[1]["versions"]["numpy"] == np.__version__


def test_the_cycle_rule_is_met():
    assert {
        one.name: one.obtained for one in suite.rule_checks() if one.expected != one.obtained
    } == {}


def test_a_certified_figure_is_met_to_four_digits_at_least():
    """The least: a deviation of 0.1 about 10 million, of which a double leaves six digits."""
    checks = [*suite.nist_checks()]
    assert len(checks) == 14  # seven sets
    assert all(check.passed for check in checks)
    assert all(check.tolerance <= 1.1e-4 * abs(check.expected) for check in checks)


def test_the_tables_of_known_effects_are_those_of_their_courses():
    for effect, text in effect_tables.tables().items():
        assert (effect_tables.FOLDER / f"{effect}.csv").read_text(encoding="utf-8") == text


def numbers_of(figure):
    return [figure["value"], *(figure["interval"] or []), figure["u"] or 0.0]


def test_the_tables_and_their_figures_are_those_of_the_oracle():
    for name, data in oracle.made().items():
        kept = (oracle.FOLDER / name).read_bytes()
        if not name.endswith(".json"):
            assert kept == data
            continue
        for mine, other in zip(json.loads(kept), json.loads(data), strict=True):
            assert mine["tables"] == other["tables"]
            for a, b in zip(mine["figures"], other["figures"], strict=True):
                assert numbers_of(a) == pytest.approx(numbers_of(b), rel=1e-6)


def test_the_sizes_of_units_are_those_of_scipy():
    stated = json.loads(suite.references("figures.json").read_text("utf-8"))["units"]
    known = {one["unit"]: one["expected"] for one in stated if "text" not in one}
    millimetres = {"um": constants.micron, "inch": constants.inch, "thou": constants.mil}
    for name, metres in millimetres.items():
        assert known[name] == pytest.approx(1000 * metres, rel=1e-15)
    degrees = {"rad": 1.0, "arcmin": constants.arcmin, "arcsec": constants.arcsec}
    for name, radians in degrees.items():
        assert known[name] == pytest.approx(math.degrees(radians), rel=1e-15)


def with_factor(factor):
    def repeatability(positions):
        found = statistics.repeatability(positions)
        return dataclasses.replace(found, RP=found.l_bar + factor * found.S_l)

    return repeatability


def half_as_long(unit):
    return dataclasses.replace(unit, numerator=unit.numerator / 2)


INCH, OPTO = quantities._BY_NAME["inch"], indicators.find_dialect("opto-rs232")
CHANGES = {
    "the factor 3 of RP": (figures, "repeatability", with_factor(2.99), "paper"),
    "its error": (statistics, "GAUSSIAN_ERROR", {1: 0.75, 2: 0.58, 3: 0.5}, "characteristics"),
    "the shortfall": (statistics, "_SHORTFALL", 2.9, "characteristics"),
    "cycles that are run": (cycles, "CYCLES_RUN", 30, "procedure"),
    "Student's quantile": (statistics, "_LEVEL", 0.051, "characteristics"),
    "n - 1": (rd, "standard_deviation", lambda x: np.std(x, axis=-1), "characteristics"),
    "an inch": (quantities._BY_NAME, "inch", half_as_long(INCH), "units"),
    "rounding": (statistics, "rounding_uncertainty", lambda q: q / 3, "characteristics"),
}  # fmt: skip


@pytest.mark.parametrize("name", CHANGES)
def test_one_changed_constant_turns_it_red(monkeypatch, name):
    where, what, changed, group = CHANGES[name]
    (monkeypatch.setitem if isinstance(where, dict) else monkeypatch.setattr)(where, what, changed)
    assert red(group)


def test_the_uncertainty_of_drift_robots_and_push_is_compared(monkeypatch):
    monkeypatch.setattr(statistics, "_LEVEL", 0.0505)
    monkeypatch.setattr(drp, "_CONFIDENCE", 0.9505)
    monkeypatch.setattr(pushed_joint, "_DITHERED", 0.1)
    differing = red("characteristics")
    for figure in ("drift: dAP XY, high [mm]", "robots: exchangeability XY, low [mm]",
                   "three directions: vAP XY, low [mm]", "drift: dRP XY, high [mm]",
                   "push with scatter: compliance reading, u [mm/100 N]"):  # fmt: skip
        assert figure in differing


def test_a_dialect_that_reads_another_number_turns_it_red(monkeypatch):
    key, found = OPTO.key, dict(indicators.find_dialects())
    found[key] = dataclasses.replace(OPTO, parse=found["maxum"].parse)
    monkeypatch.setattr("scara_iso.recorder.find_dialects", lambda: found)
    differing = red("streams")
    assert differing
    assert all(name.startswith(f"{key}/") for name in differing)


def test_a_check_that_fails_with_an_error_is_a_failed_check(monkeypatch):
    monkeypatch.setattr(two_inertia, "backlash", None)
    monkeypatch.setattr("scara_iso.commands.selftest.first_joint", None)
    assert red("paper") == ["the rest of this group"]


def test_a_reading_that_is_lost_turns_it_red(monkeypatch):
    told = suite._recorded_until_the_end
    monkeypatch.setattr(suite, "_recorded_until_the_end", lambda table: {**told(table), 31: 0.5})
    names = [check.name for check in suite.recorder_checks() if not check.passed]
    assert names == ["announced readings in the raw file", "announced readings in the table"]


def test_the_command_names_what_differs_and_exits_1(monkeypatch, capsys, tmp_path):
    monkeypatch.setitem(quantities._BY_NAME, "inch", half_as_long(INCH))
    units = {"units": suite.GROUPS["units"]}
    monkeypatch.setattr(suite, "validate", lambda: validate(units))
    for ending in ("md", "xlsx", "csv"):
        assert main(["selftest", "--report", str(tmp_path / f"record.{ending}")]) == 1
        out = capsys.readouterr().out
        assert "FAIL: 2 of 17 references are not met" in out
        assert "1 inch: 12.7 instead of 25.4" in out
    assert "NOT MET" in (tmp_path / "record.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(("name", "code"), [("a.doc", 2), ("nowhere/a.html", 73)])
def test_a_record_that_cannot_be_written(monkeypatch, capsys, tmp_path, name, code):
    monkeypatch.setattr(suite, "validate", lambda: iter(()))
    assert main(["selftest", "--report", str(tmp_path / name)]) == code
    assert capsys.readouterr().out == ""


def test_nothing_compared_is_no_pass(monkeypatch):
    monkeypatch.setattr(suite, "validate", lambda: iter(()))
    assert scara_iso.selftest().verdict == "fail"
