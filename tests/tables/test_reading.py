"""What a table is taken for: angles on one turn, poses, their commands, cycles that count."""

import json

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, strategies as st

import scara_iso
from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.quantities import Dimension, unwrap
from scara_iso.commands import main
from scara_iso.commands.operator.screen import _next, _on_one_turn
from scara_iso.comparison import compare
from scara_iso.iso9283.core.slips import REPEATED_BY_CHANCE, find_repeats
from scara_iso.recorder.events import Done
from scara_iso.run import Axis, Run, number_cycles

HEAD = "# unit: mm\n# unit_theta: deg\n# resolution: 0.001\n"
POSES = {"P1": (100, 0), "P2": (20, 50), "P3": (-70, 10), "P4": (5, 5), "P5": (44, -9)}


@pytest.fixture
def rng():
    return np.random.default_rng(9283)


def read(text):
    return scara_iso.read_table(text.encode())


def codes(analysis):
    return [finding.code for finding in analysis.findings]


def table(numbers, rng, head=HEAD):
    rows = (f"{n},{rng.normal(0, 0.004):.3f},{rng.normal(0, 0.004):.3f}" for n in numbers)
    return head + "cycle,X,Y\n" + "".join(f"{row}\n" for row in rows)


def poses_in_turn(rng, column="pose", cycle=None, head=HEAD):
    lines = []
    for n in range(31):
        for k, (label, place) in enumerate(POSES.items()):
            number = {None: "", "visit": f"{5 * n + k + 1},", "cycle": f"{n + 1},"}[cycle]
            readings = ",".join(f"{x + rng.normal(0, 0.004):.3f}" for x in place)
            lines.append(f"{number}{label},{readings}\n")
    return f"{head}{'cycle,' if cycle else ''}{column},X,Y\n" + "".join(lines)


# Angles


@given(
    st.lists(st.floats(-60, 60), min_size=2, max_size=40),
    st.floats(-180, 360),
    st.sampled_from([0.0, 180.0, 720.0]),
)
def test_angles_are_the_same_however_they_are_wrapped(offsets, about, start):
    angles = about + np.array(offsets)
    found = unwrap((angles - start) % 360 + start)
    assert np.ptp(found) == pytest.approx(np.ptp(angles), abs=1e-6)
    assert np.allclose(np.round((found - angles) / 360) * 360, found - angles, atol=1e-6)


@given(st.lists(st.floats(0, 180), min_size=1, max_size=20), st.floats(-1e4, 1e4))
def test_angles_within_half_a_turn_stay_as_they_are(offsets, about):
    angles = about + np.array(offsets)
    if np.ptp(angles) <= 180:
        assert unwrap(angles) is angles


@pytest.mark.parametrize("unit", ["deg", "rad", "arcmin", "arcsec", "mrad"])
@pytest.mark.parametrize("about", [0.0, 180.0])
def test_theta_about_a_jump_scatters_as_elsewhere(rng, unit, about):
    size = {"deg": 1, "rad": np.pi / 180, "arcmin": 60, "arcsec": 3600, "mrad": np.pi / 0.18}[unit]
    offsets = rng.normal(0, 0.01, 31)
    shown = (offsets % 360 if about == 0 else (offsets % 360) - 180) * size
    rows = "".join(f"{k + 1},{x:.9f}\n" for k, x in enumerate(shown))
    run = read(f"# unit_theta: {unit}\ncycle,theta\n{rows}")
    assert "theta passes a full turn" in run.origin.understood
    axis = scara_iso.analyze(run).poses[0].axes["theta"]
    assert axis.three_sigma == pytest.approx(3 * offsets[1:].std(ddof=1), rel=1e-5)
    assert axis.mean == pytest.approx(offsets[1:].mean() + about, abs=1e-6)


