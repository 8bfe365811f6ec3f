"""All poses in one search: joints against a Jacobian by finite differences, a slip at one pose."""

import json

import numpy as np
import pytest

from scara_iso.commands import main
from scara_iso.diagnosis import Verdict, diagnose_poses, whole_cycles
from scara_iso.diagnosis.engine.evidence import ManyPoses, constant, shrunk, views_of
from scara_iso.diagnosis.engine.places import locate, places_of
from scara_iso.diagnosis.engine.residual import PoseAxis
from scara_iso.diagnosis.separating import poses_apart
from scara_iso.robot import Arm
from scara_iso.run import Axis, Run

ARM = Arm(250, 200)
JOINTS = {"P1": (10, 80), "P2": (-30, 110), "P3": (45, 60), "P4": (-50, 60), "P5": (60, 110)}
STRAIGHT = {"P1": (10, 2), "P2": (-30, 1), "P3": (45, 2), "P4": (-50, 1), "P5": (60, 2)}
N = 30
STEP = (np.arange(N) >= 14) * 1.0
SCATTER = np.array([10e-6, 15e-6])
LATE = STEP[:, np.newaxis]


def place(q_1, q_2):
    """Return (x, y) of the tool in mm; an oracle apart from `Arm`."""
    return np.array([
        250 * np.cos(q_1) + 200 * np.cos(q_1 + q_2), 250 * np.sin(q_1) + 200 * np.sin(q_1 + q_2)
    ])  # fmt: skip


def readings(rng, joints=JOINTS, moved=(0.0, 0.0), slip=None):
    """Return readings (n, 2) by pose: ``moved`` joints [rad] from cycle 16 on, or a slip at one."""
    found = {}
    for pose, degrees in joints.items():
        q = np.radians(degrees) + rng.normal(size=(N, 2)) * SCATTER + LATE * moved
        seen = np.array([place(*row) - place(*np.radians(degrees)) for row in q])
        seen += rng.normal(size=(N, 2)) * 0.0015 + LATE * (slip or {}).get(pose, 0.0)
        found[pose] = np.round(seen, 3)
    return found


def table(path, found):
    """Write a table of the poses in turn."""
    rows = "".join(
        f"{pose},{k + 2},{xy[k, 0]:.3f},{xy[k, 1]:.3f}\n"
        for k in range(N)
        for pose, xy in found.items()
    )
    path.write_text(f"# unit: mm\n# resolution: 0.001\npose,cycle,X,Y\n{rows}", encoding="utf-8")
    return path


def model(path, joints=JOINTS):
    """Write the model file of the arm at the poses."""
    poses = "".join(f"[pose.{p}]\njoint_deg = [{a}, {b}]\n" for p, (a, b) in joints.items())
    path.write_text(
        f"[robot]\nlink_1_mm = 250\nlink_2_mm = 200\n{poses}"
        "[indicator.X]\nresolution = 0.001\n[indicator.Y]\nresolution = 0.001\n",
        encoding="utf-8",
    )
    return path


@pytest.fixture(scope="module")
def worn(tmp_path_factory):
    """Return table and model of a robot whose joint 2 jumped by 40 microradians."""
    folder = tmp_path_factory.mktemp("worn")
    found = readings(np.random.default_rng(5), moved=(0.0, 40e-6))
    return table(folder / "five.csv", found), model(folder / "five.toml")


@pytest.fixture(scope="module")
def found(worn):
    """Return the JSON object of the diagnosis."""
    return said(worn[0], "--model", worn[1])


def said(*words):
    """Return what ``diagnose --json`` says."""
    import contextlib  # noqa: PLC0415
    import io  # noqa: PLC0415

    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        assert main(["diagnose", *map(str, words), "--json"]) == 0
    return json.loads(out.getvalue())


def test_a_worn_joint_is_named_with_its_size(found):
    (effect,) = found["effects"]
    assert found["schema"] == "scara-iso/diagnose/2"
    assert (effect["effect"], effect["joint"], effect["poses"]) == ("step", 2, [*JOINTS])
    low, high = effect["size_at_joint"]["interval"]
    assert low < 40e-6 < high
    assert effect["size_at_joint"]["unit"] == "rad"


