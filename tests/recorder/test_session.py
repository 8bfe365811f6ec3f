"""Sessions on scripted instruments that answer late, twice, wrong or not at all."""

import json
import math
from decimal import Decimal

import pytest
from bench import Orders, Script, kept, run_session, stored

from scara_iso import read_table
from scara_iso.base.errors import InstrumentError, UsageError
from scara_iso.base.published import to_json
from scara_iso.recorder import (
    CycleDone,
    Note,
    Noted,
    Noticed,
    Pause,
    Problem,
    Quit,
    Refused,
    Take,
    Void,
    Voided,
)
from scara_iso.recorder.ports.port import StreamClock

OPTO = "X=opto-rs232?unit=mm@script"
MUX_Y = "Y=mitutoyo-mux?unit=mm@script2"


def frame(value: str) -> bytes:
    return b"%b\r" % f"{Decimal(value):+08.3f}".encode()


def answers(*values, delay=0.02):
    """Answer the k-th request with the k-th of ``values``: text, None (silence), or pairs."""

    def answer(k):
        value = values[k] if k < len(values) else None
        match value:
            case None:
                return []
            case str():
                return [(delay, frame(value))]
        return value

    return answer


def script(*values, **options):
    return lambda clock: Script(clock, answer=answers(*values), **options)


def refusals(said):
    return [(s.text, s.reason) for s in said if isinstance(s, Refused)]


def problems(said):
    return [(s.axis, s.event) for s in said if isinstance(s, Problem)]


def test_asks_stores_and_writes_the_table(tmp_path, monkeypatch):
    said = run_session(
        tmp_path, [OPTO], ports={"X": script("0.101", "0.102", "0.103")},
        monkeypatch=monkeypatch, metadata={"robot": "FUM SCARA"},
    )  # fmt: skip
    assert stored(said) == [(1, "0.101"), (2, "0.102"), (3, "0.103")]
    run = read_table(tmp_path / "run.csv")
    assert run.axes["X"].readings.tolist() == [0.101, 0.102, 0.103]
    assert run.axes["X"].resolution == 0.001
    assert run.covariates["time_s"].tolist() == [0.02, 1.02, 2.02]
    assert run.metadata["robot"] == "FUM SCARA"
    assert [s.discarded for s in said if isinstance(s, CycleDone)] == [True, False, False]


def test_stored_line_is_exactly_that_of_the_interface(tmp_path, monkeypatch):
    said = run_session(
        tmp_path, [OPTO], ports={"X": script("0.123")}, cycles=1, monkeypatch=monkeypatch
    )
    lines = [to_json(s) for s in said]
    assert {"event": "stored", "cycle": 1, "axis": "X", "value": 0.123} in lines
    assert all(json.loads(json.dumps(line, allow_nan=False)) for line in lines)


@pytest.mark.parametrize("delay", [1.1, 1.5, 1.9])
def test_a_late_answer_is_never_taken_for_the_next(tmp_path, monkeypatch, delay):
    late = [(delay, frame("9.999"))]
    said = run_session(
        tmp_path, [OPTO], ports={"X": script("0.101", late, "0.102", "0.103")},
        monkeypatch=monkeypatch,
    )  # fmt: skip
    assert stored(said) == [(1, "0.101"), (2, "0.102"), (3, "0.103")]
    assert [text for text, _ in refusals(said)] == ["9.999"]
    assert problems(said) == [("X", "timeout")]


@pytest.mark.parametrize("delay", [2.01, 2.3, 2.9, 3.5, 4.9])
def test_an_answer_far_too_late_is_refused_and_its_debt_paid(tmp_path, monkeypatch, delay):
    late = [(delay, frame("9.999"))]
    said = run_session(
        tmp_path, [OPTO], ports={"X": script(late, "0.101", "0.102", "0.103")},
        monkeypatch=monkeypatch,
    )  # fmt: skip
    assert stored(said) == [(1, "0.101"), (2, "0.102"), (3, "0.103")]
    assert [text for text, _ in refusals(said)] == ["9.999"]