def test_frames_and_models_are_unwrapped_too_and_poses_each_by_itself(rng):
    offsets = rng.normal(0, 0.01, 62)
    pose = np.repeat(["P1", "P2"], 31)
    theta = (offsets + np.where(pose == "P1", 0, 200)) % 360
    frame = pd.DataFrame({"cycle": [*range(1, 32)] * 2, "pose": pose, "theta": theta})
    run = Run.from_frame(frame, unit="deg")
    assert "full turn" in run.origin.understood
    for found, about, part in zip(scara_iso.analyze(run).poses, (0, 200), (1, 32), strict=True):
        s = offsets[part : part + 30].std(ddof=1)
        assert found.axes["theta"].three_sigma == pytest.approx(3 * s)
        assert found.axes["theta"].mean == pytest.approx(about, abs=0.01)
    built = Run(np.arange(1, 4), {"theta": Axis("theta", [359.9, 0.1, 0.2], Dimension.ANGLE)})
    assert built.unwrapped().axes["theta"].readings.tolist() == [-0.1, 0.1, 0.2]
    assert built.axes["theta"].readings[0] == 359.9  # as it was shown: the recorder writes it so


def test_a_scatter_of_more_than_half_a_turn_is_refused(rng):
    rows = "".join(f"{k},{rng.uniform(0, 360):.2f}\n" for k in range(1, 32))
    with pytest.raises(DataError, match="more than half a turn"):
        read(f"# unit_theta: deg\ncycle,theta\n{rows}")


def test_compare_and_accuracy_know_that_359_is_beside_0(rng):
    def analysis(about, **axis):
        theta = Axis("theta", rng.normal(about, 0.01, 31), Dimension.ANGLE, 0.001, **axis)
        metadata = {"dial_zero": "command"}
        return scara_iso.analyze(Run(np.arange(1, 32), {"theta": theta}, metadata=metadata))

    before, after = analysis(359.5), analysis(0.5, command=360.0)
    contrast = compare([before, after]).pairs[0].means[0]
    assert contrast.difference == pytest.approx(1, abs=0.02)
    assert after.poses[0].axes["theta"].accuracy == pytest.approx(0.5, abs=0.02)


# Command poses


def test_one_command_pose_is_not_that_of_five(rng):
    head = HEAD + "# dial_zero: command\n# command_X: 100\n"
    found = scara_iso.analyze(read(poses_in_turn(rng, head=head)))
    assert all(pose.axes["X"].accuracy is None for pose in found.poses)
    assert "command-pose" in codes(found)


def test_a_pose_without_its_command_is_named_and_the_others_are_used(rng):
    """No 'not used' beside an AP that is printed; the line to write is of a pose in want."""
    head = HEAD + "# dial_zero: command\n# command_X[P1]: 100\n# command_Y[P1]: 100\n"
    found = scara_iso.analyze(read(poses_in_turn(rng, head=head)))
    assert found.poses[0].axes["X"].accuracy is not None
    said = [one.in_full for one in found.findings if one.code == "command-pose"]
    for axis, message in zip("XY", said, strict=True):
        assert "not used" not in message
        assert f"command_{axis}[P2]" in message


@pytest.mark.parametrize("how", ["lines", "columns", "frame", "written"])
def test_each_pose_has_its_command(rng, how):
    lines = "".join(
        f"# command_{axis}[{label}]: {place[k]}\n"
        for label, place in POSES.items() for k, axis in enumerate("XY")
    )  # fmt: skip
    text = poses_in_turn(rng, head=HEAD + "# dial_zero: command\n" + lines)
    if how == "columns":
        head, _, body = text.replace(lines, "").partition("pose,X,Y\n")
        rows = [row.split(",") for row in body.split()]
        body = "".join(
            f"{','.join(row)},{POSES[row[0]][0] * 1000},{POSES[row[0]][1]}\n" for row in rows
        )
        text = f"{head}pose,X,Y,command_X [um],command_Y\n{body}"
    run = read(text)
    if how == "frame":
        run = Run.from_frame(run.to_frame())
    if how == "written":
        run = read(scara_iso.write_table(run))
    assert run.covariates == {}
    found = scara_iso.analyze(run)
    assert "command-pose" not in codes(found)
    for pose in found.poses:
        means = [pose.axes[axis].readings.mean() for axis in "XY"]
        offsets = [mean - command for mean, command in zip(means, POSES[pose.label], strict=True)]
        assert pose.axes["X"].accuracy == pytest.approx(offsets[0])
        assert pose.XY.accuracy == pytest.approx(np.hypot(*offsets))
        alone = run.take(pose.rows)
        assert alone.command_of("X", None) == POSES[pose.label][0]


