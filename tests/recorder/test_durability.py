"""No announced reading is lost: power cuts, failing disks, full disks, kills, interrupts."""

import errno
import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from bench import Script, run_session
from disks import FailingDisk, FullDisk, LoggedDisk, UnsyncedDisk, crash_states

from scara_iso import read_table
from scara_iso.base import process
from scara_iso.base.errors import (
    CannotCreateError,
    DataError,
    NoInputError,
    ScaraIsoError,
    WriteError,
)
from scara_iso.base.files import Disk
from scara_iso.rawfile import Tour, check_manifest, checksum, raw_path, read_history
from scara_iso.recorder import Noticed, Stored, Voided, rebuild
from scara_iso.recorder.journal import Journal
from scara_iso.recorder.ports.port import StreamClock

X = "X=opto-rs232@sim:?pace=0"
Y = "Y=mitutoyo-mux@sim:?pace=0"


def announced(said, tour=Tour()):  # noqa: B008 - frozen
    """Return the readings that a listener knows to be stored, by visit."""
    found = {}
    for event in said:
        match event:
            case Stored():
                found[event.axis, tour.visit(event.cycle, event.pose)] = event.value
            case Voided():
                for axis in event.axes:
                    del found[axis, tour.visit(event.cycle, event.pose)]
    return found


def readable(folder):
    """Return the readings that the raw file holds; none where there is no file."""
    try:
        history = read_history(raw_path(folder / "run.csv"))
    except NoInputError:
        return {}
    assert history.faults == []
    return {(a, c): v for a, cycles in history.readings().items() for c, v in cycles.items()}


def lost(told, folder):
    here = readable(folder)
    return {key: value for key, value in told.items() if here.get(key) != value}


def put(files, source, target):
    target.mkdir()
    for path, data in files.items():
        (target / path.relative_to(source)).write_bytes(data)


def logged_session(folder, *, poses=()):
    """Return the log of a session of two gauges of four visits that was resumed once."""
    folder.mkdir()
    disk = LoggedDisk()
    for visits, resume in ((2, False), (4, True)):
        cycles = visits // max(len(poses), 1)
        run_session(
            folder, [X, Y], cycles=cycles, resume=resume, disk=disk, tell=disk.announce, poses=poses
        )
    return disk.log


@pytest.fixture
def logged(tmp_path):
    folder = tmp_path / "live"
    return folder, logged_session(folder)


@pytest.mark.slow
@pytest.mark.parametrize("poses", [(), ("P1", "P2")])
def test_a_power_cut_after_any_operation_loses_no_announced_reading(tmp_path, poses):
    folder, tour = tmp_path / "live", Tour(poses)
    log = logged_session(folder, poses=poses)
    states, seen = 0, set()
    for end in range(len(log) + 1):
        told = announced([what[1] for what in log[:end] if what[0] == "said"], tour)
        done = [what for what in log[:end] if what[0] != "said"]
        for name, files in crash_states(done):
            state = (frozenset(told.items()), frozenset(files.items()))
            if state in seen:
                continue
            seen.add(state)
            states += 1
            after = tmp_path / f"{end}-{states}"
            put(files, folder, after)
            assert not lost(told, after), (end, name)
            if raw_path(after / "run.csv").exists():
                run_session(after, [X, Y], cycles=5, resume=True, disk=UnsyncedDisk(), poses=poses)
                cycle = read_table(after / "run.csv").cycle.tolist()
                assert cycle == sorted([1, 2, 3, 4, 5] * len(tour))
                assert not lost(told, after), (end, name)
    assert states > 100


def test_a_table_is_whole_or_not_there_after_a_power_cut(tmp_path, logged):
    folder, log = logged
    whole = {2, 4}
    for end in range(len(log) + 1):
        for _, files in crash_states([what for what in log[:end] if what[0] != "said"]):
            table = files.get(folder / "run.csv")
            assert table is None or table.count(b"\n") - table.count(b"#") - 1 in whole