@pytest.mark.parametrize("delay", [1.2, 2.5, 3.7, 4.6])
def test_an_instrument_that_falls_behind_never_answers_for_another_cycle(
    tmp_path, monkeypatch, delay
):
    # The arm stands at pose k from second k on; each answer shows the pose of its own request.
    class Slow(Script):
        def write(self, data):
            if data == b"?\r":
                pose, wait = int(self._clock.now()), delay if len(self.requests) > 1 else 0.02
                self.requests.append(data)
                self._waiting.append((self._clock.now() + wait, frame(f"{pose / 100}")))
                self._waiting.sort()

    with pytest.raises(InstrumentError):
        run_session(tmp_path, [OPTO], ports={"X": Slow}, monkeypatch=monkeypatch, cycles=9)
    assert stored(run_session.said) == [(1, "0.010"), (2, "0.020")]


@pytest.mark.parametrize("delay", [1.001, 1.01, 1.019, 1.021, 1.03])
def test_a_doubled_frame_that_comes_after_the_next_request_is_not_its_answer(
    tmp_path, monkeypatch, delay
):
    twice = [(0.02, frame("0.101")), (delay, frame("0.101"))]
    said = run_session(
        tmp_path, [OPTO], ports={"X": script(twice, "0.102", "0.103", "0.104")},
        monkeypatch=monkeypatch,
    )  # fmt: skip
    assert stored(said)[:2] in ([(1, "0.101"), (2, "0.102")], [(1, "0.101"), (2, "0.103")])


def test_a_damaged_answer_is_an_answer_and_is_asked_again_at_once(tmp_path, monkeypatch):
    damaged = [(0.02, b"+000.1x1\r")]
    said = run_session(
        tmp_path, [OPTO], ports={"X": script(damaged, "0.101", "0.102", "0.103")},
        monkeypatch=monkeypatch,
    )  # fmt: skip
    assert stored(said) == [(1, "0.101"), (2, "0.102"), (3, "0.103")]
    assert read_table(tmp_path / "run.csv").covariates["time_s"][0] < 1.5


def test_a_line_that_is_never_quiet_gives_no_reading(tmp_path, monkeypatch):
    noise = [(0.1 * k, b"#") for k in range(400)]
    with pytest.raises(InstrumentError):
        run_session(
            tmp_path, [OPTO], monkeypatch=monkeypatch,
            ports={"X": lambda c: Script(c, answer=answers(), pushes=noise, shows=None)},
        )  # fmt: skip
    assert list(tmp_path.iterdir()) == []


def test_a_second_answer_is_refused(tmp_path, monkeypatch):
    twice = [(0.02, frame("0.101") + frame("0.101")), (0.05, frame("0.101"))]
    said = run_session(
        tmp_path, [OPTO], ports={"X": script(twice, "0.102", "0.103")}, monkeypatch=monkeypatch
    )
    assert stored(said) == [(1, "0.101"), (2, "0.102"), (3, "0.103")]
    assert [text for text, _ in refusals(said)] == ["0.101", "0.101"]


def test_an_error_frame_is_asked_again_and_never_stored(tmp_path, monkeypatch):
    error = [(0.02, b"911\r")]
    value = [(0.02, b"01A+0000.500\r")]
    said = run_session(
        tmp_path, ["X=mitutoyo-mux?unit=mm@script"],
        ports={"X": lambda c: Script(c, answer=answers(value, error, value, value))},
        monkeypatch=monkeypatch,
    )  # fmt: skip
    assert stored(said) == [(1, "0.500"), (2, "0.500"), (3, "0.500")]
    assert problems(said) == [("X", "fault")]


def test_half_a_frame_is_dropped_and_never_parsed(tmp_path, monkeypatch):
    half = [(0.02, b"+012.")]
    said = run_session(
        tmp_path, [OPTO], ports={"X": script(half, "0.101", "0.102", "0.103")},
        monkeypatch=monkeypatch,
    )  # fmt: skip
    assert stored(said) == [(1, "0.101"), (2, "0.102"), (3, "0.103")]
    assert set(problems(said)) == {("X", "timeout"), ("X", "garbage")}