def test_the_size_at_each_pose_is_that_of_the_joint_through_the_geometry(found):
    (effect,) = found["effects"]
    value = effect["size_at_joint"]["value"]
    for pose, degrees in JOINTS.items():
        q = np.radians(degrees)
        moved = (place(q[0], q[1] + 1e-6) - place(*q)) * value / 1e-6
        sizes = effect["parameters"]["size"][pose]
        assert [sizes["X"], sizes["Y"]] == pytest.approx(moved, abs=1e-7)


def test_every_pose_has_its_error_and_all_have_one(found):
    assert [one["pose"] for one in found["poses"]] == [*JOINTS]
    for kind in ("before", "after"):
        for figure in ("rms", "held_out_rms"):
            squares = [one["error"][kind][figure]["X"] ** 2 for one in found["poses"]]
            whole = found["error"][kind][figure]["X"]
            assert whole == pytest.approx(np.sqrt(np.mean(squares)))
    held_out = [found["error"][kind]["held_out_rms"]["X"] for kind in ("before", "after")]
    assert held_out[1] < held_out[0]
    first = found["poses"][0]
    assert len(first["series"]["measured"]["X"]) == len(first["series"]["cycle"]) == N
    assert set(first["repeatability"]["completed"]) == {"X", "Y", "XY"}


def test_without_a_model_the_same_table_names_axes_and_poses(worn):
    (effect,) = said(worn[0])["effects"]
    assert effect["joint"] is None
    assert effect["size_at_joint"] is None
    assert set(effect["poses"]) <= set(JOINTS)
    assert len(effect["poses"]) > 1


def test_a_saved_joint_foretells_a_table_of_other_poses(worn, tmp_path):
    new = tmp_path / "new.toml"
    notes = said(*worn[:1], "--model", worn[1], "--save-model", new)["notes"]
    assert any("declares step" in note for note in notes)
    others = {"P6": (-60, 90), "P7": (25, 120), "P8": (0, 50)}
    text = new.read_text(encoding="utf-8")
    poses = "".join(f"[pose.{p}]\njoint_deg = [{a}, {b}]\n" for p, (a, b) in others.items())
    new.write_text(f"{poses}{text}", encoding="utf-8")
    seen = readings(np.random.default_rng(6), others, moved=(0.0, 40e-6))
    second = table(tmp_path / "others.csv", seen)
    plain, told = said(second, "--model", worn[1]), said(second, "--model", new)
    assert plain["verdict"] == "explained"
    assert told["verdict"] == "nothing-to-explain"
    before = [one["error"]["before"]["rms"]["Y"] for one in (plain, told)]
    assert before[1] < 0.9 * before[0]


def test_rp_of_unseen_cycles_is_that_of_every_other_cycle_of_the_pose(worn, found):
    table = np.genfromtxt(worn[0], delimiter=",", skip_header=3, dtype=None, encoding="utf-8")
    for pose in found["poses"]:
        xy = np.array([[row[2], row[3]] for row in table if row[0] == pose["pose"]])[1::2]
        apart = np.linalg.norm(xy - xy.mean(axis=0), axis=1)
        unseen = pose["repeatability"]["unseen"]
        radial = apart.mean() + 3 * apart.std(ddof=1)
        assert unseen["measured"]["XY"] == pytest.approx(radial, rel=1e-9)
        assert unseen["completed"].keys() == unseen["measured"].keys() == {"X", "Y", "XY"}


@pytest.mark.slow
def test_an_effect_of_a_users_own_is_found_in_its_joint_and_saved(tmp_path, capsys):
    bend = np.abs(np.arange(2, N + 2) - 17.0)[:, np.newaxis]
    rng, moved = np.random.default_rng(6), {}
    for pose, degrees in JOINTS.items():
        q = np.radians(degrees) + rng.normal(size=(N, 2)) * SCATTER + bend * (0.0, 5e-6)
        moved[pose] = np.array([place(*row) - place(*np.radians(degrees)) for row in q])
    own = tmp_path / "own.toml"
    own.write_text(
        "[[effect]]\nname = 'door'\nformula = 'abs(k - shut)'\n"
        "parameters = { shut = { from = 8, to = 24 } }\n"
    )
    five, arm, new = tmp_path / "five.csv", model(tmp_path / "five.toml"), tmp_path / "new.toml"
    words = (table(five, moved), "--model", arm, "--effects", own)
    assert main(["diagnose", *map(str, words)]) == 0
    assert "explain door" not in capsys.readouterr().out
    (effect,) = said(*words, "--save-model", new)["effects"]
    assert (effect["effect"], effect["joint"], effect["poses"]) == ("door", 2, [*JOINTS])
    low, high = effect["size_at_joint"]["interval"]
    assert low < 5e-6 < high
    again = said(five, "--model", new)
    assert again["verdict"] == "nothing-to-explain"


