"""What a raw file says was recorded, line by line of small files written here."""

import errno
import io

import numpy as np
import pytest

from scara_iso.base.errors import DataError, NoInputError
from scara_iso.base.quantities import Dimension
from scara_iso.rawfile import History, checksum, encode, read_history, wrong_sizes
from scara_iso.rawfile.integrity import decode_record, read_records


def gauge(**changes):
    return {
        "spec": "X=opto-rs232@COM3", "dialect": "opto-rs232", "line": "4800 7E2",
        "identity": "SN 7", "unit": "", "unit_from": "", "simulated": False,
    } | changes  # fmt: skip


def session(*axes, t=0.0, **changes):
    return {
        "event": "session", "t": t, "wall": None, "schema": "scara-iso/raw/1", "cycles": 3,
        "trigger": "enter", "gauges": {axis: gauge() for axis in axes or ["X"]}, "metadata": {},
    } | changes  # fmt: skip


def stored(cycle, text="0.1", axis="X", unit="mm", at=None):
    at = float(cycle) if at is None else at
    return {
        "event": "stored", "t": at, "wall": None, "cycle": cycle, "axis": axis, "text": text,
        "unit": unit, "at": at,
    }  # fmt: skip


def void(cycle, *axes, reason="slipped"):
    return {
        "event": "void", "t": 9.0, "wall": None, "cycle": cycle, "axes": list(axes or ["X"]),
        "reason": reason,
    }  # fmt: skip


def event(name, **fields):
    return {"event": name, "t": 9.0, "wall": None, **fields}


def taken(*records, chained=True):
    """Return the history of records, None for a damaged line; each names the one before it."""
    history = History("folder/run.raw.jsonl")
    previous = "00000000"
    for line, record in enumerate(records, 1):
        if record is None:
            history.take(line, None)
            continue
        named = {**record, "prev": record.get("prev", previous)} if chained else record
        previous = f"{line:08d}"
        history.take(line, {**named, "crc": previous})
    return history


def faults(*records):
    return [(fault.message, fault.line) for fault in taken(*records).faults]


@pytest.mark.parametrize(
    ("key", "text", "wrong"),
    [
        ("indicator_uncertainty", "0.001", False), ("indicator uncertainty-X", "0.001", False),
        ("indicator_uncertainty", "0", True), ("indicator_uncertainty_Z", "-0.1", True),
        ("indicator_uncertainty", "0.001 mm", True), ("command_X", "-1.5", False),
        ("command_theta", "0", False), ("command_X", "1e3", True), ("command_X", "", True),
        ("operator", "Meier", False),
    ],
)  # fmt: skip
def test_a_size_in_a_head_is_a_plain_number_and_an_uncertainty_positive(key, text, wrong):
    assert wrong_sizes({key: text}) == [key] * wrong


def test_readings_are_kept_by_cycle_in_mm_with_the_coarsest_resolution_sent():
    history = taken(session(), stored(1, "0.125"), stored(3, "1.5"), stored(2, "-2"))
    assert history.readings() == {"X": {1: 0.125, 2: -2.0, 3: 1.5}}
    assert history.columns["X"].resolution == 1.0
    fine = taken(session(), stored(1, "0.125"), stored(2, "0.25"))
    assert fine.columns["X"].resolution == pytest.approx(0.01)
    inches = taken(session(), stored(1, "0.1250", unit="inch"))
    assert inches.readings() == {"X": {1: pytest.approx(3.175)}}
    assert inches.columns["X"].resolution == pytest.approx(0.00254)
    assert inches.columns["X"].unit == "inch"
    assert inches.columns["X"].dimension is Dimension.LENGTH


def test_a_column_takes_a_later_unit_of_the_same_dimension():
    history = taken(session(), stored(1, "1", unit="inch"), stored(2, "1.000", unit="mm"))
    assert history.readings() == {"X": {1: 25.4, 2: 1.0}}
    assert history.columns["X"].unit == "mm"
    assert faults(session(), stored(1), stored(2, unit="deg")) == [("stored: deg after mm", 3)]


@pytest.mark.parametrize(
    ("record", "message"),
    [
        (stored(1, unit="furlong"), "stored: unknown unit 'furlong'"),
        (stored(1, "x" * 60), f"stored: {'x' * 40!r} is not a reading"),
        (stored(0), "stored: cycle 0"),
        (stored(10_000_001), "stored: cycle 10000001"),
        (session(schema="scara-iso/raw/2"), ("session: schema 'scara-iso/raw/2' is not "
         "scara-iso/raw/1")),
    ],
)  # fmt: skip
def test_a_line_that_cannot_be_is_a_fault_with_its_number(record, message):
    assert faults(session(), record) == [(message, 2)]


