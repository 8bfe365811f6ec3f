"""The results of the public functions: what each field means, and how they show themselves."""

import ast
import inspect
import json
import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest
from matplotlib.figure import Figure
from source import PATHS, tree_of

import scara_iso
from scara_iso.base.errors import UsageError
from scara_iso.base.published import to_json
from scara_iso.commands import main
from scara_iso.render import save_figure


@cache
def statements():
    """Return the top of every module: its statements."""
    return [node for path in PATHS for node in tree_of(path).body]


def is_dataclass(node):
    return any("dataclass" in ast.unparse(decorator) for decorator in node.decorator_list)


@cache
def dataclasses():
    """Return each dataclass by its name."""
    classes = (node for node in statements() if isinstance(node, ast.ClassDef))
    return {node.name: node for node in classes if is_dataclass(node)}


def fields_of(node):
    """Return the name, annotation and docstring of each field of a dataclass."""
    after = {id(a): b for a, b in zip(node.body, node.body[1:], strict=False)}
    for line in node.body:
        if not isinstance(line, ast.AnnAssign) or "ClassVar" in ast.unparse(line.annotation):
            continue
        below = after.get(id(line))
        said = isinstance(below, ast.Expr) and isinstance(below.value, ast.Constant)
        yield line.target.id, ast.unparse(line.annotation), below.value.value if said else None


@cache
def aliases():
    """Return other names for a type, which a dataclass elsewhere may have too."""
    named = (node for node in statements() if isinstance(node, ast.Assign | ast.AnnAssign))
    return {ast.unparse(getattr(node, "target", None) or node.targets[0]) for node in named}


def named_in(annotation):
    """Return the dataclasses that an annotation names; its Figure is matplotlib's."""
    return {*re.findall(r"\w+", annotation)} & {*dataclasses()} - aliases() - {"Figure"}


def reachable():
    """Return the results of the public functions and the public classes, and all they hold."""
    public = [getattr(scara_iso, name) for name in scara_iso.__all__]
    functions = [ast.unparse(ast.parse(inspect.signature(one).return_annotation))
                 for one in public if inspect.isfunction(one)]  # fmt: skip
    todo = {one.__name__ for one in public if inspect.isclass(one)} & {*dataclasses()}
    todo = todo.union(*map(named_in, functions))
    found = set()
    while todo - found:
        name = (todo - found).pop()
        found.add(name)
        node = dataclasses()[name]
        held = (*map(ast.unparse, node.bases), *(kind for _, kind, _ in fields_of(node)))
        todo = todo.union(*map(named_in, held))
    return sorted(found)


def test_results_are_reached():
    assert {"Analysis", "Estimate", "GearFound", "MeanContrast", "PlannedPose"} <= {*reachable()}


def silent(node):
    """Return the fields of a dataclass that nothing is said of."""
    page = ast.get_docstring(node) or ""
    return [f for f, _, said in fields_of(node) if not said and f"``{f}``" not in page]


def test_every_field_of_a_result_says_what_it_is():
    unsaid = {name: silent(dataclasses()[name]) for name in reachable()}
    assert {name: fields for name, fields in unsaid.items() if fields} == {}


EXAMPLES = Path(__file__).parents[2] / "examples"
TABLE_1, MODEL = EXAMPLES / "fum_scara_table1.csv", EXAMPLES / "fum_scara.toml"
BEFORE, AFTER = EXAMPLES / "before_repair.csv", EXAMPLES / "after_repair.csv"
POSES = "# unit: mm\npose,cycle,X,Y\n" + "".join(
    f"{pose},{cycle},{(7 * cycle + 3 * k) % 11 / 1000},{5 * cycle * cycle % 13 / 1000}\n"
    for k, pose in enumerate(("P1", "P2"))
    for cycle in range(1, 32)
)


@pytest.fixture(scope="module")
def poses(tmp_path_factory):
    path = tmp_path_factory.mktemp("poses") / "poses.csv"
    path.write_text(POSES)
    return path


RESULTS = {
    "analyze": scara_iso.analyze,
    "diagnose": lambda _: scara_iso.diagnose(TABLE_1),
    "diagnose of poses": scara_iso.diagnose,
    "diagnose_many": lambda _: scara_iso.diagnose_many([TABLE_1, EXAMPLES / "no such.csv"]),
    "compare": lambda _: scara_iso.compare(BEFORE, AFTER),
    "report": lambda _: scara_iso.report(TABLE_1),
    "simulate": lambda _: scara_iso.simulate(MODEL),
    "plan": lambda _: scara_iso.plan(MODEL),
    "backlash": lambda _: scara_iso.backlash(Im=2.65e-4, IL=4.749, arcmin=12, ratio=50),
    "record": lambda poses: scara_iso.record(
        poses.with_name("run.csv"), ["X=opto-rs232@sim:?pace=0"], trigger="timer:10"
    ),
    "read_table": scara_iso.read_table,
}


