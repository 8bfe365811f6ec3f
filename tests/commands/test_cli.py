"""The commands as a user, a script or a shell meets them."""

import io
import json
import os
import re
import subprocess
import sys
from pathlib import Path
from urllib.parse import urlsplit
from urllib.request import url2pathname

import pytest

import scara_iso
from scara_iso.commands import main
from scara_iso.commands.app import COMMANDS, GROUPS, _summary

ROOT = Path(__file__).parents[2]
TABLE_1 = ROOT / "examples" / "fum_scara_table1.csv"
FIRST_JOINT = ["--Im", "2.65e-4", "--IL", "4.749", "--arcmin", "12"]


def test_who_asks_nothing_is_shown_where_to_begin(call):
    code, out, err = call()
    assert (code, err) == (0, "")
    assert "scara-iso demo" in out


def test_table_1(call):
    code, out, err = call("analyze", TABLE_1, "--full")
    assert (code, err) == (0, "")
    rows = [line.split() for line in out.splitlines()]
    for figures in (["X", "0.014"], ["Y", "0.006"], ["Z", "0.024"], ["theta", "0.0080"],
                    ["XY", "radial", "0.014"], ["XY", "eq.", "23", "0.015"]):  # fmt: skip
        *name, RP = figures
        assert any(row[: len(name)] == name and RP in row for row in rows), figures
    y_findings = [line for line in out.splitlines() if line.strip().startswith("! Y")]
    assert len(y_findings) == 2
    assert "coarse-resolution" in out
    assert "trend" in out


def test_table_1_as_json(call):
    code, out, err = call("analyze", TABLE_1, "--json")
    assert (code, err) == (0, "")
    assert out.count("\n") == 1
    document = json.loads(out, parse_constant=pytest.fail)
    assert document["schema"] == "scara-iso/analyze/2"
    assert document["cycles"] == {"read": 30, "discarded": [], "used": 30}
    (pose,) = document["poses"]
    assert {name: round(axis["RP"], 5) for name, axis in pose["axes"].items()} == {
        "X": 0.01404, "Y": 0.00599, "Z": 0.02354, "theta": 0.00798,
    }  # fmt: skip
    assert round(pose["XY"]["RP_rss"], 5) == 0.01526
    assert round(pose["XY"]["RP_radial"], 5) == 0.01406
    assert round(pose["XY"]["uncertainty_ratio"], 3) == 0.205  # 0.01 mm / sqrt(12) over 0.01406 mm
    flagged = {f["code"] for f in document["findings"] if f["axis"] == "Y"}
    assert {"coarse-resolution", "trend"} <= flagged


def without_its_statement(tmp_path):
    lines = TABLE_1.read_text(encoding="utf-8").splitlines(keepends=True)
    path = tmp_path / "silent.csv"
    path.write_text("".join(line for line in lines if "first_cycle" not in line), encoding="utf-8")
    return path


def test_table_1_without_its_statement_is_refused_with_both_readings(call, tmp_path):
    path = without_its_statement(tmp_path)
    code, out, err = call("analyze", path)
    assert (code, out) == (65, "")
    assert "(a) the first of 31 was already removed" in err
    assert "(c) --cycles 30" in err
    assert "--first-cycle-discarded" in err
    code, said, _ = call("analyze", path, "--first-cycle-discarded", "--json")
    assert code == 0
    assert round(json.loads(said)["poses"][0]["axes"]["X"]["RP"], 5) == 0.01404


def test_backlash_of_the_paper_s_first_joint(call):
    code, out, err = call("backlash", *FIRST_JOINT, "--arm", "0.7", "--ratio", "50")
    assert (code, err) == (0, "")
    for figure in ("-1.948e-7 rad", "1.363e-4 mm", "2.443 mm", "0.6625", "0.2991 mm"):
        assert figure in out


