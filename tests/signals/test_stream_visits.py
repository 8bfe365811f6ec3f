"""Streams to visits, against a second-order response in closed form; nothing dropped unsaid."""

import hashlib
import json
from types import SimpleNamespace

import numpy as np
import pytest
import streams as simulated
from streams import Arm, text

import scara_iso
from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.quantities import Dimension
from scara_iso.commands import main
from scara_iso.reporting import visits_report
from scara_iso.run import Axis, Run
from scara_iso.signals import visits as visits_module
from scara_iso.tables import write_table


def as_run(time, reading, resolution=0.001, **more):
    axes = {"X": Axis("X", reading, resolution=resolution), **more}
    return Run(np.arange(1, len(time) + 1), axes, covariates={"time_s": time})


def codes(found):
    return [doubt.code for doubt in found.doubts]


def plateau(hz, *levels, hold=2.0, move=0.5, noise=0.001, seed=0, first=3.0):
    """Return a stream that holds each level and moves evenly between; ``first`` is free."""
    rng, pieces, last = np.random.default_rng(seed), [], first
    for level in (first, *levels):
        pieces += [np.linspace(last, level, round(move * hz)), np.full(round(hold * hz), level)]
        last = level
    reading = np.concatenate(pieces)
    return np.arange(len(reading)) / hz, reading + noise * rng.standard_normal(len(reading))


@pytest.mark.parametrize("hz", [50, 100, 500])
@pytest.mark.parametrize("noise", [0.0002, 0.003])
def test_every_visit_is_found_and_none_is_invented(hz, noise):
    rng = np.random.default_rng(hz)
    time, reading, poses = simulated.visits(rng, count=12, hz=hz, noise=noise, division=0.001)
    found = scara_iso.visits(as_run(time, reading), poses=["P1", "-"])
    assert codes(found) == ["begins-at-rest"]
    means = [visit.mean["X"] for visit in found.visits]
    assert means == pytest.approx(poses, abs=0.0005 + noise / 2)
    assert {visit.approach["X"] for visit in found.visits} == {-1}


def test_noisy_visits_between_silent_rests_are_not_lost():
    """The free dial is dead still: the threshold must not part it from the noise of the visits."""
    rng = np.random.default_rng(1)
    time, reading, poses = simulated.visits(rng, count=8, noise=0.01, free_noise=0.0)
    found = scara_iso.visits(as_run(time, reading), poses=["P1", "-"])
    assert [v.mean["X"] for v in found.visits] == pytest.approx(poses, abs=0.003)


@pytest.mark.parametrize("zeta", [0.15, 0.3, 0.6])
def test_stabilisation_and_overshoot_are_those_of_the_closed_form(zeta):
    arm, band = Arm(zeta=zeta), 0.01
    time, reading, _ = simulated.visits(
        np.random.default_rng(2), arm=arm, noise=0.0, scatter=0.0, dwell=3.0
    )
    found = scara_iso.visits(as_run(time, reading, None), poses=["P1", "-"], band=band)
    figures = {one.code: one.estimate for one in found.characteristics}
    assert figures["stabilisation_time"].value == pytest.approx(
        arm.stabilisation(0.3, band), abs=0.002
    )
    assert figures["overshoot"].value == pytest.approx(arm.overshoot(0.3), rel=0.01)
    for one in figures.values():
        assert one.interval[0] <= one.value <= one.interval[1]


def test_the_largest_overshoots_of_lengths_and_of_angles_are_told_apart():
    time, reading, _ = simulated.visits(
        np.random.default_rng(2), arm=Arm(zeta=0.3), noise=0.0, scatter=0.0, dwell=3.0
    )
    theta = Axis("theta", 10 * reading, Dimension.ANGLE, resolution=0.001)
    found = scara_iso.visits(as_run(time, reading, theta=theta), poses=["P1", "-"])
    largest = {
        unit: max(v.overshoot[name] for v in found.visits if v.overshoot[name] is not None)
        for name, unit in (("X", "mm"), ("theta", "deg"))
    }
    said = " and ".join(f"{size:.4g} {unit}" for unit, size in largest.items())
    assert f"the largest overshoot {said}" in str(visits_report(found))


def test_noise_does_not_raise_the_overshoot():
    rng = np.random.default_rng(3)
    time, reading, _ = simulated.visits(rng, noise=0.003, count=8)
    found = scara_iso.visits(as_run(time, reading), poses=["P1", "-"], band=0.02)
    (overshoot,) = (o.estimate for o in found.characteristics if o.code == "overshoot")
    assert overshoot.value == pytest.approx(Arm().overshoot(0.3), abs=0.0015)


def test_an_arm_that_creeps_in_has_no_overshoot():
    time, reading = plateau(200, 0.4, 3.0, 0.4, 3.0, 0.4, 3.0)
    found = scara_iso.visits(as_run(time, reading), poses=["P1", "-"])
    assert {v.overshoot["X"] for v in found.visits} == {0.0}


