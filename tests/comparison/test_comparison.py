"""Two runs: what is shown is there, what is not there is not shown, and the page is told why."""

import json
import math
import re
from itertools import pairwise

import numpy as np
import pytest
from budget import examples
from hypothesis import given, strategies as st
from matplotlib.backends.backend_agg import FigureCanvasAgg
from scipy import stats

import scara_iso
from scara_iso import analyze
from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.published import to_json, to_text
from scara_iso.base.quantities import Dimension
from scara_iso.commands import main
from scara_iso.comparison import ContrastVerdict, compare
from scara_iso.comparison.chance import largest_bias, mean_error, spread, through_dial
from scara_iso.comparison.decision import Distance, PermutationTest
from scara_iso.iso9283.core.statistics import repeatability
from scara_iso.render.plots import save_figure
from scara_iso.reporting.comparison import _next, comparison_report, headline
from scara_iso.reporting.pictures import comparison_pictures
from scara_iso.run import Axis, Run

SHOWN = (ContrastVerdict.LESS, ContrastVerdict.MORE)


def analysis(readings, *, resolution=1e-6, metadata=None, pose=None, source="", angle=()):
    """Return the analysis of readings by axis, shape (n,), none of which is discarded."""
    n = len(next(iter(readings.values())))
    poses = 1 if pose is None else len(set(pose))
    run = Run(
        cycle=np.tile(np.arange(2, 2 + n // poses), poses),
        axes={
            name: Axis(
                name,
                np.asarray(values),
                Dimension.ANGLE if name in angle else Dimension.LENGTH,
                resolution=resolution,
            )
            for name, values in readings.items()
        },
        pose=None if pose is None else np.array(pose),
        metadata=metadata or {},
    )
    return analyze(run, first_cycle_discarded=True, cycles=n // poses + 1)


def pair(before, after, **options):
    return compare([before, after], shuffles=499, **options).pairs[0]


def gaussian(rng, scale=1.0, place=0.0, axes=("X",), n=30):
    scales = dict.fromkeys(axes, 1.0) | {"X": scale}
    return {name: place + scales[name] * rng.standard_normal(n) for name in axes}


@pytest.mark.parametrize("components", [1, 2, 3])
def test_the_standard_error_is_the_jackknife_s(rng, components):
    positions = rng.gamma(3, 1, (components, 2000))
    figure, error = spread(positions, angle=False)
    assert figure == repeatability(positions).RP
    kept = np.arange(2000) % 100
    without = [math.log(repeatability(positions[:, kept != g]).RP) for g in range(100)]
    jackknife = math.sqrt(99 / 100 * np.sum((np.array(without) - np.mean(without)) ** 2))
    assert error == pytest.approx(jackknife, rel=0.25)


def test_the_standard_error_of_three_sigma_is_that_of_gaussian_scatter(rng):
    figure, error = spread(rng.standard_normal((400, 1, 500)), angle=True)
    assert figure.mean() == pytest.approx(3, rel=0.01)
    assert error.mean() == pytest.approx(np.log(figure).std(), rel=0.15)


@pytest.mark.parametrize("n", [6, 10, 40])
def test_the_standard_error_of_three_sigma_of_two_odd_readings_is_the_jackknife_s(n):
    """By the kurtosis, n / 2 here: its influence on the logarithm is (x^2 / s^2 - 1) / 2."""
    readings = np.zeros((1, n))
    readings[0, :2] = 1.0, -1.0
    _, error = spread(readings, angle=True)
    assert error == pytest.approx(math.sqrt(max((n / 2 - 1) / 4, 0.5) / n))


def test_the_error_of_the_means_is_welch_s(rng):
    x, y = rng.standard_normal(20), 3 * rng.standard_normal(30)
    expected = stats.ttest_ind(y, x, equal_var=False).statistic
    assert (y.mean() - x.mean()) / mean_error(x, y) == pytest.approx(expected)


def test_a_repair_is_shown_where_it_is_and_only_there(rng):
    axes = ("X", "Y", "Z")
    before = analysis(gaussian(rng, 4.0, axes=axes))
    found = pair(before, analysis(gaussian(rng, 1.0, place=7.0, axes=axes)))
    verdicts = {one.figure: one.verdict for one in found.spreads}
    assert verdicts["X"] is verdicts["XY"] is ContrastVerdict.LESS
    assert verdicts["Y"] is verdicts["Z"] is ContrastVerdict.NOT_SHOWN
    assert all(one.verdict is ContrastVerdict.MORE for one in found.means)
    assert "X better" in headline(found)


def test_no_difference_is_an_answer(rng):
    found = pair(analysis(gaussian(rng)), analysis(gaussian(rng)))
    assert headline(found).startswith("RP: no change that 30 cycles can show, X ")
    assert "; mean: no change that 30 cycles can show, X " in headline(found)
    together = pair(*(analysis(gaussian(rng, axes=("X", "Y"))) for _ in range(2)))
    assert headline(together).startswith("RP: no change that 30 cycles can show, XY ")
    X = found.spreads[0]
    assert X.cycles_needed > 30
    assert 1.5 < X.smallest_shown < 2.5


@pytest.mark.slow
@pytest.mark.parametrize("scale", [1.0, 2.0])
def test_level_and_power_of_one_axis(rng, scale):
    shown = [
        compare(
            [analysis(gaussian(rng)), analysis(gaussian(rng, scale, place=5))], shuffles=199
        ).pairs[0].spreads[0].verdict
        for _ in range(80)
    ]  # fmt: skip
    share = np.mean([verdict in SHOWN for verdict in shown])
    assert share < 0.13 if scale == 1 else share > 0.75


def test_two_places_between_the_divisions_are_no_difference(rng):
    shown = []
    for _ in range(50):
        before, after = (np.rint(0.4 * rng.standard_normal(30) + p) for p in (0.0, 0.5))
        found = pair(analysis({"X": before}, resolution=1), analysis({"X": after}, resolution=1))
        shown.append(found.spreads[0].verdict in SHOWN)
    assert np.mean(shown) < 0.06


@given(st.integers(0, 2**32), st.floats(0.2, 5), st.sampled_from([0.001, 0.5, 1.0]))
@examples(25)
def test_interval_p_value_and_verdict_say_the_same(seed, scale, division):
    rng = np.random.default_rng(seed)
    runs = [
        analysis(
            {name: np.rint(s * rng.standard_normal(12) / division) * division for name in "XY"},
            resolution=division,
        )
        for s in (1.0, scale)
    ]
    found = pair(*runs)
    for one in (*found.spreads, *found.means):
        lower, upper = one.difference_interval
        decided = one.verdict in SHOWN
        assert decided == (one.p_value <= 0.05)
        assert one.p_value >= one.p_value_alone
        assert lower is None or lower <= one.difference + 1e-12
        assert upper is None or upper >= one.difference - 1e-12
        if one in found.spreads:
            low, high = one.ratio_interval
            assert decided == (low > 1 or (high is not None and high < 1))
        if not decided:
            assert lower is None or lower <= 0
            assert upper is None or upper >= 0
    json.loads(
        to_text(to_json(compare(runs, shuffles=99))),
        parse_constant=pytest.fail,
    )


def test_a_shift_of_the_indicator_changes_no_spread(rng):
    readings = gaussian(rng, axes=("X", "Y"))
    shifted = {name: values + 1024.0 for name, values in readings.items()}
    before = analysis(gaussian(rng, axes=("X", "Y")))
    plain, moved = pair(before, analysis(readings)), pair(before, analysis(shifted))
    for one, other in zip(plain.spreads, moved.spreads, strict=True):
        assert one.verdict is other.verdict
        assert one.ratio == pytest.approx(other.ratio, rel=1e-9)
        assert one.ratio_interval == pytest.approx(other.ratio_interval, rel=1e-6)


def test_a_dial_that_never_moves_hides_up_to_its_division(rng):
    stuck = analysis({"X": np.full(30, 0.5)}, resolution=0.01)
    found = pair(analysis({"X": 0.5 + 0.2 * rng.standard_normal(30)}, resolution=0.01), stuck)
    assert (
        found.spreads[0].verdict is ContrastVerdict.LESS
    )  # no division hides RP of half a millimetre
    assert headline(found) == "nothing is compared: one of the dials stood still"
    both = pair(stuck, stuck).spreads[0]
    assert (both.verdict, both.ratio, both.ratio_interval) == (
        ContrastVerdict.NOT_SHOWN,
        None,
        (0, None),
    )
    silent = analysis({"X": np.full(30, 0.5)}, resolution=None)
    assert pair(stuck, silent).spreads[0].verdict not in SHOWN


def test_rounding_moves_a_mean_by_no_more_than_it_is_given(rng):
    for sigma in (0.05, 0.35, 0.6):
        for place in np.linspace(0, 1, 11):
            readings = np.rint(place + sigma * rng.standard_normal(4000))
            assert abs(readings.mean() - place) <= largest_bias(readings, 1.0) + 4 * sigma / 60
    assert largest_bias(rng.standard_normal(30), 0.01) < 1e-12
    assert largest_bias(rng.standard_normal(30), None) == 0


def test_a_figure_is_freed_from_its_rounding(rng):
    true = 2.60632 * 0.6
    for place in (0.0, 0.25, 0.5):
        found = through_dial(
            np.rint(place + 0.6 * rng.standard_normal((1, 20_000))), [1.0], angle=False
        )
        assert found.freed == pytest.approx(true, rel=0.03)
    fine = through_dial(rng.standard_normal((1, 30)), [0.1], angle=False)
    assert fine.read == fine.freed


def test_an_angle_is_compared_by_three_sigma(rng):
    readings = {"theta": rng.standard_normal(30)}
    found = pair(analysis(readings, angle=("theta",)), analysis(readings, angle=("theta",)))
    (theta,) = found.spreads
    assert (theta.quantity, theta.unit) == ("three_sigma", "deg")
    assert theta.before == pytest.approx(3 * readings["theta"].std(ddof=1))
    assert "same-readings" in {f.code for f in found.findings}


def test_the_wanted_cycles_show_the_difference(rng):
    found = pair(
        analysis({"X": stats.norm.ppf((np.arange(30) + 0.5) / 30)}),
        analysis({"X": 1.3 * stats.norm.ppf((np.arange(30) + 0.5) / 30)}),
    )
    n = found.spreads[0].cycles_needed
    shown = [
        pair(analysis(gaussian(rng, n=n)), analysis(gaussian(rng, 1.3, n=n))).spreads[0].verdict
        for _ in range(60)
    ]
    assert 0.6 < np.mean([verdict is ContrastVerdict.MORE for verdict in shown]) < 0.98


def test_several_runs_share_the_level(rng):
    before, after = analysis(gaussian(rng)), analysis(gaussian(rng, 1.5))
    alone = compare([before, after]).pairs[0].spreads[0]
    among = compare([before, after, before, before]).pairs
    assert len(among) == 3
    assert among[0].before is among[2].before is before
    assert among[0].spreads[0].p_value == pytest.approx(min(3 * alone.p_value, 1))
    assert among[0].spreads[0].ratio_interval[0] < alone.ratio_interval[0]


def test_what_is_not_the_same_is_said(rng):
    before = analysis(
        gaussian(rng, axes=("X", "Y", "theta")), angle=("theta",),
        metadata={"payload": "2 kg", "operator": "A", "date": "1", "velocity": "100 %"},
    )  # fmt: skip
    after = analysis(
        gaussian(rng, axes=("X", "Z", "theta"), n=40), resolution=0.01,
        metadata={"payload": "5 kg", "operator": "B", "date": "2"},
    )  # fmt: skip
    found = pair(before, after)
    assert [one.figure for one in found.means] == ["X"]
    said = {(f.code, f.axis) for f in found.findings}
    wanted = {("other-axes", "Y"), ("other-axes", "Z"), ("other-unit", "theta"),
              ("other-resolution", "X"), ("other-cycles", None)}  # fmt: skip
    assert wanted <= said
    conditions = [f.message for f in found.findings if f.code == "other-conditions"]
    assert conditions[0] == "payload is 2 kg before, 5 kg after"
    assert "operator is A before, B after" in conditions
    assert "only the first table states velocity" in conditions
    assert not any("date" in message for message in conditions)


def test_another_dial_is_a_warning(rng):
    before, after = (
        analysis(gaussian(rng, axes=("X",)), metadata={"dial": dial}) for dial in ("Mahr", "Käfer")
    )
    (finding,) = (f for f in pair(before, after).findings if f.code == "other-conditions")
    assert (finding.severity, finding.message) == ("warning", "dial is Mahr before, Käfer after")


def test_poses_are_compared_with_their_like(rng):
    labels = ["P1"] * 20 + ["P2"] * 20
    before = analysis(gaussian(rng, n=40), pose=labels)
    after = analysis(gaussian(rng, n=40), pose=["P2"] * 20 + ["P3"] * 20)
    found = pair(before, after)
    assert [one.pose for one in found.spreads] == ["P2"]
    assert found.spreads[0].before == before.poses[1].axes["X"].RP
    assert sum(f.code == "other-pose" for f in found.findings) == 2
    with pytest.raises(DataError, match="no pose in common"):
        pair(before, analysis(gaussian(rng, n=40), pose=["P4"] * 20 + ["P5"] * 20))


def test_the_cycles_that_every_pose_has_are_compared(rng):
    rows = [(c, pose, *rng.normal(0, 0.01, 2)) for c in range(1, 32) for pose in ("P1", "P2")]

    def table(*missing):
        kept = [f"{c},{p},{x:.4f},{y:.4f}\n" for c, p, x, y in rows if (c, p) not in missing]
        return ("# unit: mm\n# resolution: 0.0001\ncycle,pose,X,Y\n" + "".join(kept)).encode()

    found, whole = (
        scara_iso.compare(table(), table(*missing), allow_gaps=True).pairs[0]
        for missing in ([(5, "P1")], [(5, "P1"), (5, "P2")])
    )
    assert [one.after for one in found.spreads] == [one.after for one in whole.spreads]
    assert "after: cycle 5: not there at every pose, left out" in [
        one.message for one in found.findings
    ]


def test_a_drift_is_said_beside_the_figure(rng):
    drift = {"X": np.linspace(0, 8, 30) + rng.standard_normal(30)}
    found = pair(analysis(gaussian(rng)), analysis(drift))
    assert found.spreads[0].doubts == ("trend",)
    text = str(comparison_report(compare([analysis(gaussian(rng)), analysis(drift)])))
    assert "readings drift" in text


def test_what_cannot_be_compared_is_refused(rng):
    one = analysis(gaussian(rng))
    with pytest.raises(UsageError, match="needs two runs"):
        compare([one])
    with pytest.raises(DataError, match="no axis in common"):
        compare([one, analysis({"Y": rng.standard_normal(30)})])
    with pytest.raises(DataError, match="4 cycles count"):
        compare([one, analysis({"X": rng.standard_normal(4)})])


def test_the_picture_is_the_same_each_time_and_takes_any_name(rng, tmp_path):
    stuck = analysis({"X": np.full(30, 0.5), "Y": rng.standard_normal(30)}, resolution=0.01)
    found = compare([analysis(gaussian(rng, axes=("X", "Y"))), stuck], shuffles=99)
    for name in ("a.svg", "b.svg"):
        save_figure(found.plot(), tmp_path / name)
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
    _, ratio, mean = comparison_pictures(found)
    (pair,) = found.pairs
    open_ends = sum(end in (None, 0) for one in pair.spreads for end in one.ratio_interval)
    looks = [curve.look for curve in ratio.panels[0].curves]
    assert looks.count("below") + looks.count("above") == open_ends > 0
    assert ratio.ticks == tuple(one.figure for one in pair.spreads)
    shown = [curve.y[0] for curve in mean.panels[0].curves if curve.look in ("points", "hollow")]
    assert shown == [one.difference for one in pair.means]


def test_nothing_in_the_picture_is_written_over_another(rng):
    before, after = (
        analysis(gaussian(rng) | {"X": shift + rng.normal(0, 0.013, 30)}, source=f"{'a/' * 40}.csv")
        for shift in (0.0, -0.005)
    )
    figure = compare([before, after], shuffles=99).plot()
    FigureCanvasAgg(figure).draw()
    words = [text.get_window_extent() for part in figure.subfigs for text in part.texts]
    assert words
    assert all(figure.bbox.x0 <= box.x0 and box.x1 <= figure.bbox.x1 for box in words)
    for axes in figure.axes:
        assert axes.title.get_window_extent().width < 1.1 * axes.bbox.width
        labels = [label.get_window_extent() for label in axes.get_xticklabels(which="major")]
        inside = [box for box in labels if axes.bbox.x0 <= box.x0 + box.width / 2 <= axes.bbox.x1]
        assert all(one.x1 < other.x0 for one, other in pairwise(inside))


def test_the_command_shows_the_example_s_repair(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    tables = ["examples/before_repair.csv", "examples/after_repair.csv"]
    assert main(["compare", *tables, "--full"]) == 0
    said = capsys.readouterr().out
    assert "X better 0.019 to 0.008 mm, ×0.43 [0.22, 0.84]" in said
    assert max(map(len, said.splitlines())) <= 80
    assert main(["compare", *tables, "--json"]) == 0
    found = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    assert found["schema"] == "scara-iso/compare/1"
    assert {one["figure"]: one["verdict"] for one in found["pairs"][0]["spreads"]}["X"] == "less"


def test_the_command_names_the_faults_of_every_table(capsys, tmp_path):
    bad = tmp_path / "[bold]bad.csv"
    bad.write_text("cycle,X\n1,a\n2,b\n", encoding="utf-8")
    worse = tmp_path / "worse.csv"
    worse.write_text(bad.read_text("utf-8"), encoding="utf-8")
    assert main(["compare", str(bad), str(worse), "examples/scatter.csv"]) == 65
    said = capsys.readouterr().err
    assert "2 of 3 tables" in said
    assert "[bold]bad.csv: line 2" in said
    assert "worse.csv: line 2" in said
    assert main(["compare", str(bad), str(tmp_path / "none.csv"), "examples/scatter.csv"]) == 66
    assert "none.csv: No such file" in capsys.readouterr().err, "what is not there comes first"
    assert main(["compare", str(tmp_path / "a.csv"), str(tmp_path / "b.csv")]) == 66
    assert main(["compare", "-", "-"]) == 2
    assert main(["compare", "examples/scatter.csv"]) == 2


@pytest.mark.slow
def test_something_is_said_of_5_percent_of_unchanged_pairs():
    """RP and means share the level; with 5 % each it was 43 of these 400."""
    says = 0
    for seed in range(1000, 1400):
        readings = np.random.default_rng(seed).normal(0.5, 0.005, (2, 31)).round(3)
        runs = [Run(np.arange(1, 32), {"X": Axis("X", own, resolution=0.001)}) for own in readings]
        (pair,) = compare([analyze(run) for run in runs]).pairs
        shown = [one.verdict for one in (*pair.means, *pair.spreads)]
        says += set(shown) != {ContrastVerdict.NOT_SHOWN}
    assert says <= 31  # of 400, at 5 %: more in 0.6 % of all sets of seeds


def test_runs_of_another_length_are_compared_and_dates_that_go_back_are_asked_about(tmp_path, rng):
    def written(name, n, date):
        rows = "".join(f"{k},{x:.3f}\n" for k, x in enumerate(rng.normal(0.4, 0.005, n), 1))
        head = f"# unit: mm\n# resolution: 0.001\n# date: {date}\n"
        (tmp_path / name).write_text(f"{head}cycle,X\n{rows}")
        return tmp_path / name

    whole, short = written("a.csv", 31, "2026-03-01"), written("b.csv", 12, "2026-04-01")
    (pair,) = scara_iso.compare(whole, short, cycles=12).pairs
    assert (pair.before.cycles.used, pair.after.cycles.used) == (30, 11)
    assert not any("exchanged?" in one.message for one in pair.findings)
    (pair,) = scara_iso.compare(short, whole, cycles=12).pairs
    (order,) = (one for one in pair.findings if "exchanged?" in one.message)
    assert "is of 2026-04-01, the second of 2026-03-01" in order.message


def test_the_headline_names_every_figure_that_changed(capsys, tmp_path, rng):
    """What has no room in a line was left out: X alone was better, where Y and XY were too."""
    names = []
    for name, sigma in (("before", 0.006), ("after", 0.0025)):
        xy = rng.normal(0, sigma, (31, 2)).round(4)
        rows = "".join(f"{k},{x:.4f},{y:.4f}\n" for k, (x, y) in enumerate(xy.tolist(), 1))
        (tmp_path / f"{name}.csv").write_text(f"# resolution: 0.0001\ncycle,X mm,Y mm\n{rows}")
        names.append(str(tmp_path / f"{name}.csv"))
    assert main(["compare", *names]) == 0
    first = capsys.readouterr().out.split("mean:")[0]
    assert "; " in first
    assert {"X", "Y", "XY"} <= set(re.findall(r"\b[XY]+\b", first))
    assert first.count("better") == 2


def test_a_test_that_diagnose_does_not_take_is_not_sent_there(rng):
    for n, verb in ((400, "diagnose"), (600, "report")):
        found = compare(
            [analysis(gaussian(rng, n=n)), analysis(gaussian(rng, scale=3, n=n))], shuffles=99
        )
        assert f"scara-iso {verb} after.csv" in str(
            _next(found.pairs[0], "before.csv", "after.csv", "").command
        )


def test_a_long_name_above_the_picture_is_cut_visibly(rng, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = [f"{'a' * 40}{k}.csv" for k in "xy"]
    for name in names:
        rows = "".join(f"{c},{x:.4f}\n" for c, x in enumerate(rng.normal(0, 0.01, 31), 1))
        (tmp_path / name).write_text(f"# unit: mm\ncycle,X\n{rows}")
    title, *_ = [picture.title for picture in comparison_pictures(scara_iso.compare(names))]
    assert title == f"…{'a' * 22}x.csv → …{'a' * 22}y.csv"


@pytest.mark.parametrize("towards", [0, math.inf])
def test_a_permutation_as_far_apart_counts_whatever_the_last_bit_of_its_sums(towards):
    chance = PermutationTest(np.full((1, 1999), np.nextafter(2.0, towards)))
    decided = chance.decide(Distance(2.0, 2.0, 2.0, 1.0), 0, cycles=(31, 31))
    assert (decided.p_value, decided.p_value_alone, decided.p_value_at_floor) == (1, 1, False)
    assert decided.verdict is ContrastVerdict.NOT_SHOWN