def test_no_accuracy_without_the_zero_of_the_dial_and_the_reason_is_said(rng):
    head = HEAD + "# command_X: 0\n# command_Y: 0\n"
    without = scara_iso.analyze(read(table(range(1, 32), rng, head)))
    assert without.poses[0].XY.accuracy is None
    assert any("dial_zero" in finding.in_full for finding in without.findings)
    stated = scara_iso.analyze(read(table(range(1, 32), rng, head + "# dial_zero: command\n")))
    assert stated.poses[0].XY.accuracy is not None


def test_a_command_that_changes_within_a_pose_or_is_stated_twice_is_refused(rng):
    text = HEAD + "cycle,X,command_X\n1,0,1\n2,0,2\n"
    with pytest.raises(DataError) as caught:
        read(text)
    assert "changes within a pose" in caught.value.faults[0].message
    with pytest.raises(DataError):
        read(table(range(1, 32), rng, HEAD + "# command_X: 1\n# command_X[P1]: 2\n"))


# Poses under another name


@pytest.mark.parametrize(
    "name", ["target", "point", "position", "Punkt", "Messpunkt", "station", "Position"]
)
def test_other_names_of_the_pose(rng, name):
    text = poses_in_turn(rng, column=name)
    found = scara_iso.analyze(read(text))
    assert [pose.label for pose in found.poses] == list(POSES)
    assert max(pose.XY.RP for pose in found.poses) < 0.03
    digits = text.replace("P", "").replace(f"\n{name.replace('P', '')},", f"\n{name},")
    assert len(scara_iso.analyze(read(digits)).poses) == 5


def test_a_position_that_is_measured_is_a_covariate(rng):
    rows = "".join(f"{k},{rng.normal(0, 0.004):.3f},{k * 0.37:.2f}\n" for k in range(1, 32))
    assert list(read(f"{HEAD}cycle,X,position\n{rows}").covariates) == ["position"]


@pytest.mark.parametrize("labels", ["123", "ABC"])
def test_poses_in_a_column_of_another_name_are_refused(rng, labels):
    name = "fixture" if labels == "123" else "note"
    rows = "".join(
        f"{k + 1},{50 * (k % 3) + rng.normal(0, 0.004):.3f},{labels[k % 3]}\n" for k in range(31)
    )
    with pytest.raises(DataError, match=f"column '{name}' parts the readings of X as poses"):
        read(f"{HEAD}cycle,X,{name}\n{rows}")
    assert len(read(f"{HEAD}# covariates: {name}\ncycle,X,{name}\n{rows}")) == 31
    if labels == "123":
        frame = pd.read_csv(pd.io.common.StringIO(f"cycle,X,{name}\n{rows}"))
        with pytest.raises(DataError, match="parts the readings"):
            Run.from_frame(frame, unit="mm")


@pytest.mark.parametrize("name", ["approach", "payload_kg", "speed", "temperature_C"])
def test_a_known_condition_may_part_the_readings(rng, name):
    rows = "".join(
        f"{k + 1},{(-1) ** k * 0.5 + rng.normal(0, 0.004):.3f},{(-1) ** k}\n" for k in range(31)
    )
    assert list(read(f"{HEAD}cycle,X,{name}\n{rows}").covariates) == [name]


def test_a_column_that_explains_less_is_a_covariate(rng):
    rows = "".join(
        f"{k + 1},{k % 2 * 0.02 + rng.normal(0, 0.004):.3f},{k % 2}\n" for k in range(31)
    )
    assert list(read(f"{HEAD}cycle,X,clamp\n{rows}").covariates) == ["clamp"]


# Rows that repeat


@pytest.mark.parametrize("times", [2, 3, 5])
def test_visits_that_are_written_several_times_are_refused_until_one_row_is_left(rng, times):
    visits = np.round(rng.normal(0, 0.005, (31, 2)), 3)
    rows = np.repeat(visits, times, axis=0)
    run = Run(np.arange(1, len(rows) + 1), {n: Axis(n, rows[:, k]) for k, n in enumerate("XY")})
    with pytest.raises(DataError) as caught:
        scara_iso.analyze(run, cycles=len(rows))
    assert "rows repeat every reading of the row before" in caught.value.faults[0].message
    assert "take one row a visit, and number the cycles from 1" in caught.value.remedy
    one = run.take(np.arange(0, len(rows), times))
    one = Run(np.arange(1, len(one) + 1), one.axes)
    assert scara_iso.analyze(one).cycles.used == 30