def test_backlash_as_json(call):
    _, out, _ = call("backlash", *FIRST_JOINT, "--arm", "0.7", "--ratio", "50", "--json")
    document = json.loads(out, parse_constant=pytest.fail)
    assert list(document) == [
        "schema", "gap_rad", "load_deviation_rad", "inertia_ratio", "deviation_mm", "arm_m",
        "free_play_mm", "reflected",
    ]  # fmt: skip
    assert document["load_deviation_rad"] == pytest.approx(-1.947721e-7, rel=1e-6)
    assert document["reflected"]["deviation_mm"] == pytest.approx(0.299139, rel=1e-5)
    _, out, _ = call("backlash", *FIRST_JOINT, "--json")
    assert json.loads(out)["reflected"] is None


def test_without_a_ratio_one_line_says_how_the_rotor_was_taken(call):
    assert "taken as given, on the load's shaft" in call("backlash", *FIRST_JOINT)[1]


def test_actual_rows_of_table_ii(call):
    _, out, _ = call("backlash", *FIRST_JOINT, "--arm", "0.7", "--actual", TABLE_1)
    for row in ("1.363e-4 mm", "0.014 mm", "0.015 mm", "2.443 mm"):
        assert row in out
    assert "is not a one-sided scatter" in out


def test_actual_takes_one_pose_with_x_and_y(call, tmp_path):
    path = tmp_path / "x.csv"
    rows = "".join(f"{k},{k % 3}\n" for k in range(1, 32))
    path.write_text(f"# unit: um\ncycle,X\n{rows}", encoding="utf-8")
    code, out, err = call("backlash", *FIRST_JOINT, "--arm", "0.7", "--actual", path)
    assert (code, out) == (65, "")
    assert "one pose with X and Y" in err
    silent = without_its_statement(tmp_path)
    assert call("backlash", *FIRST_JOINT, "--actual", silent)[0] == 65
    assert call("backlash", *FIRST_JOINT, "--actual", silent, "--first-cycle-discarded")[0] == 0
    assert call("backlash", *FIRST_JOINT, "--actual", silent, "--all-count")[0] == 0
    assert call("backlash", *FIRST_JOINT, "--actual", silent, "--cycles", "30")[0] == 0


@pytest.mark.parametrize("bad", ["0", "-1", "nan", "inf", "1e999", "", "twelve"])
def test_inertias_that_are_none(call, bad):
    code, out, err = call("backlash", "--Im", bad, "--IL", "1", "--arcmin", "1")
    assert (code, out) == (2, "")
    assert len(err.splitlines()) <= 3


@pytest.mark.parametrize("missing", ["--Im", "--IL", "--arcmin"])
def test_a_missing_value_is_named(call, missing):
    at = FIRST_JOINT.index(missing)
    code, _, err = call("backlash", *FIRST_JOINT[:at], *FIRST_JOINT[at + 2 :])
    assert code == 2
    assert missing in err


def test_demo_sets_the_print_beside_the_data(call):
    code, out, _ = call("demo")
    assert code == 0
    assert re.search(r"RP XY \(eq\. 23\)\s+0\.0139\s+0\.01526", out)
    assert re.search(r"RP X \(eq\. 6\)\s+0\.013\s+0\.01404", out)


def test_demo_names_the_table_and_no_folder(call):
    assert "FUM SCARA · the paper's Table I · 30 cycles" in call("demo")[1]


def test_demo_opens_its_report_in_the_browser(call, monkeypatch):
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    code, out, err = call("demo", "--open")
    assert (code, err) == (0, "")
    page = Path(url2pathname(urlsplit(opened[0]).path))
    assert out.endswith(f"{page} is written: open it in a browser\n")  # the browser took nothing
    assert "FUM SCARA" in page.read_text(encoding="utf-8")
    assert "demo --open" not in out


def test_demo_as_json(call):
    code, out, err = call("demo", "--json")
    assert (code, err, out.count("\n")) == (0, "", 1)
    document = json.loads(out, parse_constant=pytest.fail)
    assert document["schema"] == "scara-iso/demo/1"
    found = document["analysis"]["poses"][0]["axes"]["X"]["RP"] / document["printed"]["RP"]["X"]
    assert round(found, 2) == 1.08
    assert round(document["backlash"]["reflected"]["deviation_mm"], 4) == 0.2991


