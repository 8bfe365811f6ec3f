"""Every characteristic meets one contract; RD and the figures of AP against independent sums."""

import inspect
import io
import json
import math
import re
import statistics
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import curve_fit
from scipy.spatial.distance import pdist
from scipy.stats import chi2, t, ttest_1samp, ttest_ind

from scara_iso import analyze, compare, diagnose
from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.plugins import find_modules
from scara_iso.base.quantities import Dimension
from scara_iso.commands import main
from scara_iso.commands.selftest import references
from scara_iso.iso9283 import characteristics
from scara_iso.iso9283.analysis import not_measured
from scara_iso.iso9283.core.drift import drift_courses
from scara_iso.iso9283.core.results import Measured
from scara_iso.run import Axis, Run
from scara_iso.tables import read_table, write_table

UNITS = {"stabilisation_time": "s", "compliance": "mm/100 N"}
MODULES = find_modules(characteristics, "scara_iso.characteristics")


FORCES = np.array([10.0, 20.0, 10.0, 0.0, -10.0, -20.0, -10.0, 0.0])


def of_a_stream(rng, axes, force):
    """Return the columns that a stream's table has, and those of a force that goes to and fro."""
    rows = len(force)
    found = {f"stabilisation_{name}_s": rng.uniform(0.1, 0.2, rows) for name in axes}
    sizes = {name: axis.dimension.value for name, axis in axes.items()}
    found |= {f"overshoot_{n}_{unit}": rng.uniform(0, 0.1, rows) for n, unit in sizes.items()}
    return found | {"force_N": force}


