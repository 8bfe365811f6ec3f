"""One robot over months: chart points against capstat-core, trend, limits, and what is refused."""

import errno
import json
import math
import re
import shlex
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest
from capstat_core import control_charts, time_weighted
from hypothesis import given, strategies as st
from scipy.stats import norm, t as student

import scara_iso
from scara_iso.base.errors import DataError, NoInputError, UsageError
from scara_iso.base.files import Disk
from scara_iso.commands import main
from scara_iso.comparison import charts, read_events
from scara_iso.comparison.charts import crossing, trend_of

HEAD = "# unit: mm\n# resolution: 0.0001\n"
MONTH = 365.25 / 12


def table(folder, date, *, sigma=0.005, seed=0, name=None, robot="A", x=0.4, more="", pose=None):
    """Write a test of 31 cycles; the same seed gives the same shape of scatter."""
    rng = np.random.default_rng(seed)
    rows = [f"{c},{v:.4f}" for c, v in enumerate(x + sigma * rng.standard_normal(31), 1)]
    stated = HEAD + (f"# date: {date}\n" if date else "") + (f"# robot: {robot}\n" if robot else "")
    stated += (f"# pose: {pose}\n" if pose else "") + more
    path = folder / f"{name or date[:10]}.csv"
    path.write_text("\n".join([f"{stated}cycle,X", *rows, ""]), encoding="utf-8")
    return str(path)


def months(folder, levels, **options):
    """Write a table a month, whose sigma is each level times 0.005."""
    return [
        table(
            folder, f"{2024 + k // 12}-{k % 12 + 1:02d}-05", sigma=0.005 * level, seed=k, **options
        )
        for k, level in enumerate(levels)
    ]


# the charts


def test_individuals_and_moving_ranges_are_those_of_an_independent_library(rng):
    values = rng.normal(0.4, 0.01, 30)
    mine = charts.individuals(values, np.zeros(30), [slice(0, 30)])
    pair = control_charts.i_mr_chart(values)
    assert mine.centre == pytest.approx(pair.location.limits.center)
    assert mine.low == pytest.approx(pair.location.limits.lower)
    assert mine.high == pytest.approx(pair.location.limits.upper)
    assert mine.moving_range[1:] == pytest.approx(pair.dispersion.points)
    assert mine.range_limit == pytest.approx(pair.dispersion.limits.upper)


def mean_until(alarm_free):
    """Return the mean steps until a chain leaves the states of these transitions, by state."""
    return np.linalg.solve(np.eye(len(alarm_free)) - alarm_free, np.ones(len(alarm_free)))


def cusum_run_length(slack, decision, shift, states=300):
    """Return the average run length of both sums, each a Markov chain (Brook and Evans 1972)."""
    sides, width = [], 2 * decision / (2 * states - 1)
    for mean in (shift, -shift):
        ends = width * (np.arange(states) + 0.5) - width * np.arange(states)[:, np.newaxis]
        below = norm.cdf(ends + slack - mean)
        sides.append(mean_until(np.diff(below, prepend=0.0))[0])
    return 1 / sum(1 / one for one in sides)