def test_silence_ends_a_timed_session_and_keeps_what_is_stored(tmp_path, monkeypatch):
    with pytest.raises(InstrumentError, match="cycle 2") as ended:
        run_session(tmp_path, [OPTO], ports={"X": script("0.101")}, monkeypatch=monkeypatch)
    assert "then continue with `resume=True`" in ended.value.remedy
    assert kept(tmp_path) == {1: 0.101}
    assert read_table(tmp_path / "run.csv").cycle.tolist() == [1]


def test_silence_from_the_start_leaves_nothing_behind(tmp_path, monkeypatch):
    with pytest.raises(InstrumentError) as ended:
        run_session(tmp_path, [OPTO], ports={"X": script()}, monkeypatch=monkeypatch)
    assert "begin again: no reading was stored" in ended.value.remedy
    assert "resume" not in ended.value.remedy
    assert list(tmp_path.iterdir()) == []


def test_a_lost_port_keeps_what_is_stored(tmp_path, monkeypatch):
    with pytest.raises(InstrumentError, match="lost"):
        run_session(
            tmp_path, [OPTO], ports={"X": script("0.101", "0.102", lost_at=1.5)},
            monkeypatch=monkeypatch,
        )  # fmt: skip
    assert read_table(tmp_path / "run.csv").axes["X"].readings.tolist() == [0.101, 0.102]


def test_both_gauges_of_a_cycle_or_none(tmp_path, monkeypatch):
    y = [[(0.02, b"01A+0000.%d\r" % n)] for n in (501, 502, 503, 504)]
    said = run_session(
        tmp_path, [OPTO, MUX_Y],
        ports={"X": script("0.101", None, "0.102", "0.103"),
               "Y": lambda c: Script(c, answer=answers(*y))},
        monkeypatch=monkeypatch,
    )  # fmt: skip
    assert stored(said) == [(1, "0.101"), (2, "0.102"), (3, "0.103")]
    assert stored(said, "Y") == [(1, "0.501"), (2, "0.503"), (3, "0.504")]


def test_stable_waits_for_equal_readings_and_stores_the_last(tmp_path, monkeypatch):
    series = ["0.150", "0.103", "0.102", "0.103", "0.101", "0.101", "0.101"]
    said = run_session(
        tmp_path, [OPTO], ports={"X": script(*series)}, cycles=1, stable=3,
        monkeypatch=monkeypatch,
    )  # fmt: skip
    assert stored(said) == [(1, "0.101")]


def test_stable_closes_a_flipped_bit_in_the_last_digit(tmp_path, monkeypatch):
    """The characters 2 and 3 differ in one bit, their numbers in one count."""
    said = run_session(
        tmp_path, [OPTO], ports={"X": script("0.102", "0.103", "0.102", "0.102")}, cycles=1,
        stable=2, monkeypatch=monkeypatch,
    )  # fmt: skip
    assert stored(said) == [(1, "0.102")]


def test_only_the_gauge_that_does_not_settle_is_named(tmp_path, monkeypatch):
    y = [[(0.02, b"01A+0000.%d\r" % (500 + k % 2))] for k in range(5000)]
    with pytest.raises(InstrumentError):
        run_session(
            tmp_path, [OPTO, MUX_Y],
            ports={"X": script(*["0.101"] * 5000), "Y": lambda c: Script(c, answer=answers(*y))},
            cycles=1, stable=2, monkeypatch=monkeypatch,
        )  # fmt: skip
    assert problems(run_session.said) == [("Y", "unsettled")] * 3


def test_a_value_that_does_not_settle_is_said_and_not_stored(tmp_path, monkeypatch):
    swinging = [f"0.{100 + 50 * (k % 2)}" for k in range(5000)]
    with pytest.raises(InstrumentError):
        run_session(
            tmp_path, [OPTO], ports={"X": script(*swinging)}, cycles=1, stable=2,
            monkeypatch=monkeypatch,
        )  # fmt: skip
    assert problems(run_session.said) == [("X", "unsettled")] * 3


def test_a_unit_that_changes_stops_the_cycle(tmp_path, monkeypatch):
    inch = [(0.02, b"+00.0040in\r")]
    with pytest.raises(InstrumentError, match="inch"):
        run_session(tmp_path, [OPTO], ports={"X": script("0.101", inch)}, monkeypatch=monkeypatch)
    assert kept(tmp_path) == {1: 0.101}


