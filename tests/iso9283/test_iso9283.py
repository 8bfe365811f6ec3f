"""The cycle rule: which rows count, and what is refused with every fault named."""

from dataclasses import replace

import numpy as np
import pytest

from scara_iso import read_table
from scara_iso.base.errors import DataError, UsageError
from scara_iso.iso9283.core.cycles import Counting, used_cycles
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
        (range(20), "true", {"cycles": 20}, (), 20),
        (range(2, 22), "true", {"cycles": 20}, (), 20),
        (range(1, 31), None, {"cycles": 30}, (1,), 29),
        (range(1, 101), None, {"cycles": 100}, (1,), 99),
    ],
)
def test_which_rows_count(numbers, stated, options, discarded, used):
    chosen = used_cycles(run_of(numbers, stated=stated), Counting(**options))
    assert chosen.read == len(numbers)
    assert chosen.discarded == discarded
    assert chosen.used == used
    assert [rows.tolist() for rows in chosen.rows] == [list(range(len(discarded), len(numbers)))]


def refused(*args, options=None, **kwargs):
    with pytest.raises(DataError) as caught:
        used_cycles(run_of(*args, **kwargs), Counting(**(options or {})))
    assert caught.value.remedy
    return caught.value


def test_thirty_rows_of_which_nobody_says_whether_the_first_is_among_them():
    error = refused(range(1, 31))
    (fault,) = error.faults
    assert "(a) the first of 31 was already removed, (b) 30 were run" in fault.message
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


def test_rows_in_another_order_are_no_missing_cycles():
    error = refused([*range(1, 12), 13, 12, *range(14, 32)])
    assert [(fault.line, fault.message) for fault in error.faults] == [
        (14, "cycle 12 comes after cycle 13: the order goes back"),
    ]
    assert "sort the rows" in error.remedy


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
        used_cycles(run_of(range(1, 32)), Counting(cycles=cycles))


@pytest.mark.parametrize(
    ("numbers", "options", "discarded", "missing", "used"),
    [
        ([*range(1, 10), *range(11, 32)], {}, (1,), ((10, 10),), 29),
        ([*range(1, 10), *range(13, 20), *range(21, 32)], {}, (1,), ((10, 12), (20, 20)), 26),
        (range(3, 32), {}, (), ((2, 2),), 29),  # the first and one more are missing
        (range(6, 32), {}, (), ((2, 5),), 26),
        ([*range(4, 9), *range(10, 21)], {"cycles": 20}, (), ((2, 3), (9, 9)), 16),
        ([*range(2, 10), *range(11, 32)], {}, (), ((10, 10),), 29),
        ([*range(10), *range(11, 31)], {}, (0,), ((10, 10),), 29),
    ],
)
def test_with_gaps_allowed_the_rest_counts_and_the_gap_is_listed(
    numbers, options, discarded, missing, used
):
    chosen = used_cycles(run_of(numbers), Counting(allow_gaps=True, **options))
    assert (chosen.discarded, chosen.missing, chosen.used) == (discarded, (missing,), used)
    assert chosen.read == len(list(numbers))
    assert not chosen.all_count


@pytest.mark.parametrize(
    ("numbers", "options"),
    [(range(3, 31), {}), (range(3, 33), {}), (range(3, 20), {"cycles": 20}), (range(1, 30), {})],
)
def test_gaps_at_the_end_are_a_test_that_was_cut_short(numbers, options):
    error = refused(numbers, options={"allow_gaps": True, **options})
    assert "are needed" in error.faults[0].message


def test_one_missing_cycle_is_named_alone_in_a_long_test_too():
    error = refused([*range(1, 1000), *range(1001, 1501)], options={"cycles": 1500})
    assert [fault.message for fault in error.faults] == ["cycle 1000 is missing"]