def test_rests_at_several_levels_are_refused_without_poses():
    levels = [0.2, 1.2, 2.2, 3.2, 4.2] * 3
    stream = as_run(*plateau(100, *levels, first=6.0))
    with pytest.raises(DataError, match="15 rests are at 5 levels, about") as caught:
        scara_iso.visits(stream)
    assert "`poses=P1,P2`" in caught.value.remedy
    found = scara_iso.visits(stream, poses=["P5", "P4", "P3", "P2", "P1"])
    assert found.run.pose.tolist() == ["P5", "P4", "P3", "P2", "P1"] * 3
    assert found.run.cycle.tolist() == [1] * 5 + [2] * 5 + [3] * 5


def test_the_rest_with_which_a_stream_begins_takes_no_name():
    stream = as_run(*plateau(100, *[1.0, 3.0] * 6, first=3.0))
    with pytest.raises(DataError, match="begins at rest at the level of P2"):
        scara_iso.visits(stream, poses=["P1", "P2"])
    found = scara_iso.visits(stream, poses="P1,-")
    (said,) = [note for note in found.notes if "takes no name" in note]
    assert "P1 is the rest at 2." in said


@pytest.mark.parametrize("lost", [1, 7, 14])
def test_a_rest_that_is_missing_breaks_the_order(lost):
    levels = [0.2, 1.2, 2.2] * 7
    del levels[lost]
    with pytest.raises(DataError, match="a rest is missing before it, or the order is another"):
        scara_iso.visits(as_run(*plateau(100, *levels)), poses=["P1", "P2", "P3"])


def test_one_visit_that_is_off_is_a_reading_and_no_pose():
    levels = [3.0, 0.4] * 6
    levels[5] = 0.6
    found = scara_iso.visits(as_run(*plateau(100, *levels[1:])), poses=["P1", "-"])
    assert found.run.axes["X"].readings.max() == pytest.approx(0.6, abs=0.001)


def test_what_is_doubtful_is_listed():
    time, reading = plateau(100, *[0.4, 3.0] * 8, hold=2.0)
    bumped = reading.copy()
    second = np.flatnonzero(np.abs(reading - 0.4) < 0.01)[20]
    bumped[second + 60 : second + 64] += 0.5  # something knocks the table
    found = scara_iso.visits(as_run(time, bumped), poses=["P1", "-"])
    assert "interrupted" in codes(found)
    assert len(found.visits) == 8
    assert found.visits[0].mean["X"] == pytest.approx(0.4, abs=0.0005)


def test_a_rest_shorter_than_the_dwell_is_listed_and_not_counted():
    time, reading = plateau(100, *[0.4, 3.0] * 5)
    short = np.ones(len(time), dtype=bool)
    short[1800:1880] = False  # of the rest at 0.4 from 17.5 s on
    found = scara_iso.visits(as_run(time[short.cumsum() > 0][: short.sum()], reading[short]),
                             dwell=1.5, poses=["P1"])  # fmt: skip
    assert [(d.code, d.counted) for d in found.doubts][1:] == [("short-rest", False)]
    assert len(found.visits) == 9


def test_missing_samples_are_listed():
    time, reading = plateau(100, *[0.4, 3.0] * 5)
    keep = np.ones(len(time), dtype=bool)
    keep[800:850] = False
    found = scara_iso.visits(as_run(time[keep], reading[keep]), poses=["P1", "-"])
    assert "missing-samples" in codes(found)


def test_a_visit_that_may_be_two_is_listed():
    levels = [*[0.4, 3.0] * 3, 0.4, 0.4, 3.0, *[0.4, 3.0] * 3]
    found = scara_iso.visits(as_run(*plateau(100, *levels)), poses=["P1", "-"])
    assert codes(found) == ["begins-at-rest", "long-rest"]
    assert len(found.visits) == 7


def test_a_stream_without_rests_is_refused():
    t = np.arange(5000) / 100
    with pytest.raises(DataError, match=r"cannot be told apart|no rest"):
        scara_iso.visits(as_run(t, np.sin(7 * t)))


@pytest.mark.parametrize(
    ("name", "value"),
    [("dwell", 0.0), ("dwell", float("nan")), ("dwell", 1e4), ("still", -1.0), ("band", 0.0),
     ("poses", ("", ""))],
)  # fmt: skip
def test_options_that_cannot_be_meant(name, value):
    with pytest.raises(UsageError, match=name):
        scara_iso.visits(as_run(*plateau(100, 0.4, 3.0)), **{name: value})