@pytest.mark.parametrize(
    ("limit", "code", "said"),
    [
        ("Z=0.035", 0, "PASS: inside the limits with the whole 95 % interval"),
        ("Z=0.03", 1, "NOT PROVABLE with these cycles: Z, limit 0.03 mm; find the cause"),
        (
            "0.035",
            0,
            "  Y drifted, so the interval of Y, XY, XYZ does not hold",
        ),
        ("0.01", 1, "FAIL: OUTSIDE the limit with the whole 95 % interval: Z, XYZ"),
        ("XY_eq23=0.0153", 1, "NOT PROVABLE with these cycles: XY_eq23, limit 0.0153 mm"),
    ],
)
def test_a_limit_makes_the_exit_code_a_verdict(call, limit, code, said):
    found, out, _ = call("analyze", TABLE_1, "--limit", limit, "--full")
    assert found == code
    assert said in out
    assert "XY_eq23 by eq. 23 of the paper" in " ".join(out.split())


def test_a_verdict_on_what_drifts_says_so_in_text_and_json(call):
    """Y of Table I steps in mid-test: its interval is void, and XY's with it, not Z's."""
    code, out, _ = call("analyze", TABLE_1, "--limit", "0.1", "--json")
    limits = {one["figure"]: one for one in json.loads(out)["limits"]}
    assert code == 0
    for name in ("X", "Y", "Z", "XY", "XYZ"):
        assert limits[name]["interval_void"] is ("Y" in name)
        assert limits[name]["verdict"] == "pass"
    out = " ".join(call("analyze", TABLE_1, "--limit", "0.1")[1].split())
    assert "Y drifted, so the interval of Y, XY, XYZ does not hold. Find the cause" in out
    assert call("analyze", TABLE_1, "--limit", "0.1", "--decision", "simple")[0] == 0


@pytest.mark.parametrize(
    ("limit", "code"), [("0.03", 0), ("0.02", 1), ("XY=0.0141", 0), ("XY_eq23=0.0152", 1)]
)
def test_simple_acceptance_is_named(call, limit, code):
    found, out, _ = call("analyze", TABLE_1, "--limit", limit, "--decision", "simple", "--full")
    assert found == code
    assert "by simple acceptance" in out
    assert "guard band" in out
    assert ("OUTSIDE" in out) == bool(code)


@pytest.mark.parametrize("command", ["analyze", "report"])
@pytest.mark.parametrize(
    ("options", "code", "verdict", "rule"),
    [
        ((), 1, "not-provable", "interval"),
        (("--decision", "interval"), 1, "not-provable", "interval"),
        (("--decision", "simple"), 0, "pass", "simple"),
    ],
)
def test_json_has_its_own_word_for_not_provable(call, command, options, code, verdict, rule):
    found, out, _ = call(command, TABLE_1, "--limit", "Z=0.03", "--json", *options)
    document = json.loads(out)
    analysis = document.get("analysis", document)
    (limit,) = analysis["limits"]
    assert (found, limit["verdict"], limit["rule"], analysis["conformity"]) == (
        code,
        verdict,
        rule,
        verdict,
    )
    assert (limit["cycles_wanted"] is None) == (rule == "simple")


def test_the_digits_that_decide_are_shown(call, tmp_path):
    readings = [0.0, *([0.0, 0.01] * 15)]
    table = tmp_path / "run.csv"
    rows = [f"{cycle},{reading}" for cycle, reading in enumerate(readings, start=1)]
    table.write_text("\n".join(["# unit: mm", "# resolution: 0.001", "cycle,X", *rows, ""]))
    _, out, _ = call("analyze", table, "--limit", "X=0.00499996", "--decision", "simple", "--full")
    (row,) = [line for line in out.splitlines() if line.startswith("X ") and "FAIL" in line]
    shown, limit = map(float, row.split()[1:3])
    assert shown > limit == 0.00499996