def test_a_joint_that_the_model_cannot_place_is_refused(worn, tmp_path, capsys):
    text = worn[1].read_text(encoding="utf-8")
    effect = "[[effect]]\nname = 'step'\nat_cycle = 9\nsize = { 'joint 2' = 4e-5 }\n"
    bad = tmp_path / "bad.toml"
    bad.write_text(text.replace("[pose.P3]", "[pose.Q3]") + effect, encoding="utf-8")
    assert main(["diagnose", str(worn[0]), "--model", str(bad)]) == 2
    said_so = capsys.readouterr()
    assert said_so.out == ""
    assert "joint 2" in said_so.err
    assert "joint_deg" in said_so.err


def run_of(found):
    """Return the run of the poses' readings, and their rows by pose."""
    pose = np.repeat([*found], N)
    xy = np.concatenate([*found.values()])
    axes = {name: Axis(name, xy[:, k], resolution=0.001) for k, name in enumerate("XY")}
    run = Run(np.tile(np.arange(2, N + 2), len(found)), axes, pose=pose)
    return whole_cycles(run, {str(p): rows for p, rows in run.rows_by_pose()})


def test_a_slip_at_one_pose_is_put_on_no_joint():
    seen = readings(np.random.default_rng(8), slip={"P3": (0.012, -0.006)})
    (effect,) = diagnose_poses(run_of(seen), arm=ARM, joints_deg=JOINTS).effects
    assert (effect.joint, effect.place, effect.poses) == (None, "P3", ("P3",))
    assert effect.joint_candidates == ()


def test_scatter_alone_is_nothing_at_any_pose():
    seen = readings(np.random.default_rng(11))
    found = diagnose_poses(run_of(seen), arm=ARM, joints_deg=JOINTS)
    assert found.verdict is Verdict.NOTHING
    assert {one.verdict for one in found.poses.values()} == {Verdict.NOTHING}


@pytest.mark.slow
def test_a_straight_arm_does_not_tell_its_joints_apart():
    seen = readings(np.random.default_rng(3), STRAIGHT, moved=(0.0, 60e-6))
    found = diagnose_poses(run_of(seen), arm=ARM, joints_deg=STRAIGHT)
    (effect,) = found.effects
    assert (effect.joint, effect.joint_candidates) == (None, (1, 2))
    assert found.verdict is Verdict.EXPLAINED
    assert found.separation.observability_index < 0.02


COLUMNS = [PoseAxis(pose, axis, "mm") for pose in JOINTS for axis in "XY"]
NUMBERS = np.repeat(np.arange(5), 2)


@pytest.mark.parametrize(
    ("name", "size"),
    [("joint 1", 4e-5), ("joint 2", 6e-5), ("along the arm", 4e-5), ("Y everywhere", 0.008)],
)
def test_a_place_is_found_by_the_movements_it_makes(name, size, rng):
    places = places_of(COLUMNS, ARM, JOINTS)
    moved = next(p.movement for p in places if p.name == name)[:, 0] * size
    seen = np.concatenate([*readings(rng).values()], axis=1) + LATE * moved
    located = locate(LATE, constant(N), seen, places, NUMBERS)
    assert located.place.name == name
    assert (located.weights.T @ moved)[0] == pytest.approx(size)