def test_some_repeated_rows_are_a_finding(rng):
    visits = np.round(rng.normal(0, 0.006, (25, 3)), 3)
    rows = np.sort(np.concatenate([np.arange(25), [2, 5, 9, 14, 18, 22]]))
    axes = {n: Axis(n, visits[rows, k]) for k, n in enumerate("XYZ")}
    assert "repeated-rows" in codes(scara_iso.analyze(Run(np.arange(1, 32), axes)))


def test_the_paper_s_coarse_dials_do_not_repeat():
    run = scara_iso.read_table("examples/fum_scara_table1.csv")
    assert "repeated-rows" not in codes(scara_iso.analyze(run))
    for axis in run.axes.values():
        assert find_repeats(axis.readings[:, np.newaxis], np.array([0.01])).p_value > 0.5


def courses(rng, n):
    """Yield courses that a coarse dial shows in equal neighbours."""
    sizes = 10.0 ** rng.uniform(-1, 1)
    noise = rng.normal(0, sizes, n)
    stuck = noise.copy()
    k = rng.integers(0, n - 12)
    stuck[k : k + 12] = stuck[k]
    yield noise
    yield noise / sizes * 0.2 + np.linspace(0, rng.uniform(0, 60), n)
    yield np.cumsum(noise) / sizes * 0.4
    yield stuck
    yield noise / sizes * 0.2 + 5 * np.where(np.arange(n) % 4 < 2, 1, -1)
    yield noise / sizes * 0.2 + 50 * np.sin(np.arange(n) / 5)


@pytest.mark.parametrize("n", [30, 100])
def test_coarse_dials_drifts_and_stuck_channels_are_no_repeats(n):
    rng = np.random.default_rng(1)
    found = [
        find_repeats(np.round(course)[:, np.newaxis], np.ones(1)).p_value < REPEATED_BY_CHANCE
        for _ in range(100)
        for course in courses(rng, n)
    ]
    assert sum(found) <= 1


# Which cycles count: each row of the interface's table


def counted(text, **options):
    found = scara_iso.analyze(read(text), **options)
    return found.cycles.read, list(found.cycles.discarded), found.cycles.used


@pytest.mark.parametrize(("numbers", "first"), [(range(1, 32), 1), (range(31), 0)])
def test_31_cycles_discard_the_first(rng, numbers, first):
    assert counted(table(numbers, rng)) == (31, [first], 30)


@pytest.mark.parametrize(
    ("numbers", "line", "options"),
    [
        (range(2, 32), "", {}),
        (range(1, 31), "# first_cycle_discarded: true\n", {}),
        (range(1, 31), "", {"first_cycle_discarded": True}),
    ],
)
def test_30_cycles_after_the_first(rng, numbers, line, options):
    assert counted(table(numbers, rng, HEAD + line), **options) == (30, [], 30)


def test_30_cycles_of_which_nothing_is_said(rng):
    with pytest.raises(DataError) as caught:
        counted(table(range(1, 31), rng))
    assert "the first of 31 was already removed" in caught.value.faults[0].message
    assert "30 were run and all count" in caught.value.faults[0].message
    for option in ("`first_cycle_discarded=True`", "`all_count=True`", "`cycles=30`"):
        assert option in caught.value.remedy


@pytest.mark.parametrize(
    ("line", "options"), [("", {"all_count": True}), ("# first_cycle: counts\n", {})]
)
def test_every_cycle_counts(rng, line, options):
    text = table(range(1, 31), rng, HEAD + line)
    assert counted(text, **options) == (30, [], 30)
    found = scara_iso.analyze(read(text), **options)
    assert any("none was discarded" in finding.message for finding in found.findings)
    assert not any("first cycle is not" in finding.message for finding in found.findings)
    assert counted(table(range(1, 32), rng, HEAD + line), **options) == (31, [], 31)
    assert counted(table(range(1, 21), rng, HEAD + line), cycles=20, **options) == (20, [], 20)
    for numbers in (range(2, 32), range(1, 30), range(1, 41)):
        with pytest.raises(DataError):
            counted(table(numbers, rng, HEAD + line), **options)