def test_a_cycle_that_is_missing_is_a_fault_unless_gaps_are_allowed():
    error = refused([*range(1, 10), *range(11, 15), *range(18, 32)])
    assert [fault.message for fault in error.faults] == [
        "cycle 10 is missing", "cycles 15 to 17 are missing"
    ]  # fmt: skip
    assert [fault.line for fault in error.faults] == [11, 15]
    assert "`allow_gaps=True`" in error.remedy


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        ([*range(1, 11), *range(10, 31)], "cycle 10 is there twice"),
        ([*range(1, 11), *range(9, 31)], "cycle 9 comes after cycle 10: the order goes back"),
    ],
)
@pytest.mark.parametrize("allow_gaps", [False, True])
def test_a_repeat_or_an_order_that_goes_back_is_never_allowed(numbers, message, allow_gaps):
    error = refused(numbers, options={"allow_gaps": allow_gaps})
    assert [fault.message for fault in error.faults] == [message]
    twice = "twice" in message
    assert ("take one row a visit" in error.remedy) == twice
    assert ("`cycles=N`" in error.remedy) == (not twice)


@pytest.mark.parametrize(
    ("numbers", "options"),
    [
        (range(1, 31), {}), (range(30), {}), (range(1, 32), {}), (range(31), {}),
        (range(1, 21), {"cycles": 20}), (range(20), {"cycles": 20}),
    ],
)  # fmt: skip
def test_where_every_cycle_counts_none_is_discarded(numbers, options):
    chosen = used_cycles(run_of(numbers), Counting(all_count=True, **options))
    assert (chosen.discarded, chosen.used, chosen.read) == ((), len(numbers), len(numbers))
    assert chosen.all_count


@pytest.mark.parametrize(
    ("numbers", "options", "needed"),
    [
        (range(2, 32), {}, 30), (range(1, 33), {}, 30), (range(1, 30), {}, 30),
        (range(1, 32), {"cycles": 30}, 30), (range(1, 31), {"cycles": 31}, 31),
        (range(2, 22), {"cycles": 20}, 20),
    ],
)  # fmt: skip
def test_another_number_where_every_cycle_counts_is_refused(numbers, options, needed):
    error = refused(numbers, options={"all_count": True, **options})
    assert f"where {needed} from 1 are needed, of which all count" in error.faults[0].message


def stated(numbers, **metadata):
    numbers = np.array(list(numbers))
    axis = Axis("X", np.linspace(0, 1, len(numbers)))
    return Run(cycle=numbers, axes={"X": axis}, metadata=metadata)


def test_the_table_may_say_that_its_first_cycle_counts():
    assert used_cycles(stated(range(1, 31), first_cycle=" Counts ")).used == 30
    with pytest.raises(DataError, match="first_cycle is 'maybe'"):
        used_cycles(stated(range(1, 31), first_cycle="maybe"))
    with pytest.raises(DataError, match="every cycle counts, and the first is discarded"):
        used_cycles(stated(range(1, 31), first_cycle="counts", first_cycle_discarded="true"))
    with pytest.raises(DataError, match="first_cycle_discarded is 'maybe'"):
        used_cycles(stated(range(1, 31), first_cycle_discarded="maybe"))
    with pytest.raises(DataError, match="the option says that it is discarded"):
        used_cycles(
            stated(range(1, 31), first_cycle_discarded="no"), Counting(first_cycle_discarded=True)
        )
    with pytest.raises(UsageError, match="every cycle counts, or the first is discarded"):
        used_cycles(stated(range(1, 31)), Counting(all_count=True, first_cycle_discarded=True))


def test_a_recording_that_was_cut_short_is_gone_on_with():
    with pytest.raises(DataError) as short:
        used_cycles(stated(range(1, 13), cycles_planned="31"))
    assert "`resume=True`" in short.value.remedy
    assert "`cycles=12`" in short.value.remedy


@pytest.mark.parametrize(("read", "advised"), [(12, True), (1, False)])
def test_a_number_of_cycles_is_advised_only_where_it_is_taken(read, advised):
    run = replace(run_of(range(1, read + 1)), metadata={"cycles_planned": "31"})
    with pytest.raises(DataError) as refused:
        used_cycles(run)
    assert (f"`cycles={read}`" in refused.value.remedy) is advised


@pytest.mark.parametrize(
    ("numbers", "options", "open_"),
    [
        (range(1, 31), {}, True), (range(30), {}, True), (range(2, 33), {}, False),
        (range(1, 30), {}, False), (range(1, 20), {"cycles": 20}, True),
        (range(3, 33), {}, False),
    ],
)  # fmt: skip
def test_only_one_row_less_from_the_start_leaves_open_whether_the_first_is_there(
    numbers, options, open_
):
    error = refused(numbers, options=options)
    assert ("Which applies?" in error.faults[0].message) == open_
    wanted = options.get("cycles", 31)
    assert (f"(c) `cycles={wanted - 1}`" in error.remedy) == open_
    assert ("(b) `all_count=True`" in error.remedy) == open_