@pytest.mark.parametrize(("course", "place"), [("step", "every axis"), ("drift", "along the arm")])
def test_links_do_not_grow_in_one_cycle(course, place):
    """With joint 1's zero 90 degrees off, what turns it moves the tool as links that grow."""
    moves = LATE if course == "step" else np.arange(N)[:, np.newaxis] / N
    seen = readings(np.random.default_rng(5))
    turned = {pose: (a + 90, b) for pose, (a, b) in JOINTS.items()}
    for pose, (a, b) in JOINTS.items():
        seen[pose] += moves * ARM.jacobian((a, b))[:, 0] * 60e-6
    (effect,) = diagnose_poses(run_of(seen), arm=ARM, joints_deg=turned).effects
    assert effect.place == place


def test_what_the_test_looks_at_does_not_depend_on_the_order_of_the_cycles(rng):
    """So the shuffles give the exact chance of the statistic."""
    seen = np.concatenate([*readings(rng, moved=(0.0, 40e-6)).values()], axis=1)
    directions = {p.name: p.movement[:, 0] for p in places_of(COLUMNS, ARM, JOINTS) if p.tied}
    poses = ManyPoses(NUMBERS, np.full(len(directions), 1 / len(directions)))
    order = rng.permutation(N)
    one = views_of(seen, constant(N), directions, poses=poses).columns
    other = views_of(seen[order], constant(N), directions, poses=poses).columns
    assert one.shape == (N, 10 + len(directions))
    assert other == pytest.approx(one[order])


def test_what_poses_share_counts_as_far_as_chance_does_not_give_it(rng):
    own, shared = rng.normal(size=(2, 400, 4)), rng.normal(size=(400, 1))
    numbers = np.array([0, 0, 1, 1])
    alone = own[0].T @ own[0] / 400
    assert abs(shrunk(alone, numbers, 400)[0, 2]) < abs(alone[0, 2])
    assert shrunk(alone, numbers, 400)[0, 1] == alone[0, 1]
    alike = (own[1] + shared).T @ (own[1] + shared) / 400
    assert shrunk(alike, numbers, 400)[0, 2] == pytest.approx(alike[0, 2], rel=0.05)
    assert shrunk(alone, np.zeros(4, dtype=int), 400) is alone


def test_an_axis_that_moves_little_is_no_axis_at_rest(rng):
    values = rng.normal(size=(12, 2))
    wide, narrow = (views_of(values * [1.0, size], constant(12), {}) for size in (1.0, 1e-11))
    assert narrow.columns[:, 1] == pytest.approx(wide.columns[:, 1])


@pytest.mark.parametrize("level", [0.0, 0.3])
def test_an_axis_at_rest_says_nothing_of_a_direction(level, rng):
    values = np.stack([rng.normal(size=12), np.full(12, level)], axis=1)
    found = views_of(values, constant(12), {"everywhere": np.ones(2)})
    along, moving = found.columns[:, 2], found.columns[:, 0]
    assert along / np.linalg.norm(along) == pytest.approx(moving)


def test_poses_that_turn_joint_1_alone_still_tell_the_joints_apart():
    apart = poses_apart(ARM, [(20 * k, 90) for k in range(1, 6)])
    assert apart.angle_deg > 45
    assert 0.2 < apart.observability_index < 1


def test_a_cycle_that_one_pose_lacks_is_left_out_and_said(rng):
    seen = readings(rng)
    pose = np.repeat([*seen], N)
    cycle = np.tile(np.arange(2, N + 2), 5)
    xy = np.concatenate([*seen.values()])
    keep = ~((pose == "P4") & (cycle == 9))
    run = Run(cycle[keep], {"X": Axis("X", xy[keep, 0])}, pose=pose[keep])
    test = whole_cycles(run, {str(p): rows for p, rows in run.rows_by_pose()})
    assert 9 not in test.run.cycle
    assert len(test.run) == N - 1
    assert "cycle 9" in test.notes[0]


ALONG = np.array([[1, -0.8], [0.6, 1], [-1, 0.5], [0.8, 0.7], [0.5, -1]])


