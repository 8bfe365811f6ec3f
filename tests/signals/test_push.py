"""A push test against a joint of other equations; its table as strictly read as readings are."""

import json
import math
from pathlib import Path

import numpy as np
import push_rig
import pytest
from budget import examples
from hypothesis import given, strategies as st

import scara_iso
from scara_iso.base.errors import DataError, UsageError
from scara_iso.commands import main
from scara_iso.iso9283 import push_test
from scara_iso.reporting import Dossier, Provenance, Text
from scara_iso.reporting.report import front_page
from scara_iso.signals import ForceLoop

EXAMPLE = Path(__file__).parents[2] / "examples" / "push.csv"


def of_joint(rng, arm=0.25, **joint):
    return push_test(ForceLoop(*push_rig.readings(rng, **joint), resolution=0.001), arm_m=arm)


def loop_of_readings(tmp_path, header="cycle,X,Y,force_N"):
    force, reading = push_rig.readings(None, stiffness=500.0, half_play=0.02, friction=6.0)
    rows = [f"{k},{x:.4f},{1000 * x:.1f},{F:g}"
            for k, (F, x) in enumerate(zip(force, reading, strict=True), 1)]  # fmt: skip
    table = tmp_path / "loop.csv"
    lines = ["# unit: mm", "# unit_Y: um", "# resolution: 0.0001", header, *rows, ""]
    table.write_text("\n".join(lines), encoding="utf-8")
    return table, len(rows)


def test_a_loop_among_readings_is_called_one_and_push_takes_its_axis(tmp_path, capsys):
    table, rows = loop_of_readings(tmp_path)
    assert main(["analyze", str(table), "--cycles", str(rows), "--all-count"]) == 0
    first, second, following, *_ = capsys.readouterr().out.splitlines()
    assert "a force loop, no test of repeatability" in first
    assert "RP" not in first + second
    assert "compliance X 0.2" in second
    assert f"scara-iso push {table} --axis X" in following
    assert main(["analyze", str(table), "--cycles", str(rows), "--all-count", "--full"]) == 0
    whole = capsys.readouterr().out
    assert whole.index("no test of repeatability") < whole.index("RP = l_bar")
    analysis = scara_iso.analyze(table, cycles=rows, all_count=True)
    front = [
        block.text
        for block in front_page(Dossier(analysis, Provenance((), "", "")))
        if isinstance(block, Text) and block.text
    ]
    assert front[0].startswith("Static compliance by")
    assert "no test of repeatability" in front[1]
    for axis in "XY":  # Y is in micrometres
        found = scara_iso.push(table, axis=axis)
        assert found.estimate("lost_motion", "reading").value == pytest.approx(0.04, rel=0.01)
        assert found.fit.misfit is None  # nothing but rounded numbers is left


@pytest.mark.parametrize(
    ("axis", "pose", "said"),
    [("theta", "", "no length theta"), ("Z", "", "no length Z"), ("X", "P1", "2 poses")],
)
def test_what_is_no_loop_of_one_pose_is_refused(tmp_path, axis, pose, said):
    table, _ = loop_of_readings(tmp_path)
    if pose:
        text = table.read_text("utf-8").replace("cycle", "pose,cycle")
        lines = [f"P{k % 2},{line}" if line[:1].isdigit() else line
                 for k, line in enumerate(text.splitlines())]  # fmt: skip
        table.write_text("\n".join(lines) + "\n", "utf-8")
    with pytest.raises(DataError, match=said):
        scara_iso.push(table, axis=axis)