def test_a_first_cycle_that_is_said_to_be_gone_leaves_one_row_less():
    error = refused(range(1, 30), stated="true")
    (fault,) = error.faults
    assert fault.message == (
        "29 cycles, numbered 1 to 29, where 30 are needed because the first is stated as discarded"
    )


def test_visits_that_are_written_several_times_are_no_readings_of_their_own():
    numbers = np.arange(1, 32)
    values = np.repeat(np.linspace(0, 1, 16) ** 2, 2)[:31]
    axes = {name: Axis(name, values + k) for k, name in enumerate("XYZ")}
    with pytest.raises(DataError) as twice:
        used_cycles(Run(cycle=numbers, axes=axes))
    assert "they are copies, not new readings" in twice.value.faults[0].message
    assert "take one row a visit" in twice.value.remedy


def test_poses_of_unequal_length_have_their_own_rows():
    numbers = [*range(1, 32), *range(1, 10), *range(11, 32), *range(1, 32)]
    pose = ["A"] * 31 + ["B"] * 30 + ["C"] * 31
    chosen = used_cycles(run_of(numbers, pose=pose), Counting(allow_gaps=True))
    assert chosen.missing == ((), ((10, 10),), ())
    assert (chosen.used, chosen.read) == (29, 30)
    assert chosen.poses == ("A", "B", "C")
    assert [rows.shape for rows in chosen.rows] == [(30,), (29,), (30,)]
    np.testing.assert_array_equal(chosen.rows[2], np.arange(62, 92))


@pytest.mark.parametrize(("repeats", "refused_"), [(10, False), (11, True)])
def test_a_quarter_of_repeated_rows_is_let_pass_and_more_is_not(repeats, refused_):
    """With 40 rows a repeat of every axis is no chance; a quarter of them still counts."""
    values = np.random.default_rng(1).normal(size=(3, 40))
    for k in range(repeats):
        values[:, 3 * k + 3] = values[:, 3 * k + 2]
    axes = {name: Axis(name, one) for name, one in zip("XYZ", values, strict=True)}
    run = Run(cycle=np.arange(1, 41), axes=axes)
    if not refused_:
        assert used_cycles(run, Counting(cycles=40)).used == 39
        return
    with pytest.raises(DataError) as written:
        used_cycles(run, Counting(cycles=40))
    assert "11 of 40 rows repeat" in written.value.faults[0].message


@pytest.mark.parametrize("cycles", [31, 16])
def test_sides_by_turns_are_to_be_numbers(cycles):
    rows = "".join(f"{k},0.5{k:02},{'+x' if k % 2 else '-x'}\n" for k in range(1, 32))
    run = read_table(f"# unit: mm\ncycle,X,approach\n{rows}".encode())
    with pytest.raises(DataError) as refused:
        used_cycles(run, Counting(cycles=cycles))
    assert "write +1 and -1 in the column approach" in refused.value.remedy


def test_a_second_run_below_the_first_is_told_what_to_do_and_no_number_of_cycles():
    cycle = np.array([*range(1, 32), *range(1, 32)])
    run = Run(cycle, {"X": Axis("X", np.arange(62) / 1000)})
    with pytest.raises(DataError) as refused:
        used_cycles(run)
    assert "cycles=" not in refused.value.remedy
    assert "a table of its own" in refused.value.remedy


@pytest.mark.parametrize(("lines", "count"), [(False, 1), (True, 30)])
def test_an_order_that_goes_back_all_along_is_one_fault_where_no_line_tells_them_apart(
    lines, count
):
    with pytest.raises(DataError) as error:
        used_cycles(run_of(range(31, 0, -1), lines=lines), Counting())
    said = [fault.message for fault in error.value.faults]
    assert said[0].startswith("cycle 30 comes after cycle 31: the order goes back")
    assert len(said) == count
    assert said[0].endswith("(30 times)") is not lines