def ewma_run_length(weight, width, shift, states=301):
    """Return the average run length at limits that stand, as the chain of Lucas and Saccucci."""
    edges = width * math.sqrt(weight / (2 - weight)) * np.linspace(-1, 1, states + 1)
    middles = (edges[1:] + edges[:-1]) / 2
    below = norm.cdf((edges - (1 - weight) * middles[:, np.newaxis]) / weight - shift)
    return mean_until(np.diff(below))[states // 2]


def test_the_charts_constants_make_a_false_alarm_in_370_tests():
    """The chains give Montgomery's tables 9.3 and 9.11, and then what the charts state."""
    assert cusum_run_length(0.5, 5, 0) == pytest.approx(465, abs=1)
    assert cusum_run_length(0.5, 5, 1) == pytest.approx(10.4, abs=0.05)
    assert ewma_run_length(0.1, 2.814, 0) == pytest.approx(500, abs=1)
    assert ewma_run_length(0.1, 2.814, 1) == pytest.approx(10.3, abs=0.05)
    assert cusum_run_length(charts.SLACK, charts.DECISION, 0) == pytest.approx(370, abs=2)
    assert ewma_run_length(charts.LAMBDA, charts.WIDTH, 0) == pytest.approx(370, abs=2)


def test_ewma_and_cusum_are_those_of_an_independent_library(rng):
    z = rng.normal(0.3, 1, 40)
    whole = [slice(0, 40)]
    mine = charts.ewma(z, whole)
    other = time_weighted.ewma_chart(z, target=0, sigma=1, lmbda=charts.LAMBDA, L=charts.WIDTH)
    assert mine.points == pytest.approx(other.points)
    assert mine.limits == pytest.approx(other.upper)
    assert mine.alarms == other.violations
    sums = charts.cusum(z, whole)
    theirs = time_weighted.cusum_chart(z, target=0, sigma=1, k=charts.SLACK, h=charts.DECISION)
    assert sums.up == pytest.approx(theirs.upper)
    assert sums.down == pytest.approx(np.abs(theirs.lower))
    assert sums.alarms == theirs.violations


@given(st.lists(st.tuples(st.floats(-1, 1), st.floats(0.1, 1)), min_size=2, max_size=12))
def test_a_value_stands_against_the_weighted_mean_of_those_before(pairs):
    values, sigma = map(np.array, zip(*pairs, strict=True))
    found = charts.standardised(values, sigma, [slice(0, len(values))])
    assert found[0] == 0
    for k in range(1, len(values)):
        weights = [1 / s**2 for s in sigma[:k]]
        mean = sum(w * v for w, v in zip(weights, values[:k], strict=True)) / sum(weights)
        error = math.sqrt(sigma[k] ** 2 + 1 / sum(weights))
        assert found[k] == pytest.approx((values[k] - mean) / error, abs=1e-9)


def test_a_service_begins_every_chart_anew(rng):
    z = rng.normal(0, 1, 20)
    apart = [slice(0, 8), slice(8, 20)]
    alone = charts.cusum(z[8:], [slice(0, 12)])
    assert charts.cusum(z, apart).up[8:] == pytest.approx(alone.up)
    assert charts.ewma(z, apart).points[8:] == pytest.approx(
        charts.ewma(z[8:], [slice(0, 12)]).points
    )


def test_limits_are_never_narrower_than_the_sampling_error():
    """Twelve tests that happen to agree do not make a thirteenth an alarm: 10 % is no news."""
    logs = np.log(0.013) + 0.001 * (-1.0) ** np.arange(13)
    logs[-1] += math.log(1.1)
    sampling, whole = np.full(13, 0.137), [slice(0, 13)]
    sigma = charts.between_tests(logs, sampling, whole)
    assert sigma == pytest.approx(0.137, rel=1e-3)
    z = charts.standardised(logs, sigma, whole)
    assert abs(z[-1]) < 1
    assert not charts.ewma(z, whole).alarms
    assert not charts.cusum(z, whole).alarms
    means = charts.individuals(logs, sampling, whole)
    assert means.sigma == pytest.approx(0.137)
    assert not means.alarms


# trend and limit


def worn(growth, onset, tests=24, error=0.01):
    days = MONTH * np.arange(tests)
    logs = np.log(0.02 * (1 + growth * np.maximum(np.arange(tests) - onset, 0)))
    return trend_of(days, logs, np.full(tests, error))


def test_a_trend_without_noise_is_found_again():
    trend = worn(0.05, 8)
    assert trend.shown
    assert trend.per_month == pytest.approx(0.02 * 0.05, rel=0.05)
    assert trend.onset[0] <= 8 * MONTH <= trend.onset[1]
    found = crossing(trend, 0.02 * (1 + 0.05 * 24))  # month 32 is met
    assert found.earliest < 32 * MONTH < found.latest
    assert found.likely == pytest.approx(32 * MONTH, abs=MONTH)
    assert trend.level(trend.days)[-1] == pytest.approx(0.02 * 1.75, rel=0.02)


def test_an_interval_that_ends_at_0_shows_no_trend():
    """An end of 4e-19, the cell of no growth, was a wear with the day on which a limit is met."""
    steady = np.log(0.02) + 0.15 * np.random.default_rng(80).standard_normal(6)
    trend = trend_of(MONTH * np.arange(6), steady, np.full(6, 0.15))
    assert 0.0 in trend.interval
    assert not trend.shown


def test_without_a_service_none_is_spoken_of(tmp_path, capsys):
    months(tmp_path, [1.0] * 3)
    assert main(["history", str(tmp_path), "--limit", "X=1"]) == 0
    assert "too few tests for a forecast" in " ".join(capsys.readouterr().out.split())


def test_no_growth_is_no_trend_and_meets_no_limit():
    trend = worn(0.0, 0)
    assert not trend.shown
    found = crossing(trend, 0.04)
    assert (found.earliest, found.likely, found.latest) == (None, None, None)
    assert found.horizon == pytest.approx(3 * 23 * MONTH)


def test_not_knowing_more_widens_the_interval():
    sure, unsure = (crossing(worn(0.05, 8, error=e), 0.044) for e in (0.01, 0.1))
    assert unsure.earliest < sure.earliest < sure.likely
    assert unsure.latest is None or unsure.latest > sure.latest
    assert trend_of(np.arange(4.0), np.zeros(4), np.ones(4)) is None


def test_tests_that_differ_by_more_than_their_sampling_widen_the_interval():
    days, month = MONTH * np.arange(24), np.arange(24)
    course = np.log1p(0.05 * np.maximum(month - 8, 0))
    widths = []
    for differ in (0.05, 0.3):
        trend = trend_of(days, course + differ * (-1.0) ** month, np.full(24, 0.1))
        widths.append(trend.interval[1] - trend.interval[0])
    assert widths[1] > 1.5 * widths[0]


def test_the_days_are_those_of_their_chances():
    trend = worn(0.05, 8, error=0.1)
    found = crossing(trend, 0.044)
    days = np.array([found.earliest, found.likely, found.latest])
    assert trend.chance_above(0.044, days) == pytest.approx([0.025, 0.5, 0.975], abs=0.02)


# the history


def test_every_test_in_time_order_whatever_the_order_of_the_files(tmp_path):
    paths = months(tmp_path, np.ones(7))
    one, other = scara_iso.history(paths), scara_iso.history(paths[::-1])
    (x,) = one.spreads
    assert [t.when for t in x.tests] == sorted(t.when for t in x.tests)
    assert [t.value for t in x.tests] == [t.value for t in other.spreads[0].tests]
    single = scara_iso.analyze(paths[2]).poses[0].axes["X"]
    assert (x.tests[2].value, x.tests[2].interval) == (single.RP, single.RP_interval)
    assert one.means[0].tests[2].value == single.mean
    assert one.to_frame().shape[0] == 14


def test_wear_is_seen_and_ten_per_cent_are_not(tmp_path):
    (tmp_path / "same").mkdir()
    calm = scara_iso.history(months(tmp_path / "same", [1.0] * 11 + [1.1])).spreads[0]
    assert not calm.alarms
    assert not calm.trend.shown
    worse = scara_iso.history(months(tmp_path, [1.0] * 8 + [2.0] * 4)).spreads[0]
    assert worse.alarms
    assert min(worse.alarms) >= 8
    assert worse.trend.shown


def test_a_service_that_made_it_worse_is_in_the_answer_and_nothing_beside_denies_it(
    tmp_path, capsys
):
    for k, sigma in enumerate((0.005, 0.005, 0.015, 0.015), 1):
        table(tmp_path, None, sigma=sigma, seed=k, name=f"2025-{k:02}-15")
    (tmp_path / "events.csv").write_text("date,what\n2025-03-02,greased\n", encoding="utf-8")
    assert main(["history", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert re.search(r"after the service of 2025-03-02, greased: RP X worse ×\d[.\d]* \[1", out)
    assert "4 of 4 tables state no date: that in the file's name holds" in out
    assert "no change" not in out
    (tmp_path / "events.csv").unlink()
    assert main(["history", str(tmp_path)]) == 0
    assert "first and last test differ" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["2025-01-15_2025-02-15", "20250115", "12025-01-15"])
def test_a_name_that_spells_no_single_day_is_no_date(tmp_path, name):
    with pytest.raises(DataError, match="state no date"):
        scara_iso.history([table(tmp_path, None, name=name)])


def test_a_limit_that_is_crossed_before_a_service_is_crossed_no_more(tmp_path, capsys):
    months(tmp_path, [1, 1, 1, 4, 4, 1, 1, 1])
    argv = ["history", str(tmp_path), "--limit", "0.025", "--json"]
    assert main(argv) == 1
    found = json.loads(capsys.readouterr().out)
    assert [one["figure"] for one in found["crossed"]] == ["X"]
    verdicts = [test["verdict"] for test in found["figures"][0]["tests"]]
    assert (verdicts[0], verdicts[3]) == ("pass", "fail")
    (tmp_path / "events.csv").write_text("date;what\n05.06.2024;gear <b>renewed</b>\n", "utf-8")
    assert main(argv) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["figures"][0]["since_service"] == "2024-06-05", "a test of that day is behind it"
    (change,) = found["changes"]
    (spread,) = change["comparison"]["pairs"][0]["spreads"]
    assert spread["verdict"] == "less"
    assert change["comparison"]["before"]["source"].endswith("2024-05-05.csv")
    page = tmp_path / "page.html"
    assert main(["history", str(tmp_path), "-o", str(page)]) == 0
    assert "<b>renewed" not in page.read_text(encoding="utf-8")


def test_a_limit_that_a_test_broke_is_said_of_that_test(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    months(tmp_path, [1, 1, 1, 4, 1, 1, 1, 1])
    assert main(["history", ".", "--limit", "0.025"]) == 1
    said = " ".join(capsys.readouterr().out.split())
    assert "RP X exceeded the limit of 0.025 mm on 2024-04-05, last" in said
    assert "2024-04-05.csv what is in the test of 2024-04-05" in said
    assert "no change beyond sampling" not in said
    months(tmp_path, [1, 1, 1, 1, 1, 1, 1, 4])
    assert main(["history", ".", "--limit", "0.025"]) == 1
    said = " ".join(capsys.readouterr().out.split())
    assert "RP X exceeds the limit of 0.025 mm, last" in said
    assert "2024-08-05.csv what is in the last test" in said


def test_the_last_test_above_the_limit_is_crossed_though_its_interval_is_not(tmp_path):
    paths = months(tmp_path, [1, 1, 1, 1, 1, 1.5])
    found = scara_iso.history(paths)
    last = found.spreads[0].tests[-1]
    limit = (last.interval[0] + last.value) / 2
    held = scara_iso.history(paths, limits={"X": limit}).spreads[0]
    assert scara_iso.history(paths, limits={"RP": limit}).spreads[0].limit == held.limit
    assert held.crossed
    assert held.tests[-1].verdict.value == "not-provable"


def test_poses_and_angles_have_histories_of_their_own(tmp_path):
    for month in range(1, 6):
        for pose in ("P1", "P2"):
            table(tmp_path, f"2026-0{month}-01", name=f"{month}-{pose}", seed=month, pose=pose)
    found = scara_iso.history(tmp_path)
    assert len(found.tests) == 10
    assert {(one.pose, len(one.tests)) for one in found.spreads} == {("P1", 5), ("P2", 5)}


def test_means_of_angles_are_of_one_turn_and_their_intervals_student_s(tmp_path):
    apart = np.random.default_rng(5).normal(0, 0.01, (8, 5)).round(4)
    found = []
    for zero in (0, 40):
        folder = tmp_path / str(zero)
        folder.mkdir()
        for k, readings in enumerate(zero + apart + 0.03 * (-1) ** np.arange(8)[:, np.newaxis]):
            rows = "".join(f"{c},{v % 360:.4f}\n" for c, v in enumerate(readings, 1))
            head = f"# resolution: 0.0001 deg\n# date: 2026-0{k + 1}-01\n"
            (folder / f"{k}.csv").write_text(f"{head}cycle,theta_deg\n{rows}")
        options = {"first_cycle_discarded": True, "cycles": 5}
        (mean,) = scara_iso.history(folder, **options).means
        found.append([one.value - mean.tests[0].value for one in mean.tests])
        low, high = student.interval(0.95, 4, mean.tests[0].value, mean.tests[0].error)
        assert mean.tests[0].interval == pytest.approx((low, high))
    assert found[0] == pytest.approx(found[1])


# what is refused, and what is listed


def test_several_robots_are_refused_and_one_may_be_chosen(tmp_path, capsys):
    months(tmp_path, np.ones(6))
    table(tmp_path, "2026-01-01", robot="B")
    assert main(["history", str(tmp_path)]) == 65
    out, err = capsys.readouterr()
    assert out == ""
    assert "A (6), B (1)" in err
    assert "--robot" in err
    assert len(scara_iso.history(tmp_path, robot="a").tests) == 6
    assert main(["history", str(tmp_path), "--robot", "C"]) == 65


def test_a_robot_that_one_pose_alone_states_is_still_told_from_another(tmp_path):
    for month, robot in (("01", "A"), ("02", "B")):
        cycles = [(c, (c * 7 % 11 + int(month)) / 1000) for c in range(1, 32)]
        p1, p2 = ("".join(f"{c},{x + k:.3f}\n" for c, x in cycles) for k in (0, 1))
        text = f"# unit: mm\nP1\n# robot: {robot}\ncycle,X\n{p1}\nP2\ncycle,X\n{p2}"
        (tmp_path / f"2026-{month}-01.csv").write_text(text)
    with pytest.raises(DataError, match="several robots by their robot"):
        scara_iso.history(tmp_path)


def test_a_name_in_one_file_and_a_serial_number_in_another_are_asked_about(tmp_path):
    number = "# serial_number: 4711\n"
    table(tmp_path, "2026-01-01", robot="R7")
    table(tmp_path, "2026-02-01", robot=None, more=number)
    with pytest.raises(DataError, match="serial number 4711: is it one robot") as asked:
        scara_iso.history(tmp_path)
    assert "`robot=R7`" in asked.value.remedy
    assert len(scara_iso.history(tmp_path, robot="R7").tests) == 1
    table(tmp_path, "2026-03-01", robot="R7", more=number)  # which says that they are one
    assert len(scara_iso.history(tmp_path).tests) == 3


def test_twice_on_one_day_needs_the_time(tmp_path):
    one, other = (table(tmp_path, "2026-01-01", name=n, seed=k) for k, n in enumerate("ab"))
    with pytest.raises(DataError, match="no time says which was first") as refused:
        scara_iso.history([one, other])
    assert "a.csv" in str(refused.value)
    assert "b.csv" in str(refused.value)
    late = table(tmp_path, "2026-01-01T15:00", name="b")
    found = scara_iso.history([late, one])
    assert [test.when for test in found.tests] == [
        datetime(2026, 1, 1),  # noqa: DTZ001 - as the tables state it
        datetime(2026, 1, 1, 15),  # noqa: DTZ001
    ]


def test_local_times_in_another_order_than_the_tests_are_refused(tmp_path):
    dates = ("2026-05-12T08:00+09:00", "2026-05-12T07:00-05:00", "2026-05-13T07:00-05:00")
    made = [table(tmp_path, d, name=f"t{k}", seed=k) for k, d in enumerate(dates)]
    with pytest.raises(DataError, match="time zones differ"):
        scara_iso.history(made)
    assert len(scara_iso.history(made[1:]).tests) == 2


def test_a_table_without_a_date_is_an_error_that_names_it(tmp_path, capsys):
    months(tmp_path, np.ones(3))
    table(tmp_path, "", name="undated")
    assert main(["history", str(tmp_path)]) == 65
    out, err = capsys.readouterr()
    assert out == ""
    assert "undated.csv" in err
    assert "# date:" in err


def test_a_table_that_cannot_be_read_is_listed_and_the_rest_goes_on(tmp_path, capsys):
    months(tmp_path, np.ones(6))
    (tmp_path / "broken.csv").write_bytes(b"cycle,X\n1,\x00nonsense\n")
    assert main(["history", str(tmp_path), "--json"]) == 0
    out, err = capsys.readouterr()
    found = json.loads(out)
    assert len(found["tests"]) == 6
    assert [one["source"][-10:] for one in found["unreadable"]] == ["broken.csv"]
    assert "broken.csv" in err


@pytest.mark.parametrize(
    ("argv", "code"),
    [
        (["nowhere.csv"], 66),
        (["."], 66),
        ([".", "--events", "none.csv"], 66),
        (["t.csv", "--events", "none.csv"], 66),
        (["t.csv", "--limit", "Q=1"], 2),
        (["t.csv", "-o", "page.doc"], 2),
        (["t.csv", "-o", "page.json"], 2),
        (["t.csv", "-o", "t.csv"], 73),
        (["t.csv", "-o", "nowhere/page.html"], 73),
        (["broken.csv"], 65),
    ],
)
def test_what_cannot_be_done_says_so_and_writes_nothing(tmp_path, monkeypatch, capsys, argv, code):
    monkeypatch.chdir(tmp_path)
    if argv != ["."] and argv[0] != ".":
        table(tmp_path, "2026-01-01", name="t")
        (tmp_path / "broken.csv").write_text("cycle,X\n1,a\n", encoding="utf-8")
    assert main(["history", *argv]) == code
    out, err = capsys.readouterr()
    assert out == ""
    assert err


def test_a_full_disk_leaves_the_old_page(tmp_path, monkeypatch, capsys):
    paths, page = months(tmp_path, np.ones(2)), tmp_path / "page.html"
    page.write_text("old", encoding="utf-8")

    def full(self, file, data):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Disk, "write", full)
    assert main(["history", *paths, "-o", str(page)]) == 74
    assert page.read_text(encoding="utf-8") == "old"
    assert capsys.readouterr().out == ""


def test_a_dial_that_stood_still_and_few_tests_have_no_chart(tmp_path):
    paths = months(tmp_path, [1, 0, 1, 1, 1, 1])
    still = scara_iso.history(paths).spreads[0]
    assert (still.ewma, still.trend, still.crossing) == (None, None, None)
    assert scara_iso.history(paths[2:5], limits={"X": 1.0}).spreads[0].ewma is None


@pytest.mark.parametrize("date", ["9999-12-31", "0001-01-01", "05/06/2026", "soon"])
def test_a_date_that_cannot_be_is_none(tmp_path, date):
    with pytest.raises(DataError, match="1 of 1 tables state no date"):
        scara_iso.history(table(tmp_path, date, name="t"))


def test_a_limit_of_what_is_not_followed_is_refused(tmp_path):
    head = "# dial_zero: command\n# command_X: 0\n"
    with pytest.raises(UsageError, match="AP: a history follows RP"):
        scara_iso.history(table(tmp_path, "2026-01-01", more=head), limits={"AP": 1.0})


def test_other_conditions_are_noted(tmp_path):
    paths = months(tmp_path, np.ones(3), more="# payload: 2 kg\n# Messuhr: Mahr\n")
    more = "# payload: 5 kg\n# Messuhr: Käfer\n"
    paths.append(table(tmp_path, "2026-01-01", more=more, robot=None))
    notes = "\n".join(scara_iso.history(paths).notes)
    assert "dial is not the same in all tests: Mahr, Käfer" in notes
    assert "payload is not the same in all tests: 2 kg, 5 kg" in notes
    assert "1 of 4 tables name no robot" in notes


@pytest.mark.parametrize("ending", ["md", "csv", "xlsx"])
def test_the_page_has_other_forms(tmp_path, ending):
    paths, page = months(tmp_path, np.ones(6)), tmp_path / f"page.{ending}"
    assert main(["history", *paths, "-o", str(page)]) == 0
    assert page.stat().st_size > 1000


def test_events_with_all_their_faults(tmp_path):
    path = tmp_path / "events.csv"
    for lines, wrong in (("1/2/2026,when\n31.12.1890,ok", [3, 4]), ("2026-01-02,\n,x", [3, 4])):
        path.write_text(f"date,what\n2026-01-01,ok\n{lines}\n", encoding="utf-8")
        with pytest.raises(DataError) as refused:
            read_events(path)
        assert [fault.line for fault in refused.value.faults] == wrong
    path.write_text("moment,what\n2026-01-01,ok\n", encoding="utf-8")
    with pytest.raises(DataError, match="column date is missing"):
        read_events(path)
    path.write_text('# all\ndate,what\n2026-03-01,"belt, and gear"\n2026-01-01,oil\n', "utf-8")
    assert [event.what for event in read_events(path)] == ["oil", "belt, and gear"]


def test_a_service_outside_of_all_tests_is_noted(tmp_path):
    months(tmp_path, np.ones(3))
    (tmp_path / "events.csv").write_text("Datum;was\n01.01.2000;geliefert\n01.01.2099;Fett\n")
    notes = scara_iso.history(tmp_path).notes
    assert "geliefert (2000-01-01): no test before it, so nothing is compared" in notes
    assert "Fett (2099-01-01): no test after it, so nothing is compared" in notes


def test_library_errors_are_those_of_the_command(tmp_path):
    with pytest.raises(NoInputError):
        scara_iso.history(tmp_path)
    (tmp_path / "test.toml").write_text("", encoding="utf-8")
    with pytest.raises(UsageError, match="one test"):
        scara_iso.history(tmp_path)


def test_a_test_that_is_a_copy_of_another_is_said(tmp_path):
    first = Path(table(tmp_path, "2026-01-15", seed=1))
    text = first.read_text().replace("2026-01-15", "2026-02-15")
    (tmp_path / "copy.csv").write_text(text)
    table(tmp_path, "2026-03-15", seed=2)
    (said,) = scara_iso.history(tmp_path).notes
    assert "copy.csv holds the readings of" in said


def test_a_folder_of_folders_is_a_test_each_where_one_names_a_pose(tmp_path):
    for month in (1, 2):
        poses = tmp_path / "poses" / f"2025-0{month}-05"
        robots = tmp_path / "robots" / f"0{month} März"
        for folder in (poses, robots):
            folder.mkdir(parents=True)
        for k in (1, 2):
            table(poses, "", name=f"P{k}", seed=10 * month + k)
            table(robots, f"2025-0{month}-05", name=f"R{k}", robot=f"R{k}", seed=10 * month + k)
    found = scara_iso.history(tmp_path / "poses")
    assert [one.source for one in found.tests] == [
        str(tmp_path / "poses" / f"2025-0{month}-05") for month in (1, 2)
    ]
    assert [one.pose for one in found.spreads] == ["P1", "P2"]
    found = scara_iso.history(tmp_path / "robots", robot="R2")
    assert [Path(one.source).name for one in found.tests] == ["R2.csv"] * 2


def test_tables_in_a_folder_and_in_its_folders_are_read_with_the_events_beside_them(tmp_path):
    for where, month in (("", 1), ("R1", 2), ("2025/03", 3), ("R1/old", 4)):
        (tmp_path / where).mkdir(parents=True, exist_ok=True)
        table(tmp_path / where, f"2025-0{month}-05", seed=month, robot="R1")
    (tmp_path / "R2").mkdir()
    table(tmp_path / "R2", "2025-05-05", robot="R2")
    for where, what in (("", "oil"), ("2025", "belt"), ("R2", "not this one")):
        text = f"date,what\n2025-02-20,{what}\n"
        (tmp_path / where / "events.csv").write_text(text, encoding="utf-8")
    found = scara_iso.history(tmp_path, robot="R1")
    assert [one.when.month for one in found.tests] == [1, 2, 3, 4]
    assert [one.what for one in found.events] == ["oil", "belt"]
    assert not found.unreadable


def test_a_robot_is_one_in_capitals_or_not_and_what_is_said_of_several_works(tmp_path, capsys):
    for month, robot in enumerate(("SCARA 6", "Scara 6", "SCARA 7"), 1):
        table(tmp_path, f"2025-0{month}-05", robot=robot)
    assert main(["history", str(tmp_path)]) == 65
    said, todo = capsys.readouterr().err.splitlines()
    assert "SCARA 6 (2), SCARA 7 (1)" in said
    assert main(["history", str(tmp_path), *shlex.split(todo.partition(", as ")[2])]) == 0
    assert "SCARA 6: 2 tests" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("asked", "months"),
    [("R1", [1, 2, 3]), ("4711", [1, 2, 3]), ("1", [4]), ("2", [5]), ("r1 ", [1, 2, 3])],
)
def test_a_robot_is_found_by_the_one_of_its_two_names_that_a_test_states(tmp_path, asked, months):
    stated = [("R1", "4711"), ("R1", ""), ("", "4711"), ("R8", "1"), ("R8", "2"), ("R8", "")]
    for month, (robot, serial) in enumerate(stated, 1):
        more = f"# serial_number: {serial}\n" if serial else ""
        table(tmp_path, f"2025-0{month}-05", robot=robot, more=more, seed=month)
    found = scara_iso.history(tmp_path, robot=asked)
    assert [one.when.month for one in found.tests] == months


def test_events_beside_the_poses_of_a_test_are_no_pose(tmp_path):
    (tmp_path / "05").mkdir()
    for k in (1, 2):
        table(tmp_path / "05", "2025-05-05", name=f"P{k}", seed=k)
    events = tmp_path / "05" / "events.csv"
    events.write_text("date,what\n2025-05-01,oil\n", encoding="utf-8")
    found = scara_iso.history(tmp_path)
    assert len(found.tests) == len(found.events) == 1
    assert main(["history", str(tmp_path), "-o", str(events)]) == 73


def test_a_date_that_is_not_read_is_quoted(tmp_path):
    with pytest.raises(DataError, match="'04-03-2025' is not year-month-day"):
        scara_iso.history(table(tmp_path, "04-03-2025"))


def test_one_serial_number_is_one_robot_however_its_name_is_spelt(tmp_path, capsys):
    rows = "\n".join(f"{k},{0.1 + k % 7 / 1000:.3f}" for k in range(1, 32))
    for month, name in enumerate(["SCARA 600", "Scara-600", "scara 600"], 1):
        head = f"# robot: {name}\n# serial_number: N-1\n# date: 2026-0{month}-01\n# unit: mm\n"
        (tmp_path / f"{month}.csv").write_text(f"{head}cycle,X\n{rows[: -month or None]}{month}\n")
    assert main(["history", str(tmp_path)]) == 65
    assert "if all are one robot: --robot 'N-1'" in capsys.readouterr().err
    assert main(["history", str(tmp_path), "--robot", "N-1"]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "serial N-1: 3 tests" in out
    assert "robot is not the same in all tests" in out


def test_tables_that_cannot_be_used_are_not_said_to_be_of_another_robot(tmp_path, capsys):
    (tmp_path / "a.csv").write_text("cycle,X\n1,0.1\n")
    assert main(["history", str(tmp_path), "--robot", "R1"]) == 65
    assert "none of 1 tables can be used" in capsys.readouterr().err


@pytest.mark.parametrize(("odd", "said"), [(1 / 25.4, "less"), (25.4, "more"), (0, "0")])
def test_a_test_that_does_not_go_on_from_the_others_is_named_and_forecasts_nothing(
    tmp_path, capsys, odd, said
):
    months(tmp_path, [*(1.15 ** np.arange(9)), odd * 1.15**9])
    assert main(["history", str(tmp_path), "--limit", "9"]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert re.search(
        rf"2024-10-05 does not go on from the test before: RP X is [^.,]*{said}\.", out
    )
    assert "no forecast over such a break" in out
    assert "a month" not in out


def test_wear_and_a_service_are_no_break(tmp_path, capsys):
    worn = 1.3 ** np.arange(9)
    months(tmp_path, [*worn, 1, 1.1])
    (tmp_path / "events.csv").write_text("date,what\n2024-09-20,belt\n", encoding="utf-8")
    assert main(["history", str(tmp_path)]) == 0
    assert "does not go on" not in capsys.readouterr().out


@pytest.mark.parametrize(("when", "asked"), [("2024-04-05", True), ("2024-04-05T14:00", False)])
def test_a_service_on_the_day_of_a_test_wants_its_time(tmp_path, when, asked):
    months(tmp_path, [1] * 6)
    (tmp_path / "events.csv").write_text(f"date,what\n{when},belt\n", encoding="utf-8")
    found = scara_iso.history(tmp_path)
    assert any("taken as done before the test of that day" in n for n in found.notes) is asked


def test_a_table_that_is_left_out_names_its_first_fault(tmp_path):
    months(tmp_path, [1] * 5)
    broken = tmp_path / "2024-03-05.csv"
    broken.write_text(broken.read_text().replace("\n7,", "\n7,x"), encoding="utf-8")
    (left,) = scara_iso.history(tmp_path).unreadable
    assert "line 12, column 2: 'x0." in left.error
    for one in tmp_path.glob("*.csv"):
        if one != broken:
            one.unlink()
    with pytest.raises(DataError, match="none of 1 tables can be used") as refused:
        scara_iso.history(tmp_path)
    assert "write the reading as one number" in refused.value.remedy


@pytest.mark.parametrize(("name", "code"), [("2024-09-05", 1), ("later", 1), ("before", 0)])
def test_a_test_that_cannot_be_read_and_may_be_the_last_proves_no_limit(tmp_path, name, code):
    months(tmp_path, [1.0] * 8)
    stated = {"later": "2024-09-05", "before": "2024-01-20"}.get(name)
    bad = Path(table(tmp_path, stated, name=name))
    bad.write_text(bad.read_text().replace("\n7,", "\n7,?"))
    assert main(["history", str(tmp_path), "--limit", "X=0.1"]) == code
    assert main(["history", str(tmp_path)]) == 0
    (left,) = scara_iso.history(tmp_path).unreadable
    assert left.may_be_last is bool(code)


def test_what_a_table_says_of_rows_that_count_is_said_of_the_months(tmp_path, capsys):
    months(tmp_path, [1.0] * 6)
    table(tmp_path, "2024-09-05", more="# Zyklus 9 nicht gewertet\n")
    assert main(["history", str(tmp_path)]) == 0
    assert "remarked, and counted: line 5 'Zyklus 9" in " ".join(capsys.readouterr().out.split())


def test_a_figure_above_a_limit_within_its_interval_may_exceed_it(tmp_path, capsys):
    months(tmp_path, [1.0] * 7 + [1.4])
    limit = 0.98 * scara_iso.history(tmp_path).spreads[0].tests[-1].value
    assert main(["history", str(tmp_path), "--limit", f"{limit:.5f}"]) == 1
    assert "RP X may exceed the limit" in " ".join(capsys.readouterr().out.split())


def test_alarms_before_a_service_are_no_news(tmp_path, capsys):
    months(tmp_path, [1, 1, 1, 1, 1, 4, 4, 4, 1, 1, 1, 1, 1, 1])
    assert main(["history", str(tmp_path)]) == 0
    assert re.search(r"alarms: EWMA [0-9]+ tests?, ", capsys.readouterr().out)
    (tmp_path / "events.csv").write_text("date,what\n2024-08-20,gear renewed\n", "utf-8")
    assert main(["history", str(tmp_path)]) == 0
    assert "alarms:" not in capsys.readouterr().out
