"""The path of a recording: what is refused before it begins, and what is left when it ends."""

import signal
import sys
import time

import pytest
from bench import Orders, Script, kept, run_session
from disks import FullDisk, UnsyncedDisk

from scara_iso import read_table
from scara_iso.base import process
from scara_iso.base.errors import CannotCreateError, InstrumentError, UsageError, WriteError
from scara_iso.rawfile import raw_path, read_records
from scara_iso.recorder import CycleDone, Noticed, Quit, Take, Void, recording as module
from scara_iso.recorder.ports.port import StreamClock

SIM = ["X=opto-rs232@sim:?pace=0"]


def replayed(folder):
    return [f"X=mitutoyo-mux?unit=mm&channel=1@replay:{folder / 'stream.bin'}"]


@pytest.fixture
def stream(tmp_path):
    (tmp_path / "stream.bin").write_bytes(b"01A+0000.123\r01A+0000.124\r01A+0000.125\r")
    return tmp_path


def events(folder, name):
    tape = read_records(raw_path(folder / "run.csv"))
    return [record for _, record in tape if record and record["event"] == name]


class Dated(StreamClock):
    """A simulated session's clock on a day."""

    def wall(self):
        return "2026-05-02T08:00:00Z"


@pytest.mark.parametrize(("due", "past"), [("2026-05-01", True), ("2026-05-02", False)])
def test_a_calibration_that_has_run_out_is_said_as_the_recording_begins(tmp_path, due, past):
    said = run_session(
        tmp_path, SIM, cycles=2, clock=Dated(paced=False), metadata={"calibration_due": due}
    )
    noticed = [one.message for one in said if isinstance(one, Noticed)]
    line = f"calibration_due {due} is past: calibrate the indicator, or use another"
    assert noticed == ([line] if past else [])


def test_a_recorded_stream_is_recorded_once_and_not_gone_on_with(stream):
    run_session(stream, replayed(stream), trigger="data", cycles=3)
    assert read_table(stream / "run.csv").axes["X"].readings.tolist() == [0.123, 0.124, 0.125]
    with pytest.raises(UsageError, match="a recorded stream cannot be resumed"):
        run_session(stream, replayed(stream), trigger="data", cycles=4, resume=True)
    assert kept(stream) == {1: 0.123, 2: 0.124, 3: 0.125}


@pytest.mark.parametrize("stable", [2, 3])
def test_a_recorded_stream_is_not_asked_twice(stream, stable):
    with pytest.raises(UsageError, match="cannot be asked again") as refused:
        run_session(stream, replayed(stream), trigger="data", stable=stable)
    assert "stable=" in refused.value.remedy
    assert not raw_path(stream / "run.csv").exists()


def test_a_live_indicator_is_gone_on_with_and_asked_until_it_is_stable(tmp_path):
    said = run_session(tmp_path, SIM, trigger="timer:1", cycles=2, stable=2)
    assert len([s for s in said if isinstance(s, CycleDone)]) == 2
    run_session(tmp_path, SIM, trigger="timer:1", cycles=3, stable=2, resume=True)
    assert sorted(kept(tmp_path)) == [1, 2, 3]


def test_two_axes_on_one_cable_are_refused_and_two_simulated_ones_are_not(tmp_path):
    with pytest.raises(UsageError, match="X and Y are the same device"):
        run_session(tmp_path, ["X=opto-rs232@/dev/ttyZ9", "Y=opto-rs232@/dev/ttyZ9"])
    assert list(tmp_path.iterdir()) == []
    run_session(tmp_path, ["X=opto-rs232@sim:?pace=0", "Y=opto-rs232@sim:?pace=0"], cycles=1)
    assert list(read_table(tmp_path / "run.csv").axes) == ["X", "Y"]