def test_a_cycle_is_stored_once_and_again_after_it_was_struck_out():
    assert faults(session(), stored(1), stored(1)) == [("stored: stored twice", 3)]
    history = taken(session(), stored(1, "1.0"), void(1), stored(1, "2.0"))
    assert history.faults == []
    assert history.readings() == {"X": {1: 2.0}}
    assert history.troubles == {"voided": 1}


def test_what_is_struck_out_is_that_cycle_of_those_axes_only():
    records = [session("X", "Y")]
    records += [stored(c, f"{c}.0", axis) for c in (1, 2, 3) for axis in "XY"]
    history = taken(*records, void(2, "X"))
    assert history.readings()["X"] == {1: 1.0, 3: 3.0}
    assert history.readings()["Y"] == {1: 1.0, 2: 2.0, 3: 3.0}
    assert list(history.latest) == [(1, "X"), (1, "Y"), (2, "Y"), (3, "X"), (3, "Y")]
    assert history.columns["X"].shown == {1: (1.0, "1.0", "mm"), 3: (3.0, "3.0", "mm")}
    both = taken(*records, void(3, "X", "Y"))
    assert both.troubles == {"voided": 2}
    assert dict(both.run().metadata)["record_01_struck"] == "cycle 3, X 3.0, Y 3.0: slipped"


def test_a_repeated_frame_is_in_doubt_where_the_line_sent_one_twice():
    records = [session(), stored(1, "1.0"), stored(2, "2.0"), stored(3, "2.0"), stored(4, "4.0")]
    again = {**stored(1), "event": "refused", "text": "4.0", "reason": "not asked for"}
    bounced = {**again, "reason": "came within 0.5 s of the one before"}
    head = lambda *more: taken(*records, *more).run().metadata  # noqa: E731
    assert head(again)["record_doubted"] == "X: cycle 3"
    late = (event("timeout", axis="X"), again)
    silent = {**again, "reason": "another gauge is silent"}
    for more in (
        (), ({**again, "text": "9.0"},), (bounced,), (again, void(3), stored(3, "3.0")),
        (silent,), late,
    ):  # fmt: skip
        assert "record_doubted" not in head(*more)
    assert "record_doubted" in head(*late, again)


@pytest.mark.parametrize("coarse", [True, False])
def test_a_dial_that_repeats_by_itself_puts_no_frame_in_doubt(coarse):
    texts = [f"{(k * k) % 3 if coarse else k}.0" for k in range(1, 13)] + ["12.0", "12.0"]
    records = [stored(k, text) for k, text in enumerate(texts, 1)]
    again = {**stored(1), "event": "refused", "text": "12.0", "reason": "not asked for"}
    head = taken(session(cycles=14), *records, again).run().metadata
    assert ("record_doubted" in head) != coarse


def begun(history):
    """Return the axes of the unfinished visit."""
    return sorted(history.present(history.visit))


def test_half_a_visit_is_not_gone_on_with():
    half = [session("X", "Y", trigger="data", poses=["P1", "P2"]), {**stored(1), "pose": "P1"}]
    assert begun(taken(*half)) == ["X"]
    assert begun(taken(session("X", "Y", trigger="data"), stored(1))) == ["X"]


def test_only_the_last_hundred_readings_can_be_struck_out():
    history = taken(session(), *(stored(c) for c in range(1, 103)), void(2))
    assert [fault.line for fault in history.faults] == [104]
    assert next(iter(history.latest)) == (3, "X")


def test_the_first_cycle_that_is_not_complete_is_the_next():
    assert taken(session()).visit == 1
    assert taken(session(), stored(1), stored(2)).visit == 3
    assert taken(session(), stored(1), stored(3)).visit == 2
    two = [session("X", "Y"), stored(1, axis="X"), stored(1, axis="Y"), stored(2, axis="Y")]
    assert taken(*two).visit == 2
    assert taken(*two).present(1) == {"X", "Y"}
    assert taken(*two).present(2) == {"Y"}
    assert taken(*two).present(3) == frozenset()
    assert taken(*two).complete_visits() == [1]


def test_a_recording_is_complete_with_as_many_cycles_as_were_planned():
    readings = [stored(cycle) for cycle in (1, 2, 3)]
    assert not taken(session(cycles=4), *readings).is_complete
    assert taken(session(cycles=3), *readings).is_complete
    assert not taken(session(cycles=2), *readings).is_complete