@examples(40)
@given(
    stiffness=st.floats(50, 5000),
    half_play=st.floats(0, 0.1),
    friction=st.floats(0, 20),
)
def test_an_exact_loop_gives_back_what_it_is_made_of(stiffness, half_play, friction):
    joint = {"stiffness": stiffness, "half_play": half_play, "friction": friction}
    force, reading = push_rig.readings(np.random.default_rng(0), **joint)
    found = push_test(ForceLoop(force, reading), arm_m=0.25)
    assert found.fit.compliance == pytest.approx(1 / stiffness, rel=1e-3)
    assert 2 * found.fit.half_play == pytest.approx(2 * half_play, abs=0.01 / stiffness + 1e-6)
    width = found.estimate("friction_width", "reading").value
    assert width == pytest.approx(2 * friction / stiffness, abs=0.01 / stiffness + 1e-6)


def test_figures_of_the_joint_follow_from_the_arm(rng):
    found = of_joint(rng, stiffness=400.0, half_play=0.036, friction=5.0)
    arcmin = 60 * math.degrees(1 / 250)  # of 1 mm at 250 mm
    joint = {one.code: one.estimate for one in found.characteristics if one.of == "joint"}
    assert joint["lost_motion"].value == pytest.approx(0.072 * arcmin, rel=0.01)
    assert joint["friction_width"].value == pytest.approx(2 * 5 / 400 * arcmin, rel=0.02)
    assert joint["friction_torque"].value == pytest.approx(5 * 0.25, rel=0.02)
    assert joint["stiffness"].value == pytest.approx(400 * 0.25 / arcmin, rel=0.01)
    assert joint["stiffness"].unit == "N m/arcmin"
    compliance = found.estimate("compliance", "reading")
    assert (compliance.value, compliance.unit, compliance.clause) == (
        pytest.approx(0.25, rel=0.01), "mm/100 N", "10"
    )  # fmt: skip


def test_a_dial_on_the_far_side_finds_the_same(rng):
    force, reading = push_rig.readings(rng, noise=0.0005)
    one, other = (push_test(ForceLoop(force, way * reading), arm_m=0.3) for way in (1, -1))
    for mine, theirs in zip(one.characteristics, other.characteristics, strict=True):
        assert mine.estimate.value == pytest.approx(theirs.estimate.value)


def test_a_drift_from_loop_to_loop_is_no_lost_motion(rng):
    steady, moving = (of_joint(np.random.default_rng(3), noise=0.0003, drift=d) for d in (0, 0.01))
    play = [one.estimate("lost_motion", "reading").value for one in (steady, moving)]
    assert play[0] == pytest.approx(play[1], abs=0.001)


@pytest.mark.slow
def test_intervals_hold_what_they_should():
    """Coverage in 150 loops; benchmarks/push.py has it for more joints and dials."""
    truth = {"lost_motion": 0.04, "friction_width": 0.024, "hysteresis": 0.064, "compliance": 0.2}
    inside = dict.fromkeys(truth, 0)
    for seed in range(150):
        found = of_joint(np.random.default_rng(seed), noise=0.001, division=0.001)
        for code, value in truth.items():
            low, high = found.estimate(code, "reading").interval
            inside[code] += low <= value <= high
    assert all(135 <= count <= 150 for count in inside.values()), inside


def test_a_shape_that_the_model_misses_is_said_and_widens_the_intervals(rng):
    force, reading = push_rig.readings(rng, noise=0.0002)
    bent = reading + 3e-6 * force**2  # stiffer on one side
    plain, found = (push_test(ForceLoop(force, x)) for x in (reading, bent))
    assert plain.fit.misfit is None
    assert found.fit.misfit == pytest.approx(3e-6 * force.std() ** 2, rel=0.5)
    widths = [one.estimate("lost_motion", "reading").u for one in (plain, found)]
    assert widths[1] > 3 * widths[0]


@pytest.mark.parametrize("loops", [2, 3, 5])
def test_the_deflection_is_a_difference_of_means_over_the_loops(rng, loops):
    force, reading = push_rig.readings(rng, noise=0.001, loops=loops)
    found = push_test(ForceLoop(force, reading))
    expected = math.sqrt(2 / loops) * found.fit.residual
    assert found.estimate("deflection", "reading").u == pytest.approx(expected)