def test_every_cycle_counts_or_the_first_is_discarded_but_not_both(rng):
    text = table(range(1, 31), rng)
    with pytest.raises(UsageError):
        counted(text, all_count=True, first_cycle_discarded=True)
    head = HEAD + "# first_cycle_discarded: true\n"
    with pytest.raises(DataError):
        counted(table(range(1, 31), rng, head), all_count=True)
    with pytest.raises(DataError, match="first_cycle is 'perhaps'"):
        counted(table(range(1, 31), rng, HEAD + "# first_cycle: perhaps\n"))


@pytest.mark.parametrize(
    ("numbers", "found", "said"),
    [
        ([*range(1, 14), *range(15, 32)], (30, [1], 29), "cycle 14 is missing"),
        ([1, *range(3, 32)], (30, [1], 29), "cycle 2 is missing"),
        ([*range(2, 14), *range(17, 32)], (27, [], 27), "cycles 14 to 16 are missing"),
        (range(4, 32), (28, [], 28), "cycles 2 to 3 are missing"),
    ],
)
def test_gaps(rng, numbers, found, said):
    text = table(numbers, rng)
    with pytest.raises(DataError):
        counted(text)
    assert counted(text, allow_gaps=True) == found
    analysis = scara_iso.analyze(read(text), allow_gaps=True)
    assert any(said in finding.message for finding in analysis.deviations)


def test_a_gap_at_one_pose_of_two_leaves_the_other_whole(rng):
    text = "".join(
        f"{n},{p},{rng.normal(0, 0.004):.3f}\n"
        for n in range(1, 32) for p in ("A", "B") if (n, p) != (7, "B")
    )  # fmt: skip
    run = read(f"{HEAD}cycle,pose,X\n{text}")
    with pytest.raises(DataError) as caught:
        scara_iso.analyze(run)
    assert [fault.message for fault in caught.value.faults] == ["pose B: cycle 7 is missing"]
    assert "`allow_gaps=True`" in caught.value.remedy
    found = scara_iso.analyze(run, allow_gaps=True)
    assert [(pose.label, pose.axes["X"].n) for pose in found.poses] == [("A", 30), ("B", 29)]


@pytest.mark.parametrize(
    "numbers", [range(1, 30), range(1, 33), [1, 1, *range(2, 31)], [*range(1, 30), 31, 30]]
)
def test_any_other_numbers_are_refused_also_where_gaps_are_allowed(rng, numbers):
    for allow_gaps in (False, True):
        with pytest.raises(DataError):
            counted(table(numbers, rng), allow_gaps=allow_gaps)


@pytest.mark.parametrize("cell", ["", "x", "nan", "inf"])
def test_a_cell_that_is_no_number_is_refused(rng, cell):
    text = table(range(1, 32), rng).replace("\n5,", f"\n5,{cell}|", 1).split("|")
    with pytest.raises(DataError):
        read(f"{text[0]}{text[1][text[1].index(',') :]}")


def test_another_number_is_a_deviation(rng):
    text = table(range(1, 21), rng)
    assert counted(text, cycles=20) == (20, [1], 19)
    assert any(f.code == "cycle-count" for f in scara_iso.analyze(read(text), cycles=20).deviations)


@pytest.mark.parametrize("cycle", [None, "visit", "cycle"])
def test_poses_in_turn(rng, cycle):
    run = read(poses_in_turn(rng, cycle=cycle))
    assert run.cycle.tolist() == np.repeat(np.arange(1, 32), 5).tolist()
    found = scara_iso.analyze(run)
    assert (found.cycles.read, found.cycles.used, len(found.poses)) == (31, 30, 5)


def test_visits_in_turn_tell_which_is_missing(rng):
    lines = poses_in_turn(rng, cycle="visit").splitlines(keepends=True)
    text = "".join(line for line in lines if not line.startswith("33,"))
    with pytest.raises(DataError) as caught:
        scara_iso.analyze(read(text))
    assert caught.value.faults[0].message == "pose P3: cycle 7 is missing"
    assert scara_iso.analyze(read(text), allow_gaps=True).poses[2].axes["X"].n == 29