@pytest.fixture(scope="module", params=RESULTS)
def result(request, poses):
    return RESULTS[request.param](poses)


def test_a_result_is_short_in_a_console_a_table_in_pandas_and_a_page_in_a_notebook(result):
    assert re.fullmatch(r"<(\w+)[ :].{5,110}>", repr(result))
    frame = result.to_frame()
    assert len(frame)
    assert frame.columns.is_unique
    page = result._repr_html_()
    assert re.match("<main>\n<h3>[A-Z]", page)
    assert not re.search(r"<(script|style|iframe|link|object|meta)|<[^>]* on\w+=", page)


def test_the_bars_of_a_screen_are_in_a_notebook_too():
    step = [0.0] * 15 + [0.05] * 16
    rows = "\n".join(f"{k},{x + k % 3 / 1000:.3f}" for k, x in enumerate(step, 1))
    page = scara_iso.diagnose(f"# unit: mm\ncycle,X\n{rows}\n".encode())._repr_html_()
    assert re.search("<b>X measured</b> [▁▂▃]{14}[▆▇█]{16} ", page)


def test_no_text_of_a_file_is_markup_in_a_notebook(poses):
    run = scara_iso.read_table(poses)
    run = replace(run, metadata={**run.metadata, "robot": "<script>alert(1)</script>"})
    page = scara_iso.analyze(run)._repr_html_()
    assert "&lt;script&gt;" in page
    assert "<script" not in page


def test_a_result_with_a_picture_gives_a_figure(result):
    if hasattr(result, "plot"):
        figure = result.plot()
        assert isinstance(figure, Figure)
        assert figure._repr_png_().startswith(b"\x89PNG")
    else:
        assert type(result).__name__ in {
            "Analysis",
            "Backlash",
            "Diagnoses",
            "DiagnosisOfPoses",
            "Run",
            "TestReport",
        }


def test_poses_are_found_by_number_and_by_name(poses):
    analysis, plan = scara_iso.analyze(poses), scara_iso.plan(MODEL)
    assert analysis.poses["P2"] is analysis.poses[1]
    assert plan.poses["P5"] is plan.poses[4]
    with pytest.raises(KeyError, match="no pose 'P9'"):
        analysis.poses["P9"]


def test_a_diagnosis_of_several_poses_is_what_the_command_says(poses, capsys):
    found = scara_iso.diagnose(poses)
    assert list(found.poses) == ["P1", "P2"]
    assert found["P2"] is found[1] is found.poses["P2"]
    with pytest.raises(KeyError, match="there is P1, P2"):
        found["P3"]
    assert main(["diagnose", str(poses), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == json.loads(json.dumps(to_json(found)))
    assert isinstance(scara_iso.diagnose(poses, pose="P1"), scara_iso.Diagnosis)


@pytest.mark.parametrize(
    ("command", "drawn"),
    [
        (("diagnose", TABLE_1, "--plot"), lambda: scara_iso.diagnose(TABLE_1)),
        (("compare", BEFORE, AFTER, "--plot"), lambda: scara_iso.compare(BEFORE, AFTER)),
        (("plan", MODEL, "--picture"), lambda: scara_iso.plan(MODEL)),
    ],
)
def test_a_command_writes_the_figure_that_the_function_returns(command, drawn, tmp_path):
    assert main([*map(str, command), str(tmp_path / "command.svg")]) == 0
    save_figure(drawn().plot(), tmp_path / "own.svg")
    assert (tmp_path / "own.svg").read_bytes() == (tmp_path / "command.svg").read_bytes()


def test_an_option_that_is_not_there_is_answered_with_the_nearest():
    with pytest.raises(UsageError) as refused:
        scara_iso.analyze(TABLE_1, limit=0.02)
    assert "limits=" in refused.value.remedy


def test_thirty_readings_are_thirty_bars_whatever_stands_next_to_them(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    main(["analyze", str(TABLE_1.parent / "scatter.csv"), "--limit", "0.03"])
    bars = re.findall("[▁-█]+", capsys.readouterr().out)
    assert [len(bar) for bar in bars] == [30] * 4