@pytest.mark.parametrize(
    ("argv", "code", "said"),
    [
        (["analyze", "nowhere.csv"], 66, "nowhere.csv"),
        (["analyze"], 2, "TABLE"),
        (["analyse"], 2, "analyse"),
        (["analyze", "--bogus"], 2, "--bogus"),
        (["analyze", TABLE_1, "--limit", "much"], 2, "--limit"),
        (["analyze", TABLE_1, "--limit", "Q=1"], 2, "no such figure"),
        (["analyze", TABLE_1, "--limit", "X=1_0"], 2, "not a length"),
        (["analyze", TABLE_1, "--limit", "X=1", "--limit", "X=2"], 2, "already"),
        (["analyze", TABLE_1, "--cycles", "5"], 65, "--cycles"),
        (["analyze", TABLE_1, "--unit", "furlong"], 2, "furlong"),
        (["compare", TABLE_1, TABLE_1, "--unit", "furlong"], 2, "furlong"),
        (["history", "/dev/null"], 66, "not a regular file"),
        ([TABLE_1], 2, f"scara-iso analyze {TABLE_1}"),
        (["analyze", ROOT / "examples/reports/whole_test.html"], 65, "a web page"),
    ],
)
def test_errors_are_short_and_have_their_code(call, argv, code, said):
    found, out, err = call(*argv)
    assert (found, out) == (code, "")
    assert said in err
    assert 1 <= len(err.splitlines()) <= 3


def test_no_traceback_unless_asked_for(call, monkeypatch):
    def broken(*_args, **_kwargs):
        raise RuntimeError("a defect")

    monkeypatch.setattr("scara_iso.commands.shared.inputs.read_table", broken)
    code, _, err = call("analyze", TABLE_1)
    assert code == 70
    assert "Traceback" not in err
    assert "--debug" in err
    code, _, err = call("analyze", TABLE_1, "--debug")
    assert code == 70
    assert "Traceback" in err


def test_a_folder_that_is_closed_is_not_said_to_be_a_full_disk(call, monkeypatch, tmp_path):
    def closed(path):
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "iterdir", closed)
    code, _, err = call("analyze", tmp_path)
    assert (code, err.splitlines()) == (
        66,
        [
            f"scara-iso: {tmp_path}: Permission denied",
            "  name another file or folder, or have it opened to you",
        ],
    )


def test_interrupted(call, monkeypatch):
    def interrupted(*_args, **_kwargs):
        raise KeyboardInterrupt

    monkeypatch.setattr("scara_iso.commands.shared.inputs.read_table", interrupted)
    assert call("analyze", TABLE_1) == (130, "", "scara-iso: interrupted\n")


@pytest.mark.parametrize(
    "command",
    ["analyze", "backlash", "demo", "diagnose", "plan", "ports", "record", "simulate"],
)
def test_help_has_an_example(call, command):
    code, out, _ = call(command, "--help")
    assert code == 0
    assert "Example" in out
    assert "--json" in out


@pytest.mark.parametrize("words", [[], ["--no-color"]])
def test_alone_it_says_in_ten_lines_what_to_try(capsys, words):
    assert main(words) == 0
    out = capsys.readouterr().out
    assert out.count("\n") <= 10
    tried = re.findall(r"^  scara-iso (\w+)", out, re.MULTILINE)
    assert len(tried) >= 3
    assert set(tried) <= set(COMMANDS)


