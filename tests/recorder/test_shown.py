"""What a display showed before, and sessions on indicators whose unit or zero is lost."""

import pytest
from bench import Orders, Script, kept, run_session, stored

from scara_iso import read_table
from scara_iso.base.errors import InstrumentError
from scara_iso.base.published import to_json
from scara_iso.recorder import Gross, Noticed, Pause, Paused, Problem, Quit, Take, Void
from scara_iso.recorder.gauge import Shown
from scara_iso.recorder.ports.port import StreamClock

OPTO = "X=opto-rs232?unit=mm@script"
MUX = "X=mitutoyo-mux?unit=mm@script"


def shown(*texts, fixed=True):
    made = Shown(fixed_decimals=fixed)
    for cycle, text in enumerate(texts, 1):
        made.put(cycle, text)
    return made


STEADY = ("0.812", "0.815", "0.811", "0.813", "0.814")


@pytest.mark.parametrize("text", ["0.03197", "0.81", "81.2345"])
def test_another_number_of_decimals_is_a_display_that_changed(text):
    assert "decimals" in shown(*STEADY).changed(text, 9)


@pytest.mark.parametrize("text", ["0.032", "20.640", "0.033"])
def test_a_step_by_25_4_is_a_unit_that_changed(text):
    assert "25.4" in shown(*STEADY).changed(text, 9)


@pytest.mark.parametrize("before", [("8.000",), ("8.000", "8.001")])
def test_a_step_by_25_4_is_seen_from_the_first_reading_on(before):
    assert "25.4" in shown(*before).changed("0.315", 9)


@pytest.mark.parametrize("text", ["0.812", "0.900", "0.100", "-0.812", "5.812", "0.000", "-0.032"])
def test_other_values_are_no_change_of_display(text):
    assert shown(*STEADY).changed(text, 9) == ""


@pytest.mark.parametrize(
    "texts", [(), ("0.001", "-0.002", "0.001", "0.002"), ("0.1", "5.0", "0.2")]
)
def test_near_zero_or_without_a_level_no_step_is_a_unit(texts):
    assert shown(*texts).changed("0.051" if len(texts) == 4 else "2.5", 9) == ""


def test_a_pattern_of_the_user_may_drop_zeros():
    assert shown("0.51", "0.512", fixed=False).changed("0.5", 9) == ""


@pytest.mark.parametrize(
    ("text", "away"), [("5.812", "5"), ("0.816", None), ("0.700", "0.1"), ("-0.813", "1.6")]
)
def test_how_far_a_gross_reading_is_from_the_others(text, away):
    found = shown("9.999", *STEADY).far(text, 9)
    assert (found and f"{found:.1g}" if away in ("5", "0.1") else found and f"{found:.2g}") == away


@pytest.mark.parametrize("early", [2, 3, 4, 5, 6])
def test_a_gross_reading_that_comes_early_is_told_once_the_others_are_enough(early):
    texts = ["9.999", "0.801", "0.803", "0.799", "0.802", "0.800", "0.801"]
    texts[early - 1] = "1.802"
    made, found = shown(), []
    for visit, text in enumerate(texts, 1):
        made.put(visit, text)
        found += [(visit, far, f"{distance:.0g}") for far, _, distance in made.gross(visit)]
    assert found == [(6, early, "1")]


def test_struck_readings_are_no_others():
    made = shown("0.8", *STEADY)
    for cycle in range(2, 7):
        made.void(cycle)
    assert made.far("5.812", 9) is None


def frames(*values, key="opto"):
    """Answer the k-th request with the k-th frame, as an indicator of six or eight characters."""
    ends = {"opto": "+{:0>7}\r", "mux": "01A+{:0>8}\r"}[key]
    return lambda k: [(0.02, ends.format(values[k]).encode())] if k < len(values) else []


MM = [f"0.8{n}" for n in range(11, 20)]
INCH = [f"0.0320{n}" for n in range(9)]


@pytest.mark.parametrize("inch", [INCH, ["0.032"] * 9])
@pytest.mark.parametrize(("gauge", "key"), [(OPTO, "opto"), (MUX, "mux")])
def test_a_unit_lost_in_mid_run_stops_the_recording(tmp_path, monkeypatch, inch, gauge, key):
    with pytest.raises(InstrumentError, match="unit"):
        run_session(
            tmp_path, [gauge], cycles=20, monkeypatch=monkeypatch,
            ports={"X": lambda c: Script(c, answer=frames(*MM, *inch, key=key))},
        )  # fmt: skip
    assert list(kept(tmp_path).values()) == [float(text) for text in MM]
    assert len(read_table(tmp_path / "run.csv")) == 9
    assert '"event":"changed"' in (tmp_path / "run.raw.jsonl").read_text()