def visits(rng, column, moved=0.0, along=ALONG, **more):
    """Return five poses of which X and Y follow a column (n, 5), ``along`` their directions."""
    seen = rng.normal(0, 0.004, (N, 5, 2)) + moved * column[:, :, np.newaxis] * along
    axes = {a: Axis(a, seen[..., k].ravel().round(3), resolution=0.001) for k, a in enumerate("XY")}
    cycle, pose = np.repeat(np.arange(2, N + 2), 5), np.tile([*JOINTS], N)
    columns = {name: values.ravel() for name, values in more.items()}
    run = Run(cycle, axes, pose=pose, covariates=columns)
    return whole_cycles(run, {str(p): rows for p, rows in run.rows_by_pose()})


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1002, 1013])
def test_a_vee_that_five_poses_share_is_no_transient(seed):
    rng, vee = np.random.default_rng(seed), np.abs(np.linspace(-0.5, 0.5, N))
    seen = rng.normal(0, 0.004, (5, 2, N)).transpose(2, 0, 1)
    along = [rng.uniform(0.3, 1) * rng.choice([-1, 1]) for _ in range(10)]
    seen += 0.064 * vee[:, np.newaxis, np.newaxis] * np.reshape(along, (5, 2))
    axes = {a: Axis(a, seen[..., k].ravel().round(3), resolution=0.001) for k, a in enumerate("XY")}
    run = Run(np.repeat(np.arange(N) + 2, 5), axes, pose=np.tile([*JOINTS], N))
    test = whole_cycles(run, {str(p): rows for p, rows in run.rows_by_pose()})
    assert diagnose_poses(test).verdict is Verdict.UNEXPLAINED


def test_a_column_that_differs_between_the_visits_of_a_cycle_is_that_of_each_pose(rng):
    by_cycle, by_visit = np.outer(rng.normal(20, 1, N), np.ones(5)), rng.normal(20, 1, (N, 5))
    same = np.where(np.arange(5) == 2, 20.0, by_visit)
    test = visits(rng, by_visit, temperature_C=by_cycle, force_N=by_visit, load_N=same)
    assert test.run.covariates.keys() == {"temperature_C"}
    assert test.run.covariates["temperature_C"] == pytest.approx(by_cycle[:, 0])
    own = test.conditions(["P4"]).at("P4").covariates
    assert own.keys() == {"temperature_C", "force_N"}
    assert own["force_N"] == pytest.approx(by_visit[:, 3])
    assert test.notes[0].startswith("load_N differs between the visits of a cycle")


@pytest.mark.parametrize("slow", [False, True])
def test_a_temperature_of_each_visit_explains_what_it_moves(rng, slow):
    room = rng.normal(0, 1, (N, 5)).cumsum(0) if slow else rng.normal(0, 1, (N, 5))
    test = visits(rng, room, 0.006, temperature_C=20 + room)
    found = diagnose_poses(test, seed=1)
    (one,) = found.effects
    assert (one.effect, one.poses) == ("temperature", tuple(JOINTS))
    assert one.probability > 0.95
    assert one.parameters["size"]["P3"]["X"] == pytest.approx(-0.006, abs=0.002)
    assert one.standard_errors["size"]["P3"]["X"] < 0.0015
    assert found.error.after.held_out_rms["X"] < 0.75 * found.error.before.held_out_rms["X"]
    second = visits(rng, room[::-1], 0.006, temperature_C=20 + room[::-1])
    again = diagnose_poses(test, seed=1, held_out=(second, {}))
    assert again.error.after.held_out_rms["X"] < 0.75 * again.error.before.held_out_rms["X"]


def test_a_temperature_that_was_shuffled_is_not_named(rng):
    drift = np.outer(np.linspace(0, 4, N), np.ones(5))
    shuffled = rng.permuted(drift + rng.normal(0, 1, (N, 5)), axis=0)
    found = diagnose_poses(visits(rng, drift, 0.006, temperature_C=20 + shuffled), seed=1)
    assert [one.effect for one in found.effects] == ["linear_drift"]


def test_an_approach_of_each_visit_shows_lost_motion(rng):
    side = rng.choice([-1.0, 1.0], (N, 5))
    (one,) = diagnose_poses(visits(rng, side, 0.008, approach=side), seed=1).effects
    assert (one.effect, one.poses) == ("lost_motion", tuple(JOINTS))