def test_every_single_failure_of_the_disk_ends_the_session_and_loses_nothing(tmp_path):
    n = 0
    while True:
        folder = tmp_path / str(n)
        folder.mkdir()
        disk = FailingDisk(n)
        try:
            run_session(folder, [X], disk=disk)
        except (WriteError, CannotCreateError) as error:
            assert error.exit_code in (73, 74)  # noqa: PT017
        if disk.failed is None:
            break
        assert not lost(announced(run_session.said), folder)
        n += 1
    assert n > 15


def test_a_failed_sync_is_never_tried_again(tmp_path):
    for n in range(3, 40):
        folder = tmp_path / str(n)
        folder.mkdir()
        disk = FailingDisk(n)
        try:
            run_session(folder, [X], disk=disk)
        except WriteError:
            if disk.failed[0] == "sync":
                again = [what for what in disk.after if what[0] in ("sync", "write")]
                assert again == []
                assert not (folder / "run.csv").exists()
                return
    pytest.fail("no sync of the raw file was met")


@pytest.mark.parametrize("room", [0, 1, 300, 700, 701, 730, 900, 1100, 1500, 2000])
def test_a_full_disk_ends_the_session_and_the_rest_is_recorded_later(tmp_path, room):
    with pytest.raises(WriteError) as caught:
        run_session(tmp_path, [X], cycles=30, disk=FullDisk(room))
    assert caught.value.exit_code == 74
    told = announced(run_session.said)
    assert not lost(told, tmp_path)
    run_session(tmp_path, [X], cycles=30, resume=True)
    assert not lost(told, tmp_path)
    assert len(read_table(tmp_path / "run.csv")) == 30


class Interrupting(StreamClock):
    """A clock that is interrupted (Ctrl-C) at its n-th pause."""

    def __init__(self, n):
        super().__init__(paced=False)
        self.left = n

    def idle(self, until):
        self.left -= 1
        if self.left == -1:
            raise KeyboardInterrupt
        super().idle(until)


def test_an_interrupt_at_any_moment_keeps_what_was_announced(tmp_path):
    n = 0
    while True:
        folder = tmp_path / str(n)
        folder.mkdir()
        clock = Interrupting(n)
        try:
            run_session(folder, [X, Y], clock=clock)
            break
        except KeyboardInterrupt:
            told = announced(run_session.said)
            assert not lost(told, folder)
            rows = len({cycle for _, cycle in told})
            if rows:
                assert len(read_table(folder / "run.csv")) == rows
            else:
                assert list(folder.iterdir()) == []
        n += 1
    assert n > 3


def test_the_last_line_of_a_recording_is_safe_before_its_table_is_made(tmp_path):
    disk = LoggedDisk()
    run_session(tmp_path, [X], disk=disk)
    raw = raw_path(tmp_path / "run.csv")
    done = [one[:2] for one in disk.log if one[0] in ("write", "sync")]
    last = max(k for k, one in enumerate(done) if one == ("write", raw))
    assert done[last + 1] == ("sync", raw)


def test_a_recording_with_a_gap_is_not_gone_on_with(tmp_path):
    run_session(tmp_path, [X])
    raw = raw_path(tmp_path / "run.csv")
    journal = Journal(raw, disk=UnsyncedDisk(), clock=StreamClock(paced=False), new=False)
    journal.previous = read_history(raw).previous
    journal.append("void", cycle=2, axes=["X"], reason="by hand")
    journal.close()
    before = raw.read_bytes()
    with pytest.raises(DataError, match="cycle 2 is missing and later ones are there"):
        run_session(tmp_path, [X], cycles=5, resume=True)
    assert raw.read_bytes().startswith(before)


def test_a_torn_last_line_is_reported_and_recording_goes_on(tmp_path):
    run_session(tmp_path, [X])
    raw = raw_path(tmp_path / "run.csv")
    raw.write_bytes(raw.read_bytes()[:-40])
    assert read_history(raw).damaged == [raw.read_bytes().count(b"\n") + 1]
    run_session(tmp_path, [X], cycles=4, resume=True)
    assert len(read_table(tmp_path / "run.csv")) == 4