@pytest.mark.parametrize("name", ["run.csv", "run.raw.jsonl", "run.manifest.json"])
def test_files_that_are_there_stop_it_before_a_port_is_opened(tmp_path, monkeypatch, name):
    (tmp_path / name).write_text("mine")
    monkeypatch.setattr(module, "open_port", None)
    with pytest.raises(CannotCreateError, match="exists already"):
        run_session(tmp_path, SIM)
    assert [path.name for path in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_text() == "mine"


class Closing(Script):
    closed = 0

    def close(self):
        type(self).closed += 1


def test_every_port_is_closed_however_it_ends(tmp_path, monkeypatch):
    Closing.closed = 0
    ports = {"X": lambda c: Closing(c, lost_at=0.5), "Y": Closing}
    with pytest.raises(InstrumentError):
        run_session(
            tmp_path, ["X=opto-rs232?unit=mm@a", "Y=opto-rs232?unit=mm@b"], ports=ports,
            monkeypatch=monkeypatch,
        )  # fmt: skip
    assert Closing.closed == 2


def silent(tmp_path, monkeypatch):
    with pytest.raises(InstrumentError) as ended:
        run_session(
            tmp_path, ["X=opto-rs232?unit=mm@script"], ports={"X": Script}, trigger="enter",
            operator=Orders(Quit()), monkeypatch=monkeypatch,
        )  # fmt: skip
    return ended.value


def test_without_a_reading_nothing_is_left_and_what_to_try_is_said(tmp_path, monkeypatch):
    error = silent(tmp_path, monkeypatch)
    assert error.what == "no reading was recorded, and no file is kept"
    assert "probe=PORT" in error.remedy
    assert list(tmp_path.iterdir()) == []


def test_a_reading_that_was_struck_out_stays_in_the_raw_file(tmp_path):
    with pytest.raises(InstrumentError, match="no cycle is complete") as ended:
        run_session(
            tmp_path, SIM, trigger="enter", operator=Orders(Take(), Void("slipped"), Quit())
        )
    assert ended.value.where == str(tmp_path / "run.csv")
    assert "run.raw.jsonl holds the readings" in ended.value.what
    assert [path.name for path in tmp_path.iterdir()] == ["run.raw.jsonl"]
    assert [record["complete"] for record in events(tmp_path, "end")] == [False]


def test_the_table_and_manifest_go_with_the_last_cycle(tmp_path):
    run_session(tmp_path, SIM, trigger="enter", cycles=1, operator=Orders(Take()))
    assert len(list(tmp_path.iterdir())) == 3
    with pytest.raises(InstrumentError, match="no cycle is complete"):
        run_session(
            tmp_path, SIM, trigger="enter", cycles=2, resume=True,
            operator=Orders(Void("slipped"), Quit()),
        )  # fmt: skip
    assert [path.name for path in tmp_path.iterdir()] == ["run.raw.jsonl"]


@pytest.mark.parametrize(("cycles", "complete"), [(2, True), (3, False)])
def test_the_end_says_whether_all_planned_cycles_are_there(tmp_path, cycles, complete):
    said = run_session(
        tmp_path, SIM, trigger="enter", cycles=cycles, operator=Orders(Take(), Take(), Quit())
    )
    assert [record["complete"] for record in events(tmp_path, "end")] == [complete]
    done = said[-1]
    assert (done.cycles, done.planned) == (2, cycles)
    assert done.table == str(tmp_path / "run.csv")
    assert done.raw == str(tmp_path / "run.raw.jsonl")


def full_output(_event):
    raise WriteError("standard output cannot be written")


class Closed(UnsyncedDisk):
    """A folder whose names this user may not read: it cannot be synced."""

    def sync_folder(self, folder):
        raise PermissionError(13, "Permission denied")


@pytest.mark.parametrize(
    ("failing", "error"),
    [({"tell": full_output}, WriteError), ({"disk": Closed()}, CannotCreateError)],
)
def test_nothing_is_left_behind_where_no_reading_was_stored(tmp_path, failing, error):
    with pytest.raises(error):
        run_session(tmp_path, SIM, **failing)
    assert list(tmp_path.iterdir()) == []


def test_a_full_disk_that_keeps_the_raw_file_is_gone_on_with(tmp_path):
    with pytest.raises(WriteError) as ended:
        run_session(tmp_path, SIM, disk=FullDisk(10))
    assert "resume=True" in ended.value.remedy
    assert "begin again" not in ended.value.remedy


@pytest.fixture
def listening(monkeypatch):
    monkeypatch.setattr(process, "_heard", [])
    monkeypatch.setattr(sys, "unraisablehook", sys.unraisablehook)
    before = {number: signal.getsignal(number) for number in process._numbers()}
    process.listen()
    yield
    time.sleep(0.1)  # until none is put off any more
    for number, handler in before.items():
        signal.signal(number, handler)


class Interrupted(UnsyncedDisk):
    """A disk at which somebody presses Ctrl-C as a file ``appears``."""

    def __init__(self, appears):
        self.appears = appears

    def sync_folder(self, folder):
        if self.appears(folder):
            signal.raise_signal(signal.SIGINT)


@pytest.mark.usefixtures("listening")
def test_an_interrupt_as_the_raw_file_appears_leaves_nothing(tmp_path):
    raw = tmp_path / "run.raw.jsonl"
    disk = Interrupted(lambda _: raw.exists() and not raw.stat().st_size)
    with pytest.raises(KeyboardInterrupt):
        run_session(tmp_path, SIM, cycles=100_000, disk=disk)
    assert "run.csv" in {path.name for path in tmp_path.iterdir()} or not raw.exists()


@pytest.mark.usefixtures("listening")
def test_a_second_interrupt_does_not_cost_the_table(tmp_path, monkeypatch):
    def again(*_):
        signal.raise_signal(signal.SIGINT)
        return made(*_)

    def stop(event):
        if isinstance(event, CycleDone):
            raise KeyboardInterrupt

    def session():
        try:
            run_session(tmp_path, SIM, cycles=3, tell=stop)
        finally:
            time.sleep(5)  # until the second is raised

    made = module.table_of
    monkeypatch.setattr(module, "table_of", again)
    with pytest.raises(KeyboardInterrupt):
        session()
    assert len(read_table(tmp_path / "run.csv")) == 1


def test_a_table_rebuilt_meanwhile_is_gone_on_with(tmp_path):
    def make(event):
        if isinstance(event, CycleDone) and event.cycle == 2:
            module.rebuild(tmp_path / "run.raw.jsonl", None, disk=UnsyncedDisk())

    run_session(tmp_path, SIM, cycles=3, tell=make)
    assert len(read_table(tmp_path / "run.csv")) == 3


def test_a_table_that_another_program_wrote_meanwhile_is_kept(tmp_path):
    table = tmp_path / "run.csv"

    def write(event):
        if isinstance(event, CycleDone):
            table.write_text("theirs")

    with pytest.raises(CannotCreateError, match="written by another program") as ended:
        run_session(tmp_path, SIM, cycles=2, tell=write)
    assert "rebuild=True" in ended.value.remedy
    assert table.read_text() == "theirs"
    assert sorted(kept(tmp_path)) == [1, 2]


def test_a_session_that_goes_on_writes_its_own_table_anew(tmp_path):
    run_session(tmp_path, SIM, cycles=1)
    run_session(tmp_path, SIM, cycles=2, resume=True)
    assert len(read_table(tmp_path / "run.csv")) == 2
    assert len(events(tmp_path, "session")) == 2


def test_ctrl_c_leaves_the_table_of_what_was_recorded(tmp_path):
    def interrupt(event):
        if isinstance(event, CycleDone) and event.cycle == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_session(tmp_path, SIM, cycles=5, tell=interrupt)
    assert len(read_table(tmp_path / "run.csv")) == 2


class Broken(UnsyncedDisk):
    """Fails at the third line of the raw file that holds a reading."""

    stored = 0

    def write(self, file, data):
        self.stored += b'"stored"' in bytes(data)
        if self.stored > 2:
            raise OSError(5, "Input/output error")
        return super().write(file, data)


def test_after_a_disk_that_failed_no_table_is_written(tmp_path):
    with pytest.raises(WriteError):
        run_session(tmp_path, SIM, cycles=5, disk=Broken())
    assert sorted(kept(tmp_path)) == [1, 2]
    assert [path.name for path in tmp_path.iterdir()] == ["run.raw.jsonl"]
