"""What was changed after it was recorded is said for ever: in head, manifest and report."""

import json

import pytest
from bench import Orders, kept, run_session
from budget import examples
from disks import UnsyncedDisk
from hypothesis import given, strategies as st

from scara_iso import read_table
from scara_iso.base.errors import CannotCreateError, DataError
from scara_iso.commands import main
from scara_iso.rawfile import check_manifest, encode, raw_path, read_history, read_records
from scara_iso.rawfile.integrity import decode_record
from scara_iso.recorder import Quit, Take, Void

X = ["X=opto-rs232@sim:?pace=0"]
CHANGED = "run.raw.jsonl was changed after it was recorded"
MISSING = "run.manifest.json is missing: whether the recording was changed cannot be seen"


@pytest.fixture
def recording(tmp_path, monkeypatch):
    """Four cycles of five planned, the last of them struck out."""
    monkeypatch.chdir(tmp_path)
    orders = Orders(*[Take()] * 4, Void("slipped"), Quit())
    run_session(tmp_path, X, trigger="enter", cycles=5, operator=orders)
    return tmp_path


def lines_of(folder):
    return raw_path(folder / "run.csv").read_bytes().splitlines(keepends=True)


def change(folder, change_lines):
    raw = raw_path(folder / "run.csv")
    raw.write_bytes(b"".join(change_lines(lines_of(folder))))


def find(lines, word):
    return next(k for k, line in enumerate(lines) if word in line)


def flip(lines):
    """Flip a bit of the line that strikes a reading out."""
    k = find(lines, b'"event":"void"')
    return [*lines[:k], bytes([lines[k][0] ^ 1]) + lines[k][1:], *lines[k + 1 :]]


def forge(lines):
    """Give a reading another value, with a checksum that fits."""
    k = find(lines, b'"event":"stored"')
    record = decode_record(lines[k])
    return [*lines[:k], encode({**record, "text": "9.999"}), *lines[k + 1 :]]


def take_away(lines):
    k = find(lines, b'"event":"void"')
    return [*lines[:k], *lines[k + 1 :]]


def resume(folder):
    run_session(folder, X, trigger="enter", cycles=6, resume=True, operator=Orders(*[Take()] * 9))


def rebuild(folder):
    (folder / "run.csv").unlink()
    assert main(["record", "--rebuild", "run.raw.jsonl"]) == 0


def said_everywhere(folder, capsys, *words):
    """Say whether head, manifest, analysis and report have each word."""
    capsys.readouterr()
    main(["analyze", "run.csv", "--cycles", str(len(read_table(folder / "run.csv"))), "--json"])
    findings = json.loads(capsys.readouterr().out)["findings"]
    found = [one["message"] for one in findings if one["code"] == "edited"]
    assert len(found) == len(set(found))
    main(["report", "run.csv", "--cycles", "5", "-o", "run.md"])
    texts = {
        "head": read_table(folder / "run.csv").metadata.get("doubts", ""),
        "manifest": "\n".join(json.loads((folder / "run.manifest.json").read_text())["doubts"]),
        "analysis": "\n".join(found),
    }
    return {(word, where): word in text for where, text in texts.items() for word in words}


@pytest.mark.parametrize("edited", [False, True])
def test_a_table_that_is_edited_after_its_recording_is_said_by_analyze(recording, capsys, edited):
    table = recording / "run.csv"
    if edited:  # the last digit of the last reading
        text = table.read_text().rstrip()
        table.write_text(f"{text[:-1]}{(int(text[-1]) + 1) % 10}\n")
    words = ["analyze", "run.csv", "--cycles", str(len(read_table(table))), "--json"]
    capsys.readouterr()
    main(words)
    findings = json.loads(capsys.readouterr().out)["findings"]
    assert [one["code"] for one in findings].count("edited") == edited


@pytest.mark.parametrize("go_on", [resume, rebuild])
@pytest.mark.parametrize("tamper", [flip, forge, take_away])
def test_a_changed_raw_file_is_said_in_all_that_is_made_of_it(recording, capsys, go_on, tamper):
    change(recording, tamper)
    go_on(recording)
    found = said_everywhere(recording, capsys, CHANGED, "lines were changed or taken away before")
    assert all(found.values()), found