def test_the_instrument_is_asked_for_its_unit(tmp_path, monkeypatch):
    port = None

    def make(clock):
        nonlocal port
        port = Script(clock, answer=answers([(0.05, b"IN\r")], [(0.02, b"+0.10000\r")]), shows=None)
        return port

    said = run_session(
        tmp_path, ["X=opto-rs232@script"], ports={"X": make}, cycles=1, monkeypatch=monkeypatch
    )
    assert port.requests == [b"UNI?\r", b"?\r", b"UNI?\r"]
    (line,) = [to_json(s) for s in said if to_json(s)["event"] == "stored"]
    assert line["value"] == 2.54
    assert read_table(tmp_path / "run.csv").axes["X"].resolution == pytest.approx(25.4e-5)


@pytest.mark.parametrize("driver", ["opto-rs232", "mitutoyo-mux"])
def test_an_unknown_unit_is_refused_and_the_option_named(tmp_path, monkeypatch, driver):
    value = [(0.02, b"+000.101\r" if driver == "opto-rs232" else b"01A+0000.101\r")]
    with pytest.raises(UsageError) as caught:
        run_session(
            tmp_path, [f"X={driver}@script"],
            ports={"X": lambda c: Script(c, answer=lambda k: value, shows=None)},
            monkeypatch=monkeypatch,
        )  # fmt: skip
    assert "`unit=mm`" in caught.value.remedy
    assert list(tmp_path.iterdir()) == []


def test_a_stated_unit_is_held_against_the_display(tmp_path, monkeypatch):
    with pytest.raises(InstrumentError, match="shows inch, and the option said mm"):
        run_session(
            tmp_path, [OPTO], ports={"X": script("0.1", shows=b"IN\r")}, monkeypatch=monkeypatch
        )
    assert list(tmp_path.iterdir()) == []


def test_an_instrument_that_does_not_tell_its_unit_is_believed_to_show_the_stated_one(
    tmp_path, monkeypatch
):
    value = [(0.02, frame("0.101"))]
    said = run_session(
        tmp_path, [OPTO], cycles=1, monkeypatch=monkeypatch,
        ports={"X": lambda c: Script(c, answer=answers(None, value), shows=None)},
    )  # fmt: skip
    assert stored(said) == [(1, "0.101")]


def test_resume_keeps_the_unit_of_the_readings_there_are(tmp_path, monkeypatch):
    def mux(clock):
        return Script(clock, answer=lambda k: [(0.02, b"01A+0000.500\r")])

    spec = "X=mitutoyo-mux{}@script"
    run_session(
        tmp_path, [spec.format("?unit=inch")], ports={"X": mux}, cycles=1, monkeypatch=monkeypatch
    )
    with pytest.raises(UsageError, match="the option says mm, and the session before inch"):
        run_session(
            tmp_path, [spec.format("?unit=mm")], ports={"X": mux}, resume=True,
            monkeypatch=monkeypatch,
        )  # fmt: skip
    run_session(
        tmp_path, [spec.format("")], ports={"X": mux}, cycles=2, resume=True,
        monkeypatch=monkeypatch,
    )  # fmt: skip
    assert read_table(tmp_path / "run.csv").axes["X"].readings.tolist() == [12.7, 12.7]


def test_pushed_readings_make_cycles_and_repeats_are_refused(tmp_path, monkeypatch):
    pushes = [(1.0, frame("0.101")), (1.1, frame("0.101")), (3.0, frame("0.102")),
              (4.0, frame("0.103")), (5.0, frame("0.104"))]  # fmt: skip
    said = run_session(
        tmp_path, [OPTO], ports={"X": lambda c: Script(c, pushes=pushes)}, trigger="data",
        monkeypatch=monkeypatch,
    )  # fmt: skip
    assert stored(said) == [(1, "0.101"), (2, "0.102"), (3, "0.103")]
    assert refusals(said) == [("0.101", "came within 0.5 s of the one before")]