def test_a_temperature_of_each_visit_at_one_pose_is_named_there(rng):
    room = rng.normal(0, 1, (N, 5))
    only = room * (np.arange(5) == 2)
    (one,) = diagnose_poses(visits(rng, only, 0.012, temperature_C=20 + room), seed=1).effects
    assert (one.effect, one.poses, one.place) == ("temperature", ("P3",), "P3")


def test_a_temperature_of_each_visit_that_moves_an_axis_alike_is_traced_to_it(rng):
    room = rng.normal(0, 1, (N, 5))
    test = visits(rng, room, 0.006, [1, 0], temperature_C=20 + room)
    (one,) = diagnose_poses(test, seed=1).effects
    assert (one.effect, one.place) == ("temperature", "X everywhere")
    assert one.at_joint.value == pytest.approx(0.006, abs=0.001)
    assert one.at_joint.standard_error < 0.001


def test_what_is_noted_of_an_axis_stands_at_its_pose_alone(rng):
    seen = {name: readings(rng)["P1"] for name in ("P1", "P10", "P3")}
    seen["P10"][:, 0] = 0.5
    run = Run(
        np.tile(np.arange(2, N + 2), 3),
        {a: Axis(a, np.concatenate([*seen.values()])[:, k]) for k, a in enumerate("XY")},
        pose=np.repeat([*seen], N),
    )
    found = diagnose_poses(whole_cycles(run, {str(p): r for p, r in run.rows_by_pose()}), seed=1)
    saying = [
        pose for pose, one in found.poses.items() if any("X at P10 never" in n for n in one.notes)
    ]
    assert saying == ["P10"]


def test_a_course_of_no_name_is_said_at_its_pose(tmp_path, capsys):
    k = np.arange(N)
    course = 0.02 * np.sin(2 * np.pi * k / 30) + 0.015 * np.cos(2 * np.pi * k / 8.4)
    rng = np.random.default_rng(4)
    seen = {p: rng.normal(size=(N, 2)) * 0.002 for p in ("P1", "P2")}
    seen["P2"][:, 1] += course
    assert main(["diagnose", str(table(tmp_path / "two.csv", seen)), "--full"]) == 0
    said = capsys.readouterr().out
    assert "pose P2: unexplained\n  Y " in said
    assert "pose P1: unexplained" not in said


def test_the_table_of_poses_shows_rp_of_what_an_effect_moves(tmp_path, rng, capsys):
    """Theta moves, in no plane: its own RP stands there, and not that of the axis before it."""
    rows = "".join(
        f"{c},{pose},{rng.normal(0.4, 0.004):.4f},{rng.normal(1, 0.01) + 0.1 * (c > 14):.4f}\n"
        for c in range(1, 32)
        for pose in ("P1", "P2")
    )
    head = "# unit_X: mm\n# unit_theta: deg\n# resolution: 0.0001\ncycle,pose,X,theta\n"
    (tmp_path / "two.csv").write_text(head + rows)
    assert main(["diagnose", str(tmp_path / "two.csv")]) == 0
    table = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert [line[:3] for line in table if line[:1] in (["P1"], ["P2"])] == [
        ["P1", "step", "theta"],
        ["P2", "step", "theta"],
    ]


def test_a_rate_in_a_joint_says_that_it_is_one_and_an_odd_reading_names_its_joint(tmp_path, capsys):
    model(tmp_path / "arm.toml")
    turns = np.arange(N) - (N - 1) / 2
    for column, said in (
        (turns * 2e-6, " per cycle"),
        ((np.arange(N) == 17) * 150e-6, "Likely: gear, belt, encoder or bearing of joint 1, as"),
    ):
        rng, found = np.random.default_rng(4), {}
        for pose, degrees in JOINTS.items():
            q = np.radians(degrees) + rng.normal(size=(N, 2)) * SCATTER
            q[:, 0] += column
            seen = [place(*row) - place(*np.radians(degrees)) for row in q]
            found[pose] = np.round(seen + rng.normal(size=(N, 2)) * 0.0015, 3)
        path = table(tmp_path / "run.csv", found)
        call = ["diagnose", str(path), "--model", str(tmp_path / "arm.toml")]
        assert main([*call, "--first-cycle-discarded"]) == 0
        assert said in " ".join(capsys.readouterr().out.split())
