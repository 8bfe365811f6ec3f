"""How RP of a fleet moves, and whose RP grows: against scipy's regression, robot by robot."""

import json
import math

import duckdb
import numpy as np
import pandas as pd
import pytest
from scipy.stats import kstest, linregress, t

import scara_iso
from scara_iso.commands import main
from scara_iso.fleets.drift import moderated

DATES = ("2026-01", "2026-02-05", "2026-03-05", "2026-04-05 10:30", "2026-06-01", "2026-07-01")
DAYS = [0, 35, 63, 94 + 10.5 / 24, 151, 181]


def table(robot, test, rng, size):
    found = pd.DataFrame({"robot": robot, "test": test, "cycle": np.arange(1, 32)})
    return found.assign(**{axis: rng.normal(0, size, 31).round(4) for axis in "XY"})


def write(frame, folder):
    duckdb.from_df(frame).write_parquet(str(folder / "a.parquet"))


def fleet_of(folder, robots=8, ill=2):
    """Write a part of robots of which the first get worse, and one that was tested once."""
    folder.mkdir()
    rng = np.random.default_rng(4)
    frames = [table(f"R{k}", date, rng, 0.003 * (1 + 0.3 * n * (k < ill)))
              for k in range(robots) for n, date in enumerate(DATES)]  # fmt: skip
    frame = pd.concat([*frames, table("once", "2026-01", rng, 0.003)])
    write(frame, folder)
    return folder, frame


def RP_XY(readings):  # noqa: N802 - the symbol
    run = scara_iso.Run.from_frame(readings.reset_index(drop=True), unit="mm")
    return scara_iso.analyze(run).poses[0].XY.RP


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    folder = tmp_path_factory.mktemp("drift")
    source, frame = fleet_of(folder / "s")
    found = scara_iso.fleet_figures(source, folder / "o", unit="mm", resolution=0.0001)
    RP = {
        robot: [RP_XY(own[["cycle", "X", "Y"]]) for _, own in rows.groupby("test", sort=False)]
        for robot, rows in frame.groupby("robot")
    }
    return source, folder / "o", found, RP


def test_growth_is_that_of_a_regression_of_each_robot(done):
    *_, found, RP = done
    several = {robot: own for robot, own in RP.items() if len(own) > 1}
    fits = {robot: linregress(DAYS, np.log(own), alternative="greater")
            for robot, own in several.items()}  # fmt: skip
    growth = sorted(math.expm1(fit.slope * 365.25 / 12) for fit in fits.values())
    drift = found.drift
    assert (drift.figure, drift.robots, drift.asked) == ("XY", 8, 8)
    assert drift.per_month == pytest.approx(math.sqrt((1 + growth[3]) * (1 + growth[4])) - 1)
    assert drift.interval == pytest.approx((growth[0], growth[-1]))  # sign test: 1 - 2/256
    assert {one.robot for one in drift.growing} == {"R0", "R1"}
    for one in drift.growing:
        fit = fits[one.robot]
        assert one.per_month == pytest.approx(math.expm1(fit.slope * 365.25 / 12))
        assert one.p_value < fit.pvalue  # 4 degrees of its own, more with those of the others
        assert one.q_value >= one.p_value


@pytest.mark.parametrize("prior", [3.0, 40.0, math.inf])
def test_the_scatter_of_others_is_taken_as_far_as_robots_are_alike(prior):
    """Variances of robots as drawn from Smyth's prior: p-values of no slope are uniform."""
    rng, n = np.random.default_rng(2), 4000
    freedom = rng.integers(1, 9, n).astype(float)
    true = np.ones(n) if prior == math.inf else prior / rng.chisquare(prior, n)
    found, total = moderated(true * rng.chisquare(freedom) / freedom, freedom)
    assert kstest(t.sf(rng.normal(0, np.sqrt(true / found)), total), "uniform").pvalue > 0.01
    if prior < 10:  # else it hardly matters
        assert np.median(total - freedom) == pytest.approx(prior, rel=0.25)


def test_a_robot_alone_is_judged_by_its_own_scatter():
    variance, freedom = moderated(np.array([2.0]), np.array([4.0]))
    assert (variance.tolist(), freedom.tolist()) == ([2.0], [4.0])


def test_each_period_has_its_tests_and_how_many_are_worse_than_before(done):
    *_, found, RP = done
    periods = found.drift.periods
    assert [one.period for one in periods] == ["2026-01-01", *(date[:10] for date in DATES[1:-2]),
                                               "2026-06-01", "2026-07-01"]  # fmt: skip
    assert [one.robots for one in periods] == [9, 8, 8, 8, 8, 8]
    several = [own for own in RP.values() if len(own) > 1]
    for k, one in enumerate(periods[1:], 1):
        assert one.compared == 8
        assert one.worse == sum(own[k] > own[k - 1] for own in several)
        assert one.RP_quantiles[2] == pytest.approx(np.median([own[k] for own in several]))


def test_page_and_object_say_it_and_are_silent_without_dates(done, tmp_path, capsys):
    source, out, found, _ = done
    words = ["--figures", "--unit", "mm", "--resolution", "0.0001"]
    assert main(["fleet", str(source), "-o", str(out), *words, "--json"]) == 0
    said = json.loads(capsys.readouterr().out)["drift"]
    assert [one["robot"] for one in said["growing"]] == [o.robot for o in found.drift.growing]
    assert said["periods"][0]["worse"] == 0
    assert main(["fleet", str(source), "-o", str(out), *words]) == 0
    assert "grows in 2 of the 8 robots with three dates or more" in capsys.readouterr().out
    (tmp_path / "s").mkdir()
    rng = np.random.default_rng(1)
    tables = [table("R", name, rng, 0.003) for name in ("1", "2000-1", "t 2026-01-01")]
    write(pd.concat(tables), tmp_path / "s")
    assert scara_iso.fleet_figures(tmp_path / "s", tmp_path / "o", unit="mm").drift is None


def test_a_date_that_a_table_states_counts_before_its_name(tmp_path):
    """A column `date`, and the statement of a table of one robot."""
    (tmp_path / "s").mkdir()
    rows = [f"R1,2020-0{t},2026-0{t}-03,{c},{c * t * 7 % 11}" for t in (1, 2) for c in range(1, 32)]
    text = "# unit: um\nrobot,test,date,cycle,X\n" + "\n".join(rows) + "\n"
    (tmp_path / "s" / "a.csv").write_text(text, encoding="utf-8")
    own = "".join(f"{c},{c * 3 % 13}\n" for c in range(1, 32))
    one = "# unit: um\n# robot: R1\n# date: 2026-05-01\ncycle,X\n" + own
    (tmp_path / "s" / "b.csv").write_text(one, encoding="utf-8")
    found = scara_iso.fleet_figures(tmp_path / "s", tmp_path / "o")
    assert [o.period for o in found.drift.periods] == ["2026-01-03", "2026-02-03", "2026-05-01"]
    assert (found.drift.robots, found.drift.interval) == (1, None)


def test_the_first_lines_name_who_wears(done, capsys):
    source, out, *_ = done
    main(
        [
            "fleet",
            str(source),
            "-o",
            str(out),
            "--figures",
            "--unit",
            "mm",
            "--resolution",
            "0.0001",
        ]
    )
    first = capsys.readouterr().out.splitlines()[:3]
    assert any(line.startswith("  Wears: R") and "% a month (p = " in line for line in first)