def test_below_50_hz_no_transient_is_read():
    found = scara_iso.visits(as_run(*plateau(40, *[0.4, 3.0] * 4)), poses=["P1", "-"])
    assert not found.characteristics
    assert any("need 50 Hz" in note for note in found.notes)
    assert not [name for name in found.run.covariates if "overshoot" in name]


def test_two_sensors_are_two_axes_and_the_table_reads_back(tmp_path):
    time, x = plateau(100, *[0.4, 3.0] * 4)
    stream = tmp_path / "stream.csv"
    stream.write_text(text(time, {"X": x, "Y": 2.0 - x / 2}))
    found = scara_iso.visits(stream, poses=["P1", "-"])
    assert {v.approach["X"] for v in found.visits} == {-1}
    assert {v.approach["Y"] for v in found.visits} == {1}
    again = scara_iso.read_table(write_table(found.run).encode())
    for name, axis in found.run.axes.items():
        np.testing.assert_array_equal(again.axes[name].readings, axis.readings)
    digest = hashlib.sha256(stream.read_bytes()).hexdigest()
    assert again.metadata["stream_sha256"] == digest
    assert set(again.covariates) >= {"time_s", "approach", "stabilisation_X_s", "overshoot_Y_mm"}


def test_arrivals_along_several_axes_are_named_by_their_directions():
    time, x = plateau(100, *[3.0, 0.4, 0.4, 0.4] * 3, first=0.4)
    _, y = plateau(100, *[0.4, 0.4, -2.0, 0.4] * 3, first=0.4, seed=2)
    axes = {n: Axis(n, r, resolution=0.001) for n, r in (("X", x), ("Y", y))}
    run = Run(np.arange(1, len(time) + 1), axes, covariates={"time_s": time})
    found = scara_iso.visits(run, poses=["-", "P1"])
    assert found.run.direction.tolist() == ["-x", "+y"] * 3
    assert "approach" not in found.run.covariates
    again = scara_iso.read_table(write_table(found.run).encode())
    assert again.direction.tolist() == found.run.direction.tolist()
    assert found.run.cycle.tolist() == [1, 1, 2, 2, 3, 3]


def test_a_recorded_stream_is_read_from_its_raw_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    model = """
[robot]
name = "R"
[indicator.X]
resolution = 0.001
level = 0.4
scatter = 0.001
[[effect]]
name = "step"
at_cycle = 200
size = { X = 2.0 }
"""
    (tmp_path / "arm.toml").write_text(model, "utf-8")
    gauge = "X=opto-rs232@sim:?pace=0&model=arm.toml"
    recorded = scara_iso.record("run.csv", [gauge], trigger="timer:0.06", cycles=400, rearm=0)
    found = scara_iso.visits("run.raw.jsonl")
    (visit,) = found.visits
    assert visit.mean["X"] == pytest.approx(recorded.axes["X"].readings[-50:].mean(), abs=0.001)
    assert found.run.metadata["stream"] == "run.raw.jsonl"
    digest = hashlib.sha256((tmp_path / "run.raw.jsonl").read_bytes()).hexdigest()
    assert found.run.metadata["stream_sha256"] == digest
    assert scara_iso.visits("run.csv").visits[0].mean == visit.mean


def test_a_pose_column_of_the_stream_names_the_visits():
    time, reading = plateau(100, *[0.2, 1.2] * 5)
    run = as_run(time, reading)
    pose = np.where(reading < 0.7, "P1", np.where(reading < 2.0, "P2", "none"))
    labelled = Run(run.cycle, run.axes, pose, run.covariates)
    assert scara_iso.visits(labelled).run.pose.tolist() == ["P1", "P2"] * 5


def test_a_stream_of_short_bursts_has_no_rests():
    burst = np.ravel(np.arange(40)[:, np.newaxis] * 1.02 + [0.0, 0.01, 0.02])
    with pytest.raises(DataError):
        scara_iso.visits(as_run(burst, np.sin(burst)))


def test_a_mean_of_still_samples_stays_on_the_division():
    time, reading = plateau(100, *[0.4, 3.0] * 4, noise=0.0)
    found = scara_iso.visits(as_run(time, np.round(reading, 2), 0.01), poses=["P1", "-"])
    assert found.run.axes["X"].resolution == 0.01
    np.testing.assert_array_equal(found.run.axes["X"].readings, 0.4)


def test_how_an_arrival_ended_is_no_cause():
    rng = np.random.default_rng(5)
    cycle = np.arange(1, 31)
    scatter = rng.normal(0, 0.01, 30)
    run = Run(
        cycle,
        {"X": Axis("X", scatter, resolution=1e-5)},
        covariates={"overshoot_X_mm": scatter * 2 + 0.1},
    )
    names = [e.parameters.get("column") for e in scara_iso.diagnose(run, all_count=True).effects]
    assert "overshoot_X_mm" not in names


