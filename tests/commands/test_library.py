"""The public functions: the command's options as keywords, and the command's results."""

import ast
import inspect
import json
import pickle
import re
import traceback
from pathlib import Path
from types import SimpleNamespace
from typing import get_type_hints

import numpy as np
import pandas as pd
import pytest
import threadpoolctl

import scara_iso
from scara_iso.base.errors import DataError, UsageError, as_keywords
from scara_iso.base.published import to_json
from scara_iso.commands import main, published_run
from scara_iso.commands.shared.inputs import ReadingOptions, TablesOptions
from scara_iso.diagnosis import close_the_loop

EXAMPLES = Path(__file__).parents[2] / "examples"
TABLE_1, MODEL = EXAMPLES / "fum_scara_table1.csv", EXAMPLES / "fum_scara.toml"
BEFORE, AFTER = EXAMPLES / "before_repair.csv", EXAMPLES / "after_repair.csv"
SPEC = "X=opto-rs232@sim:?pace=0"


@pytest.fixture
def said(capsys):
    """Return a function that gives the object which a command writes."""

    def run(*argv):
        assert main([*map(str, argv), "--json"]) == 0
        return json.loads(capsys.readouterr().out)

    return run


def plain(document):
    return json.loads(json.dumps(document, default=float))


def test_analyze_is_the_command(said):
    wanted = said("analyze", TABLE_1)
    assert plain(to_json(scara_iso.analyze(TABLE_1))) == wanted
    assert plain(to_json(scara_iso.analyze(scara_iso.read_table(TABLE_1)))) == wanted


def test_analyze_takes_the_options_of_the_command(said):
    found = scara_iso.analyze(BEFORE, limits={"XY": 9.0}, decision="simple", cycles=31)
    options = ("--limit", "XY=9", "--decision", "simple", "--cycles", 31)
    assert plain(to_json(found)) == said("analyze", BEFORE, *options)


@pytest.mark.parametrize(
    "call",
    [
        scara_iso.analyze, scara_iso.report, scara_iso.history, scara_iso.compare, scara_iso.push,
        lambda table, limits: scara_iso.gauge_study(table, tolerance=limits),
    ],
)  # fmt: skip
@pytest.mark.parametrize("wrong", ["0.02", {"XY": "0.02"}, [0.02], True])
def test_a_size_of_another_kind_is_refused_in_words(call, wrong):
    with pytest.raises(UsageError, match="is not a size") as refused:
        call(TABLE_1, limits=wrong)
    assert "=0.02, or" in refused.value.remedy


def test_one_number_limits_every_length():
    found = scara_iso.analyze(TABLE_1, limits=0.02).limits
    assert {check.figure for check in found} == {"X", "Y", "Z", "theta", "XY", "XYZ"}
    assert {check.limit for check in found} == {0.02}


@pytest.mark.parametrize(
    "call",
    [
        scara_iso.analyze, scara_iso.report, scara_iso.history, scara_iso.compare, scara_iso.push,
        scara_iso.gauge_study, scara_iso.visits,
    ],
)  # fmt: skip
def test_an_option_that_is_none_is_answered_with_the_nearest(call):
    with pytest.raises(UsageError, match=r"\(\) has no option limit=") as refused:
        call(TABLE_1, limit=0.02)
    wanted = "limits=" if "limits" in inspect.signature(call).parameters else "unit="
    assert wanted in refused.value.remedy


@pytest.mark.parametrize(("name", "renamed"), [("x", "{'x': 'X'}"), ("Theta", "theta"), ("a", "X")])
def test_a_frame_whose_axis_is_called_otherwise_says_what_to_rename(name, renamed):
    frame = pd.DataFrame({name: scara_iso.read_table(BEFORE).axes["X"].readings})
    with pytest.raises(DataError, match=f"no axis is called {name}") as refused:
        scara_iso.analyze(frame, unit="mm")
    assert renamed in refused.value.remedy


def test_a_plain_frame_needs_its_unit():
    run = scara_iso.read_table(BEFORE)
    frame = pd.DataFrame({"cycle": run.cycle, "X": run.axes["X"].readings})
    with pytest.raises(DataError, match="no unit stated for X"):
        scara_iso.analyze(frame)
    found = scara_iso.analyze(frame, unit="mm").poses[0].axes["X"].RP
    assert found == scara_iso.analyze(BEFORE).poses[0].axes["X"].RP
    assert scara_iso.analyze(run.to_frame()).poses[0].axes["X"].RP == found


def test_an_option_of_text_is_refused_where_there_is_none():
    with pytest.raises(UsageError, match="unit, decimal: a Run is not read from text"):
        scara_iso.analyze(scara_iso.read_table(BEFORE), unit="mm", decimal=",")


def test_compare_is_the_command(said):
    wanted = said("compare", BEFORE, AFTER)
    assert plain(to_json(scara_iso.compare(BEFORE, AFTER))) == wanted
    analyses = [scara_iso.analyze(BEFORE), scara_iso.analyze(AFTER)]
    assert plain(to_json(scara_iso.compare(analyses))) == wanted


