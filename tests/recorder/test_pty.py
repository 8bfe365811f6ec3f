"""End to end on pseudo-terminals, the instrument in another process."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from scara_iso import read_table
from scara_iso.commands import main
from scara_iso.rawfile import raw_path
from scara_iso.rawfile.integrity import decode_record
from scara_iso.recorder.indicators import LineSettings
from scara_iso.recorder.ports.device import DevicePort

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs pseudo-terminals")
EXAMPLE = Path(__file__).parents[2] / "examples" / "fum_scara.toml"


def record(folder, capsys, *options, table="run.csv"):
    """Run the command; return exit code, JSON events and standard error."""
    code = main(["record", str(folder / table), "--json", *options])
    out, err = capsys.readouterr()
    return code, [json.loads(line) for line in out.splitlines()], err


def stored(events):
    return [(e["cycle"], e["value"]) for e in events if e["event"] == "stored"]


def kinds(events):
    return [e["event"] for e in events if e["event"] in ("fault", "garbage", "timeout", "refused")]


OPTO = "X=opto-rs232?unit=mm@"


def test_reads_a_good_instrument(tmp_path, capsys, instrument):
    device = instrument(r"+000.101\r", r"+000.102\r")
    code, events, _ = record(
        tmp_path, capsys, "--gauge", OPTO + device, "--trigger", "timer:0.01", "--cycles", "2"
    )
    assert code == 0
    assert stored(events) == [(1, 0.101), (2, 0.102)]
    run = read_table(tmp_path / "run.csv")
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", run.metadata["recorded"])
    assert run.axes["X"].readings.tolist() == [0.101, 0.102]
    assert device in run.metadata["indicator"]


@pytest.mark.slow
def test_late_twice_wrong_and_silent_answers(tmp_path, capsys, instrument):
    device = instrument(
        r"+000.101\r", r"1.2:+009.999\r", r"+000.102\r+000.102\r", r"ERR3\r", r"\xb1\xb2\x8d",
        r"+000.103\r", r"+000.104\r",
    )  # fmt: skip
    code, events, _ = record(
        tmp_path, capsys, "--gauge", OPTO + device, "--trigger", "timer:0.01", "--cycles", "4"
    )
    assert code == 0
    assert stored(events) == [(1, 0.101), (2, 0.102), (3, 0.103), (4, 0.104)]
    assert kinds(events) == [
        "timeout", "refused", "refused", "fault", "garbage", "timeout",
    ]  # fmt: skip


def test_a_cable_pulled_mid_frame_is_seen_within_a_second(tmp_path, capsys, instrument):
    device = instrument(r"+000.101\r", "unplug:+012.")
    code, events, err = record(
        tmp_path, capsys, "--gauge", OPTO + device, "--trigger", "timer:0.01", "--cycles", "3"
    )
    assert code == 69
    assert stored(events) == [(1, 0.101)]
    assert "unplugged" in err
    assert "another program" in err
    assert read_table(tmp_path / "run.csv").axes["X"].readings.tolist() == [0.101]
    assert b"+012.".hex() in raw_path(tmp_path / "run.csv").read_text()
    records = [
        decode_record(line) for line in raw_path(tmp_path / "run.csv").read_bytes().splitlines()
    ]
    last_byte = next(r["t"] for r in records if r.get("hex") == b"+012.".hex())
    assert records[-1]["event"] == "end"
    assert records[-1]["t"] - last_byte < 1.0


def test_pushed_readings_and_two_gauges(tmp_path, capsys, instrument):
    x = instrument(*[rf"+000.10{n}\r" for n in range(9)], "push:0.3")
    y = instrument(*[rf"01A+0000.50{n}\r" for n in range(9)], "push:0.3")
    code, _, _ = record(
        tmp_path, capsys, "--gauge", OPTO + x, "--gauge", f"Y=mitutoyo-mux@{y}", "--unit", "mm",
        "--trigger", "data", "--cycles", "3", "--rearm", "0.01",
    )  # fmt: skip
    assert code == 0
    run = read_table(tmp_path / "run.csv")
    assert len(run) == 3
    assert set(run.axes) == {"X", "Y"}


def test_one_device_for_two_axes_is_refused(tmp_path, capsys, instrument):
    device = instrument("-")
    link = tmp_path / "gauge"
    link.symlink_to(device)
    code, _, err = record(
        tmp_path, capsys, "--gauge", OPTO + device, "--gauge", f"Y=opto-rs232@{link}",
        "--trigger", "data",
    )  # fmt: skip
    assert code == 2
    assert "same device" in err


def test_a_port_in_use_is_refused(tmp_path, capsys, instrument):
    device = instrument("-")
    port = DevicePort(device, LineSettings())
    try:
        code, _, err = record(tmp_path, capsys, "--gauge", OPTO + device, "--trigger", "data")
    finally:
        port.close()
    assert code == 69
    assert "another program" in err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(sys.platform != "linux", reason="asks the kernel of Linux")
def test_a_program_without_a_lock_is_kept_out_too(instrument):
    fcntl = pytest.importorskip("fcntl")
    device = instrument("-")
    port = DevicePort(device, LineSettings())
    other = os.open(device, os.O_RDWR | os.O_NOCTTY) if os.getuid() == 0 else None
    try:
        if other is None:
            with pytest.raises(OSError, match="busy"):
                os.open(device, os.O_RDWR | os.O_NOCTTY)
        else:  # root may open it all the same: ask whether it is marked as exclusive
            assert fcntl.ioctl(other, 0x80045440, b"\0" * 4) != b"\0" * 4  # TIOCGEXCL
            os.close(other)
    finally:
        port.close()


def test_an_interrupt_ends_with_130_and_keeps_the_readings(tmp_path, instrument):
    device = instrument(r"+000.101\r")
    process = subprocess.Popen(
        [sys.executable, "-m", "scara_iso", "record", tmp_path / "run.csv", "--gauge",
         OPTO + device, "--trigger", "timer:0.05"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    told = 0
    for line in process.stdout:
        told += json.loads(line)["event"] == "stored"
        if told == 3:
            process.terminate()
            break
    out, _ = process.communicate()
    told += out.count('"stored"')
    assert process.returncode == 130
    assert len(read_table(tmp_path / "run.csv")) == told


def test_the_live_screen_on_a_terminal(tmp_path):
    main_end, terminal = os.openpty()
    process = subprocess.Popen(
        [sys.executable, "-m", "scara_iso", "record", tmp_path / "run.csv", "--gauge",
         "X=opto-rs232@sim:", "--rearm", "0"],
        stdin=terminal, stdout=terminal, stderr=terminal,
        env={**os.environ, "TERM": "xterm", "COLUMNS": "80", "LINES": "24"},
    )  # fmt: skip
    os.close(terminal)
    seen = ""

    def until(text):
        nonlocal seen
        while text not in seen:
            seen += os.read(main_end, 4096).decode("utf-8", "replace")

    until("robot")
    os.write(main_end, b"FUM SCARA\n" + 5 * b"\n")
    until("Cycle 1")
    os.write(main_end, b"\n")
    until("cycle 1 STORED")
    os.write(main_end, b"\n")
    until("cycle 2 STORED")
    os.write(main_end, b"vslipped\n")
    until("voided")
    os.write(main_end, b"q")
    until("record --resume")
    assert process.wait() == 0
    os.close(main_end)
    run = read_table(tmp_path / "run.csv")
    assert run.cycle.tolist() == [1]
    assert run.metadata["robot"] == "FUM SCARA"


def test_a_simulated_robot_seen_by_a_simulated_instrument(tmp_path, capsys, instrument):
    direct = tmp_path / "direct.csv"
    words = ("--effect", "warm_up@X:size=0.03,tau=8", "--seed", "4", "-o", str(direct))
    assert main(["simulate", str(EXAMPLE), *words]) == 0
    shown = read_table(direct).axes["X"].readings
    device = instrument(*[rf"{value:+08.3f}\r" for value in shown])
    code, _, _ = record(
        tmp_path, capsys, "--gauge", OPTO + device, "--trigger", "timer:0.005",
    )  # fmt: skip
    assert code == 0
    assert read_table(tmp_path / "run.csv").axes["X"].readings.tolist() == shown.tolist()
    figures = []
    for table in (direct, tmp_path / "run.csv"):
        assert main(["analyze", str(table), "--json"]) == 0
        axis = json.loads(capsys.readouterr().out)["poses"][0]["axes"]["X"]
        # the instrument shows a digit more than the model's dial resolves
        figures.append([axis[key] for key in ("n", "mean", "l_bar", "S_l", "RP", "three_sigma")])
    assert figures[0] == figures[1]


def test_a_model_behind_a_simulated_port_gives_the_figures_of_simulate(tmp_path, capsys):
    code, events, _ = record(
        tmp_path, capsys, "--gauge", f"X=opto-rs232@sim:?pace=0&seed=4&model={EXAMPLE}",
        "--trigger", "timer:1",
    )  # fmt: skip
    assert code == 0
    assert len(stored(events)) == 31
    assert main(["simulate", str(EXAMPLE), "--seed", "4", "-o", str(tmp_path / "direct.csv")]) == 0
    direct, recorded = (read_table(tmp_path / f"{name}.csv") for name in ("direct", "run"))
    assert recorded.axes["X"].readings.tolist() == direct.axes["X"].readings.tolist()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("frame", "named"),
    [
        (r"+000.4000\r", "--gauge 'X=opto-rs232-ibr?unit=mm@{}' reads it"),
        (r"01A+00000.40000\r", "scara-iso ports --dialects"),
    ],
)
def test_bytes_that_the_driver_does_not_read_are_quoted_with_the_driver_that_does(
    tmp_path, capsys, instrument, frame, named
):
    device = instrument(*[frame] * 9)
    code, _, err = record(tmp_path, capsys, "--gauge", OPTO + device, "--trigger", "timer:0.1")
    assert code == 69
    assert f"opto-rs232 does not read what comes: '{frame[:-2]}'" in err
    assert named.format(device) in " ".join(err.split())
    assert "no answer" not in err
    if "ibr" in named:  # the advice, done literally
        device = instrument(*[frame] * 9)
        words = ["--gauge", f"X=opto-rs232-ibr?unit=mm@{device}", "--trigger", "timer:0.01"]
        code, events, _ = record(tmp_path, capsys, *words, "--cycles", "2", table="ibr.csv")
        assert (code, len(stored(events))) == (0, 2)