@pytest.mark.parametrize(
    ("stream", "said"),
    [
        ("# unit: mm\ncycle,X\n1,0.1\n2,0.2\n", "no time"),
        ("time_s,X\n0,0.1\n1,0.2\n", "no unit stated"),
        ("# unit: mm\ntime_s,X\n0,0.1\n1,x\n2,y\n", "2 faults"),
        ("# unit: mm\ntime_s,X\n" + "".join(f"{k % 15},0.{k}\n" for k in range(30)), "line 18"),
        ("# unit: mm\ntime_s,X\n0,0.1\n1,0.2\n", "not a stream"),
    ],
)
def test_what_is_no_stream_is_refused(stream, said, tmp_path, capsys):
    path = tmp_path / "s.csv"
    path.write_text(stream)
    assert main(["visits", str(path)]) == 65
    out, err = capsys.readouterr()
    assert said in err
    assert not out


def test_command_line(tmp_path, capsys):
    time, reading = plateau(100, *[0.4, 3.0] * 4)
    stream, table = tmp_path / "stream.csv", tmp_path / "run.csv"
    stream.write_text(text(time, {"X": reading}).replace(",", ";").replace(".", ","))
    assert main(["visits", str(stream), "--poses", "P1,-", "-o", str(table), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [visit["cycle"] for visit in told["visits"]] == [1, 2, 3, 4]
    assert told["rule"]["dwell_s"] == 1.0
    assert scara_iso.read_table(table).cycle.tolist() == [1, 2, 3, 4]
    assert main(["visits", str(stream), "-o", str(stream)]) == 73
    assert main(["visits", str(stream), "--poses", "P1,-"]) == 0
    assert "4 visits" in capsys.readouterr().out


@pytest.mark.parametrize("order", [["-"], [*["-"] * 40, "P1"]])
def test_an_order_without_a_pose_at_any_rest_is_refused(order):
    time, reading = plateau(100, 0.0, 1.0, 0.0)
    with pytest.raises(DataError, match=r"none of the \d+ rests is a pose"):
        scara_iso.visits(as_run(time, reading), poses=order)


def test_an_order_may_be_one_text():
    time, reading, _ = simulated.visits(np.random.default_rng(1), count=4)
    found = scara_iso.visits(as_run(time, reading), poses="P1, -")
    assert [visit.pose for visit in found.visits] == ["P1"] * 4


@pytest.mark.parametrize(("rests", "said"), [(1, "would find 1 rest, not 4"), (2, "2 rests, not")])
def test_another_threshold_that_finds_one_rest_is_said_in_the_singular(monkeypatch, rests, said):
    ranked = [SimpleNamespace(low=0.01, high=0.1, rests=n) for n in (4, rests)]
    monkeypatch.setattr(visits_module, "plateaus", lambda *_: ranked)
    monkeypatch.setattr(visits_module, "still_of", lambda _: 0.05)
    wanted = SimpleNamespace(still=None, dwell_s=1.0)
    _, others = visits_module._still(SimpleNamespace(axes={}), None, wanted, 0.1)
    assert said in others[0]


@pytest.mark.parametrize(("count", "options"), [(31, ""), (30, " --all-count --cycles 30")])
def test_a_whole_test_is_analyzed_as_the_procedure_has_it(tmp_path, capsys, count, options):
    """31 visits with an option that counts them all would be a deviation that was advised."""
    stream, table = tmp_path / "s.csv", tmp_path / "run.csv"
    time, reading, _ = simulated.visits(np.random.default_rng(4), count=count, hz=50)
    stream.write_text(text(time, {"X": reading}))
    assert main(["visits", str(stream), "--poses", "P1,-", "-o", str(table)]) == 0
    assert f"Next: scara-iso analyze {table}{options}\n" in capsys.readouterr().out
    assert main(["analyze", str(table), *options.split()]) == 0
    assert "not the standard's" not in capsys.readouterr().out


def test_a_visit_of_two_axes_is_one_line_of_a_screen_and_its_table_is_used_whole(tmp_path, capsys):
    time, reading = plateau(100, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0)
    rows = "".join(f"{t:.3f},{x:.5f},{x + 1:.5f}\n" for t, x in zip(time, reading, strict=True))
    stream, table = tmp_path / "s.csv", tmp_path / "t.csv"
    stream.write_text(f"# unit: mm\n# resolution: 0.0001\ntime_s,X,Y\n{rows}")
    assert main(["visits", str(stream), "--poses", "P1,P2"]) == 0
    said = capsys.readouterr().out
    assert "X, Y: the samples scatter over divisions" in said
    assert "scatter X" not in said
    assert main(["visits", str(stream), "--poses", "P1,P2", "-o", str(table)]) == 0
    capsys.readouterr()
    main(["analyze", str(table), "--all-count", "--cycles", "4"])
    assert "not used" not in capsys.readouterr().out