def test_a_cycle_of_two_pushed_gauges_takes_one_of_each_the_last_of_one_that_sent_again(
    tmp_path, monkeypatch
):
    x = [(1.0, frame("0.101")), (2.0, frame("0.109")), (5.0, frame("0.102"))]
    y = [(3.0, b"01A+0000.501\r"), (6.0, b"01A+0000.502\r")]
    said = run_session(
        tmp_path, [OPTO, MUX_Y], trigger="data", cycles=2, monkeypatch=monkeypatch,
        ports={"X": lambda c: Script(c, pushes=x), "Y": lambda c: Script(c, pushes=y)},
    )  # fmt: skip
    assert stored(said) == [(1, "0.101"), (1, "0.109"), (2, "0.102")]
    assert stored(said, "Y") == [(1, "0.501"), (2, "0.502")]
    assert read_table(tmp_path / "run.csv").axes["X"].readings.tolist() == [0.109, 0.102]
    run = read_table(tmp_path / "run.csv")
    assert run.covariates["time_s"].tolist() == [3.0, 6.0]


def test_a_reading_pushed_while_none_is_asked_for_is_refused(tmp_path, monkeypatch):
    ports = {"X": lambda c: Script(c, answer=answers("0.1", "0.2"), pushes=[(0.5, frame("7"))])}
    said = run_session(tmp_path, [OPTO], ports=ports, cycles=2, monkeypatch=monkeypatch)
    assert stored(said) == [(1, "0.100"), (2, "0.200")]
    assert refusals(said) == [("7.000", "not asked for")]


def test_the_line_under_way_at_opening_is_noticed_and_not_taken(tmp_path, monkeypatch):
    # What follows the opening looks like a frame of its own on some dialects.
    pushes = [(0.1, b"-01"), (1.5, b"2.345\r"), (3.0, frame("0.101"))]
    said = run_session(
        tmp_path, [OPTO], trigger="data", cycles=1, monkeypatch=monkeypatch,
        ports={"X": lambda c: Script(c, pushes=pushes, settle_s=0.2, shows=None)},
    )  # fmt: skip
    assert stored(said) == [(1, "0.101")]
    assert refusals(said) == []
    assert "-12.345 not taken: began before the session" in [
        s.message for s in said if isinstance(s, Noticed)
    ]


@pytest.mark.parametrize("at", [0.1, 0.4])  # before the unit is asked for, and while it is
def test_a_key_that_is_pressed_too_early_is_asked_for_again(tmp_path, monkeypatch, at):
    pushes = [(at, frame("0.795")), (3.0, frame("0.101"))]
    said = run_session(
        tmp_path, [OPTO], trigger="data", cycles=1, monkeypatch=monkeypatch,
        ports={"X": lambda c: Script(c, pushes=pushes, settle_s=0.2, shows=None)},
    )  # fmt: skip
    noticed = [s.message for s in said if isinstance(s, Noticed)]
    assert noticed == ["0.795 not taken: the recording was not ready: press again"]


def test_a_stream_gives_the_first_reading_begun_after_the_trigger(tmp_path, monkeypatch):
    # The line +0000.111 began before the timer fired at 1.0 s.
    pushes = [(0.3, b"+0000.099\r"), (0.95, b"+0000"), (1.05, b".111\r+00"), (1.3, b"00.222\r")]
    said = run_session(
        tmp_path, ["X=stream-4800?unit=mm@script"], cycles=2, monkeypatch=monkeypatch,
        ports={"X": lambda c: Script(c, pushes=pushes)},
    )  # fmt: skip
    assert stored(said) == [(1, "0.099"), (2, "0.222")]


def test_void_strikes_the_whole_cycle_and_keeps_it_in_the_raw_file(tmp_path, monkeypatch):
    commands = Orders(None, Take(), None, Take(), Void("the arm was pushed"), Take(), Take())
    said = run_session(
        tmp_path, [OPTO], trigger="enter", operator=commands, monkeypatch=monkeypatch,
        ports={"X": script("0.101", "0.999", "0.102", "0.103")},
    )  # fmt: skip
    assert stored(said) == [(1, "0.101"), (2, "0.999"), (2, "0.102"), (3, "0.103")]
    assert Voided(2, ("X",), "the arm was pushed") in said
    run = read_table(tmp_path / "run.csv")
    assert run.axes["X"].readings.tolist() == [0.101, 0.102, 0.103]
    assert run.metadata["record_voided"] == "1"
    raw = (tmp_path / "run.raw.jsonl").read_text()
    assert "the arm was pushed" in raw
    assert frame("0.999").hex() in raw