def test_a_shape_that_the_model_misses_is_told_though_the_last_loop_stops_early(rng):
    force, reading = push_rig.readings(rng, noise=0.0002, loops=2)
    found = push_test(ForceLoop(force[:-10], (reading + 3e-6 * force**2)[:-10]))
    assert found.fit.misfit == pytest.approx(3e-6 * force.std() ** 2, rel=0.5)


@pytest.mark.parametrize(
    ("force", "said"),
    [
        (np.tile([0.0, 10, 20, 10], 8), "do not go to both sides"),
        (push_rig.forces(loops=1), "two loops|2 loops"),
        (np.array([10.0, -10.0]), "do not go to both sides"),
    ],
)
def test_forces_that_make_no_loops_are_refused(force, said):
    with pytest.raises(DataError, match=said):
        push_test(ForceLoop(force, force * 0.001))


def test_readings_without_a_spring_are_refused(rng):
    force = push_rig.forces()
    with pytest.raises(DataError, match="no spring can be told"):
        push_test(ForceLoop(force, rng.normal(0, 0.001, len(force))))


@pytest.mark.parametrize(
    ("limits", "verdict"),
    [({"": 5.0}, "pass"), ({"lost_motion": 0.1}, "fail"), ({"hysteresis": 0.88}, "not-provable"),
     ({"": 5.0, "deflection_mm": 0.1}, "fail"), (None, None)],
)  # fmt: skip
def test_limits_are_decided_on_the_interval(rng, limits, verdict):
    force, reading = push_rig.readings(np.random.default_rng(1), noise=0.002, division=0.001)
    found = push_test(ForceLoop(force, reading), arm_m=0.25, limits=limits)
    assert (found.conformity and found.conformity.value) == verdict


def test_a_limit_of_what_is_not_there(rng):
    with pytest.raises(UsageError, match="this figure takes no limit"):
        of_joint(rng, arm=None, noise=0.001).loop and push_test(
            of_joint(rng).loop, limits={"lost_motion": 1.0}
        )


def written(tmp_path, rng, head="# unit: mm\n# resolution: 0.001\n", change=lambda text: text):
    path = tmp_path / "loop.csv"
    force, reading = push_rig.readings(rng, noise=0.0005)
    path.write_text(change(push_rig.text(force, reading, head)))
    return path


SPELLINGS = {
    "decimal commas": (
        "# unit: mm\n# resolution: 0.001\n",
        lambda t: t.replace(",", ";").replace(".", ","),
    ),
    "unit in the header": ("", lambda t: t.replace("reading", "reading [mm]", 1)),
    "unit behind the name": ("", lambda t: t.replace("reading", "reading_mm", 1)),
    "another column": ("# unit: mm\n", lambda t: t.replace("reading", "reading,note", 1)
                       .replace("\n", ",x\n").replace("note,x", "note").replace("mm,x", "mm")),
    "tabs": ("# unit: mm\n", lambda t: t.replace(",", "\t")),
}  # fmt: skip


@pytest.mark.parametrize("spelling", SPELLINGS)
def test_spellings(spelling, tmp_path):
    head, change = SPELLINGS[spelling]
    rng = np.random.default_rng
    plain = scara_iso.push(written(tmp_path, rng(4)), arm=0.25)
    other = scara_iso.push(written(tmp_path, rng(4), head, change), arm=0.25)
    one, two = (f.estimate("stiffness", "joint").value for f in (plain, other))
    assert one == pytest.approx(two, rel=1e-9)


