"""Two inertias and a gap against closed forms, limits, conservation laws and each other."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from budget import examples
from hypothesis import example, given, strategies as st
from oracles.drivetrain import DriveTrain, Move, arrivals
from oracles.integration import integrate
from oracles.motion import (
    LEFT,
    NO_CONTACT,
    RIGHT,
    Held,
    Servo,
    State,
    Torque,
    solve,
)

from scara_iso.base.errors import UsageError
from scara_iso.robot import Approach, Gearbox, sides
from scara_iso.robot.prediction import rest_in_gap

PAPER = DriveTrain(2.65e-4, 4.749, math.radians(12 / 60))  # eq. 17 and 18
GEARED = replace(PAPER, ratio=50.0)

inertias = st.floats(-5, 2).map(lambda e: 10.0**e)
gaps = st.floats(-5, -1).map(lambda e: 10.0**e)
pieces = st.lists(st.tuples(st.floats(0.01, 0.3), st.floats(-1, 1)), min_size=1, max_size=5)
trains = st.builds(
    DriveTrain, st.floats(0.1, 2), st.floats(0.1, 2), st.floats(0.01, 0.1), st.floats(1, 3)
)


def centre_of_mass(train, load, motor):
    """Eq. 10."""
    j, i = train.ratio**2 * train.motor_inertia, train.load_inertia
    return (j * motor + i * load) / (j + i)


def energy(train, run):
    """Kinetic energy, and what a compliant gear stores."""
    j, i = train.ratio**2 * train.motor_inertia, train.load_inertia
    kinetic = (j * run.motor_velocity**2 + i * run.load_velocity**2) / 2
    if math.isinf(train.stiffness):
        return kinetic
    depth = np.maximum(np.abs(run.gap_angle) - train.gap / 2, 0)
    return kinetic + train.stiffness * depth**2 / 2


# --- the paper's model ------------------------------------------------------------------------


@given(inertias, inertias, gaps, st.floats(1, 100))
def test_a_reversal_moves_the_load_by_equation_16(I_m, I_L, gap, ratio):
    train = DriveTrain(I_m, I_L, gap, ratio)
    j = ratio**2 * I_m
    crossing = math.sqrt(2 * gap * j)  # under an output torque of 1 N m
    drive = Torque((crossing * 1.2,), (-1 / ratio,))
    run = solve(train, drive, State.touching(train, RIGHT))
    assert run.contact[0] == NO_CONTACT
    assert run.contact[-1] == LEFT
    start = centre_of_mass(train, run.load_angle[0], run.motor_angle[0])
    end = start - run.time[-1] ** 2 / (2 * (j + I_L))  # eq. 11, whatever the contacts did
    deviation = (run.load_angle[0] - start) - (run.load_angle[-1] - end)
    assert deviation == pytest.approx(-gap / (1 + I_L / j), rel=1e-9)


def test_the_paper_s_joint_1():
    run = solve(PAPER, Torque((0.02,), (-0.01,)), State.touching(PAPER, RIGHT))
    moved = run.load_angle[-1] - run.load_angle[0]
    drift = -0.01 * 0.02**2 / 2 / (2.65e-4 + 4.749)
    assert moved - drift == pytest.approx(1.947721e-7, rel=1e-6)


@given(trains, pieces, st.floats(-1, 1), st.floats(-1, 1), st.floats(-0.99, 0.99))
def test_the_centre_of_mass_moves_by_equation_11_whatever_the_contacts_do(
    train, pieces, velocity, relative, place
):
    durations, torques = zip(*pieces, strict=True)
    start = State(0.3, velocity, place * train.gap / 2, relative)
    run = solve(train, Torque(durations, torques), start)
    total = train.ratio**2 * train.motor_inertia + train.load_inertia
    share = train.ratio**2 * train.motor_inertia / total
    angle = 0.3 + share * start.gap_angle
    speed = velocity + share * relative
    for duration, torque in pieces:
        a = train.ratio * torque / total
        angle += speed * duration + a * duration**2 / 2
        speed += a * duration
    end = centre_of_mass(train, run.load_angle[-1], run.motor_angle[-1])
    assert end == pytest.approx(angle, rel=1e-9, abs=1e-11)
    moving = centre_of_mass(train, run.load_velocity[-1], run.motor_velocity[-1])
    assert moving == pytest.approx(speed, rel=1e-9, abs=1e-11)


@given(trains, pieces, st.floats(-1, 1), st.floats(-1, 1))
def test_the_gap_is_never_left_and_contact_means_its_end(train, pieces, velocity, relative):
    durations, torques = zip(*pieces, strict=True)
    run = solve(train, Torque(durations, torques), State(0, velocity, 0, relative), points=9)
    assert np.all(np.abs(run.gap_angle) <= train.gap / 2 * (1 + 1e-12))
    touching = run.contact != NO_CONTACT
    assert np.all(run.gap_angle[touching] == run.contact[touching] * train.gap / 2)
    assert np.all(run.gap_velocity[touching] == 0)


@given(trains, st.floats(0, 1), st.floats(-1, 1), st.floats(-1, 1))
@example(DriveTrain(1.0, 1.0, 0.0625), 0.5, 5e-324, 0.0)
@example(DriveTrain(1.0, 1.0, 0.0625), 0.0, 0.0, 1e-5)
def test_impacts_keep_momentum_and_never_bring_energy(train, friction, velocity, relative):
    train = replace(train, coulomb=friction)
    idle = Torque((50.0,), (0.0,))
    run = solve(train, idle, State(0, velocity, 0, relative))
    j, i = train.ratio**2 * train.motor_inertia, train.load_inertia
    momentum = j * run.motor_velocity + i * run.load_velocity
    before, after = momentum[1:-1:2], momentum[2::2]
    assert after == pytest.approx(before, rel=1e-12, abs=1e-12)
    assert np.all(np.diff(energy(train, run)) <= 1e-12)
    meets = abs(relative) * 50 > train.gap  # it begins in the middle of the gap
    if friction == 0 and meets:
        assert energy(train, run)[-1] == pytest.approx((momentum[0] ** 2) / (2 * (j + i)))


def test_a_gear_multiplies_torque_and_squares_inertia():
    direct = replace(GEARED, motor_inertia=GEARED.reflected_inertia, ratio=1.0)
    geared = solve(GEARED, Torque((0.3, 0.3), (0.1, -0.2)), State())
    plain = solve(direct, Torque((0.3, 0.3), (5.0, -10.0)), State())
    assert geared.load_angle == pytest.approx(plain.load_angle, rel=1e-12)
    assert geared.gap_angle == pytest.approx(plain.gap_angle, rel=1e-12)


# --- what the paper leaves out ------------------------------------------------------------------


def test_friction_brings_a_coasting_load_to_rest_after_its_stopping_distance():
    train = replace(PAPER, gap=10.0, coulomb=2.0)
    for follow in (solve, integrate):
        run = follow(train, Torque((3.0,), (0.0,)), State(0, 0.5, 0, -0.5))
        assert run.load_velocity[-1] == 0
        assert run.load_angle[-1] == pytest.approx(4.749 * 0.5**2 / (2 * 2.0), rel=1e-9)


@pytest.mark.parametrize("follow", [solve, integrate])
def test_friction_holds_what_is_pushed_weakly(follow):
    train = replace(GEARED, coulomb=2.0, load_torque=1.5)
    weak = follow(train, Torque((1.0,), (0.4 / 50,)), State.touching(train, RIGHT))
    assert weak.load_angle[-1] == 0
    strong = follow(train, Torque((1.0,), (0.6 / 50,)), State.touching(train, RIGHT))
    acceleration = (1.5 + 0.6 - 2.0) / (GEARED.reflected_inertia + 4.749)
    assert strong.load_angle[-1] == pytest.approx(acceleration / 2, rel=1e-8)


@pytest.mark.parametrize("follow", [solve, integrate])
def test_a_load_torque_presses_the_load_on_a_held_motor(follow):
    train = replace(PAPER, load_torque=3.0, coulomb=1.0)
    run = follow(train, Held((1.0,), (0.0,)), State.touching(train, RIGHT))
    fall = math.sqrt(2 * train.gap * 4.749 / (3.0 - 1.0))
    hit = run.time[np.flatnonzero(run.contact == LEFT)[0]]
    assert hit == pytest.approx(fall, rel=1e-9)
    assert run.load_angle[-1] == pytest.approx(train.gap, rel=1e-9)
    assert run.load_velocity[-1] == pytest.approx(0, abs=1e-12)


def test_viscous_friction_slows_a_coasting_load_exponentially():
    train = replace(PAPER, gap=10.0, viscous=4.0)
    run = integrate(train, Torque((2.0,), (0.0,)), State(0, 0.5, 0, -0.5), points=30)
    rate = 4.0 / 4.749
    assert run.load_velocity == pytest.approx(0.5 * np.exp(-rate * run.time), rel=1e-8)
    assert run.load_angle == pytest.approx(0.5 / rate * -np.expm1(-rate * run.time), rel=1e-8)


def test_viscous_and_coulomb_friction_stop_the_load_in_time():
    train = replace(PAPER, gap=10.0, viscous=4.0, coulomb=1.0)
    run = integrate(train, Torque((2.0,), (0.0,)), State(0, 0.5, 0, -0.5))
    stop = 4.749 / 4.0 * math.log(1 + 4.0 * 0.5 / 1.0)
    assert run.time[1] == pytest.approx(stop, rel=1e-9)
    assert run.load_velocity[-1] == 0


def test_a_spring_without_damping_rebounds():
    train = DriveTrain(1.0, 2.0, 0.02, stiffness=1e5)
    reduced = 1.0 * 2.0 / 3.0
    run = integrate(train, Torque((0.035,), (0.0,)), State(0, 0, 0, 1.0), points=2001)
    pressed = run.contact == RIGHT
    deepest = (run.gap_angle[pressed] - 0.01).max()
    assert deepest == pytest.approx(math.sqrt(reduced / 1e5), rel=1e-5)
    lasted = np.ptp(run.time[pressed])
    assert lasted == pytest.approx(math.pi * math.sqrt(reduced / 1e5), rel=1e-6)
    assert run.gap_velocity[-1] == pytest.approx(-1.0, rel=1e-8)
    assert energy(train, run) == pytest.approx(0.5, rel=1e-8)


def test_a_stiff_and_heavily_damped_gear_tends_to_plastic_impacts():
    rigid = DriveTrain(1.0, 2.0, 0.02, coulomb=0.2)
    drive, start = Torque((0.3,), (0.5,)), State(0, 0, 0, 0.5)
    plastic = solve(rigid, drive, start)
    misses = []
    for stiffness in (1e4, 1e6):
        soft = replace(rigid, stiffness=stiffness, damping=3 * math.sqrt(stiffness))
        run = integrate(soft, drive, start)
        misses.append(abs(run.load_angle[-1] - plastic.load_angle[-1]))
    assert misses[1] < misses[0] / 5
    assert misses[1] < 1e-4 * plastic.load_angle[-1] + 1e-5


def test_wind_up_is_torque_over_stiffness():
    train = DriveTrain(1.0, 2.0, 0.02, load_torque=5.0, stiffness=1e3, damping=30.0)
    run = integrate(train, Held((5.0,), (0.0,)), State.touching(train, LEFT))
    assert run.gap_angle[-1] == pytest.approx(-0.01 - 5.0 / 1e3, rel=1e-6)


def test_a_gear_at_rest_on_its_flank_stays_there():
    train = DriveTrain(1.0, 2.0, 0.02, stiffness=1e3)
    run = integrate(train, Torque((1.0,), (0.0,)), State.touching(train, LEFT))
    assert len(run.time) == 2
    assert run.gap_angle[-1] == pytest.approx(-0.01)


def test_a_servo_in_the_open_gap_is_a_damped_oscillator():
    train = DriveTrain(1.0, 2.0, 1.0)
    servo = Servo((2.0,), (0.0,), proportional=100.0, derivative=4.0)
    run = integrate(train, servo, State(0, 0, 0.1, 0), points=50)
    rate, turn = 2.0, math.sqrt(100.0 - 4.0)
    t = run.time
    expected = 0.1 * np.exp(-rate * t) * (np.cos(turn * t) + rate / turn * np.sin(turn * t))
    assert run.motor_angle == pytest.approx(expected, abs=1e-9)


def test_a_servo_gives_no_more_than_its_limit():
    train = DriveTrain(1.0, 2.0, 1.0)
    servo = Servo((0.1,), (0.0,), proportional=1e4, derivative=0.0, limit=3.0)
    run = integrate(train, servo, State(0, 0, 0.4, 0))
    assert run.motor_angle[-1] == pytest.approx(0.4 - 3.0 * 0.1**2 / 2, rel=1e-9)


def test_a_stiff_servo_tends_to_a_motor_that_is_held():
    train = replace(GEARED, coulomb=5.0)
    durations, accelerations = (0.05, 0.4), (-6.0, 0.0)
    start = State.touching(train, RIGHT, velocity=0.3)
    held = solve(train, Held(durations, accelerations), start)
    misses = []
    for gain in (1e4, 1e5):
        servo = Servo(
            durations,
            accelerations,
            proportional=gain,
            derivative=10 * math.sqrt(gain * 5.4),  # over-damped: else it recoils
            angle=train.gap / 2,
            velocity=0.3,
        )
        run = integrate(train, servo, start, tolerance=1e-8)
        misses.append(abs(run.load_angle[-1] - held.load_angle[-1]))
    assert misses[1] < misses[0] / 2
    assert misses[1] < 0.02 * train.gap


@examples(15)
@given(
    trains,
    st.floats(0, 1),
    st.floats(-0.5, 0.5),
    pieces,
    st.booleans(),
    st.floats(-1, 1),
    st.floats(-1, 1),
)
@example(DriveTrain(1.0, 1.0, 0.0625), 1.0, 0.0, [(0.25, 1.0), (0.25, -1.0)], False, 0.0, 0.0)
@example(
    DriveTrain(0.5, 0.5, 0.0625), 1.0, 0.0, [(0.125, 0.5), (0.25, -0.25), (0.125, 0.5)], True, -1, 1
)
def test_closed_form_and_integration_agree(
    train, coulomb, load_torque, pieces, held, velocity, relative
):
    train = replace(train, coulomb=coulomb, load_torque=load_torque)
    drive = (Held if held else Torque)(*zip(*pieces, strict=True))
    start = State(0, velocity, 0, relative)
    exact, numeric = solve(train, drive, start), integrate(train, drive, start)
    for name in ("load_angle", "gap_angle"):  # velocities jump if the end is an impact
        assert getattr(numeric, name)[-1] == pytest.approx(getattr(exact, name)[-1], abs=1e-7)


@examples(15)
@given(
    st.floats(0, 0.5),
    st.floats(0, 0.5),
    st.sampled_from([(math.inf, 0.0), (1e3, 0.0), (1e3, 20.0)]),
    st.floats(-1, 1),
    st.floats(-1, 1),
)
def test_energy_never_grows_in_a_passive_run(coulomb, viscous, gear, velocity, relative):
    stiffness, damping = gear
    train = DriveTrain(
        1.0, 2.0, 0.05, coulomb=coulomb, viscous=viscous, stiffness=stiffness, damping=damping
    )
    start = State(0, velocity, 0, relative)
    run = integrate(train, Torque((1.5,), (0.0,)), start, points=20, tolerance=1e-12)
    values = energy(train, run)
    assert np.all(np.diff(values) <= 1e-9 * (1e-3 + values[0]))


# --- arrivals -----------------------------------------------------------------------------------

RUBBING = replace(GEARED, coulomb=5.0)


def rest_by_work(train, move, friction, approach):
    """Rest in the gap from the work of friction: an oracle without events or motor."""
    way = move.speed**2 / 2 * (train.load_inertia / friction - 1 / move.deceleration)
    return approach * (min(max(way, 0.0), train.gap) - train.gap / 2)


@pytest.mark.parametrize("speed", [0.01, 0.03, 0.05, 0.06, 0.08, 0.3])
@pytest.mark.parametrize("deceleration", [0.5, 1.0, 1.2, 10.0])
def test_a_load_rests_where_friction_has_used_up_its_energy(speed, deceleration):
    move = Move(speed, deceleration)
    found = arrivals(RUBBING, move, Approach.BOTH_SIDES, count=4, rng=np.random.default_rng(1))
    assert found.approach.tolist() == [1, -1, 1, -1]
    expected = [rest_by_work(RUBBING, move, 5.0, a) for a in found.approach]
    assert found.load_angle == pytest.approx(np.array(expected), abs=1e-15)
    at_end = np.abs(found.load_angle) == RUBBING.gap / 2
    assert np.array_equal(found.contact != NO_CONTACT, at_end)
    assert np.all(np.sign(found.load_angle[at_end]) == -found.contact[at_end])


@pytest.mark.parametrize("speed", [0.03, 0.06, 0.3])
def test_arrivals_agree_with_an_integrated_servo(speed):
    move, gain = Move(speed, 10.0), 1e5
    servo = Servo(
        (speed / 10.0, 0.5),
        (-10.0, 0.0),
        proportional=gain,
        derivative=10 * math.sqrt(gain * 5.4),  # over-damped: else it recoils
        angle=RUBBING.gap / 2,
        velocity=speed,
    )
    start = State.touching(RUBBING, RIGHT, velocity=speed)
    run = integrate(RUBBING, servo, start, tolerance=1e-8)
    stop = RUBBING.gap / 2 + speed**2 / 20.0
    found = arrivals(RUBBING, move, Approach.ONE_SIDE, count=1, rng=np.random.default_rng(1))
    sag = RUBBING.coulomb / gain  # by which friction holds a standing servo off its command
    assert run.load_angle[-1] - stop == pytest.approx(found.load_angle[0], abs=1.05 * sag)


@pytest.mark.parametrize("friction", [0.0, 0.5, 2.0, 5.0, 40.0, 300.0])
def test_the_program_rests_loads_where_their_motion_through_time_does(friction):
    gear = Gearbox(2.65e-4, 4.749, 12.0, friction=friction)
    train = replace(PAPER, coulomb=friction)
    move = Move(speed=1.0, deceleration=10.0, speed_scatter=0.02, friction_scatter=0.1)
    way = sides(Approach.RANDOM, 200, np.random.default_rng(1))
    found = arrivals(train, move, way, count=200, rng=np.random.default_rng(2))
    rests = rest_in_gap(gear, way, np.random.default_rng(2))
    assert rests == pytest.approx(found.load_angle, abs=1e-14)


def test_without_scatter_arrivals_from_one_side_repeat_exactly():
    found = arrivals(
        RUBBING, Move(0.05, 10), Approach.ONE_SIDE, count=30, rng=np.random.default_rng(1)
    )
    assert np.ptp(found.load_angle) == 0
    assert np.all(found.approach == 1)


def test_without_friction_the_load_crosses_the_whole_gap():
    found = arrivals(
        GEARED, Move(0.05, 10), Approach.RANDOM, count=50, rng=np.random.default_rng(1)
    )
    assert found.load_angle == pytest.approx(found.approach * GEARED.gap / 2)
    assert set(found.approach) == {1, -1}


def test_a_load_torque_beyond_friction_takes_every_arrival_to_one_flank():
    pulled = replace(RUBBING, load_torque=-6.0)
    found = arrivals(
        pulled, Move(0.05, 10, 0.05, 0.01), Approach.RANDOM, count=200, rng=np.random.default_rng(1)
    )
    assert found.load_angle == pytest.approx(np.full(200, -RUBBING.gap / 2))
    assert np.all(found.contact == RIGHT)


def test_scatter_of_friction_and_speed_is_the_generator_s():
    move = Move(0.05, 10, speed_scatter=0.02, friction_scatter=0.05)

    def follow(seed):
        rng = np.random.default_rng(seed)
        return arrivals(RUBBING, move, Approach.RANDOM, count=2000, rng=rng).load_angle

    assert np.array_equal(follow(1), follow(1))
    assert not np.array_equal(follow(1), follow(2))
    way = 0.05**2 / 2 * np.array([4.749 / 5.0, 1 / 10.0])
    spread = math.hypot(0.05 * way[0], 0.04 * (way[0] - way[1]))
    one_side = arrivals(RUBBING, move, Approach.ONE_SIDE, count=20000, rng=np.random.default_rng(3))
    assert one_side.load_angle.std() == pytest.approx(spread, rel=0.03)
    assert np.all(np.abs(follow(1)) <= RUBBING.gap / 2)


# --- what is refused ----------------------------------------------------------------------------


def test_every_impossible_number_of_a_train_is_named():
    with pytest.raises(UsageError, match=r"motor_inertia is 0.*gap is -1.*stiffness is nan") as e:
        DriveTrain(0, 1, -1, stiffness=math.nan, load_torque=math.inf)
    assert "load_torque is inf" in str(e.value)


@pytest.mark.parametrize(
    ("change", "drive"),
    [
        ({"viscous": 1.0}, Torque((1.0,), (0.0,))),
        ({"stiffness": 1e4}, Torque((1.0,), (0.0,))),
        ({}, Servo((1.0,), (0.0,), 1.0, 1.0)),
    ],
)
def test_the_closed_form_refuses_what_it_cannot_hold(change, drive):
    with pytest.raises(UsageError, match="no closed form"):
        solve(replace(PAPER, **change), drive, State())


@pytest.mark.parametrize(
    "drive",
    [
        Torque((), ()),
        Torque((1.0, 1.0), (0.0,)),
        Held((-1.0,), (0.0,)),
        Held((1.0,), (math.nan,)),
    ],
)
def test_a_drive_needs_a_value_and_a_duration_for_each_piece(drive):
    for follow in (solve, integrate):
        with pytest.raises(UsageError, match="one positive duration"):
            follow(PAPER, drive, State())


def test_a_start_outside_the_gap_is_refused():
    with pytest.raises(UsageError, match="outside the gap"):
        solve(PAPER, Torque((1.0,), (0.0,)), State(gap_angle=1.0))


@pytest.mark.parametrize(
    ("train", "move", "count"),
    [
        (replace(PAPER, viscous=1.0), Move(1, 1), 1),
        (replace(PAPER, stiffness=1e3), Move(1, 1), 1),
        (PAPER, Move(0, 1), 1),
        (PAPER, Move(1, math.inf), 1),
        (PAPER, Move(1, 1, friction_scatter=0.5), 1),
        (PAPER, Move(1, 1), 0),
    ],
)
def test_arrivals_that_cannot_be_followed_are_refused(train, move, count):
    with pytest.raises(UsageError):
        arrivals(train, move, Approach.RANDOM, count=count, rng=np.random.default_rng(1))


def test_results_are_read_only():
    run = solve(PAPER, Torque((0.02,), (-0.01,)), State.touching(PAPER, RIGHT))
    for values in (run.time, run.load_angle):
        with pytest.raises(ValueError, match="read-only"):
            values[0] = 1.0
    assert all(a <= b for a, b in pairwise(run.time))