def test_troubles_are_counted_by_kind_and_other_events_are_none():
    kinds = ["fault", "garbage", "garbage", "timeout", "refused", "in", "out", "begun"]
    assert taken(session(), *map(event, kinds)).troubles == {
        "fault": 1, "garbage": 2, "timeout": 1, "refused": 1
    }  # fmt: skip


def test_a_table_is_left_where_a_session_ended_with_a_whole_cycle():
    two = session("X", "Y")
    assert not taken(two, stored(1, axis="X")).has_table
    assert not taken(two, stored(1, axis="X"), event("end")).has_table
    assert taken(two, stored(1, axis="X"), stored(1, axis="Y"), event("end")).has_table
    gone = [session(), stored(1), event("end"), void(1)]
    assert taken(*gone).has_table
    assert not taken(*gone, event("end")).has_table


@pytest.mark.parametrize("trigger", ["timer:1", "data"])
def test_what_a_crash_left_of_a_cycle_is_cut(trigger):
    half = [
        session("X", "Y", trigger=trigger),
        stored(1, axis="X"), stored(1, axis="Y"), stored(2, axis="Y"),
    ]  # fmt: skip
    assert begun(taken(*half)) == ["Y"]
    assert begun(taken(*half, void(1, "X", "Y"))) == []


def test_times_go_on_over_sessions_and_are_rounded_to_milliseconds():
    history = taken(
        session(wall="2026-01-01T00:00:00"),
        {**stored(1, at=1.23456), "wall": "2026-01-01T00:00:01"},
        session(wall="2026-01-01T00:01:41"),
        {**stored(2, at=2.5), "wall": "2026-01-01T00:01:43"},
    )
    np.testing.assert_allclose(history.run().covariates["time_s"], [1.235, 103.735], atol=1e-9)


def test_where_a_recording_was_resumed_stands_in_the_head_of_the_table():
    first = [session(cycles=4), stored(1), stored(2)]
    assert "record_01_resumed" not in taken(*first).run().metadata
    again = taken(*first, session(cycles=4), stored(3), session(cycles=4), stored(4)).run().metadata
    assert again["record_01_resumed"] == "before cycle 3"
    assert again["record_02_resumed"] == "before cycle 4"


def test_the_run_holds_the_complete_cycles_of_every_axis():
    history = taken(
        session("X", "Theta", cycles=4),
        stored(1, "0.10"), stored(1, "5.0", "Theta", "deg"),
        stored(2, "0.20"),
        stored(3, "0.30"), stored(3, "7.0", "Theta", "deg"),
    )  # fmt: skip
    run = history.run()
    np.testing.assert_array_equal(run.cycle, [1, 3])
    np.testing.assert_array_equal(run.axes["X"].readings, [0.1, 0.3])
    np.testing.assert_array_equal(run.axes["Theta"].readings, [5.0, 7.0])
    assert run.axes["Theta"].dimension is Dimension.ANGLE
    assert run.axes["X"].resolution == pytest.approx(0.01)
    np.testing.assert_array_equal(run.covariates["time_s"], [1.0, 3.0])
    assert run.origin.source == "folder/run.raw.jsonl"
    assert run.origin.understood == "2 cycles recorded"
    assert run.metadata["cycles_planned"] == "4"
    assert run.metadata["axes_recorded"] == "together"


def test_the_head_of_the_table_says_where_the_readings_come_from():
    mm = gauge(unit="mm", unit_from="the indicator", simulated=True)
    history = taken(
        session(
            gauges={"X": gauge(), "Y": mm},
            metadata={"robot": "SCARA", "payload": 2},
            wall="2026-03-04T05:06:07.891011+00:00",
            cycles=1,
        ),
        {**stored(1), "wall": "2026-03-04T05:06:08+00:00"},
        {**stored(1, axis="Y"), "wall": "2026-03-04T05:06:08+00:00"},
        event("timeout"), event("fault"),
    )  # fmt: skip
    assert list(history.run().metadata.items()) == [
        ("recorded", "2026-03-04T05:06:07Z"),
        ("robot", "SCARA"),
        ("payload", "2"),
        ("first_cycle_discarded", "false"),
        ("axes_recorded", "together"),
        (
            "indicator",
            (
                "X opto-rs232 4800 7E2 at SN 7"
                " | Y opto-rs232 4800 7E2 at SN 7; mm as the indicator states"
            ),
        ),
        ("simulated", "Y"),
        ("record_fault", "1"),
        ("record_timeout", "1"),
    ]


def test_one_axis_alone_says_nothing_of_others():
    assert list(taken(session(cycles=1), stored(1)).run().metadata) == [
        "first_cycle_discarded", "indicator"
    ]  # fmt: skip