def test_compare_lists_the_faults_of_every_table(tmp_path):
    (tmp_path / "a.csv").write_text("nothing")
    (tmp_path / "b.csv").write_text("nothing")
    with pytest.raises(DataError) as caught:
        scara_iso.compare(tmp_path / "a.csv", tmp_path / "b.csv")
    assert str(caught.value).count("\n") >= 2


def test_diagnose_many_is_diagnose_of_each(said):
    names = [str(TABLE_1), str(EXAMPLES / "no such.csv")]
    first, second = scara_iso.diagnose_many(names)
    assert to_json(first) == said("diagnose", TABLE_1)
    assert second.exit_code == 66


def test_simulate_is_the_command(said):
    effect = "warm_up:size=0.03,tau=8"
    found = scara_iso.simulate(
        MODEL, effects=[effect], seed=4, approach="random", temperature=(20, 24), payload=[0, 2]
    )
    wanted = said(
        "simulate", MODEL, "--effect", effect, "--seed", 4, "--approach", "random",
        "--temperature", "20:24", "--payload", "0,2",
    )  # fmt: skip
    assert plain(to_json(published_run(found, seed=4))) == wanted
    assert plain(to_json(published_run(scara_iso.simulate(MODEL), seed=0))) == said(
        "simulate", MODEL
    )


def test_plan_is_the_command(said):
    assert plain(to_json(scara_iso.plan(MODEL))) == said("plan", MODEL)
    with pytest.raises(UsageError, match="solid 'ball'"):
        scara_iso.plan(MODEL, solid="ball")


@pytest.mark.slow
def test_plan_takes_the_options_of_the_command(said):
    found = scara_iso.plan(MODEL, solid="box", elbow="left", m=0.12, cycles=11)
    options = ("--solid", "box", "--elbow", "left", "--m", 0.12, "--cycles", 11)
    assert plain(to_json(found)) == said("plan", MODEL, *options)


def test_report_is_the_command_and_writes_what_it_writes(said, tmp_path):
    found = scara_iso.report(TABLE_1, to=tmp_path / "own.md")
    wanted = said("report", TABLE_1, "-o", tmp_path / "command.md")
    assert {
        **plain(to_json(found.dossier)),
        "command": wanted["command"],
    } == wanted
    own, by_command = ((tmp_path / n).read_text() for n in ("own.md", "command.md"))
    pairs = zip(own.splitlines(), by_command.splitlines(), strict=True)
    assert [a for a, b in pairs if a != b] == [r"| command | scara\_iso.report |"]
    assert found.write(tmp_path / "again.md").read_text() == own
    assert found._repr_html_().startswith("<main>")


def test_figures_go_into_a_frame():
    analysis = scara_iso.analyze(TABLE_1)
    frame = analysis.to_frame()
    assert frame["figure"].tolist() == ["X", "Y", "Z", "theta", "XY", "XYZ"]
    row = frame.set_index("figure").loc["X"]
    assert (row["RP"], row["n"], row["unit"]) == (analysis.poses[0].axes["X"].RP, 30, "mm")
    assert (row["RP_low"], row["RP_high"]) == analysis.poses[0].axes["X"].RP_interval
    assert np.isnan(row["RP_rss"])


def test_a_diagnosis_gives_its_series_and_shows_itself():
    found = scara_iso.diagnose(TABLE_1)
    frame = found.to_frame()
    assert np.array_equal(frame["Y_measured"], found.series.measured["Y"])
    assert np.array_equal(frame["Y_predicted_after"], found.series.predicted_after["Y"])
    assert repr(found).startswith("<Diagnosis of X, Y, Z, theta over 30 cycles: explained step")


def test_record_is_a_run_of_what_was_stored(tmp_path):
    stored = []
    found = scara_iso.record(
        tmp_path / "run.csv", [SPEC], trigger="timer:10", metadata={"robot": "R"},
        tell=stored.append,
    )  # fmt: skip
    again = scara_iso.read_table(tmp_path / "run.csv")
    assert np.array_equal(found.axes["X"].readings, again.axes["X"].readings)
    assert found.cycle.tolist() == list(range(1, 32))
    assert found.metadata["robot"] == "R"
    assert sum(type(event).__name__ == "Stored" for event in stored) == 31


def test_small_matrices_are_worked_on_by_one_thread():
    def threads():
        return {pool["num_threads"] for pool in threadpoolctl.threadpool_info()}

    def take(_):
        raise LookupError(threads())

    with threadpoolctl.threadpool_limits(2, user_api="blas"):
        with pytest.raises(LookupError) as seen:
            close_the_loop(None, None, SimpleNamespace(take=take), seed=1)
        assert seen.value.args == ({1},)
        assert threads() == {2}