def test_void_with_pushed_gauges_strikes_one_reading(tmp_path, monkeypatch):
    x = [(1.0, frame("0.101")), (7.0, frame("0.102"))]
    y = [(2.0, b"01A+0000.909\r"), (3.5, b"01A+0000.501\r"), (8.0, b"01A+0000.502\r")]

    class VoidsAfterY:
        def __init__(self):
            self.done = False

        def poll(self):
            ready = kept(tmp_path, "Y") and not self.done
            self.done |= bool(ready)
            return Void("slipped") if ready else None

    run_session(
        tmp_path, [OPTO, MUX_Y], trigger="data", cycles=2, operator=VoidsAfterY(),
        monkeypatch=monkeypatch,
        ports={"X": lambda c: Script(c, pushes=x), "Y": lambda c: Script(c, pushes=y)},
    )  # fmt: skip
    run = read_table(tmp_path / "run.csv")
    assert run.axes["X"].readings.tolist() == [0.101, 0.102]
    assert run.axes["Y"].readings.tolist() == [0.501, 0.502]


def test_nothing_to_void_is_no_harm(tmp_path, monkeypatch):
    said = run_session(
        tmp_path, [OPTO], trigger="enter", cycles=1, operator=Orders(Void("why"), Take()),
        ports={"X": script("0.1")}, monkeypatch=monkeypatch,
    )  # fmt: skip
    assert stored(said) == [(1, "0.100")]
    assert not [s for s in said if isinstance(s, Voided)]


def test_paused_readings_are_refused_and_notes_are_kept(tmp_path, monkeypatch):
    class Pauses:
        def __init__(self):
            self.orders = [(1.5, Pause()), (2.5, Pause()), (2.6, Note("warm"))]

        def poll(self):
            if self.orders and clock.now() >= self.orders[0][0]:
                return self.orders.pop(0)[1]
            return None

    clock = StreamClock(paced=False)
    clock.watch(lambda: next((t for t in (1.5, 2.5, 2.6) if t > clock.now()), math.inf))
    pushes = [(1.0, frame("0.101")), (2.0, frame("0.5")), (3.0, frame("0.102"))]
    said = run_session(
        tmp_path, [OPTO], trigger="data", cycles=2, operator=Pauses(), clock=clock,
        ports={"X": lambda c: Script(c, pushes=pushes)}, monkeypatch=monkeypatch,
    )  # fmt: skip
    assert stored(said) == [(1, "0.101"), (2, "0.102")]
    assert refusals(said) == [("0.500", "paused")]
    assert Noted("warm") in said
    assert "warm" in (tmp_path / "run.raw.jsonl").read_text()


def test_quit_keeps_what_is_stored(tmp_path, monkeypatch):
    run_session(
        tmp_path, [OPTO], trigger="enter", operator=Orders(Take(), Quit()),
        ports={"X": script("0.1", "0.2")}, monkeypatch=monkeypatch,
    )  # fmt: skip
    run = read_table(tmp_path / "run.csv")
    assert run.cycle.tolist() == [1]
    assert run.metadata["cycles_planned"] == "3"


def test_enter_stays_with_a_cycle_that_gave_no_reading(tmp_path, monkeypatch):
    said = run_session(
        tmp_path, [OPTO], trigger="enter", cycles=1, operator=Orders(Take(), Take()),
        ports={"X": script(None, None, None, "0.1")}, monkeypatch=monkeypatch,
    )  # fmt: skip
    assert stored(said) == [(1, "0.100")]
    assert problems(said) == [("X", "timeout")] * 3


class Key:
    """An operator whose key goes down at the given times [s], and who then quits."""

    def __init__(self, clock, times):
        self._clock = clock
        self._times = [*times]
        clock.watch(lambda: self._times[0] if self._times else math.inf)

    def poll(self):
        if self._times and self._clock.now() < self._times[0]:
            return None
        return Take() if self._times and self._times.pop(0) else Quit()