@pytest.mark.parametrize("odd", ["0.0320", "0.032"])
def test_one_odd_frame_is_refused_and_asked_again(tmp_path, monkeypatch, odd):
    said = run_session(
        tmp_path, [OPTO], cycles=10, monkeypatch=monkeypatch,
        ports={"X": lambda c: Script(c, answer=frames(*MM, odd, "0.820"))},
    )  # fmt: skip
    assert stored(said)[-1] == (10, "0.820")
    assert [s.event for s in said if isinstance(s, Problem)] == ["changed"]


class Turns(Script):
    """A gauge whose unit request is answered by the next of ``units``, the last one for ever."""

    units = (b"MM\r",)

    def write(self, data):
        if data == b"UNI?\r":
            self._shows, *rest = self.units
            self.units = tuple(rest) or self.units
        super().write(data)


def test_the_unit_is_asked_for_where_an_answer_is_odd(tmp_path, monkeypatch):
    def make(clock):
        port = Turns(clock, answer=frames(*MM, "0.0320", "0.820", "0.821"))
        port.units = (*[b"MM\r"] * 10, b"IN\r")
        return port

    with pytest.raises(InstrumentError, match="shows inch"):
        run_session(tmp_path, [OPTO], cycles=20, monkeypatch=monkeypatch, ports={"X": make})
    assert len(kept(tmp_path)) == 9


@pytest.mark.parametrize("reply", [b"ERR1\r", b"+000.812\r", b"?\r", b""])
def test_an_answer_that_is_no_unit_proves_nothing(tmp_path, monkeypatch, reply):
    for resume, cycles in ((False, 3), (True, 6)):
        said = run_session(
            tmp_path, [OPTO], cycles=cycles, monkeypatch=monkeypatch, resume=resume,
            ports={"X": lambda c: Script(c, answer=frames(*MM), shows=reply)},
        )  # fmt: skip
    assert [cycle for cycle, _ in stored(said)] == [4, 5, 6]


def test_an_indicator_that_was_switched_off_and_on_has_lost_its_zero(tmp_path, monkeypatch):
    banner = [(2.5, b"SY270.101\r")]
    with pytest.raises(InstrumentError, match="zero"):
        run_session(
            tmp_path, [OPTO], cycles=9, monkeypatch=monkeypatch,
            ports={"X": lambda c: Script(c, answer=frames(*MM), pushes=banner)},
        )  # fmt: skip
    assert [s.event for s in run_session.said if isinstance(s, Problem)] == ["changed"]
    assert len(kept(tmp_path)) == 3
    assert "zero" in (tmp_path / "run.raw.jsonl").read_text()


@pytest.mark.parametrize("trigger", ["timer:1", "data"])
def test_switched_on_before_the_first_reading_harms_nothing(tmp_path, monkeypatch, trigger):
    pushes = [(0.1, b"SY270.101\r"), *[(1.0 + k, b"+000.812\r") for k in range(3)]]
    said = run_session(
        tmp_path, [OPTO], monkeypatch=monkeypatch, trigger=trigger,
        ports={"X": lambda c: Script(c, answer=frames(*MM), pushes=pushes, settle_s=0.5)},
    )  # fmt: skip
    assert len(stored(said)) == 3


def test_whoever_sits_at_the_terminal_is_asked(tmp_path, monkeypatch):
    said = run_session(
        tmp_path, [OPTO], cycles=10, monkeypatch=monkeypatch, attended=True,
        operator=Orders(*[None] * 40, Pause(), *[None] * 10, Quit()),
        ports={"X": lambda c: Script(c, answer=frames(*MM, *INCH[:2], "0.820"))},
    )  # fmt: skip
    paused = next(k for k, s in enumerate(said) if s == Paused(True))
    assert "put it right" in said[paused + 1].message
    assert stored(said)[-1] == (10, "0.820")


def test_resume_holds_the_display_against_the_session_before(tmp_path, monkeypatch):
    def take(*values, cycles):
        return run_session(
            tmp_path, [OPTO], cycles=cycles, monkeypatch=monkeypatch, resume=cycles > 9,
            ports={"X": lambda c: Script(c, answer=frames(*values))},
        )  # fmt: skip

    take(*MM, cycles=9)
    with pytest.raises(InstrumentError, match="unit"):
        take(*INCH, cycles=12)
    assert [cycle for cycle, _ in stored(take(*MM, cycles=12))] == [10, 11, 12]


def test_a_gross_reading_is_said_when_it_comes(tmp_path, monkeypatch):
    said = run_session(
        tmp_path, [OPTO], cycles=8, monkeypatch=monkeypatch,
        ports={"X": lambda c: Script(c, answer=frames("0.800", *STEADY, "5.813", "0.812"))},
    )  # fmt: skip
    (gross,) = [s for s in said if isinstance(s, Gross)]
    assert to_json(gross) == {
        "event": "gross", "cycle": 7, "axis": "X", "value": 5.813, "distance": 5.0,
        "message": "X 5.813 mm of cycle 7 is 5 mm from the others; v strikes it",
    }  # fmt: skip
    assert stored(said)[6] == (7, "5.813")