@pytest.mark.parametrize("go_on", [resume, rebuild])
@pytest.mark.parametrize("tamper", [flip, forge, take_away])
def test_it_is_said_without_the_manifest_too(recording, capsys, go_on, tamper):
    change(recording, tamper)
    for name in ("run.csv", "run.manifest.json"):
        (recording / name).unlink()
    (recording / "run.csv").touch()
    if go_on is resume:
        (recording / "run.csv").unlink()
    go_on(recording)
    found = said_everywhere(recording, capsys, MISSING, "lines were changed or taken away before")
    assert all(found.values()), found


@pytest.mark.parametrize("go_on", [resume, rebuild])
@pytest.mark.parametrize("text", [None, "", "{}", "\x00", '{"sha256": {"run.csv": "0"}}'])
def test_a_damaged_or_deleted_manifest_is_remembered(recording, capsys, go_on, text):
    manifest = recording / "run.manifest.json"
    manifest.unlink() if text is None else manifest.write_text(text)
    go_on(recording)
    assert all(said_everywhere(recording, capsys, "manifest").values())


def flip_last(lines):
    return [*lines[:-1], lines[-1].replace(b"complete", b"complet3")]


def strike_last(lines):
    """End with the line that strikes a reading out, as a kill does, and harm it."""
    k = find(lines, b'"event":"void"')
    return [*lines[:k], lines[k].replace(b"slipped", b"sliPped")]


@pytest.mark.parametrize("go_on", [resume, rebuild])
@pytest.mark.parametrize("tamper", [flip_last, strike_last])
def test_a_last_line_that_was_changed_is_no_tear(recording, capsys, go_on, tamper):
    change(recording, tamper)
    (recording / "run.manifest.json").unlink()
    if go_on is resume:
        (recording / "run.csv").unlink()
    go_on(recording)
    found = said_everywhere(recording, capsys, "lines were changed or taken away before")
    assert all(found.values()), found


@pytest.mark.parametrize("cut", range(1, 40))
def test_a_last_line_that_a_crash_tore_is_not_called_changed(recording, cut):
    raw = raw_path(recording / "run.csv")
    raw.write_bytes(raw.read_bytes()[:-cut])
    assert read_history(raw).doubts == ()


@pytest.mark.parametrize(
    "go_on", [resume, lambda _: main(["record", "--rebuild", "run.raw.jsonl"])]
)
def test_a_table_whose_manifest_is_gone_is_doubted_though_no_end_is_recorded(
    recording, capsys, go_on
):
    change(recording, lambda lines: lines[:-1])
    (recording / "run.manifest.json").unlink()
    go_on(recording)
    assert all(said_everywhere(recording, capsys, MISSING).values())


def test_a_doubt_outlives_every_later_session(recording, capsys):
    change(recording, forge)
    resume(recording)
    (recording / "run.manifest.json").unlink()
    rebuild(recording)
    run_session(
        recording, X, trigger="enter", cycles=7, resume=True, operator=Orders(*[Take()] * 9)
    )
    assert all(said_everywhere(recording, capsys, CHANGED, MISSING).values())


def test_a_raw_file_that_is_gone_is_missing_and_not_changed(recording):
    raw_path(recording / "run.csv").unlink()
    assert check_manifest(recording / "run.csv") == ("run.raw.jsonl is missing or cannot be read",)