@pytest.mark.parametrize(
    ("presses", "taken"),
    [
        ((1.0, 1.05), 1),  # bounced
        ((1.0, *(1.5 + 0.03 * k for k in range(50))), 1),  # held down: repeats after half a second
        ((1.0, 3.0, 3.1, 9.0), 3),
    ],
)
def test_a_key_that_bounces_or_is_held_down_takes_one_cycle(tmp_path, monkeypatch, presses, taken):
    clock = StreamClock(paced=False)
    said = run_session(
        tmp_path, [OPTO], trigger="enter", cycles=99, rearm_s=1.0, clock=clock,
        operator=Key(clock, presses), monkeypatch=monkeypatch,
        ports={"X": script(*["0.101"] * 99)},
    )  # fmt: skip
    assert len(stored(said)) == taken
    refused = [s for s in said if isinstance(s, Noticed) and s.message.startswith("Enter not")]
    assert len(refused) == len(presses) - taken


def test_another_channel_is_refused(tmp_path, monkeypatch):
    pushes = [(1.0, b"01A+0000.101\r"), (2.0, b"02A+0000.201\r"), (3.0, b"01A+0000.102\r")]
    said = run_session(
        tmp_path, ["X=mitutoyo-mux?unit=mm&channel=1@script"], trigger="data", cycles=2,
        ports={"X": lambda c: Script(c, pushes=pushes)}, monkeypatch=monkeypatch,
    )  # fmt: skip
    assert stored(said) == [(1, "0.101"), (2, "0.102")]


def test_resume_goes_on_with_the_next_cycle(tmp_path, monkeypatch):
    with pytest.raises(InstrumentError):
        run_session(
            tmp_path, [OPTO], ports={"X": script("0.101", "0.102")}, monkeypatch=monkeypatch
        )
    said = run_session(
        tmp_path, [OPTO], ports={"X": script("0.103")}, resume=True, monkeypatch=monkeypatch
    )
    assert stored(said) == [(3, "0.103")]
    run = read_table(tmp_path / "run.csv")
    assert run.axes["X"].readings.tolist() == [0.101, 0.102, 0.103]
    times = run.covariates["time_s"]
    assert times[2] > times[1]


class EndsAfterX:
    """An operator who presses ``q`` or Ctrl-C when X has a reading."""

    def __init__(self, folder, *, by):
        self._folder = folder
        self._by = by

    def poll(self):
        if not kept(self._folder):
            return None
        if self._by is KeyboardInterrupt:
            raise KeyboardInterrupt
        return Quit()


@pytest.mark.parametrize("error", [InstrumentError, KeyboardInterrupt])
def test_a_session_without_a_whole_cycle_keeps_its_readings(tmp_path, monkeypatch, error):
    ports = {"X": lambda c: Script(c, pushes=[(1.0, frame("0.101"))]), "Y": script()}
    with pytest.raises(error, match="no cycle is complete" if error is InstrumentError else None):
        run_session(
            tmp_path, [OPTO, MUX_Y], trigger="data", ports=ports, monkeypatch=monkeypatch,
            operator=EndsAfterX(tmp_path, by=error),
        )  # fmt: skip
    assert kept(tmp_path) == {1: 0.101}
    assert not (tmp_path / "run.csv").exists()


def test_the_table_goes_when_its_last_cycle_is_struck_out(tmp_path, monkeypatch):
    run_session(tmp_path, [OPTO], ports={"X": script("0.101")}, cycles=1, monkeypatch=monkeypatch)
    with pytest.raises(InstrumentError, match="no cycle is complete"):
        run_session(
            tmp_path, [OPTO], ports={"X": script()}, cycles=2, resume=True, trigger="enter",
            operator=Orders(None, Void("wrong pose"), Quit()), monkeypatch=monkeypatch,
        )  # fmt: skip
    assert not (tmp_path / "run.csv").exists()


def test_resume_with_another_driver_is_refused(tmp_path, monkeypatch):
    run_session(tmp_path, [OPTO], ports={"X": script("0.1")}, cycles=1, monkeypatch=monkeypatch)
    with pytest.raises(UsageError, match="recorded with X=opto-rs232"):
        run_session(
            tmp_path, ["X=mitutoyo-mux?unit=mm@script"], ports={"X": script()}, resume=True,
            monkeypatch=monkeypatch,
        )  # fmt: skip