def cut_behind(raw, axis, cycle):
    """Leave of a raw file what a crash behind one stored line leaves."""
    lines = raw.read_bytes().splitlines(keepends=True)
    stored = b'"event":"stored"', b'"cycle":%d,"axis":"%s"' % (cycle, axis.encode())
    k = next(k for k, line in enumerate(lines) if all(word in line for word in stored))
    raw.write_bytes(b"".join(lines[: k + 1]))


def test_what_a_crash_left_of_a_cycle_asked_together_is_not_mixed_with_a_later_one(tmp_path):
    run_session(tmp_path, [X, Y])
    for path in (tmp_path / "run.csv", tmp_path / "run.manifest.json"):
        path.unlink()
    cut_behind(raw_path(tmp_path / "run.csv"), "X", 2)
    said = run_session(tmp_path, [X, Y], resume=True)
    for cycle in (2, 3):
        assert {s.axis for s in said if isinstance(s, Stored) and s.cycle == cycle} == {"X", "Y"}
    assert len(read_table(tmp_path / "run.csv")) == 3


def test_a_reading_announced_alone_is_not_paired_with_one_of_a_later_visit(tmp_path, monkeypatch):
    def keys(*frames):
        sent = {a: [(t, b"+000.%03d\r" % v) for b, v, t in frames if a == b] for a in "XY"}
        return {a: lambda c, a=a: Script(c, pushes=sent[a], answer=lambda _: None) for a in sent}

    sessions = [
        keys(("X", 1, 1.0), ("Y", 1, 1.4), ("X", 2, 5.0), ("Y", 2, 5.4)),
        keys(("Y", 3, 1.0), ("X", 3, 1.4)),  # the arm has gone on
    ]
    for k, ports in enumerate(sessions):
        if k:
            cut_behind(raw_path(tmp_path / "run.csv"), "X", 2)
            (tmp_path / "run.csv").unlink()
        said = run_session(
            tmp_path, [f"{axis}=opto-rs232?unit=mm@{axis}" for axis in "XY"], ports=ports,
            trigger="data", cycles=2, monkeypatch=monkeypatch, resume=k > 0,
        )  # fmt: skip
    axes = read_table(tmp_path / "run.csv").axes.values()
    assert [axis.readings.tolist() for axis in axes] == [[0.001, 0.003]] * 2
    struck = [one.message for one in said if isinstance(one, Noticed) and "struck" in one.message]
    assert struck == ["X of cycle 2 struck out: the cycle was cut short"]


def test_a_changed_digit_in_the_raw_file_is_seen(tmp_path):
    run_session(tmp_path, [X])
    raw = raw_path(tmp_path / "run.csv")
    lines = raw.read_bytes().splitlines(keepends=True)
    k = next(k for k, line in enumerate(lines) if b'"cycle":2' in line)
    lines[k] = lines[k].replace(b'"text":"0.', b'"text":"1.')
    raw.write_bytes(b"".join(lines))
    history = read_history(raw)
    assert history.damaged == [k + 1]
    assert sorted(history.readings()["X"]) == [1, 3]


def test_two_recorders_do_not_write_one_file(tmp_path):
    run_session(tmp_path, [X])
    file = Disk().open(raw_path(tmp_path / "run.csv"), new=False)
    try:
        with pytest.raises(CannotCreateError, match="another recorder"):
            run_session(tmp_path, [X], cycles=4, resume=True)
    finally:
        Disk().close(file)


def test_nothing_is_overwritten(tmp_path):
    (tmp_path / "run.csv").write_text("mine")
    with pytest.raises(CannotCreateError):
        run_session(tmp_path, [X])
    assert (tmp_path / "run.csv").read_text() == "mine"
    assert [path.name for path in tmp_path.iterdir()] == ["run.csv"]


def test_resume_without_a_recording_is_no_input(tmp_path):
    with pytest.raises(NoInputError):
        run_session(tmp_path, [X], resume=True)
    assert list(tmp_path.iterdir()) == []