def test_a_clock_that_was_set_and_doubts_are_said_in_the_head():
    late = "2026-01-01T00:10:00"
    history = taken(
        session(wall="2026-01-01T00:00:00"),
        {**stored(1), "wall": late},
        {**stored(2), "wall": late},
    )
    history.inherit(["first", "second"])
    history.inherit(["first"])
    metadata = history.run().metadata
    assert metadata["record_clock"] == "the clock was set by +598 s during session 1"
    assert history.doubts == ("first", "second")
    assert next(iter(metadata)) == "doubts"
    assert all(text in metadata["doubts"] for text in ("first", "second"))


def test_a_later_session_adds_to_the_first_one():
    first = session(
        metadata={"robot": "A", "operator": "one"}, excel_locale="de", trigger="timer:1"
    )
    later = session(
        gauges={"X": gauge(identity="SN 8", simulated=True), "Y": gauge()},
        metadata={"operator": "two"}, cycles=9, trigger="data",
    )  # fmt: skip
    header = taken(first, later, later).header
    assert header["metadata"] == {"robot": "A", "operator": "two"}
    assert (header["cycles"], header["excel_locale"], header["trigger"]) == (9, "de", "timer:1")
    assert header["gauges"]["X"]["identity"] == "SN 7, then SN 8"
    assert header["gauges"]["X"]["simulated"] is True
    assert header["gauges"]["Y"] == gauge()
    assert first["gauges"]["X"]["identity"] == "SN 7"
    other = taken(first, session(excel_locale="en"), session()).header
    assert other["excel_locale"] == "en"
    assert other["gauges"]["X"]["simulated"] is False


def test_the_axes_are_those_of_the_first_session():
    history = taken(session(), stored(1), session("X", "Y"), stored(1, axis="Y"))
    assert list(history.columns) == ["X"]
    assert history.readings() == {"X": {1: 0.1}}
    assert [fault.line for fault in history.faults] == [4]


@pytest.mark.parametrize("key", ["cycles", "metadata", "trigger", "gauges", "schema"])
def test_a_header_that_lacks_what_the_table_needs_is_a_fault(key):
    header = {k: v for k, v in session().items() if k != key}
    assert faults(header) == [(f"session: {key!r}", 1)]


@pytest.mark.parametrize(
    "key", ["spec", "dialect", "line", "identity", "unit", "unit_from", "simulated"]
)
def test_a_gauge_that_lacks_what_the_table_needs_is_a_fault(key):
    lacking = {k: v for k, v in gauge().items() if k != key}
    assert faults(session(gauges={"X": gauge(), "Y": lacking})) == [(f"session: {key!r}", 1)]


def test_doubts_of_an_earlier_session_go_on():
    assert taken(session(doubts=["torn page", 7])).doubts == ("torn page", "7")
    assert taken(session()).doubts == ()


BROKEN = "run.raw.jsonl: lines were changed or taken away before line "


def test_each_line_names_the_one_before_it():
    assert taken(session(), stored(1), stored(2)).doubts == ()
    changed = taken(session(), {**stored(1), "prev": "ffffffff"}, stored(2))
    assert changed.doubts == (BROKEN + "2",)
    assert changed.previous == "00000003"
    unnamed = taken(session(), stored(1))
    unnamed.take(3, {**stored(2), "crc": "00000003"})
    assert unnamed.doubts == (BROKEN + "3",)


def test_ten_places_are_named_and_then_no_more():
    wrong = [{**stored(c), "prev": "ffffffff"} for c in range(1, 12)]
    ten = ", ".join(map(str, range(2, 12)))
    assert taken(session(), *wrong[:10]).doubts == (BROKEN + ten,)
    assert taken(session(), *wrong).doubts == (f"{BROKEN}{ten}, ..",)


def test_lines_of_older_versions_name_none_and_a_crash_tears_only_before_a_session():
    old = [session(), stored(1), None]
    assert taken(*old, session(), stored(2), chained=False).doubts == ()
    assert taken(*old, session(), stored(2), chained=False).damaged == [3]
    assert taken(*old, stored(2), chained=False).doubts == (BROKEN + "4",)
    assert taken(*old, session(), None, stored(2), chained=False).doubts == (BROKEN + "6",)
    assert taken(session(), None, session(), stored(1), stored(2), chained=False).doubts == ()


def test_a_changed_last_line_is_a_doubt_and_a_torn_one_is_none():
    """No next line names the last one: a whole line that does not fit its checksum was changed."""
    torn, changed = taken(session(), stored(1), None), taken(session(), stored(1))
    changed.take(3, {})
    assert (torn.doubts, torn.damaged) == ((), [3])
    assert (changed.doubts, changed.damaged) == ((BROKEN + "4",), [3])
    changed.take(4, None)
    assert changed.doubts == ()