def test_results_go_to_another_process_and_back():
    found = pickle.loads(pickle.dumps(scara_iso.analyze(TABLE_1)))  # noqa: S301 - our own
    assert to_json(found) == to_json(scara_iso.analyze(TABLE_1))
    assert isinstance(found.run.covariates, type(scara_iso.read_table(TABLE_1).covariates))


@pytest.mark.parametrize("table", [None, {"X": [0.1]}, np.ones((31, 2)), pd.Series([0.1])])
def test_what_is_no_table_is_refused_in_words(table):
    with pytest.raises(UsageError, match="is not a table of readings") as caught:
        scara_iso.analyze(table, unit="mm")
    assert "pandas.DataFrame" in caught.value.remedy


def test_one_effect_may_be_one_text():
    one = scara_iso.simulate(MODEL, effects="warm_up:size=0.03,tau=8")
    several = scara_iso.simulate(MODEL, effects=["warm_up:size=0.03,tau=8"])
    assert np.array_equal(one.axes["X"].readings, several.axes["X"].readings)


def test_several_poses_are_not_held_out_of_one():
    with pytest.raises(DataError, match="what it is held out of has one"):
        scara_iso.diagnose(TABLE_1, hold_out=EXAMPLES / "five_poses.csv")


def test_what_to_do_stands_below_a_traceback_too():
    with pytest.raises(UsageError) as caught:
        scara_iso.analyze(b"", limit=0.02)
    assert "did you mean limits=?" in "".join(traceback.format_exception(caught.value))


def test_a_table_of_results_has_the_values_of_a_mapping_and_names_in_one_text():
    frame = scara_iso.push(EXAMPLES / "push.csv", arm=0.25).to_frame()
    assert {"parts_sampling", "parts_reading"} <= set(frame.columns)
    assert frame["parts_sampling"].notna().all()


ON_THE_COMMAND_LINE = {
    "ask", "definitions", "dialects", "full", "gauge", "json", "limit", "output", "plot", "probe",
    "rebuild", "separating",
}  # fmt: skip
"""What a message names that is no keyword: the commands' own."""


def named_in_messages():
    """Return every parameter that a text of the package names, with its value: `` `unit=mm` ``."""
    package = Path(scara_iso.__file__).parent
    nodes = (n for path in package.rglob("*.py") for n in ast.walk(ast.parse(path.read_text())))
    texts = (n.value for n in nodes if isinstance(n, ast.Constant) and isinstance(n.value, str))
    return {found for text in texts for found in re.findall(r"(?<!`)`([a-z]\w*)=([^`]*)`", text)}


def keywords():
    """Return the keywords of all public functions."""
    found = set()
    for function in (getattr(scara_iso, name) for name in scara_iso.__getattr__("__all__")):
        if inspect.isfunction(function):
            own = inspect.signature(function, eval_str=False).parameters.values()
            found |= {one.name for one in own}
    return found | {*get_type_hints(ReadingOptions), *get_type_hints(TablesOptions)}


def test_what_a_message_names_is_a_keyword_as_python_takes_it():
    named = named_in_messages()
    assert len(named) > 60
    assert {name for name, _ in named} - keywords() <= ON_THE_COMMAND_LINE
    for name, value in named:
        if value and value != "N":
            said = as_keywords(f"`{name}={value}`").strip("`")
            (keyword,) = ast.parse(f"call({said})").body[0].value.keywords
            ast.literal_eval(keyword.value)


@pytest.mark.parametrize(
    ("limits", "said"),
    [(-1, "`limits=0.02`"), ({"theta": 0}, "`limits=0.02`")],
)
def test_the_remedy_for_a_limit_works_when_it_is_typed(limits, said):
    with pytest.raises(scara_iso.UsageError) as refused:
        scara_iso.analyze(TABLE_1, limits=limits)
    assert said in refused.value.remedy
    assert scara_iso.analyze(TABLE_1, limits=0.02).limits


def test_what_an_error_adds_to_a_traceback_is_python():
    error = scara_iso.UsageError(
        "x", remedy="`decimal=,`, `limits=theta=0.05`, `metadata=operator=A. B`, `cycles=N`"
    )
    said = '`decimal=","`, `limits={"theta": 0.05}`, `metadata={"operator": "A. B"}`, '
    assert error.__notes__ == [said + "`cycles=N`"]


def test_a_missing_reading_is_left_out_and_none_is_invented():
    frame = pd.DataFrame({"cycle": range(1, 32), "X": np.linspace(0.1, 0.11, 31)})
    frame.loc[6, "X"] = np.nan
    with pytest.raises(scara_iso.DataError) as refused:
        scara_iso.analyze(frame, unit="mm")
    assert "`allow_gaps=True`" in refused.value.remedy
    assert "fill" not in refused.value.remedy
    found = scara_iso.analyze(frame.drop(6), unit="mm", allow_gaps=True)
    assert found.cycles.used == 29
