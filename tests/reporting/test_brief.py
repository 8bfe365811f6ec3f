"""The short forms: the answer in three lines, nothing of the warnings lost, the rest on --full."""

import io
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from scara_iso import analyze
from scara_iso.commands import main
from scara_iso.iso9283.checks import in_brief
from scara_iso.render.terminal import open_console, show
from scara_iso.reporting import NextStep, analysis_report, in_form
from scara_iso.reporting.named_effects import sureness
from scara_iso.reporting.shared.digits import result

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"
ANALYZED = (
    "fum_scara_table1.csv", "before_repair.csv", "after_repair.csv", "scatter.csv", "warm_up.csv",
    "unexplained.csv", "drift.csv", "three_directions.csv",
)  # fmt: skip
DIAGNOSED = tuple(name for name in ANALYZED if name != "drift.csv")
PLAIN = tuple((name, *files) for name, files in (
    *((one, (name,)) for one in ("analyze", "diagnose") for name in DIAGNOSED),
    ("compare", ("fum_scara_table1.csv", "warm_up.csv")),
    ("compare", ("before_repair.csv", "after_repair.csv")),
))  # fmt: skip
"""What issues of one pose and no limit take: at most twenty lines."""
CALLS = (
    *(("analyze", name) for name in ANALYZED),
    *(("analyze", name, "--limit", "0.02") for name in ANALYZED[:3]),
    *(("diagnose", name) for name in DIAGNOSED),
    ("diagnose", "five_poses.csv", "--model", "five_poses.toml"),
    ("compare", "before_repair.csv", "after_repair.csv"),
    ("compare", "after_repair.csv", "before_repair.csv"),
    ("compare", "scatter.csv", "fum_scara_table1.csv"),
    ("push", "push.csv", "--arm", "0.25"),
    ("push", "push.csv", "--arm", "0.25", "--limit", "1.2"),
    ("visits", "stream.csv", "--poses", "P1,-"),
    ("history", "months"),
)
COPIES = ("compare", "scatter.csv", "scatter.csv", "--cycles", "31")
INTERVAL = re.compile(r"\[[-+.\d]+, [-+.\d]+\]")
PROGRAMMERS = re.compile(r"model before|shown here|p floor|p <=|Mann-Kendall|coarse-resolution")


@pytest.fixture
def said(capsys, monkeypatch):
    """Return a function: what a command on the examples writes at a width."""
    monkeypatch.chdir(EXAMPLES)

    def call(*words, columns=80):
        monkeypatch.setenv("COLUMNS", str(columns))
        code = main([str(word) for word in words])
        out, err = capsys.readouterr()
        assert code in (0, 1), err
        return out

    return call


@pytest.mark.parametrize("call", CALLS, ids=" ".join)
def test_three_lines_say_what_was_asked_and_what_is_next(said, call):
    out = said(*call)
    lines = out.rstrip("\n").splitlines()
    assert len(lines) <= (20 if call in PLAIN else 23)
    at = next(k for k, line in enumerate(lines) if line.startswith("  Next: scara-iso "))
    latest = 4 if "--limit" in call else 3  # a verdict on many figures takes two lines
    assert at < latest or all(line.startswith("  RP ") for line in lines[1:at])
    if call[0] not in ("diagnose", "visits", "history"):
        assert any(INTERVAL.search(line) for line in lines[: 3 if "--limit" in call else 2])
    elif call[0] == "diagnose" and len(lines) > 12:
        assert re.search(r"\d", lines[1])
    assert not PROGRAMMERS.search(out.partition("\n")[2])
    if "--limit" in call:
        assert re.match(r"  (PASS|FAIL|NOT PROVABLE)", lines[0])