@pytest.mark.parametrize("columns", ["40", "80", "120"])
def test_help_lists_every_command_in_a_group_and_cuts_no_summary(capsys, monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", columns)
    assert main(["--help"]) == 0
    out = capsys.readouterr().out
    assert "..." not in out.partition("\n")[2]
    assert re.findall(r"^  (\w[\w-]*)  ", out, re.MULTILINE) == list(COMMANDS)
    assert re.findall(r"^(\w[\w ]*):", out, re.MULTILINE)[2:] == list(GROUPS)


def test_help_and_version(call):
    code, out, _ = call("--help")
    assert code == 0
    for command in ("analyze", "backlash", "demo"):
        assert command in out
    assert re.fullmatch(r"scara-iso \d+\.\d+\.\d+\S*\n", call("--version")[1])


def shell(*argv, stdin=None, **env):
    return subprocess.run(
        [sys.executable, "-m", "scara_iso", *map(str, argv)],
        capture_output=True, input=stdin, check=False, cwd=ROOT, env={**os.environ, **env},
    )  # fmt: skip


def test_standard_input_gives_the_same_as_the_file():
    piped = shell("analyze", "-", "--json", stdin=TABLE_1.read_bytes())
    assert piped.returncode == 0, piped.stderr
    named = json.loads(shell("analyze", TABLE_1, "--json").stdout)
    assert json.loads(piped.stdout)["poses"] == named["poses"]


def test_same_input_same_bytes_and_no_colour_in_a_pipe():
    first, second = shell("analyze", TABLE_1), shell("analyze", TABLE_1)
    assert first.stdout == second.stdout
    assert b"\x1b" not in first.stdout


@pytest.mark.parametrize("encoding", ["cp1252", "cp437", "ascii", "utf-8"])
@pytest.mark.parametrize("columns", ["80", "40", "20"])
def test_any_code_page_and_width(monkeypatch, encoding, columns):
    monkeypatch.setenv("COLUMNS", columns)
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(io.BytesIO(), encoding=encoding))
    assert main(["demo"]) == 0
    figures = sys.stdout.buffer.getvalue().decode(encoding)
    assert "0.01404" in figures
    assert "…" not in figures, "a figure was cut off"


def test_a_reader_that_leaves_is_no_error():
    command = f'"{sys.executable}" -m scara_iso demo | true'
    done = subprocess.run(command, shell=True, capture_output=True, check=False, cwd=ROOT)  # noqa: S602
    assert done.stderr == b""


def test_a_recording_is_not_overwritten(call, tmp_path):
    table = tmp_path / "run.csv"
    table.with_suffix(".raw.jsonl").touch()
    table.write_text("readings", encoding="utf-8")
    code, _, err = call("simulate", MODEL, "-o", table)
    assert code == 73
    assert "holds a recording" in err
    assert table.read_text(encoding="utf-8") == "readings"


@pytest.mark.parametrize(
    ("name", "code"),
    [
        ("run.html", 0),
        ("run.HTML", 0),
        ("run.manifest.json", 73),
        pytest.param("run.pdf", 0, marks=pytest.mark.slow),
    ],
)
def test_a_report_may_bear_the_name_of_its_recording(call, tmp_path, monkeypatch, name, code):
    monkeypatch.chdir(tmp_path)
    sim = ["--gauge", "X=opto-rs232@sim:?pace=0", "--trigger", "timer:1"]
    assert call("record", "run.csv", *sim)[0] == 0
    assert call("report", "run.csv", "-o", name)[0] == code


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_full_disk_is_said():
    command = f'"{sys.executable}" -m scara_iso demo > /dev/full'
    done = subprocess.run(command, shell=True, capture_output=True, check=False, cwd=ROOT)  # noqa: S602
    assert done.returncode == 74
    assert b"cannot write" in done.stderr
    assert b"Traceback" not in done.stderr


@pytest.mark.skipif(os.name == "nt", reason="a POSIX shell closes the streams")
@pytest.mark.parametrize(
    ("streams", "code", "said"),
    [
        ("demo >&-", 74, b"standard output is closed"),
        ("analyze - <&-", 66, b"standard input is closed"),
        ("analyze nowhere.csv 2>&-", 66, b""),
    ],
)
def test_closed_streams(streams, code, said):
    command = f'"{sys.executable}" -m scara_iso {streams}'
    done = subprocess.run(command, shell=True, capture_output=True, check=False, cwd=ROOT)  # noqa: S602
    assert done.returncode == code
    assert said in done.stderr
    assert b"Error" not in done.stderr