@pytest.mark.parametrize("order", [(0.02, 0.5), (0.5, 0.02)])
def test_a_damaged_answer_and_another_one_are_none(tmp_path, monkeypatch, order):
    damaged, doubled = order
    both = [(damaged, b"+000.1x2\r"), (doubled, frame("0.101"))]
    said = run_session(
        tmp_path, [OPTO], monkeypatch=monkeypatch,
        ports={"X": script([(0.6, frame("0.101"))], both, "0.102", "0.103")},
    )  # fmt: skip
    assert stored(said) == [(1, "0.101"), (2, "0.102"), (3, "0.103")]


def test_what_a_resumed_session_states_anew_is_noted(tmp_path, monkeypatch):
    run_session(
        tmp_path, [OPTO], ports={"X": script("0.101", "0.102")}, cycles=2,
        monkeypatch=monkeypatch, metadata={"robot": "R1", "operator": "A"},
    )  # fmt: skip
    run_session(
        tmp_path, [OPTO], ports={"X": script("0.103")}, cycles=3, resume=True,
        monkeypatch=monkeypatch, metadata={"robot": "R2", "operator": "A"},
    )  # fmt: skip
    head = read_table(tmp_path / "run.csv").metadata
    changed = [text for key, text in head.items() if key.endswith("_changed")]
    assert changed == ["robot: R2, stated before as R1", "planned: 3 cycles, before 2"]


def on_cables(tmp_path, monkeypatch, first, then):
    """Record a cycle, resume with other cables, and return what the table says has changed."""
    for cycle, identities in enumerate((first, then), 1):
        ports = dict.fromkeys("XY"[: len(first)], script("0.1"))

        def on(cable, make):
            def opened(clock):
                port = make(clock)
                port.identity = cable
                return port

            return opened

        run_session(
            tmp_path, [OPTO, OPTO.replace("X", "Y") + "2"][: len(first)],
            ports={a: on(c, make) for (a, make), c in zip(ports.items(), identities, strict=True)},
            cycles=cycle, resume=cycle > 1, monkeypatch=monkeypatch,
        )  # fmt: skip
    head = read_table(tmp_path / "run.csv").metadata
    return [text for key, text in head.items() if key.endswith("_changed") and " was " in text]


A, B = "/dev/ttyUSB0 (usb 0403:6001{} location 1-1)", "/dev/ttyUSB1 (usb 0403:6001{} location 1-2)"
A_HAS, B_HAS = A.format(" serial A"), B.format(" serial B")


@pytest.mark.parametrize(
    ("first", "then"),
    [
        (("dx", "dy"), ("dy", "dx")),
        (("dx", "dy"), ("dz", "dx")),
        ((A_HAS, B_HAS), (B_HAS, A_HAS)),
        ((A_HAS, B_HAS), (A.format(" serial B"), B.format(" serial A"))),
        ((A.format(" serial 1"), B.format(" serial 1")), (B.format(" serial 1"), "dz")),
        ((A.format(""), B.format("")), (B.format(""), A.format(""))),
    ],
)
def test_the_gauge_of_another_axis_is_refused_on_resume(tmp_path, monkeypatch, first, then):
    with pytest.raises(UsageError, match=r"is given the gauge that [XY] had") as refused:
        on_cables(tmp_path, monkeypatch, first, then)
    assert "the same `gauge=` options, or none" in refused.value.remedy
    assert len(read_table(tmp_path / "run.csv")) == 1


@pytest.mark.parametrize(
    ("first", "then"),
    [
        (("dx",), ("dz",)),
        ((A_HAS, B_HAS), (A.format(" serial B").replace("B", "C"), B_HAS)),
        ((A_HAS, B_HAS), (B.format(" serial A"), A.format(" serial B"))),
        ((A.format(""), B.format("")), (A.format("").replace("USB0", "USB1"), B.format(""))),
    ],
)
def test_a_gauge_on_another_port_is_named_by_analyze(tmp_path, monkeypatch, first, then):
    changed = on_cables(tmp_path, monkeypatch, first, then)
    assert changed == [
        f"{axis} was read by opto-rs232 at {one}, then by opto-rs232 at {other}"
        for axis, one, other in zip("XY", first, then, strict=False)
        if one != other
    ]