def ends_at_seven(tmp_path, monkeypatch, *commands, attended=True, resume=False, last="0.815"):
    """Record seven cycles by Enter, the last of them far away; ``last`` is what comes then."""
    steady = [Take()] * 7
    return run_session(
        tmp_path, [OPTO], cycles=7, trigger="enter", monkeypatch=monkeypatch, attended=attended,
        operator=Orders(*([] if resume else steady), *commands), resume=resume,
        ports={"X": lambda c: Script(c, answer=frames(
            *([] if resume else ["0.800", *STEADY, "5.813"]), last))},
    )  # fmt: skip


def test_a_far_last_reading_may_be_struck_and_taken_again(tmp_path, monkeypatch):
    said = ends_at_seven(tmp_path, monkeypatch, Void("mistyped"), Take())
    assert [text for cycle, text in stored(said) if cycle == 7] == ["5.813", "0.815"]
    assert read_table(tmp_path / "run.csv").axes["X"].readings[-1] == 0.815
    (asked,) = [s.message for s in said if isinstance(s, Noticed) and not s.axis]
    assert asked == (
        "every cycle is recorded; X 5.813 mm of cycle 7 is 5 mm from the others; v strikes it, "
        "q ends"
    )


@pytest.mark.parametrize("ends", [Quit(), Take()])
def test_a_far_last_reading_may_stay(tmp_path, monkeypatch, ends):
    ends_at_seven(tmp_path, monkeypatch, None, ends)
    assert read_table(tmp_path / "run.csv").axes["X"].readings[-1] == 5.813


def test_nobody_is_waited_for_where_nobody_is(tmp_path, monkeypatch):
    said = ends_at_seven(tmp_path, monkeypatch, attended=False)
    assert not [s for s in said if isinstance(s, Noticed) and not s.axis]


def test_the_last_reading_may_be_struck_by_going_on_with_the_recording(tmp_path, monkeypatch):
    ends_at_seven(tmp_path, monkeypatch, attended=False)
    ends_at_seven(tmp_path, monkeypatch, Void("mistyped"), Take(), resume=True)
    assert read_table(tmp_path / "run.csv").axes["X"].readings[-1] == 0.815


def test_what_comes_before_the_first_cycle_is_a_notice(tmp_path, monkeypatch):
    pushes = [(0.1, b"+000.5x0\r"), (0.2, b"+000.500\r"), (0.3, b"ERR1\r"), (0.45, b"+00"),
              (1.5, b"0.700\r"), (3.0, b"+000.812\r")]  # fmt: skip
    clock = StreamClock(paced=False)
    said = run_session(
        tmp_path, [OPTO], cycles=1, monkeypatch=monkeypatch, trigger="data", clock=clock,
        ports={"X": lambda c: Script(c, pushes=pushes, settle_s=0.5, shows=None)},
    )  # fmt: skip
    names = [to_json(s)["event"] for s in said]
    assert names.count("notice") == 4
    assert not {"refused", "garbage", "fault", "timeout"} & set(names)
    assert stored(said) == [(1, "0.812")]
    assert "record_refused" not in read_table(tmp_path / "run.csv").metadata


NEAR = ["0.001", "0.002", "-0.001", "0.000", "0.001", "0.002"]


@pytest.mark.parametrize("trigger", ["timer:1", "data"])
def test_near_zero_a_display_that_changed_is_found_by_asking(tmp_path, monkeypatch, trigger):
    pushes = [(2.0 + 2 * k, b"%+08.3f\r" % float(text)) for k, text in enumerate(NEAR)]

    def make(clock):
        sent = {"pushes": pushes} if trigger == "data" else {"answer": frames(*NEAR)}
        port = Turns(clock, **sent)
        port.units = (b"MM\r", b"MM\r", b"MM\r", b"IN\r")
        return port

    with pytest.raises(InstrumentError, match="shows inch"):
        run_session(
            tmp_path, [OPTO], cycles=6, monkeypatch=monkeypatch, ports={"X": make}, trigger=trigger
        )
    assert len(kept(tmp_path)) == 2
    assert "record_unit" not in read_table(tmp_path / "run.csv").metadata


@pytest.mark.parametrize("cycles", [(4,), (2, 4)])
def test_a_unit_that_no_gauge_states_is_the_word_of_the_user(tmp_path, monkeypatch, cycles):
    for k, last in enumerate(cycles):
        run_session(
            tmp_path, [OPTO], cycles=last, monkeypatch=monkeypatch, resume=k > 0,
            ports={"X": lambda c, k=k: Script(c, answer=frames(*NEAR), shows=(None, b"MM\r")[k])},
        )  # fmt: skip
    said = read_table(tmp_path / "run.csv").metadata["record_unit"]
    assert said == "X: mm as the option states, not confirmed by the gauge"
