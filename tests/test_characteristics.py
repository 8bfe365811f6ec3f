"""Every characteristic meets one contract; RD and the figures of AP against independent sums."""

import inspect
import json
import math
import re
import statistics

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.stats import chi2, t

from scara_iso.cli import main
from scara_iso.errors import UsageError
from scara_iso.iso9283 import characteristics
from scara_iso.iso9283.analysis import analyze
from scara_iso.iso9283.estimates import _student
from scara_iso.plugins import find_modules
from scara_iso.quantities import Dimension
from scara_iso.run import Axis, Run

MODULES = find_modules(characteristics, "scara_iso.characteristics")


def two_poses(rng, *, axes="XYZ", cycles=31, dial_zero=True, in_turn=True, apart=40.0, **changes):
    """Return a run that visits P1 and P2 in each cycle, ``apart`` from each other in every axis."""
    pose = np.tile(["P1", "P2"], cycles)
    cycle = np.repeat(np.arange(1, cycles + 1), 2)
    found = {
        name: Axis(
            name,
            rng.normal(0, 0.01, 2 * cycles) + np.where(pose == "P2", apart, 0.0),
            command={"P1": 0.0, "P2": apart},
            **changes,
        )
        for name in axes
    }
    found["theta"] = Axis("theta", rng.normal(0, 0.01, 2 * cycles), Dimension.ANGLE)
    run = Run(
        cycle=cycle,
        axes=found,
        pose=pose,
        metadata={"dial_zero": "command"} if dial_zero else {},
    )
    return run if in_turn else run.take(np.argsort(pose, kind="stable"))


def by_name(analysis, code):
    return {(c.pose, c.of): c for c in analysis.characteristics if c.code == code}


@pytest.mark.parametrize("module", MODULES, ids=lambda module: module.__name__.split(".")[-1])
def test_contract(module, rng):
    title, _, page = inspect.getdoc(module).partition("\n\n")
    assert title.endswith(".")
    assert len(page) > 100, "the docstring is the page that explains it"
    assert re.fullmatch(r"[A-Za-z_]+", module.CODE)
    analysis = analyze(two_poses(rng, resolution=0.001, uncertainty=0.0005))
    found = list(module.compute(analysis))
    assert found, "two poses of four axes with their command poses have everything there is"
    assert len({(one.pose, one.of) for one in found}) == len(found)
    for one in found:
        estimate = one.estimate
        assert (one.code, estimate.clause) == (module.CODE, module.CLAUSE)
        assert estimate.unit == ("deg" if one.of == "theta" else "mm")
        assert estimate.n == 30
        assert estimate.interval[0] <= estimate.value <= estimate.interval[1]
        assert estimate.u == pytest.approx(math.hypot(*estimate.parts.values()))
    few = analyze(two_poses(rng, cycles=4), cycles=4)
    assert all(one.estimate.u is one.estimate.interval is None for one in module.compute(few))


def test_codes_are_unique():
    assert len({module.CODE for module in MODULES}) == len(MODULES)


def test_the_figures_of_a_pose_are_its_characteristics(rng):
    analysis = analyze(two_poses(rng))
    for pose in analysis.poses:
        for name in ("X", "Y", "Z", "XY", "XYZ"):
            found = by_name(analysis, "RP")[pose.label, name].estimate
            assert (found.value, found.interval) == (
                pose.figures[name].RP, pose.figures[name].RP_interval
            )  # fmt: skip
        theta = by_name(analysis, "RP_a")[pose.label, "theta"].estimate
        assert theta.value == pytest.approx(3 * statistics.stdev(pose.axes["theta"].readings))
        assert (pose.label, "theta") not in by_name(analysis, "RP")


def test_distance_repeatability_is_three_standard_deviations_of_the_distances(rng):
    run = two_poses(rng)
    found = by_name(analyze(run), "RD")
    assert [key[1] for key in found] == ["X", "Y", "Z", "XY", "XYZ"]
    for of in ("X", "XY", "XYZ"):
        readings = np.stack([run.axes[name].readings for name in of], axis=1)[2:]
        distances = [math.dist(a, b) for a, b in readings.reshape(30, 2, -1)]
        assert found["P1-P2", of].estimate.value == pytest.approx(3 * statistics.stdev(distances))


def test_the_interval_of_a_distance_holds_what_it_should():
    """Coverage of 3 sigma sqrt(2) in 200 tests; the chi-square interval is the oracle's width."""
    inside, widths = 0, []
    for seed in range(200):
        run = two_poses(np.random.default_rng(seed), axes="X")
        found = by_name(analyze(run), "RD")["P1-P2", "X"].estimate
        inside += found.interval[0] <= 3 * math.sqrt(2) * 0.01 <= found.interval[1]
        widths.append((found.interval[1] - found.interval[0]) / found.value)
    ends = [math.sqrt(29 / chi2.ppf(q, 29)) for q in (0.025, 0.975)]
    assert 0.91 < inside / 200 <= 1
    assert np.median(widths) == pytest.approx(ends[0] - ends[1], rel=0.25)


def test_a_dial_set_to_zero_at_each_pose_changes_no_distance_along_an_axis(rng):
    run = two_poses(rng, axes="X", apart=0.0)
    x = run.axes["X"].readings + np.where(run.pose == "P2", 0.25, 0.0)
    moved = Run(run.cycle, {"X": Axis("X", x)}, run.pose)
    one, other = (by_name(analyze(r), "RD")["P1-P2", "X"].estimate for r in (run, moved))
    assert one.value == pytest.approx(other.value)