def two_poses(
    rng, *, axes="XYZ", cycles=31, dial_zero=True, in_turn=True, apart=40.0, stream=False, **changes
):
    """Return a run that visits P1 and P2 in each cycle, ``apart`` from each other in every axis."""
    pose = np.tile(["P1", "P2"], cycles)
    cycle = np.repeat(np.arange(1, cycles + 1), 2)
    force = np.resize(np.repeat(FORCES, 2), 2 * cycles)
    found = {
        name: Axis(
            name,
            rng.normal(0, 0.01, 2 * cycles)
            + np.where(pose == "P2", apart, 0.0)
            + (0.01 * force if stream else 0.0),
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
        covariates=of_a_stream(rng, found, force) if stream else {},
        metadata={"dial_zero": "command"} if dial_zero else {},
    )
    return run if in_turn else run.take(np.argsort(pose, kind="stable"))


def three_directions(rng, *, axes="XYZ", cycles=31, pose=None, moved=0.03, **changes):
    """Return a run that arrives from +x, +y and +z in each cycle, ``moved`` apart in X by +y."""
    direction = np.tile(["+x", "+y", "+z"], cycles)
    found = {
        name: Axis(
            name,
            rng.normal(0, 0.01, 3 * cycles)
            + np.where(direction == "+y", moved, 0.0) * (name == "X"),
            **changes,
        )
        for name in axes
    }
    if axes == "XYZ":
        found["theta"] = Axis("theta", rng.normal(0, 0.01, 3 * cycles), Dimension.ANGLE)
    pose = None if pose is None else np.full(3 * cycles, pose)
    cycle = np.repeat(np.arange(1, cycles + 1), 3)
    return Run(cycle=cycle, axes=found, pose=pose, direction=direction)


def drift_test(
    rng, *, axes="XYZ", cycles=10, blocks=33, size=0.06, tau_h=0.9, every_h=0.25, **changes
):
    """Return blocks of visits, one each quarter of an hour, that X and half of it Y drift in."""
    block = np.repeat(np.arange(1, blocks + 1), cycles)
    visit = np.tile(np.arange(1, cycles + 1), blocks)
    time_s = 3600 * every_h * (block - 1) + 12.0 * visit
    drift = size * (1 - np.exp(-time_s / 3600 / tau_h))
    share = {"X": 1.0, "Y": -0.5}
    found = {
        n: Axis(n, rng.normal(0, 0.004, len(block)) + share.get(n, 0) * drift, **changes)
        for n in axes
    }
    covariates = {"block": block.astype(float), "time_s": time_s}
    return Run(cycle=visit, axes=found, covariates=covariates)


FITTING = {
    "vAP": three_directions,
    **dict.fromkeys(("dAP", "dRP", "steady_after"), drift_test),
}


def of_two_robots(analysis, other):
    """Return the test of two robots with one program."""
    one, two = (Measured(a.run, a.cycles, a.poses) for a in (analysis, other))
    return Measured(one.run, one.cycles, one.poses, robots=(two,))


"""Runs that have what a characteristic needs, where two poses in turn do not."""


def by_name(analysis, code):
    return {(c.pose, c.of): c for c in analysis.characteristics if c.code == code}


@pytest.mark.parametrize("module", MODULES, ids=lambda module: module.__name__.split(".")[-1])
def test_contract(module, rng):
    title, _, page = inspect.getdoc(module).partition("\n\n")
    assert title.endswith(".")
    assert len(page) > 100, "the docstring is the page that explains it"
    assert re.fullmatch(r"[A-Za-z_]+", module.CODE)
    assert len(module.NEEDS) > 10
    make = FITTING.get(module.CODE, two_poses)
    more = {"stream": True} if make is two_poses else {}
    several = module.CODE == "exchangeability"
    analysis = analyze(make(rng, resolution=0.001, uncertainty=0.0005, **more))
    measured = Measured(
        analysis.run, analysis.cycles, analysis.poses, analysis.block, analysis.drift
    )
    analysis = of_two_robots(analysis, analyze(make(rng))) if several else measured
    found = list(module.compute(analysis))
    assert found, "a fitting run has it"
    assert len({(one.pose, one.of) for one in found}) == len(found)
    for one in found:
        estimate = one.estimate
        assert (one.code, estimate.clause) == (module.CODE, module.CLAUSE)
        length = UNITS.get(module.CODE, "mm")
        units = {"theta": "deg"} if length == "mm" else {}
        units |= {"XYZ": "h"} if module.CODE == "steady_after" else {}
        assert estimate.unit == units.get(one.of, length)
        assert estimate.n == (30 if make is not drift_test else 33 if estimate.unit == "h" else 10)
        assert estimate.interval[0] <= estimate.value <= estimate.interval[1]
        assert estimate.u == pytest.approx(math.hypot(*estimate.parts.values()))
    few = analyze(make(rng, cycles=4), **({} if make is drift_test else {"cycles": 4}))
    few = (
        of_two_robots(few, few)
        if several
        else Measured(few.run, few.cycles, few.poses, few.block, few.drift)
    )
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


@pytest.mark.slow
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


def test_limits_by_code_and_by_pair(rng):
    run = two_poses(rng, axes="XY")
    found = analyze(run, limits={"RD": 0.5, "RD:P1-P2": 0.001, "XY": 0.5})
    assert [(c.figure, c.pose, c.verdict.value) for c in found.limits] == [
        ("XY", "P1", "pass"), ("XY", "P2", "pass"),
        *((f"RD {of}", "P1-P2", "fail") for of in ("X", "Y", "XY")),
    ]  # fmt: skip
    held = {(c.code, c.of) for c in found.characteristics if c.limit is not None}
    assert held == {("RP", "XY"), ("RD", "X"), ("RD", "Y"), ("RD", "XY")}


def test_a_general_limit_is_one_of_repeatability(rng):
    limits = analyze(two_poses(rng), limits={"": 1.0}).limits
    assert [check.figure for check in limits] == 2 * ["X", "Y", "Z", "XY", "XYZ"]


def test_a_limit_of_what_takes_none_is_said_so(rng):
    with pytest.raises(UsageError, match="it has none at this pose"):
        analyze(two_poses(rng), limits={"RD:P8-P9": 1.0})
    drift = read_table(references("vectors", "drift.csv"))
    with pytest.raises(UsageError, match="this figure takes no limit"):
        analyze(drift, limits={"steady_after": 1.0})


def test_a_limit_by_its_code_is_that_of_every_figure_of_it(rng):
    limits = analyze(two_poses(rng), limits={"RP": 1.0, "XY": 2.0}).limits
    assert [check.figure for check in limits] == 2 * ["X", "Y", "Z", "XY", "XYZ"]
    assert [check.limit for check in limits] == 2 * [1.0, 1.0, 1.0, 2.0, 1.0]


def test_a_limit_of_what_is_not_there_names_what_is(rng):
    run = two_poses(rng, in_turn=False)
    with pytest.raises(UsageError) as caught:
        analyze(run, limits={"RD": 1.0})
    assert caught.value.remedy.startswith("it has X, Y, Z, theta, XY, XY_eq23, XYZ")
    assert "RD" not in caught.value.remedy
    assert "needs two to ten poses that are visited in each cycle" in caught.value.what
    with pytest.raises(UsageError) as caught:
        analyze(two_poses(rng), limits={"RQ": 1.0})
    assert caught.value.remedy.startswith(
        "it has X, Y, Z, theta, XY, XY_eq23, XYZ, RP, RP_a, RP_rss, AD"
    )


@pytest.mark.parametrize("code", ["AP", "AD", "vAP"])
def test_a_step_that_is_not_stated_widens_what_is_said_of_means(rng, code):
    run = three_directions(rng, axes="X") if code == "vAP" else two_poses(rng, axes="X")

    def interval(values, resolution=None):
        axis = replace(run.axes["X"], readings=values, resolution=resolution)
        found = by_name(analyze(replace(run, axes={"X": axis})), code)
        return next(iter(found.values())).estimate.interval

    rounded = run.axes["X"].readings.round(2)
    low, high = interval(rounded)
    assert (low, high) == pytest.approx(interval(rounded, 0.01))
    assert high - low > 0.01
    still = interval(rounded.round(-1))  # of two poses, on two levels that are 40 mm apart
    assert still is None or still[1] - still[0] > 1


def test_terminal_and_json_show_it(rng, tmp_path, capsys):
    run = two_poses(rng, axes="XY")
    rows = zip(run.pose, run.axes["X"].readings, run.axes["Y"].readings, strict=True)
    table = tmp_path / "two.csv"
    lines = [f"{pose},{x:.4f},{y:.4f}" for pose, x, y in rows]
    table.write_text("\n".join(["# unit: mm", "pose,X,Y", *lines, ""]), encoding="utf-8")
    assert main(["analyze", str(table), "--limit", "RD=0.001", "--full"]) == 1
    out = capsys.readouterr().out
    assert "RD (7.3)" in out
    assert "RD X at P1-P2" in out
    assert main(["analyze", str(table), "--json", "--limit", "RD=0.5"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["schema"] == "scara-iso/analyze/2"
    (x,) = (c for c in document["characteristics"] if (c["code"], c["of"]) == ("RD", "X"))
    assert x["limit"] == {"limit": 0.5, "verdict": "pass", "rule": "interval"}


@pytest.mark.parametrize(
    ("division", "seed", "limit"), [(0.003, 1, 0.025), (0.005, 33, 0.02), (0.01, 30, 0.03)]
)
def test_the_verdict_of_the_whole_is_the_gravest_of_any_figure(division, seed, limit):
    drawn = np.random.default_rng(seed).normal(0, 0.004, (31, 2)).T
    axes = {
        name: Axis(name, np.round(x / division) * division, resolution=division)
        for name, x in zip("XY", drawn, strict=True)
    }
    analysis = analyze(Run(np.arange(1, 32), axes), limits={"XY": limit, "XY_eq23": limit})
    radial, eq_23 = (one.limit for one in analysis.characteristics if one.limit)
    assert eq_23.RP > radial.RP, "the larger one alone would decide"
    assert (radial.verdict.value, eq_23.verdict.value) == ("not-provable", "pass")
    assert analysis.conformity.value == "not-provable"


def test_distance_accuracy_against_students_interval_of_the_distances(rng):
    run = two_poses(rng, apart=40.0, resolution=0.001)
    found = by_name(analyze(run), "AD")
    assert [key[1] for key in found] == ["X", "Y", "Z", "XY", "XYZ"]
    u = math.sqrt(2) * 1e-3 / math.sqrt(12)
    for of in ("X", "XY", "XYZ"):
        readings = np.stack([run.axes[name].readings for name in of], axis=1)[2:].reshape(30, 2, -1)
        D = np.array([math.dist(a, b) for a, b in readings]) - 40 * math.sqrt(len(of))
        estimate = found["P1-P2", of].estimate
        assert estimate.value == pytest.approx(D.mean())
        ends = ttest_1samp(D, 0).confidence_interval()
        reach = math.hypot((ends.high - ends.low) / 2, 2 * u)
        assert estimate.interval == pytest.approx((D.mean() - reach, D.mean() + reach), abs=1e-6)


@pytest.mark.parametrize("change", [{"dial_zero": False}, {"apart": 0.0}])
def test_without_a_scale_that_both_poses_share_there_is_no_distance_accuracy(rng, change):
    assert by_name(analyze(two_poses(rng, **change)), "AD") == {}


def test_along_an_axis_the_distance_counts_in_the_direction_commanded(rng):
    found = by_name(analyze(two_poses(rng, axes="X", apart=-40.0)), "AD")
    (estimate,) = (one.estimate for one in found.values())
    assert abs(estimate.value) < 0.01


def test_a_limit_of_a_signed_figure_is_one_of_its_size(rng):
    run = two_poses(rng, axes="X")
    low = Axis("X", run.axes["X"].readings - np.where(run.pose == "P2", 0.5, 0.0),
               command=run.axes["X"].command)  # fmt: skip
    run = Run(run.cycle, {"X": low}, run.pose, metadata=run.metadata)
    (check,) = analyze(run, limits={"AD": 0.4}).limits
    assert check.verdict.value == "fail"
    assert check.RP == pytest.approx(0.5, abs=0.02)
    assert [c.verdict.value for c in analyze(run, limits={"AP:P2": 0.6}).limits] == ["pass"]


def test_variation_is_the_largest_distance_of_the_barycentres(rng):
    run = three_directions(rng)
    found = by_name(analyze(run), "vAP")
    assert [of for _, of in found] == ["X", "Y", "Z", "theta", "XY", "XYZ"]
    for of in ("X", "XY", "XYZ"):
        positions = np.stack([run.axes[name].readings for name in of], axis=1)[3:]
        centres = positions.reshape(30, 3, -1).mean(axis=0)
        assert found[None, of].estimate.value == pytest.approx(pdist(centres).max())


def test_the_interval_of_two_directions_along_an_axis_is_welchs(rng):
    run = three_directions(rng, axes="X")
    two = run.take(np.flatnonzero(run.direction != "+z"))
    estimate = by_name(analyze(two), "vAP")[None, "X"].estimate
    x = two.axes["X"].readings[2:]
    ends = ttest_ind(x[1::2], x[::2], equal_var=False).confidence_interval()
    assert estimate.interval == pytest.approx((ends.low, ends.high))


def test_each_direction_has_its_own_repeatability_and_a_pose_its_name(rng):
    analysis = analyze(three_directions(rng, pose="P1", moved=1.0), limits={"vAP:P1": 2.0})
    assert [pose.label for pose in analysis.poses] == [f"P1 from {d}" for d in ("+x", "+y", "+z")]
    assert all(pose.axes["X"].RP < 0.05 for pose in analysis.poses)
    assert {pose for pose, _ in by_name(analysis, "vAP")} == {"P1"}
    assert not by_name(analysis, "RD"), "one pose has no distance to itself"
    assert {check.verdict.value for check in analysis.limits} == {"pass"}
    assert not [f for f in analysis.findings if f.code == "approach-directions"]


@pytest.mark.parametrize(
    ("left", "said", "is_there"),
    [(["+x"], "no vAP", False), (["+x", "+y"], "may be larger", True)],
)
def test_directions_that_lack_are_said(rng, left, said, is_there):
    run = three_directions(rng)
    analysis = analyze(run.take(np.flatnonzero(np.isin(run.direction, left))))
    (finding,) = (f for f in analysis.findings if f.code == "approach-directions")
    assert said in finding.message
    assert bool(by_name(analysis, "vAP")) is is_there


def test_opposite_directions_are_not_perpendicular(rng):
    run = three_directions(rng)
    direction = np.where(run.direction == "+z", "-x", run.direction)
    analysis = analyze(Run(run.cycle, run.axes, direction=direction))
    assert [f.rule for f in analysis.findings if f.code == "approach-directions"] == [
        "ISO 9283 7.2.3: three perpendicular directions"
    ]


@pytest.mark.parametrize("spelt", ["+x", "'+x", "+X", " +x "])
def test_a_table_may_name_directions(rng, tmp_path, capsys, spelt):
    rows = [
        f"{c},{d},{rng.normal(0, 0.01):.4f}" for d in (spelt, "-Y", "\u2212z") for c in range(1, 32)
    ]
    table = tmp_path / "three.csv"
    table.write_text("\n".join(["# unit: mm", "cycle,approach,X", *rows, ""]), encoding="utf-8")
    assert main(["analyze", str(table), "--json", "--limit", "vAP=0.05"]) == 0
    document = json.loads(capsys.readouterr().out)
    (x,) = (c for c in document["characteristics"] if c["code"] == "vAP")
    assert (x["of"], x["n"], x["limit"]["verdict"]) == ("X", 30, "pass")
    run = read_table(table)
    assert run.direction.tolist() == ["+x"] * 31 + ["-y"] * 31 + ["-z"] * 31
    again = read_table(io.BytesIO(write_table(run).encode()))
    assert again.direction.tolist() == run.direction.tolist()
    framed = Run.from_frame(run.to_frame())
    assert framed.direction.tolist() == run.direction.tolist()


def test_another_word_for_a_direction_is_refused_with_its_line(tmp_path):
    table = tmp_path / "odd.csv"
    table.write_text("# unit: mm\napproach,X\n+x,1\nleft,2\n+1,3\n", encoding="utf-8")
    with pytest.raises(DataError) as caught:
        read_table(table)
    assert [(f.line, f.message.partition(" (")[0]) for f in caught.value.faults] == [
        (4, "'left' is not a direction of approach"), (5, "'+1' is not a direction of approach"),
    ]  # fmt: skip


def blocks_of(run, names):
    return np.stack([run.axes[n].readings.reshape(33, 10) for n in names], axis=-1)


def test_drift_is_the_largest_distance_from_the_first_block(rng):
    run = drift_test(rng)
    analysis = analyze(run)
    found = by_name(analysis, "dAP")
    assert [of for _, of in found] == ["X", "Y", "Z", "XY", "XYZ"]
    for of in ("X", "XY", "XYZ"):
        centres = blocks_of(run, of).mean(axis=1)
        largest = np.linalg.norm(centres - centres[0], axis=1).max()
        assert found[None, of].estimate.value == pytest.approx(largest)
    assert not by_name(analysis, "RP"), "no RP counts the drift of hours as scatter"
    assert found[None, "X"].estimate.interval[0] > 0.05
    assert found[None, "Z"].estimate.interval[0] == 0


def test_drift_of_repeatability_is_the_largest_change_of_rp(rng):
    run = drift_test(rng)
    found = by_name(analyze(run), "dRP")
    for of in ("X", "XY", "XYZ"):
        blocks = blocks_of(run, of)
        distances = np.linalg.norm(blocks - blocks.mean(axis=1, keepdims=True), axis=2)
        RP = distances.mean(axis=1) + 3 * distances.std(axis=1, ddof=1)
        estimate = found[None, of].estimate
        assert estimate.value == pytest.approx(np.abs(RP[1:] - RP[0]).max())
        assert estimate.interval[0] == 0, "the scatter does not change"


def test_a_scatter_that_grows_is_shown(rng):
    run = drift_test(rng, axes="X", size=0.0)
    later = run.axes["X"].readings * np.where(run.covariates["block"] > 16, 6.0, 1.0)
    grown = Run(run.cycle, {"X": Axis("X", later)}, covariates=run.covariates)
    assert by_name(analyze(grown), "dRP")[None, "X"].estimate.interval[0] > 0


def test_the_time_constant_is_that_of_a_nonlinear_least_squares_fit(rng):
    run = drift_test(rng, axes="X")
    analysis = analyze(run)
    means = run.axes["X"].readings.reshape(33, 10).mean(axis=1)
    hours = (run.covariates["time_s"] - 12.0).reshape(33, 10).mean(axis=1) / 3600
    fit, _ = curve_fit(lambda t, c, a, tau: c + a * np.exp(-t / tau), hours, means, (0, 0, 1))
    (course,) = drift_courses(run, analysis.poses, analysis.block)
    assert course.fit.time_constant_h == pytest.approx(fit[2], rel=0.005)
    steady = by_name(analysis, "steady_after")[None, "X"].estimate
    assert steady.value == pytest.approx(math.log(10) * fit[2], rel=0.005)
    assert steady.interval[0] < math.log(10) * 0.9 < steady.interval[1]


def test_without_drift_or_before_its_end_nothing_is_steady(rng):
    assert not by_name(analyze(drift_test(rng, size=0.0)), "steady_after")
    slow = analyze(drift_test(rng, tau_h=30.0, size=0.3))
    assert not by_name(slow, "steady_after")
    (course,) = drift_courses(slow.run, slow.poses, slow.block)
    assert not course.fit.steady


def test_a_drift_that_is_over_in_the_first_block_may_have_taken_any_short_time(rng):
    run = drift_test(rng, axes="X", tau_h=0.03)
    analysis = analyze(run)
    (course,) = drift_courses(run, analysis.poses, analysis.block)
    low, high = course.fit.interval_h
    assert low == 0
    assert 0.03 < high < 1


def test_gaps_in_time_part_the_blocks_of_a_stated_drift_test(rng):
    run = drift_test(rng)
    unnumbered = Run(
        np.arange(1, 331), run.axes, covariates={"time_s": run.covariates["time_s"]},
        metadata={"test": "drift"},
    )  # fmt: skip
    analysis = analyze(unnumbered)
    assert np.array_equal(analysis.block, run.covariates["block"] - 1)
    (said,) = (f.message for f in analysis.findings if f.code == "drift-test")
    assert said.startswith("a drift test: 33 blocks of 10 visits over 8.03 h, parted at gaps")
    pair, again = (by_name(analyze(r), "dAP")[None, "XYZ"].estimate for r in (run, unnumbered))
    assert pair == again


def test_a_block_without_times_is_a_covariate_of_an_ordinary_test(rng):
    x = Axis("X", rng.normal(0, 0.01, 31))
    run = Run(np.arange(1, 32), {"X": x}, covariates={"block": np.repeat([1.0, 2.0], [15, 16])})
    analysis = analyze(run)
    assert analysis.block is None
    assert by_name(analysis, "RP")


@pytest.mark.parametrize("name", ["first_cycle_discarded", "cycles"])
def test_no_visit_of_a_drift_test_is_discarded(rng, name):
    with pytest.raises(UsageError, match="every visit of a drift test counts"):
        analyze(drift_test(rng), **{name: 31 if name == "cycles" else True})


def test_a_drift_test_that_cannot_be_read_says_why(rng):
    run = drift_test(rng)
    stated = Run(run.cycle, run.axes, metadata={"test": "drift"})
    with pytest.raises(DataError, match="'# visits_per_block: 10', nor times tell its blocks"):
        analyze(stated)
    cycle = run.cycle.copy()
    cycle[5] = 9
    with pytest.raises(DataError) as caught:
        analyze(Run(cycle, run.axes, covariates=run.covariates, lines=np.arange(len(run)) + 11))
    first = caught.value.faults[0]
    assert (first.line, first.message) == (16, "visit 9 comes after visit 5 of the same block")


def test_terminal_json_and_report_show_a_drift_test(rng, tmp_path, capsys):
    run = drift_test(rng, resolution=0.001)
    table, page = tmp_path / "drift.csv", tmp_path / "drift.html"
    table.write_text(write_table(run), encoding="utf-8")
    assert main(["analyze", str(table), "--limit", "dAP=0.01", "--full"]) == 1
    out = capsys.readouterr().out
    said = " ".join(out.split())
    assert re.search(r"steady after [12]\.\d+ h \[[12]\.\d+, 2\.\d+\]: a tenth is left then", said)
    assert "330 visits in 33 blocks; every visit counts." in said
    assert main(["analyze", str(table), "--json"]) == 0
    (course,) = json.loads(capsys.readouterr().out)["drift"]
    assert len(course["time_h"]) == len(course["mean"]["X"]) == 33
    assert course["fit"]["steady"]
    assert main(["report", str(table), "-o", str(page)]) == 0
    text = page.read_text(encoding="utf-8")
    assert "Course of the drift" in text
    assert "Repeatability at" not in text


def test_three_arrivals_have_a_stabilisation_time_with_students_interval(rng):
    run = two_poses(rng, axes="X", cycles=4, stream=True)
    found = by_name(analyze(run, cycles=4), "stabilisation_time")["P1", "X"].estimate
    times = run.covariates["stabilisation_X_s"][2::2]  # of P1, the first cycle discarded
    assert found.value == pytest.approx(statistics.mean(times))
    reach = t.ppf(0.975, 2) * statistics.stdev(times) / math.sqrt(3)
    assert found.interval[1] == pytest.approx(found.value + reach)
    assert found.interval[0] == pytest.approx(max(found.value - reach, 0.0))
    assert not by_name(analyze(two_poses(rng, cycles=3, stream=True), cycles=3), "overshoot")


def test_compliance_is_the_slope_of_the_reading_over_the_force(rng):
    run = two_poses(rng, axes="X", stream=True)
    analysis = analyze(run)
    found = by_name(analysis, "compliance")["P1", "X"].estimate
    assert found.value == pytest.approx(1.0, abs=4 * found.u)  # 0.01 mm/N
    warned = [(one.pose, one.axis) for one in analysis.findings if one.code == "force-loop"]
    assert warned == [("P1", "X"), ("P2", "X")]  # RP counts what the force moves
    assert found.u < 0.1
    assert not by_name(analyze(two_poses(rng)), "compliance")


def robots(rng, folder, zero="command", serials="ABC"):
    """Write a table of each of three robots, X of the third 0.04 mm from the others."""
    tables = []
    for serial, at in zip(serials, (0.0, 0.01, 0.04), strict=True):
        rows = [
            f"{c},{x:.4f},{y:.4f}"
            for c, (x, y) in enumerate(rng.normal((at, 0), 0.005, (31, 2)), 1)
        ]
        stated = [
            "# unit: mm",
            f"# serial_number: {serial}",
            *([f"# dial_zero: {zero}"] if zero else []),
        ]
        tables.append(folder / f"{serial}{len(tables)}.csv")
        tables[-1].write_text("\n".join([*stated, "cycle,X,Y", *rows, ""]), encoding="utf-8")
    return [str(table) for table in tables]


def test_robots_are_as_exchangeable_as_their_barycentres_are_near(rng, tmp_path, capsys):
    tables = robots(rng, tmp_path)
    found = compare(*tables, exchangeability=True).characteristics
    assert [(one.code, one.of) for one in found] == [
        ("exchangeability", of) for of in ("X", "Y", "XY")
    ]
    centres = np.stack([
        [axis.readings[1:].mean() for axis in read_table(table).axes.values()] for table in tables
    ])  # fmt: skip
    assert found[2].estimate.value == pytest.approx(pdist(centres).max())
    argv = ["compare", *tables, "--exchangeability", "--limit"]
    assert main([*argv, "exchangeability=0.1", "--json"]) == 0
    (x, *_) = json.loads(capsys.readouterr().out)["characteristics"]
    assert (x["clause"], x["limit"]["verdict"]) == ("7.7", "pass")
    assert main([*argv, "exchangeability=0.01", "--full"]) == 1
    out = capsys.readouterr().out
    assert "exchangeability (7.7)" in out
    assert "FAIL" in out


@pytest.mark.parametrize(
    ("change", "said"),
    [({"zero": ""}, "share one zero"), ({"serials": "ABA"}, "the same serial_number")],
)
def test_robots_that_cannot_be_exchanged_for_another_are_refused(rng, tmp_path, change, said):
    with pytest.raises(DataError, match=said):
        compare(*robots(rng, tmp_path, **change), exchangeability=True)
    with pytest.raises(UsageError):
        compare(*robots(rng, tmp_path), limits={"exchangeability": 1.0})


def test_what_is_not_measured_is_said_by_clause(rng, capsys):
    found = {one.name: one for one in not_measured(analyze(two_poses(rng)))}
    assert "RP" not in found
    assert found["vAP"].clause == "7.2.3"
    assert "three perpendicular directions" in found["vAP"].why
    assert {"8.2", "8.3", "8.5", "8.6", "9", "11"} <= {one.clause for one in found.values()}
    assert main(["explain", "beyond-dials"]) == 0
    assert "path accuracy AT" in capsys.readouterr().out


def test_a_drift_test_is_not_diagnosed_and_says_where_its_course_is(rng):
    with pytest.raises(DataError, match="a drift test is not diagnosed") as caught:
        diagnose(drift_test(rng))
    assert "scara-iso analyze" in caught.value.remedy