def test_micrometres_are_converted(tmp_path, rng):
    text = "# unit: um\nforce_N,reading\n" + "".join(
        f"{F:g},{1000 * x:.1f}\n"
        for F, x in zip(*push_rig.readings(rng, noise=0.0005), strict=True)
    )
    found = scara_iso.push(text.encode())
    assert found.estimate("lost_motion", "reading").value == pytest.approx(0.04, abs=0.002)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("force_N,reading\n1,2\n2,3\n", "no unit stated"),
        ("# unit: deg\nforce_N,reading\n1,2\n2,3\n", "a dial reads lengths"),
        ("# unit: mm\nforce_N,reading [um]\n1,2\n2,3\n", "unit um against mm"),
        ("# unit: mm\n# resolution: x\nforce_N,reading\n1,2\n", "is not a number above zero"),
        ("# unit: mm\nforce_N,reading\n1,x\ny,3\n", "2 faults"),
        ("# unit: mm\nforce_N;reading\n1,5;2.5\n", "commas and points both occur"),
        ("# unit: mm\nforce,reading\n1,2\n", "column force_N is missing"),
        ("", "at least one row|empty"),
    ],
)
def test_faults_of_a_table(text, said):
    with pytest.raises(DataError) as caught:
        scara_iso.push(text.encode())
    assert any(part in str(caught.value) for part in said.split("|"))


def test_command_line(tmp_path, rng, capsys):
    loop = str(written(tmp_path, rng))
    assert main(["push", loop, "--arm", "0.25", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["joint"]["lost_motion"]["unit"] == "arcmin"
    assert told["loops"] == 3
    assert main(["push", loop, "--arm", "0.25", "--limit", "0.1"]) == 1
    assert "OUTSIDE the limit" in capsys.readouterr().out
    assert main(["push", loop, "--limit", "1"]) == 2
    assert main(["push", loop, "--arm", "0"]) == 2
    assert main(["push", str(tmp_path / "none.csv")]) == 66


@pytest.mark.slow
def test_rounding_that_repeats_is_counted():
    """Steps of whole divisions: all readings of a flank are rounded alike, loop after loop."""
    inside = 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        joint = {"half_play": 0.02 + 0.002 * rng.random(), "friction": 6.0 + rng.random()}
        force, reading = push_rig.readings(rng, noise=0.001, division=0.01, **joint)
        found = push_test(ForceLoop(force, reading, resolution=0.01))
        low, high = found.estimate("friction_width", "reading").interval
        inside += low <= 2 * joint["friction"] / 500 <= high
    assert inside >= 37


@pytest.mark.parametrize(
    ("limit", "verdict"),
    [
        ("0.2..0.4", "pass"),  # deflection 0.2968 [0.2938, 0.2998] mm
        ("0.2..0.29", "fail"),
        ("0.31..0.4", "fail"),
        ("0.295..0.4", "not-provable"),
        ("0.2..0.299", "not-provable"),
    ],
)
def test_a_makers_limit_has_two_ends(limit, verdict, capsys):
    code = main(["push", str(EXAMPLE), "--limit", f"deflection_mm={limit}", "--json"])
    (held,) = json.loads(capsys.readouterr().out)["limits"]
    assert (held["verdict"], code) == (verdict, 0 if verdict == "pass" else 1)
    assert [held["lower"], held["limit"]] == [float(end) for end in limit.split("..")]


@pytest.mark.parametrize(
    "limit", ["0.4..0.2", "..0.4", "0.2..", "-1..2", "0.1..0.2..0.3", "0..nan"]
)
def test_ends_that_are_none_are_refused(limit, capsys):
    assert main(["push", str(EXAMPLE), "--limit", f"deflection_mm={limit}"]) == 2
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize("arm", [0.0, 1e-300, -1.0, 250.0, math.inf, math.nan])
def test_an_arm_in_millimetres_is_refused(arm):
    with pytest.raises(UsageError, match="not the length of an arm in metres") as caught:
        scara_iso.push(EXAMPLE, arm=arm)
    assert "`arm=0.25`" in caught.value.remedy


def test_what_a_limit_of_loops_means_is_said_once_and_in_full_only(capsys):
    means = "the whole interval is at most the limit; fail"
    for more, times in ((), 0), (("--full",), 1):
        assert main(["push", str(EXAMPLE), "--limit", "hysteresis_mm=0.2", *more]) == 0
        assert " ".join(capsys.readouterr().out.split()).count(means) == times
