"""The cycle rule: which rows count, and what is refused with every fault named."""

import numpy as np
import pytest

from scara_iso.errors import DataError, UsageError
from scara_iso.iso9283.cycles import used_cycles
from scara_iso.run import Axis, Run


def run_of(numbers, *, pose=None, stated=None, lines=True):
    numbers = np.array(list(numbers))
    return Run(
        cycle=numbers,
        axes={"X": Axis("X", np.linspace(0, 1, len(numbers)))},
        pose=None if pose is None else np.array(pose),
        metadata={} if stated is None else {"first_cycle_discarded": stated},
        lines=np.arange(len(numbers)) + 2 if lines else None,
    )


@pytest.mark.parametrize(
    ("numbers", "stated", "options", "discarded", "used"),
    [
        (range(1, 32), None, {}, (1,), 30),
        (range(31), None, {}, (0,), 30),
        (range(1, 32), "false", {}, (1,), 30),
        (range(2, 32), None, {}, (), 30),
        (range(1, 31), "true", {}, (), 30),
        (range(30), "yes", {}, (), 30),
        (range(1, 31), None, {"first_cycle_discarded": True}, (), 30),
        (range(1, 31), "true", {"first_cycle_discarded": True}, (), 30),
        (range(1, 21), None, {"cycles": 20}, (1,), 19),
        (range(2, 21), None, {"cycles": 20}, (), 19),
        (range(1, 20), "true", {"cycles": 20}, (), 19),
        (range(1, 21), "true", {"cycles": 20}, (), 20),
        (range(1, 31), None, {"cycles": 30}, (1,), 29),
        (range(1, 101), None, {"cycles": 100}, (1,), 99),
    ],
)
def test_which_rows_count(numbers, stated, options, discarded, used):
    chosen = used_cycles(run_of(numbers, stated=stated), **options)
    assert chosen.read == len(numbers)
    assert chosen.discarded == discarded
    assert chosen.used == used
    assert [rows.tolist() for rows in chosen.rows] == [list(range(len(discarded), len(numbers)))]


def refused(*args, options=None, **kwargs):
    with pytest.raises(DataError) as caught:
        used_cycles(run_of(*args, **kwargs), **(options or {}))
    return caught.value


def test_thirty_rows_of_which_nobody_says_whether_the_first_is_among_them():
    error = refused(range(1, 31))
    (fault,) = error.faults
    assert "discarded before, and all 30 count" in fault.message
    assert "still among them, and one is missing" in fault.message
    assert "`first_cycle_discarded=True`" in error.remedy


def test_every_numbering_fault_is_listed_with_its_line():
    numbers = [1, 2, 2, 4, 5, 9, 8, *range(9, 32)]
    error = refused(numbers)
    assert [(fault.line, fault.message) for fault in error.faults] == [
        (4, "cycle 2 is there twice"),
        (5, "cycle 3 is missing"),
        (7, "cycles 6 to 8 are missing"),
        (8, "cycle 8 comes after cycle 9: the order goes back"),
    ]


@pytest.mark.parametrize("count", [1, 2, 28, 29, 32, 62])
def test_another_number_of_cycles_is_refused_and_names_the_option(count):
    error = refused(range(1, count + 1))
    assert f"{count} cycles" in error.faults[0].message
    assert "`cycles=N`" in error.remedy


@pytest.mark.parametrize(
    ("numbers", "stated", "options"),
    [
        (range(1, 32), "true", {}),
        (range(1, 32), None, {"first_cycle_discarded": True}),
        (range(2, 32), "false", {}),
        (range(3, 33), None, {}),
        (range(2, 33), None, {}),
        (range(1, 31), "false", {}),
        (range(1, 32), "false", {"first_cycle_discarded": True}),
        (range(1, 32), "perhaps", {}),
        (range(1, 32), None, {"cycles": 20}),
    ],
)
def test_statements_that_contradict_the_numbers_are_refused(numbers, stated, options):
    refused(numbers, stated=stated, options=options)


def test_faults_of_all_poses_are_listed_and_named():
    pose = ["P1"] * 31 + ["P2"] * 30
    numbers = [*range(1, 32), *range(1, 15), *range(16, 32)]
    error = refused(numbers, pose=pose)
    assert [fault.message for fault in error.faults] == ["pose P2: cycle 15 is missing"]


def test_poses_may_be_interleaved():
    numbers = np.repeat(np.arange(1, 32), 2)
    chosen = used_cycles(run_of(numbers, pose=["P2", "P1"] * 31))
    assert chosen.poses == ("P2", "P1")
    assert chosen.rows[0].tolist() == list(range(2, 62, 2))
    assert chosen.rows[1].tolist() == list(range(3, 62, 2))


def test_poses_that_disagree_about_their_first_cycle_are_refused():
    pose = ["P1"] * 31 + ["P2"] * 30
    error = refused([*range(1, 32), *range(2, 32)], pose=pose)
    assert "some poses" in error.what


def test_a_run_without_line_numbers_is_refused_without_them():
    error = refused([1, 3], lines=False)
    assert error.faults[0].line is None


def test_poses_of_different_length_are_refused():
    pose = ["P1"] * 31 + ["P2"] * 30
    numbers = [*range(1, 32), *range(2, 32)]
    error = refused(numbers, pose=pose, options={"cycles": 31, "first_cycle_discarded": True})
    assert "some poses" in error.what


def test_the_first_cycles_of_poses_numbered_apart():
    chosen = used_cycles(run_of([*range(31), *range(1, 32)], pose=["P1"] * 31 + ["P2"] * 31))
    assert chosen.discarded == (0, 1)


@pytest.mark.parametrize("cycles", [1, 0, -5])
def test_a_number_of_cycles_that_is_none(cycles):
    with pytest.raises(UsageError, match=f"{cycles} cycles"):
        used_cycles(run_of(range(1, 32)), cycles=cycles)