@pytest.mark.parametrize("call", [*CALLS, COPIES], ids=" ".join)
def test_what_it_says_to_do_next_works(said, call, tmp_path, monkeypatch, capsys):
    following = re.search(r"Next: scara-iso (.*?)(   |\n)", said(*call, columns=200))[1]
    words = shlex.split(following)
    if words[0] == "diagnose" and call[0] != "diagnose":
        words += ["--json"]  # the same work, and its text is tried above
    tables = shutil.ignore_patterns("reports", "*.html", "*.toml", "*.xlsx")
    shutil.copytree(EXAMPLES, tmp_path, ignore=tables, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    assert main(words) in (0, 1), capsys.readouterr().err


@pytest.mark.parametrize("name", ANALYZED)
def test_no_warning_is_lost(said, name):
    out = " ".join(said("analyze", name).split())
    for finding in analyze(EXAMPLES / name).findings:
        if finding.severity != "info":
            assert in_brief(finding.code) in out


@pytest.mark.parametrize("command", ["analyze", "diagnose"])
def test_simulated_readings_are_marked(said, tmp_path, command):
    said("simulate", "fum_scara.toml", "-o", tmp_path / "run.csv")
    assert "SIMULATED" in said(command, tmp_path / "run.csv")


@pytest.mark.parametrize("command", ["analyze", "diagnose"])
def test_full_says_more(said, command):
    short, full = said(command, EXAMPLES / "scatter.csv"), said(command, "scatter.csv", "--full")
    assert full.count("\n") > 1.5 * short.count("\n")
    assert "model before" not in full  # without a model, which would foretell scatter


def test_a_run_that_drifts_is_named_and_is_what_to_look_at_next(said):
    drifting_before = said("compare", "warm_up.csv", "scatter.csv")
    assert "X before, Y before: moved, its interval is void" in drifting_before
    assert "Next: scara-iso diagnose warm_up.csv" in drifting_before
    assert "Next: scara-iso diagnose warm_up.csv" in said("compare", "scatter.csv", "warm_up.csv")


def test_the_same_readings_twice_are_said_first(said):
    out = said("compare", "before_repair.csv", "before_repair.csv")
    assert out.startswith("  The same readings twice: nothing can differ")
    assert "no change that" not in out


def test_one_fact_of_two_tables_is_no_eight_warnings_and_has_its_remedy_beside_it(said, tmp_path):
    tables = [tmp_path / name for name in ("before_repair.csv", "after_repair.csv")]
    for table in tables:
        text = (EXAMPLES / table.name).read_text("utf-8")
        table.write_text(re.sub("# resolution.*\n", "", text), encoding="utf-8")
    out = said("compare", *tables, columns=200)
    assert "! resolution not stated (state it, as --resolution 0.001)\n" in out
    assert "warnings" not in out


def test_the_options_that_read_a_table_are_said_again(said, tmp_path):
    rows = [f"{k},0.8{k % 7}" for k in range(1, 31)]
    table = tmp_path / "a run.csv"
    table.write_text("\n".join(["cycle,X", *rows]), encoding="utf-8")
    out = said("analyze", table, "--unit", "mm", "--first-cycle-discarded", "--cycles", "31",
               columns=300)  # fmt: skip
    assert f"Next: scara-iso diagnose {shlex.quote(str(table))} --unit mm" in out
    assert "--first-cycle-discarded" in out
    assert "--cycles 31" in out


@pytest.mark.parametrize("columns", [40, 80, 120])
@pytest.mark.parametrize("call", CALLS[::3], ids=" ".join)
def test_no_line_but_a_command_is_wider_than_the_window(said, call, columns):
    for line in said(*call, columns=columns).splitlines():
        assert len(line) <= columns or line.startswith("  Next: "), line


def test_the_headline_gives_up_what_has_no_room():
    analysis = analyze(EXAMPLES / "fum_scara_table1.csv")
    report = in_form(analysis_report(analysis, NextStep("scara-iso x")), "brief")
    first = {}
    for width in (40, 80, 120):
        stream = io.StringIO()
        console = open_console(stream)
        console.width = width
        show(report, console)
        first[width] = stream.getvalue().splitlines()[0]
    assert first[40] == "  RP  XY 0.014 mm [0.009, 0.022]"
    assert first[80].startswith(f"{first[40]}   Z 0.024 mm [0.017, 0.035]")
    assert "theta 0.0080 mm [0.0056, 0.0118]" in first[120]


@pytest.mark.parametrize(
    ("ends", "said"),
    [
        ((0.0091, 0.0218), "0.014 mm [0.009, 0.022]"), ((8.0, 32.0), "14 mm [8, 32]"),
        ((0.0056, 0.0118), "0.0087 mm [0.0056, 0.0118]"), (None, "0.0141 mm"),
        ((-0.0002, None), "0.014 mm [0.000, any]"),
    ],
)  # fmt: skip
def test_two_digits_of_the_interval_decide(ends, said):
    value = {0.0056: 0.0087, 8.0: 14.0}.get(ends and ends[0], 0.0141)
    assert str(result(value, ends, "mm")) == said


@pytest.mark.parametrize("cycles", [(8,), (8, 20)])
def test_the_cycles_of_odd_readings_are_said_once(said, tmp_path, cycles):
    rng = np.random.default_rng(4)
    readings = 0.1 + rng.normal(0, 0.004, 31)
    readings[[cycle - 1 for cycle in cycles]] += 0.1
    rows = (f"{k},{x:.3f}" for k, x in enumerate(readings, 1))
    (tmp_path / "t.csv").write_text(
        "\n".join(["# unit: mm", "# resolution: 0.001", "cycle,X", *rows])
    )
    size = said("diagnose", tmp_path / "t.csv").splitlines()[1]
    if len(cycles) == 1:
        assert size.endswith("]   at cycle 8")
    else:
        assert re.fullmatch(r" *cycle 8: X \+0.101 mm \[.*\]   cycle 20: X \+0.096 mm \[.*\]", size)
    assert not any(f"cycle {cycle}" in size.replace(f"cycle {cycle}", "", 1) for cycle in cycles)


def test_the_figure_of_the_plane_that_a_limit_names_decides(said):
    """XY is the radial figure (0.014 mm), XY_eq23 that of eq. 23 (0.015 mm)."""
    out = said("analyze", "fum_scara_table1.csv", "--limit", "XY=0.02")
    assert "NOT PROVABLE with these cycles: XY, limit 0.02 mm\n" in out
    assert out.count("ind the cause first") == 1
    assert re.search(r"XY +0\.014 +0\.009\.\.0\.022 +not provable", out)
    assert "eq23" not in out
    out = said("analyze", "fum_scara_table1.csv", "--limit", "xy_EQ23=0.02")
    assert "NOT PROVABLE with these cycles: XY_eq23, limit 0.02 mm\n" in out
    assert re.search(r"XY +0\.014 +0\.009\.\.0\.022\n", out)
    assert re.search(r"XY_eq23 +0\.015 .* not provable", out)


def test_digits_that_decide_against_a_limit_are_shown():
    assert str(result(0.02004, (0.015, 0.025), limit=0.02)) == "0.02004 [0.01500, 0.02500]"


@pytest.mark.parametrize("call", [("analyze", "fum_scara_table1.csv"), ("diagnose", "scatter.csv")])
def test_a_code_page_of_windows_shows_digits_for_levels(call):
    done = subprocess.run(
        [sys.executable, "-m", "scara_iso", *call], capture_output=True, check=True, cwd=EXAMPLES,
        env={"PYTHONPATH": str(ROOT), "PYTHONIOENCODING": "cp1252", "NO_COLOR": "1"},
    )  # fmt: skip
    text = done.stdout.decode("cp1252")
    assert "?" not in text
    assert "\x1b" not in text
    assert re.search(r"[0-9]{26,}", text)


def test_demo_is_short(said):
    assert said("demo").count("\n") <= 46


class Terminal(io.StringIO):
    """A terminal."""

    def isatty(self):
        return True


def test_an_error_wraps_between_words_on_a_terminal(monkeypatch, tmp_path):
    table = tmp_path / "run.csv"
    table.write_text("cycle,X\n" + "\n".join(f"{k},0.8{k % 7}" for k in range(1, 32)))
    monkeypatch.setenv("COLUMNS", "50")
    screen, pipe = Terminal(), io.StringIO()
    for stream in (screen, pipe):
        monkeypatch.setattr("sys.stderr", stream)
        main(["analyze", str(table)])
    words = [word for word in screen.getvalue().split() if len(word) < 48]
    assert words == [word for word in pipe.getvalue().split() if len(word) < 48]
    assert all(len(line) < 50 for line in screen.getvalue().splitlines() if str(table) not in line)
    assert screen.getvalue().count("\n") > pipe.getvalue().count("\n")


def test_a_figure_against_a_limit_keeps_its_unit(said):
    out = said("analyze", "scatter.csv", "--limit", "0.03")
    assert "RP [mm]   95 % interval  limit 0.03 mm" in out  # of theta too, a length at a radius
    lines = said("analyze", "before_repair.csv", "--limit", "0.03").splitlines()
    units = {line.split()[0]: re.search("mm|deg", line)[0] for line in lines if ".." in line}
    assert (units["theta"], units["X"]) == ("deg", "mm")


def test_no_fact_is_lost_where_room_is_short(said):
    """Headings and the cycle of a step stood on wide screens only."""
    narrow = said("analyze", "scatter.csv", "--limit", "0.03", columns=40)
    assert all(head in narrow for head in ("RP [mm]", "95 % interval", "limit 0.03"))
    step = said("diagnose", "fum_scara_table1.csv", columns=30)
    assert "at cycle 15" in " ".join(step.split())


def test_many_effects_that_fit_are_no_list_of_causes():
    rivals = tuple(SimpleNamespace(effect=name, probability=0.1) for name in "abcdef")
    unclear = SimpleNamespace(effect="g", axes=("Y",), joint=None, place=None, probability=0.2,
                              parameters={}, rivals=rivals)  # fmt: skip
    said = "more than scatter on Y, its kind not clear: g, a, b or 4 others"
    assert sureness(unclear) == said


@pytest.mark.parametrize("more", [["--definitions"], ["--definitions", "--full"]])
def test_other_definitions_stand_there_once(capsys, more):
    assert main(["analyze", str(EXAMPLES / "scatter.csv"), *more]) == 0
    assert capsys.readouterr().out.count("half range of 7  ") == 1


def test_a_verdict_on_another_figure_than_stands_beside_it_names_it(tmp_path, capsys):
    rng = np.random.default_rng(1)
    for pose in ("P1", "P2"):
        values = rng.normal(0, (0.003, 0.02), (31, 2))
        rows = "".join(f"{k},{x:.3f},{y:.3f}\n" for k, (x, y) in enumerate(values, 1))
        head = "# unit: mm\n# resolution: 0.001\ncycle,X,Y\n"
        (tmp_path / f"{pose}.csv").write_text(head + rows)
    tables = [str(tmp_path / "P1.csv"), str(tmp_path / "P2.csv")]
    for limit, says in (("X=0.01", r"P1 .*  X 0\.00\d+: "), ("XY=0.01", r"P1 .*\]  +FAIL$")):
        main(["analyze", *tables, "--limit", limit])
        assert re.search(f"(?m)^{says}", capsys.readouterr().out), limit


def test_scatter_is_not_shown_as_none_beside_a_change_of_which_little_is_known(tmp_path, capsys):
    values = 0.5 + 0.003 * np.random.default_rng(1).normal(size=31)
    for name in ("good", "gross"):
        rows = "".join(f"{k},{x:.3f}\n" for k, x in enumerate(values, 1))
        (tmp_path / f"{name}.csv").write_text(f"# unit: mm\n# resolution: 0.001\ncycle,X\n{rows}")
        values[10] = 5.012
    assert main(["compare", *(str(tmp_path / f"{n}.csv") for n in ("good", "gross"))]) == 0
    out = capsys.readouterr().out
    assert re.search(r"X 0\.00\d+ to 3 mm", out)
    assert re.search(r"(?m)^RP X \[mm\] +0\.00\d+ +3 ", out)