@pytest.mark.parametrize(
    "argv", [["--help"], ["analyze", str(TABLE_1)], ["analyze", str(TABLE_1), "--json"],
             ["backlash", *FIRST_JOINT], ["simulate", str(ROOT / "examples" / "fum_scara.toml")]],
    ids=lambda argv: argv[0],
)  # fmt: skip
def test_heavy_packages_are_not_imported(argv):
    program = (
        "import sys; from scara_iso.commands import main; main(sys.argv[1:]); "
        "heavy = {'pandas', 'scipy', 'matplotlib', 'serial', 'numpy.ma'}; "
        "sys.exit(','.join(heavy & set(sys.modules)) or 0)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, *argv], capture_output=True, check=False, cwd=ROOT
    )
    assert done.returncode == 0, done.stderr


def test_the_library_gives_what_the_command_uses():
    assert set(scara_iso.__all__) <= set(dir(scara_iso))
    for name in scara_iso.__all__:
        assert getattr(scara_iso, name).__doc__
    with pytest.raises(AttributeError, match="nothing"):
        _ = scara_iso.nothing


def test_the_packaged_table_is_the_example():
    packaged = ROOT / "scara_iso" / "robot" / "data" / TABLE_1.name
    assert packaged.read_bytes() == TABLE_1.read_bytes()


MODEL = ROOT / "examples" / "fum_scara.toml"


def test_plan_says_the_cube_and_writes_visits_and_picture(call, tmp_path):
    visits, picture = tmp_path / "visits.csv", tmp_path / "plan.svg"
    code, out, err = call("plan", MODEL, "-o", visits, "--picture", picture)
    assert (code, err) == (0, "")
    assert "200.0 x 200.0 x 200.0 mm" in out
    header, *rows = visits.read_text(encoding="utf-8").splitlines()
    assert header.startswith("visit,pose,x_mm")
    assert [row.split(",")[1] for row in rows] == ["P5", "P4", "P3", "P2", "P1"]
    assert picture.read_text(encoding="utf-8").startswith("<?xml")


def test_plan_as_json(call):
    document = json.loads(call("plan", MODEL, "--json")[1], parse_constant=pytest.fail)
    assert document["schema"] == "scara-iso/plan/1"
    assert document["m_mm"] == pytest.approx(0.1 * document["diagonal_mm"])
    assert len(document["corners"]) == 8


@pytest.mark.parametrize("argv", [["--m", "0.2"], ["--plane", "C1-C2"], ["--picture", "a.txt"]])
def test_a_plan_that_cannot_be_meant(call, argv):
    assert call("plan", MODEL, *argv)[0] == 2


def test_simulate_is_read_by_analyze():
    made = shell("simulate", MODEL, "--effect", "warm_up@X:size=0.3,tau=8", "--seed", "1")
    again = shell("simulate", MODEL, "--effect", "warm_up@X:size=0.3,tau=8", "--seed", "1")
    assert made.stdout == again.stdout
    assert b"warm" not in made.stdout
    found = json.loads(shell("analyze", "-", "--json", stdin=made.stdout).stdout)
    assert found["cycles"] == {"read": 31, "discarded": [1], "used": 30}
    assert found["poses"][0]["axes"]["X"]["RP"] > 0.1


def test_simulate_as_json_holds_the_readings_of_its_table(call, tmp_path):
    out = tmp_path / "run.csv"
    code, said, err = call("simulate", MODEL, "--json", "--seed", "3", "-o", out)
    assert (code, err, said.count("\n")) == (0, "", 1)
    document = json.loads(said, parse_constant=pytest.fail)
    run = scara_iso.read_table(out)
    assert (document["schema"], document["seed"]) == ("scara-iso/simulate/1", 3)
    assert document["cycle"] == run.cycle.tolist()
    for name, axis in run.axes.items():
        assert document["axes"][name]["readings"] == axis.readings.tolist()
    assert json.loads(call("simulate", MODEL, "--json", "--seed", "3")[1]) == document