def test_a_recording_that_has_no_gauge_has_no_cycle():
    history = taken(session(gauges={}))
    assert history.complete_visits() == []
    assert (history.visit, history.readings()) == (1, {})


def test_what_the_user_states_of_an_indicator_goes_to_its_axis():
    """An uncertainty without an axis is a length: an axis in degrees has none of it."""
    metadata = {"indicator_uncertainty": "0.002", "command_Theta": "45.5"}
    run = taken(
        session("X", "Theta", metadata=metadata, cycles=1),
        stored(1), stored(1, "45.1", "Theta", "deg"),
    ).run()  # fmt: skip
    assert (run.axes["X"].uncertainty, run.axes["X"].command) == (0.002, None)
    assert (run.axes["Theta"].uncertainty, run.axes["Theta"].command) == (None, 45.5)


def test_a_file_that_is_no_recording_says_so_with_at_most_ten_lines():
    with pytest.raises(DataError) as nothing:
        History("x").run()
    assert [(f.message, f.line) for f in nothing.value.faults] == [("no session was recorded", 1)]
    torn = History("x")
    torn.take(1, None)
    with pytest.raises(DataError) as copied:
        torn.run()
    assert "line ends" in copied.value.faults[0].message
    with pytest.raises(DataError) as faulty:
        taken(session(), *[stored(0)] * 12).check()
    assert [fault.line for fault in faulty.value.faults] == list(range(2, 12))
    with pytest.raises(DataError) as alone:
        taken(stored(1)).check()
    assert [fault.line for fault in alone.value.faults] == [1]
    with pytest.raises(DataError, match="no cycle is complete"):
        taken(session()).run()
    taken(session()).check()


def test_a_file_is_read_line_by_line_and_damage_is_noted(tmp_path):
    path = tmp_path / "run.raw.jsonl"
    lines = [encode(r) for r in (session(), stored(1, "0.5"), stored(2, "0.7"))]
    assert all(map(decode_record, lines))
    path.write_bytes(lines[0] + lines[1] + b"torn\n" + lines[2])
    history = read_history(path)
    assert history.damaged == [3]
    assert history.readings() == {"X": {1: 0.5, 2: 0.7}}
    assert history.source == str(path)


def test_a_whole_file_whose_lines_name_each_other_raises_no_doubt(tmp_path):
    path, previous = tmp_path / "run.raw.jsonl", "00000000"
    for record in (session(), stored(1), stored(2)):
        line = encode({**record, "prev": previous})
        previous = checksum(line)
        path.write_bytes((path.read_bytes() if path.exists() else b"") + line)
    history = read_history(path)
    assert history.doubts == ()
    assert history.previous == previous


def test_a_disk_that_fails_while_it_is_read_is_no_input(tmp_path, monkeypatch):
    class Failing(io.BytesIO):
        def readline(self, *_):
            raise OSError(errno.EIO, "the disk has gone")

    monkeypatch.setattr("scara_iso.rawfile.integrity.open_file", lambda _: Failing())
    with pytest.raises(NoInputError, match="cannot be read: the disk has gone"):
        list(read_records(tmp_path / "a.raw.jsonl"))


def test_the_gauge_that_read_is_named_where_it_is_another_than_before():
    def head(*sessions):
        records = []
        for cycle, gauges in enumerate(sessions, 1):
            records += [session(gauges={"X": gauge(**gauges)}), stored(cycle)]
        said = taken(*records).run().metadata
        return [text for key, text in said.items() if key.endswith("_changed")]

    one, other = {"spec": "X=mux?channel=1@COM3"}, {"spec": "X=mux?channel=2&unit=mm@COM3"}
    assert head(one, one) == []
    assert head(one, other, one, one) == [
        "X was read by opto-rs232 channel 1 at SN 7, then by opto-rs232 channel 2 at SN 7",
        "X was read by opto-rs232 channel 2 at SN 7, then by opto-rs232 channel 1 at SN 7",
    ]
    seeds = ({"identity": f"sim:?seed={k} (simulated)", "simulated": True} for k in (1, 2))
    assert head(*seeds) == []


def test_a_gauge_that_read_nothing_changes_nothing():
    away = session(gauges={"X": gauge(identity="SN 8")})
    history = taken(session(), stored(1), away, session(), stored(2))
    assert not [key for key in history.run().metadata if key.endswith("_changed")]