def test_rebuild_gives_the_same_table(tmp_path):
    run_session(tmp_path, [X, Y])
    before = (tmp_path / "run.csv").read_bytes()
    (tmp_path / "run.csv").unlink()
    rebuild(tmp_path / "run.raw.jsonl", None, disk=Disk())
    assert (tmp_path / "run.csv").read_bytes() == before


def test_rebuild_does_not_overwrite_another_table(tmp_path):
    run_session(tmp_path, [X])
    (tmp_path / "run.csv").write_text("edited")
    with pytest.raises(CannotCreateError):
        rebuild(tmp_path / "run.raw.jsonl", None, disk=Disk())
    assert (tmp_path / "run.csv").read_text() == "edited"


@pytest.mark.parametrize(
    "text", [b"", b"hello\n", b'{"event":"session"}\n', b"\x00" * 100, b"[1,2]\n" * 3]
)
def test_a_file_that_is_no_recording_is_refused(tmp_path, text):
    raw = tmp_path / "run.raw.jsonl"
    raw.write_bytes(text)
    with pytest.raises(ScaraIsoError) as caught:
        rebuild(raw, None, disk=Disk())
    assert caught.value.exit_code == 65


def test_the_manifest_says_what_was_edited(tmp_path):
    run_session(tmp_path, [X])
    table = tmp_path / "run.csv"
    assert check_manifest(table) == ()
    table.write_text(table.read_text().replace("0.", "1.", 1))
    assert check_manifest(table) == ("run.csv was changed after it was recorded",)
    raw_path(table).unlink()
    assert len(check_manifest(table)) == 2


def test_resume_does_not_overwrite_an_edited_table(tmp_path):
    run_session(tmp_path, [X])
    table = tmp_path / "run.csv"
    table.write_text("edited")
    with pytest.raises(CannotCreateError, match="was changed"):
        run_session(tmp_path, [X], cycles=4, resume=True)
    assert table.read_text() == "edited"
    table.unlink()
    run_session(tmp_path, [X], cycles=4, resume=True)
    assert len(read_table(table)) == 4


@pytest.mark.parametrize("text", ["", "{}", "[]", '{"sha256": {"other.csv": "0"}}', "\x00"])
def test_a_strange_manifest_is_said(tmp_path, text):
    run_session(tmp_path, [X])
    (tmp_path / "run.manifest.json").write_text(text)
    assert len(check_manifest(tmp_path / "run.csv")) == 1


def test_no_manifest_says_nothing(tmp_path):
    assert check_manifest(tmp_path / "run.csv") == ()


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="needs fork and SIGKILL")
def test_killed_at_random_moments():
    script = Path(__file__).parents[2] / "benchmarks" / "durability.py"
    found = subprocess.run(
        [sys.executable, script, "--kills", "20", "--only", "kills"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert found.returncode == 0, found.stderr
    assert "| kill -9 at a random moment | 20 |" in found.stdout
    assert found.stdout.rstrip().endswith("| 0 | 0 |")


def test_no_error_number_is_hidden(tmp_path):
    with pytest.raises(WriteError, match="injected"):
        run_session(tmp_path, [X], disk=FailingDisk(4, errno.EDQUOT))


def test_an_interrupt_within_a_line_breaks_no_chain(tmp_path, monkeypatch):
    class Interrupted(UnsyncedDisk):
        def write(self, file, data):
            taken = super().write(file, data)
            if b"second" in data:
                signal.raise_signal(signal.SIGINT)
            return taken

    def wait_behind(journal):
        journal.append("note", text="second")
        time.sleep(5)

    monkeypatch.setattr(process, "_heard", [])
    before = signal.signal(signal.SIGINT, process._hear)
    raw = tmp_path / "run.raw.jsonl"
    journal = Journal(raw, disk=Interrupted(), clock=StreamClock(paced=False), new=True)
    try:
        journal.append("note", text="first")
        with pytest.raises(KeyboardInterrupt):
            wait_behind(journal)
        journal.append("end")
    finally:
        signal.signal(signal.SIGINT, before)
        journal.close()
    lines = raw.read_bytes().splitlines(keepends=True)
    assert [json.loads(line)["prev"] for line in lines[1:]] == [*map(checksum, lines[:-1])]