def test_the_report_shows_the_doubt(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    run_session(tmp_path, X, cycles=31)
    change(tmp_path, forge)
    rebuild(tmp_path)
    (tmp_path / "elsewhere.csv").write_bytes((tmp_path / "run.csv").read_bytes())
    assert main(["report", "elsewhere.csv", "-o", "out.md"]) == 0
    assert (tmp_path / "out.md").read_text(encoding="utf-8").count("changed after it was") >= 2


def test_what_nobody_touched_is_not_doubted(recording, capsys):
    resume(recording)
    rebuild(recording)
    assert "doubts" not in read_table(recording / "run.csv").metadata
    assert check_manifest(recording / "run.csv") == ()


def test_what_a_crash_tore_is_not_doubted(recording):
    (recording / "run.csv").unlink()
    (recording / "run.manifest.json").unlink()
    lines = lines_of(recording)
    change(recording, lambda lines: [*lines[:-1], lines[-1][:20]])
    resume(recording)
    assert len(lines_of(recording)) > len(lines)
    assert read_history(raw_path(recording / "run.csv")).doubts == ()
    assert check_manifest(recording / "run.csv") == ()


def test_a_session_that_a_crash_ended_leaves_the_manifest_of_the_one_before(recording):
    names = ("run.csv", "run.manifest.json")
    before = {name: (recording / name).read_bytes() for name in names}
    ended = len(lines_of(recording))
    resume(recording)
    for name, data in before.items():
        (recording / name).write_bytes(data)
    change(recording, lambda lines: [*lines[: ended + 4], lines[ended + 4][:9]])
    assert check_manifest(recording / "run.csv") == ()
    resume(recording)
    assert check_manifest(recording / "run.csv") == ()
    assert "doubts" not in read_table(recording / "run.csv").metadata


@pytest.mark.parametrize(("again", "nth"), [(False, 1), (True, 0), (True, 1)])
def test_a_crash_between_table_and_manifest_is_not_doubted(tmp_path, again, nth):
    class Cut(UnsyncedDisk):
        left = nth

        def replace(self, source, target):
            self.left -= 1
            if self.left < 0:
                raise KeyboardInterrupt
            super().replace(source, target)

    if again:
        run_session(tmp_path, X, cycles=3)
    with pytest.raises(KeyboardInterrupt):
        run_session(tmp_path, X, cycles=5, resume=again, disk=Cut())
    run_session(tmp_path, X, cycles=7, resume=True)
    table = read_table(tmp_path / "run.csv")
    assert len(table) == 7
    assert "doubts" not in table.metadata
    assert check_manifest(tmp_path / "run.csv") == ()


def test_a_table_without_its_manifest_is_not_written_over_where_it_says_something_else(recording):
    (recording / "run.manifest.json").unlink()
    (recording / "run.csv").write_text("mine")
    with pytest.raises(CannotCreateError, match="was changed"):
        resume(recording)
    assert (recording / "run.csv").read_text() == "mine"


def test_a_table_that_came_meanwhile_is_not_written_over(tmp_path):
    class Busy(Orders):
        def poll(self):
            (tmp_path / "run.csv").write_text("mine")
            return super().poll()

    with pytest.raises(CannotCreateError, match="another program"):
        run_session(tmp_path, X, trigger="enter", cycles=2, operator=Busy(Take(), Take()))
    assert (tmp_path / "run.csv").read_text() == "mine"
    assert sorted(kept(tmp_path)) == [1, 2]


def test_a_manifest_that_is_there_is_not_written_over(tmp_path):
    (tmp_path / "run.manifest.json").write_text("mine")
    with pytest.raises(CannotCreateError):
        run_session(tmp_path, X)
    assert [path.name for path in tmp_path.iterdir()] == ["run.manifest.json"]


def unchained(lines):
    """Return the lines as older versions wrote them."""
    records = [{k: v for k, v in decode_record(line).items() if k != "prev"} for line in lines]
    return [encode(record) for record in records]


def test_a_raw_file_of_an_older_version_is_read_and_gone_on_with(recording):
    before = kept(recording)
    for name in ("run.csv", "run.manifest.json"):
        (recording / name).unlink()
    change(recording, lambda lines: unchained(lines)[:-1])
    assert read_history(raw_path(recording / "run.csv")).doubts == ()
    resume(recording)
    assert {k: v for k, v in kept(recording).items() if k in before} == before
    assert "doubts" not in read_table(recording / "run.csv").metadata
    change(recording, flip)
    assert read_history(raw_path(recording / "run.csv")).doubts != ()


@examples(300)
@given(data=st.data())
def test_any_bit_of_any_line_but_the_last_is_noticed(data, tmp_path_factory):
    lines = _recorded(tmp_path_factory)
    line = data.draw(st.integers(0, len(lines) - 2))
    place = data.draw(st.integers(0, len(lines[line]) - 1))
    bit = data.draw(st.integers(0, 7))
    whole = bytearray(lines[line])
    whole[place] ^= 1 << bit
    raw = tmp_path_factory.getbasetemp() / "flipped.raw.jsonl"
    raw.write_bytes(b"".join([*lines[:line], bytes(whole), *lines[line + 1 :]]))
    assert read_history(raw).doubts != ()


_LINES = []


def _recorded(factory):
    if not _LINES:
        folder = factory.mktemp("recorded")
        run_session(folder, X)
        _LINES.extend(lines_of(folder))
    return _LINES


def session(**changes):
    gauge = {
        "spec": "X=opto-rs232@sim:", "dialect": "opto-rs232", "line": "", "identity": "",
        "unit": "mm", "unit_from": "you", "simulated": True,
    }  # fmt: skip
    return {
        "event": "session", "t": 0.0, "wall": None, "schema": "scara-iso/raw/1", "cycles": 3,
        "trigger": "timer:1", "gauges": {"X": gauge}, "metadata": {},
    } | changes  # fmt: skip


def stored(cycle=1, **changes):
    return {
        "event": "stored", "t": 1.0, "wall": None, "cycle": cycle, "axis": "X", "text": "0.1",
        "unit": "mm", "at": 0.5,
    } | changes  # fmt: skip


VOID = {"event": "void", "t": 2.0, "wall": None, "cycle": 1, "axes": ["X"], "reason": ""}


@pytest.mark.parametrize(
    ("records", "line", "word"),
    [
        ([session(), stored(1), stored(1)], 3, "stored twice"),
        ([session(), stored(0)], 2, "cycle 0"),
        ([session(), stored(-1)], 2, "cycle -1"),
        ([session(), stored(10_000_001)], 2, "cycle 10000001"),
        ([session(schema="scara-iso/raw/2"), stored()], 1, "is not scara-iso/raw/1"),
        ([session(schema=None), stored()], 1, "is not scara-iso/raw/1"),
        ([session(gauges={"X": {}}), stored()], 1, "spec"),
        ([session(gauges=[]), stored()], 1, "session"),
        ([session(cycles="many"), stored()], 1, "session"),
        ([session(metadata=[1]), stored()], 1, "session"),
        ([{k: v for k, v in session().items() if k != "trigger"}, stored()], 1, "trigger"),
        ([session(), stored(axis="Q")], 2, "Q"),
        ([session(), stored(unit="furlong")], 2, "unknown unit"),
        ([session(), stored(1), stored(2, unit="deg")], 3, "deg after"),
        ([session(), stored(text="nan")], 2, "not a reading"),
        ([session(), stored(text="1e999")], 2, "not a reading"),
        ([session(), stored(at="soon")], 2, "stored"),
        ([session(), stored(t="soon")], 2, "stored"),
        ([session(), VOID], 2, "void"),
        ([session(), stored(1), {**VOID, "cycle": 9}], 3, "void"),
        ([stored(1)], 1, "X"),
        ([session(wall="2026-11-22T00:00:00"), session(wall="yesterday")], 2, "session"),
        ([session(), stored(1), session(doubts=3)], 3, "session"),
    ],
)
def test_a_raw_file_that_contradicts_itself_is_refused_with_its_line(
    tmp_path, capsys, records, line, word
):
    raw = tmp_path / "run.raw.jsonl"
    raw.write_bytes(b"".join(map(encode, records)))
    assert main(["record", "--rebuild", str(raw)]) == 65
    out, err = capsys.readouterr()
    assert out == ""
    assert f"line {line}: " in err
    assert word in err
    assert not (tmp_path / "run.csv").exists()
    with pytest.raises(DataError):
        run_session(tmp_path, X, resume=True)
    assert raw.read_bytes().count(b"\n") == len(records)


def test_every_line_names_the_one_before_it(recording):
    records = [record for _, record in read_records(raw_path(recording / "run.csv"))]
    assert [r["prev"] for r in records] == ["00000000", *[r["crc"] for r in records[:-1]]]
