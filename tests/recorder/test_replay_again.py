"""A raw file replayed gives its table again; what was struck and noted stays readable."""

import pytest
from bench import Orders, Script, run_session
from disks import UnsyncedDisk

from scara_iso import read_table
from scara_iso.commands import main
from scara_iso.rawfile import Timeline, encode, raw_path
from scara_iso.rawfile.integrity import decode_record
from scara_iso.recorder import Note, Quit, Take, Void, rebuild

OPTO = "X=opto-rs232?unit=mm@script"
MUX = "Y=mitutoyo-mux?unit=mm@script2"


def line(n):
    return b"+000.%03d\r" % n


def body(path):
    """Return what the table holds below its head."""
    return [row for row in path.read_text().splitlines() if not row.startswith("#")]


def replay(tmp_path, monkeypatch, trigger, *gauges):
    """Replay run.raw.jsonl by the command; return the new table's rows."""
    monkeypatch.chdir(tmp_path)
    code = main(["record", "again.csv", "--json", "--trigger", trigger, *gauges])
    assert code == 0
    return body(tmp_path / "again.csv")


class Struck:
    """Strikes the third reading when it is stored, and says so in a note."""

    def __init__(self, folder):
        self._orders = [Void("knocked, \r\n<b>twice</b>"), Note("door open")]
        self._folder = folder

    def poll(self):
        raw = raw_path(self._folder / "run.csv").read_text()
        return self._orders.pop(0) if '"cycle":3' in raw and self._orders else None


@pytest.mark.parametrize("trigger", ["data", "timer:1"])
def test_a_recording_with_troubles_gives_its_table_again(tmp_path, monkeypatch, trigger, capsys):
    early = [(0.1, line(900)), (0.3, line(901))]
    values = [*range(1, 6), 7, 8]
    pushes = [*early, *((2.0 * k + 1, line(n)) for k, n in enumerate(values))]
    pushes += [(2.0 * k + 1.1, line(n)) for k, n in enumerate(values)]  # each sent twice
    port = {
        "data": lambda c: Script(c, pushes=pushes, settle_s=0.5, shows=b"+000.902\r"),
        "timer:1": lambda c: Script(
            c, answer=lambda k: [(0.02, b"x\r" if k == 2 else line(k))], pushes=early, settle_s=0.5
        ),
    }[trigger]
    run_session(
        tmp_path, [OPTO], ports={"X": port}, trigger=trigger, cycles=6, monkeypatch=monkeypatch,
        operator=Struck(tmp_path),
    )  # fmt: skip
    before = read_table(tmp_path / "run.csv")
    gauge = "--gauge=X=opto-rs232?unit=mm@replay:run.raw.jsonl"
    monkeypatch.undo()
    rows = replay(tmp_path, monkeypatch, trigger, gauge)
    assert len(rows) == 7
    if trigger == "data":
        assert rows == body(tmp_path / "run.csv")
    after = read_table(tmp_path / "again.csv")
    assert after.axes["X"].readings.tolist() == before.axes["X"].readings.tolist()
    capsys.readouterr()


@pytest.mark.parametrize("shows", [None, b"MM\r"])
def test_a_unit_that_no_gauge_stated_is_so_still_when_replayed(tmp_path, monkeypatch, shows):
    run_session(
        tmp_path, [OPTO], cycles=4, monkeypatch=monkeypatch,
        ports={"X": lambda c: Script(c, answer=lambda k: [(0.02, line(k))], shows=shows)},
    )  # fmt: skip
    monkeypatch.undo()
    rebuild(raw_path(tmp_path / "run.csv"), tmp_path / "rebuilt.csv", disk=UnsyncedDisk())
    gauge = "--gauge=X=opto-rs232@replay:run.raw.jsonl"
    replay(tmp_path, monkeypatch, "data", gauge)
    for end in ("csv", "raw.jsonl", "manifest.json"):
        (tmp_path / f"again.{end}").rename(tmp_path / f"once.{end}")
    replay(tmp_path, monkeypatch, "data", gauge.replace("run", "once"))
    said = "X: mm as {} states, not confirmed by the gauge"
    for name, who in (("run", "the option"), ("rebuilt", "the option"),
                      ("once", "the recording"), ("again", "the recording")):  # fmt: skip
        head = read_table(tmp_path / f"{name}.csv").metadata
        assert head.get("record_unit") == (None if shows else said.format(who))


def test_two_gauges_give_their_rows_again(tmp_path, monkeypatch):
    x = lambda c: Script(c, answer=lambda k: [(0.02, line(k))])  # noqa: E731
    y = lambda c: Script(  # noqa: E731
        c, answer=lambda k: [] if k == 2 else [(0.6, b"01A+0000.%03d\r" % k)]
    )
    run_session(
        tmp_path, [OPTO, MUX], ports={"X": x, "Y": y}, trigger="timer:1", cycles=6,
        monkeypatch=monkeypatch,
    )  # fmt: skip
    monkeypatch.undo()
    gauges = [
        f"--gauge={a}={key}?unit=mm@replay:run.raw.jsonl"
        for a, key in (("X", "opto-rs232"), ("Y", "mitutoyo-mux"))
    ]
    assert replay(tmp_path, monkeypatch, "data", *gauges) == body(tmp_path / "run.csv")