def test_numbers_that_count_visits_pose_after_pose_or_from_the_second_cycle():
    pose = np.repeat(["A", "B"], 3)
    assert number_cycles(np.arange(1.0, 7), pose, 6).tolist() == [1, 2, 3, 1, 2, 3]
    turns = np.array(["A", "B"] * 3)
    assert number_cycles(np.arange(3.0, 9), turns, 6).tolist() == [2, 2, 3, 3, 4, 4]
    assert number_cycles(np.arange(0.0, 6), turns, 6).tolist() == [1, 1, 2, 2, 3, 3]
    own = np.array([1.0, 2, 3, 1, 2, 3])
    assert number_cycles(own, pose, 6).tolist() == own.tolist()


@pytest.mark.parametrize("command", ["analyze", "diagnose", "report"])
@pytest.mark.parametrize(
    ("numbers", "option"),
    [(range(1, 31), "--all-count"), ([*range(1, 9), *range(10, 32)], "--allow-gaps")],
)
def test_the_options_of_the_commands(rng, tmp_path, capsys, command, numbers, option):
    file = tmp_path / "run.csv"
    file.write_text(table(numbers, rng), encoding="utf-8")
    assert main([command, str(file), "--json"]) == 65
    assert capsys.readouterr().out == ""
    assert main([command, str(file), "--json", option]) == 0
    assert json.loads(capsys.readouterr().out)


def test_compare_takes_the_options_too(rng, tmp_path, capsys):
    file = tmp_path / "run.csv"
    file.write_text(table(range(1, 31), rng), encoding="utf-8")
    assert main(["compare", str(file), str(file), "--json", "--all-count"]) == 0
    assert json.loads(capsys.readouterr().out)


def test_the_report_names_the_cycle_that_was_discarded(rng, tmp_path):
    file, page = tmp_path / "run.csv", tmp_path / "run.md"
    file.write_text(table(range(1, 32), rng), encoding="utf-8")
    assert main(["report", str(file), "-o", str(page)]) == 0
    assert "cycle 1 is discarded" in page.read_text(encoding="utf-8")
    file.write_text(table(range(1, 31), rng), encoding="utf-8")
    assert main(["report", str(file), "-o", str(page), "--all-count"]) == 0
    said = page.read_text(encoding="utf-8")
    assert "all of them count, none was discarded: the standard's own 30 cycles" in said


def test_a_recording_that_was_cut_short_names_resume(rng):
    head = HEAD + "# first_cycle_discarded: false\n# cycles_planned: 31\n"
    with pytest.raises(DataError) as caught:
        counted(table(range(1, 21), rng, head))
    assert "`resume=True`" in caught.value.remedy
    assert "`cycles=20`" in caught.value.remedy
    assert counted(table(range(1, 21), rng, head), cycles=20) == (20, [1], 19)


def test_a_covariate_that_is_missing_is_refused():
    with pytest.raises(DataError, match="speed: a value is missing or not finite"):
        Run(np.arange(1, 3), {"X": Axis("X", [0.1, 0.2])}, covariates={"speed": [1.0, np.nan]})


def test_the_hint_after_a_recording_of_five_cycles_works(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    gauge = "X=opto-rs232@sim:?pace=0"
    words = ["record", "run.csv", "--gauge", gauge, "--trigger", "timer:0.01", "--cycles", "5"]
    assert main([*words, "--json"]) == 0
    hint = _next(Done(5, 5, "run.csv", "run.raw.jsonl"))
    capsys.readouterr()
    assert main([*hint.split(), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["cycles"]["used"] == 4
    assert _next(Done(31, 31, "run.csv", "run.raw.jsonl")) == "analyze run.csv"


def test_a_theta_that_jumps_is_shown_on_one_turn_while_it_is_recorded():
    assert _on_one_turn((359.99, 0.01)) == (-0.01, 0.01)
    assert _on_one_turn((0.0, 120.0, 240.0)) == (0.0, 120.0, 240.0)