@pytest.mark.parametrize("change", [{"dial_zero": False}, {"apart": 0.0}])
def test_without_a_common_scale_there_is_no_distance_in_a_plane(rng, change):
    assert {of for _, of in by_name(analyze(two_poses(rng, **change)), "RD")} == {"X", "Y", "Z"}


def test_poses_one_after_the_other_have_no_distance(rng):
    assert by_name(analyze(two_poses(rng, in_turn=False)), "RD") == {}


def test_a_missing_cycle_of_one_pose_is_left_out_of_both(rng):
    run = two_poses(rng, axes="X")
    gone = run.take(np.array([k for k in range(len(run)) if k != 20]))  # P1 in cycle 11
    found = by_name(analyze(gone, allow_gaps=True), "RD")["P1-P2", "X"].estimate
    kept = [k for k in range(1, 31) if k != 10]
    x = run.axes["X"].readings
    distances = [x[2 * k + 1] - x[2 * k] for k in kept]
    assert found.n == 29
    assert found.value == pytest.approx(3 * statistics.stdev(distances))


def test_rounding_that_hides_the_scatter_of_a_distance_leaves_its_lower_end_at_0(rng):
    pose = np.tile(["P1", "P2"], 31)
    x = Axis("X", rng.integers(0, 2, 62) * 0.01, resolution=0.01)
    run = Run(np.repeat(np.arange(1, 32), 2), {"X": x}, pose)
    found = by_name(analyze(run), "RD")["P1-P2", "X"].estimate
    assert found.interval[0] == 0


def test_accuracy_of_an_axis_has_students_interval(rng):
    run = two_poses(rng, resolution=0.001, uncertainty=0.002)
    found = by_name(analyze(run), "AP")
    x = run.axes["X"].readings[run.pose == "P2"][1:]
    S = statistics.stdev(x)
    reach = math.hypot(t.ppf(0.975, 29) * S / math.sqrt(30), 2 * math.hypot(0.002, 1e-3 / 12**0.5))
    estimate = found["P2", "X"].estimate
    assert estimate.value == pytest.approx(x.mean() - 40, abs=1e-9)
    assert estimate.interval == pytest.approx(
        (x.mean() - 40 - reach, x.mean() - 40 + reach), abs=1e-7
    )
    assert all(one.estimate.interval[0] >= 0 for (_, of), one in found.items() if of == "XY")
    assert by_name(analyze(two_poses(rng, dial_zero=False)), "AP") == {}


@given(st.integers(4, 400))
def test_students_quantile(freedom):
    assert _student(freedom) == pytest.approx(t.ppf(0.975, freedom), rel=0.004)


def test_limits_by_code_and_by_pair(rng):
    run = two_poses(rng, axes="XY")
    found = analyze(run, limits={"RD": 0.5, "RD:P1-P2": 0.001, "XY": 0.5})
    assert [(c.figure, c.pose, c.verdict.value) for c in found.limits] == [
        ("XY", "P1", "pass"), ("XY", "P2", "pass"),
        *((f"RD {of}", "P1-P2", "fail") for of in ("X", "Y", "XY")),
    ]  # fmt: skip
    held = {(c.code, c.of) for c in found.characteristics if c.limit is not None}
    assert held == {("RP", "XY"), ("RP_rss", "XY"), ("RD", "X"), ("RD", "Y"), ("RD", "XY")}


def test_a_general_limit_is_one_of_repeatability(rng):
    limits = analyze(two_poses(rng), limits={"": 1.0}).limits
    assert [check.figure for check in limits] == 2 * ["X", "Y", "Z", "XY", "XYZ"]


def test_a_limit_of_what_is_not_there_names_what_is(rng):
    run = two_poses(rng, in_turn=False)
    with pytest.raises(UsageError) as caught:
        analyze(run, limits={"RD": 1.0})
    assert caught.value.remedy.startswith("it has X, Y, Z, theta, XY, XYZ")
    assert "RD" not in caught.value.remedy
    with pytest.raises(UsageError) as caught:
        analyze(two_poses(rng), limits={"RQ": 1.0})
    assert caught.value.remedy.startswith("it has X, Y, Z, theta, XY, XYZ, RD")


def test_terminal_and_json_show_it(rng, tmp_path, capsys):
    run = two_poses(rng, axes="XY")
    rows = zip(run.pose, run.axes["X"].readings, run.axes["Y"].readings, strict=True)
    table = tmp_path / "two.csv"
    lines = [f"{pose},{x:.4f},{y:.4f}" for pose, x, y in rows]
    table.write_text("\n".join(["# unit: mm", "pose,X,Y", *lines, ""]), encoding="utf-8")
    assert main(["analyze", str(table), "--limit", "RD=0.001"]) == 1
    out = capsys.readouterr().out
    assert "RD (7.3)" in out
    assert "RD X at P1-P2" in out
    assert main(["analyze", str(table), "--json", "--limit", "RD=0.5"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["schema"] == "scara-iso/analyze/2"
    (x,) = (c for c in document["characteristics"] if (c["code"], c["of"]) == ("RD", "X"))
    assert x["limit"] == {"limit": 0.5, "verdict": "pass", "rule": "interval"}
