"""What the program itself writes into the head of a table is no remark, and strikes no reading."""

import re
import tomllib
from io import BytesIO

import pytest

import scara_iso
from scara_iso.base.files import KeyFaults
from scara_iso.commands import main
from scara_iso.rawfile import History
from scara_iso.tables import write_table
from scara_iso.testfolder.statements import metadata_of, parse_test

TEST = """
[robot]
name = "FUM SCARA"
serial_number = "0123"
rated_payload_kg = 5.5
rated_velocity_mm_s = 2000.5

[test]
velocities = [12.5]
loads = [1.25]
dwell_s = 1.25
stabilisation_time_s = 0.75
approach = "one side"
warm_up_min = 1.5
dial_zero = "command"
date = 2026-05-12
{schedule}

[pose.P1]
x_mm = 1.25
y_mm = -0.5
z_mm = 1.5
theta_deg = 0.75
{command}

[instrument.X]
name = "Mitutoyo ID-H 0530"
serial_number = "4711"
certificate = "K-2026-17"
calibration_date = 2026-01-10
calibration_due = 2027-01-10
uncertainty = 0.0005
correction = [[0, 0], [2, 0.001]]
correction_zero = 0.5
correction_uncertainty = 0.0005
alignment_deg = 0.5
alignment_u_deg = 0.25

[environment]
temperature_C = 20.5
temperature_limits_C = [18.5, 22.5]
humidity_percent = 45.5

[people]
operator = "A. Name"
laboratory = "Name, town"
address = "Street 1, town"
location = "Hall 2"
customer = "Name, town"
authorized_by = "B. Name"
report_number = "R-12"
{drift}
"""
DRIFT = '\n[drift]\npose = "P1"\n'


def heads():
    """Yield the lines that test folder and recorder put in front of readings, by who states."""
    for k, (schedule, command, drift) in enumerate(
        [("", "", ""), ('first_cycle = "counts"', "command = { X = 0.5 }", DRIFT)]
    ):
        faults = KeyFaults()
        document = tomllib.loads(TEST.format(schedule=schedule, command=command, drift=drift))
        test = parse_test(document, faults)
        assert not faults, faults
        for part in test.parts():
            yield f"test {k} {part.name}", metadata_of(part, test, ("X", "Y"))


def recorded(spec, **gauge):
    """Return the head of a recording of three cycles with all that a recorder may note."""
    history = History("run.raw.jsonl")
    stated = {
        "spec": spec, "dialect": "opto-rs232", "line": "4800 7E2", "unit": "mm",
        "unit_from": "the option", "unit_confirmed": False, "simulated": True, **gauge,
    }  # fmt: skip
    session = {
        "event": "session", "t": 0, "wall": "2026-05-12T08:00:00Z", "schema": "scara-iso/raw/1",
        "cycles": 31, "trigger": "timer:0.5", "metadata": {}, "excel_locale": None,
        "doubts": ["torn at 0.5"], "gauges": dict.fromkeys("XY", stated),
    }  # fmt: skip
    lines = [session]
    for cycle in (1, 2, 3):
        lines += [
            {"event": "stored", "t": cycle, "wall": "2026-05-12T08:00:01Z", "cycle": cycle,
             "axis": axis, "text": f"0.40{cycle}", "unit": "mm", "at": cycle} for axis in "XY"
        ]  # fmt: skip
    lines += [
        {"event": "void", "t": 4, "cycle": 3, "axes": ["X", "Y"], "reason": "shock 0.5"},
        {"event": "changed", "t": 4, "axis": "X", "message": "0.5 is 25.4 of the readings before"},
        {"event": "covariates", "t": 4, "cycle": 1, "values": {"temp": "20.5"}},
        *({"event": e, "t": 5} for e in ("fault", "garbage", "timeout", "refused")),
        {**session, "t": 0, "wall": "2026-05-12T07:00:00Z", "cycles": 30},
    ]
    for k, record in enumerate(lines, 1):
        history.take(
            k, {"wall": "2026-05-12T08:00:09Z", **record, "crc": "0", "prev": history.previous}
        )
    assert not history.faults, history.faults
    return dict(history.run().metadata)


IDENTITIES = {
    "simulated": "sim:?pace=0&value=0.012 (simulated)",
    "typed": "keyboard: (typed)",
    "a cable": "/dev/ttyUSB0 (0403:6001 FTDI 1.25)",
}


def remarks_of(lines):
    """Return what is remarked, where these lines stand in the head of a table of 31 rows."""
    rows = "".join(f"{k},{0.4 + k % 7 / 1000:.3f},{0.5 + k % 5 / 1000:.3f}\n" for k in range(1, 32))
    head = "".join(f"# {key}: {text}\n" for key, text in lines.items())
    table = BytesIO(f"# unit: mm\n# resolution: 0.001\n{head}cycle,X,Y\n{rows}".encode())
    return scara_iso.read_table(table).origin.remarks


@pytest.mark.parametrize(("who", "lines"), [*heads()])
def test_what_a_test_folder_writes_is_no_remark(who, lines):
    lines = {k: v for k, v in lines.items() if not re.match("correction|alignment", k)}
    assert remarks_of(lines) == ()


@pytest.mark.parametrize("identity", IDENTITIES)
def test_what_a_recorder_writes_is_no_remark(identity):
    lines = recorded("X=opto-rs232@PORT", identity=IDENTITIES[identity])
    assert {
        "doubts",
        "recorded",
        "indicator",
        "axes_recorded",
        "cycles_planned",
        "record_clock",
    } < (lines.keys())
    assert remarks_of(lines) == ()


def test_what_visits_write_is_no_remark():
    rule = "dwell 0.5 s, window 0.25 s, still 3, band X 0.5 Y 1.25"
    said = {"stream_samples": "120", "stream_rate_hz": "1.25", "visit_rule": rule}
    assert remarks_of(said) == ()


def test_what_a_technician_writes_under_the_same_keys_stays_a_remark():
    assert remarks_of({"indicator": "X and Y exchanged at cycle 12"}) != ()
    assert remarks_of({"velocity": "halved from cycle 12 on"}) != ()


def test_what_simulate_writes_is_no_remark():
    run = scara_iso.simulate("examples/fum_scara.toml", effects=["warm_up:size=0.03,tau=8"])
    assert scara_iso.read_table(BytesIO(write_table(run).encode())).origin.remarks == ()


def test_a_test_folder_has_no_warning_of_its_own_words(tmp_path, capsys):
    folder = tmp_path / "acc"
    assert main(["test", "new", str(folder), "--model", "examples/fum_scara.toml"]) == 0
    words = ["--gauge", "X=opto-rs232@sim:?pace=0", "--trigger", "timer:2"]
    assert all(main(["record", str(folder), *words]) == 0 for _ in range(5))
    assert "remarked-rows" not in [one.code for one in scara_iso.analyze(folder).findings]
    capsys.readouterr()
    assert main(["analyze", str(folder)]) == 0
    assert "commanded pose" not in capsys.readouterr().out