def test_simulate_adds_the_columns_that_were_asked_for(call):
    code, out, _ = call("simulate", MODEL, "--approach", "both", "--temperature", "20:23",
                        "--payload", "0,2", "--cycles", "6")  # fmt: skip
    assert code == 0
    rows = [line for line in out.splitlines() if not line.startswith("#")]
    assert rows[0] == "cycle,X,Y,Z,theta,temperature_C,payload_kg,approach"
    assert rows[1].endswith(",20.0,0.0,+1")
    assert rows[-1].endswith(",23.0,2.0,-1")


def test_simulate_by_the_drive_train_scatters_over_the_gap(call):
    _, out, _ = call("simulate", MODEL, "--drivetrain", "--approach", "both")
    y = [float(line.split(",")[2]) for line in out.splitlines() if line[:1].isdigit()]
    assert max(y) - min(y) > 1.0


@pytest.mark.parametrize(
    "argv",
    [
        ["--effect", "magic:size=1"],
        ["--temperature", "20"],
        ["--payload", "a"],
        ["--seed", "-1"],
        ["--temperature", "nan:1"],
        ["--payload", "0,inf"],
        ["--payload", "1_0"],
    ],
)
def test_a_simulation_that_cannot_be_meant(call, argv):
    code, out, err = call("simulate", MODEL, *argv)
    assert (code, out) == (2, "")
    assert len(err.splitlines()) <= 3


@pytest.mark.parametrize("name", COMMANDS)
def test_the_list_says_of_a_command_what_its_own_help_begins_with(call, monkeypatch, name):
    monkeypatch.setenv("COLUMNS", "200")
    assert f"  {_summary(name)}\n" in call(name, "--help")[1]


def test_the_next_step_of_standard_input_names_a_file(monkeypatch, capsys):
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(TABLE_1.read_bytes())))
    assert main(["analyze", "-"]) == 0
    assert "diagnose run.csv   once the table is saved as run.csv" in capsys.readouterr().out


def test_the_next_step_says_what_must_be_so_first_on_a_line_of_its_own(monkeypatch, capsys):
    """Where it was left out for want of room, an older run.csv would have been reported."""
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(TABLE_1.read_bytes())))
    main(["analyze", "-", "--unit", "0.01 mm", "--first-cycle-discarded"])
    out = capsys.readouterr().out
    command = "diagnose run.csv --unit '0.01 mm' --first-cycle-discarded"
    assert f"{command}\n      once the table is saved as run.csv\n" in out


def test_a_file_named_like_an_option_can_be_typed_again(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "-x.csv").write_bytes(TABLE_1.read_bytes())
    _, out, _ = call("analyze", "--", "-x.csv")
    command = next(line for line in out.splitlines() if "Next: " in line).split("   ")[0].split()
    assert call(*command[2:])[0] == 0


def test_tables_that_are_read_alike_are_said_in_one_line(call, tmp_path):
    """Five of them hid what is to be seen: that one table alone states a payload."""
    for n in range(1, 6):
        rows = "".join(f"{k},{0.1 + n * k % 7 / 1000:.3f}\n" for k in range(1, 32))
        load = "# payload: 2 kg\n" if n == 5 else ""
        (tmp_path / f"P{n}.csv").write_text(f"# unit: mm\n{load}cycle,X\n{rows}")
    _, out, _ = call("analyze", tmp_path)
    said = " ".join(out.split())
    assert "poses P1, P2, P3, P4, P5, each from the file's name: comma-separated" in said
    assert "payload: stated in" in said
    assert "more; --json" not in said


@pytest.mark.parametrize("width", ["40", "60"])
def test_help_fits_a_narrow_terminal(call, monkeypatch, width):
    monkeypatch.setenv("COLUMNS", width)
    assert max(map(len, call("--help")[1].splitlines())) <= int(width)