def test_a_recorded_stream_is_not_asked_twice(tmp_path, monkeypatch, capsys):
    (tmp_path / "stream").write_bytes(line(1) * 9)
    monkeypatch.chdir(tmp_path)
    gauge = "--gauge=X=opto-rs232?unit=mm@replay:stream"
    assert main(["record", "a.csv", "--trigger", "timer:1", "--stable", "2", gauge]) == 2
    assert "--stable" in capsys.readouterr().err


def test_another_driver_than_the_recordings_is_refused(tmp_path, monkeypatch, capsys):
    run_session(
        tmp_path, [OPTO], ports={"X": lambda c: Script(c, answer=lambda k: [(0.02, line(k))])},
        monkeypatch=monkeypatch,
    )  # fmt: skip
    monkeypatch.undo()
    monkeypatch.chdir(tmp_path)
    gauge = "--gauge=X=opto-rs232-tesa?unit=mm@replay:run.raw.jsonl"
    assert main(["record", "again.csv", "--trigger", "data", gauge]) == 2
    assert "X was recorded by opto-rs232, not opto-rs232-tesa" in capsys.readouterr().err


def test_bytes_that_are_not_there_are_said(tmp_path, monkeypatch, capsys):
    run_session(
        tmp_path, [OPTO], ports={"X": lambda c: Script(c, answer=lambda k: [(0.02, line(k))])},
        monkeypatch=monkeypatch,
    )  # fmt: skip
    monkeypatch.undo()
    monkeypatch.chdir(tmp_path)
    raw = raw_path(tmp_path / "run.csv")
    kept = [one for one in raw.read_bytes().splitlines(keepends=True) if b'"event":"in"' not in one]
    raw.write_bytes(b"".join(kept))
    gauge = "--gauge=X=opto-rs232?unit=mm@replay:run.raw.jsonl"
    assert main(["record", "again.csv", "--trigger", "data", gauge]) == 65
    assert "bytes of cycle 1" in capsys.readouterr().err


def test_reasons_and_notes_stand_in_the_table_and_the_report(tmp_path, monkeypatch, capsys):
    orders = Orders(None, Take(), None, Take(), Void("knocked\r\n# unit: inch"), Note("door open"),
                    *[Take(), None] * 40, Quit())  # fmt: skip
    run_session(
        tmp_path, [OPTO], trigger="enter", operator=orders, cycles=31, monkeypatch=monkeypatch,
        ports={"X": lambda c: Script(c, answer=lambda k: [(0.02, line(500 + k % 7))])},
    )  # fmt: skip
    found = read_table(tmp_path / "run.csv")
    assert found.metadata["record_01_struck"].startswith("cycle 2, X 0.501: knocked")
    assert found.metadata["record_02_note"] == "door open"
    assert found.axes["X"].readings.max() < 1
    monkeypatch.chdir(tmp_path)
    assert main(["report", "run.csv", "-o", "report.md"]) == 0
    text = (tmp_path / "report.md").read_text()
    assert "knocked" in text
    assert "door open" in text
    capsys.readouterr()


def record(event, t, wall):
    return {"event": event, "t": t, "wall": f"2026-01-01T{wall}Z"}


@pytest.mark.parametrize(
    ("second", "starts", "said"),
    [("00:10:00", 599.9, ""), ("00:00:05", 10.0, "went back 5 s"), ("00:00:10", 10.0, "")],
)
def test_time_never_goes_back_between_sessions(second, starts, said):
    timeline = Timeline()
    times = [
        timeline.at(record("session", 0.0, "00:00:00")),
        timeline.at(record("in", 10.0, "00:00:10")),
    ]
    times += [
        timeline.at(record("session", 0.1, second)),
        timeline.at(record("in", 1.1, second[:-2] + "59")),
    ]
    assert times == sorted(times)
    assert timeline.start == pytest.approx(starts, abs=0.11)
    assert said in " ".join(timeline.jumps)
    assert bool(said) == any("back" in jump for jump in timeline.jumps)


def test_a_clock_that_was_set_within_a_session_does_not_move_the_next():
    timeline = Timeline()
    timeline.at(record("session", 0.0, "00:00:00"))
    timeline.at(record("in", 10.0, "05:00:10"))
    timeline.at(record("session", 0.0, "05:00:20"))
    assert timeline.start == 20.0
    assert timeline.jumps == ("the clock was set by +18000 s during session 1",)


def test_a_clock_that_jumped_between_sessions_is_said_in_the_table(tmp_path, monkeypatch):
    for cycles, resume in ((3, False), (6, True)):
        run_session(
            tmp_path, [OPTO], cycles=cycles, resume=resume, monkeypatch=monkeypatch,
            ports={"X": lambda c: Script(c, answer=lambda k: [(0.02, line(k))])},
        )  # fmt: skip
    raw = raw_path(tmp_path / "run.csv")
    records, hour = [], 9
    for one in map(decode_record, filter(None, raw.read_bytes().splitlines())):
        hour = 8 if one["event"] == "session" and records else hour
        records.append({**one, "wall": f"2026-01-01T{hour:02d}:00:{one['t']:09.6f}Z"})
    raw.write_bytes(b"".join(map(encode, records)))
    assert main(["record", "--rebuild", str(raw), str(tmp_path / "new.csv")]) == 0
    table = read_table(tmp_path / "new.csv")
    assert "went back 36" in table.metadata["record_clock"]
    times = table.covariates["time_s"].tolist()
    assert times == sorted(times)
