"""`scara-iso explain`: every finding and effect has its page."""

import ast
import json
import re
from pathlib import Path

import pytest
from hostile import TEXTS
from once import once
from source import PATHS, nodes_of

import scara_iso
from scara_iso.commands import main
from scara_iso.effects import find_effects, find_gear_effects
from scara_iso.reporting import (
    analysis_report,
    comparison_report,
    diagnosis_report,
    explain,
    gauge_study_report,
    history_report,
    poses_report,
)
from scara_iso.reporting.explain import SAME, WORDS, find_pages, pages
from scara_iso.robot.model import ARM_PLACES

ROOT = Path(__file__).parents[2]


@pytest.fixture(autouse=True, scope="module")
def pages_made_once():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(explain, "pages", once(pages))
        yield


def codes_in_the_source():
    """Yield every ``CODE``, and the code of every ``Finding(...)`` that is written there."""
    for path in PATHS:
        for node in nodes_of(path):
            match node:
                case ast.Call(func=ast.Name("Finding"), args=[ast.Constant(code), *_]):
                    yield code
                case ast.Assign(targets=[ast.Name("CODE")], value=ast.Constant(code)):
                    yield code


def test_every_effect_and_finding_has_a_page_and_no_other():
    wanted = {*codes_in_the_source(), *(e.name for e in (*find_effects(), *find_gear_effects()))}
    assert {"trend", "edited", "same-readings", "warm_up", "gap"} <= wanted
    assert {page.code for page in pages()} == {*wanted, "beyond-dials"}
    assert all(page.title and page.text for page in pages())


@pytest.mark.parametrize("code", ["trend", "warm_up", "warm-up", "warm up", "REFLECTED_INERTIA"])
def test_a_page(code, capsys):
    assert main(["explain", code]) == 0
    assert code.lower().replace("-", "_").replace(" ", "_") in capsys.readouterr().out


def test_the_words_on_the_screen_lead_to_the_page(capsys):
    assert main(["explain", "dial too coarse"]) == 0
    assert capsys.readouterr().out.lstrip().startswith("coarse-resolution:")


@pytest.mark.parametrize(
    ("word", "page"),
    [
        ("XY", "XY"), ("eq. 23", "RP_rss"), ("interval", "interval"), ("FAIL", "not provable"),
        ("not-provable", "not provable"), ("tau", "settles"), ("p", "p"), ("theta", "X"),
        ("XY_eq23", "RP_rss"), ("XY eq. 23", "RP_rss"), ("RP XY", "RP"), ("moved", "trend"),
        ("its interval is void", "trend"), ("void", "trend"), ("drifted", "trend"),
        ("too coarse", "coarse-resolution"), ("steps", "step"), ("conditional", "R&R"),
        ("3 s", "3 s"), ("three sigma", "3 s"), ("hysteresis", "hysteresis"), ("driver", "driver"),
        ("recording edited or not sealed", "edited"), ("step or linear drift", "step"),
    ],
)  # fmt: skip
def test_a_word_of_the_screens_is_explained(word, page, capsys):
    assert main(["explain", word]) == 0
    assert capsys.readouterr().out.lstrip().startswith(f"{page}:")


EXAMPLES = ROOT / "examples"
PLAIN = {
    "", "95 % from", "RP of", "acts", "after", "axis", "before", "change", "change is",
    "characteristic",
    "charts", "criterion", "date", "effects", "effect", "end", "figure", "first", "from", "in",
    "last", "left out by turns", "limit of", "mean", "measured", "n", "of", "other words",
    "over the cycles", "pose", "settled", "source", "standard deviation", "start", "table",
    "tests", "to", "visit", "after/before", "by average and range", "VDA 5, ISO 22514-7",
    "what was done", "what", "why", "X", "Y", "Z", "theta", "held out, before", "held out, after",
}  # fmt: skip
"""Headings of columns that are no terms, or say with their neighbours what they are."""


def documents():
    def name(table):
        return EXAMPLES / f"{table}.csv"

    for table in ("scatter", "five_poses", "fum_scara_table1"):
        yield analysis_report(scara_iso.analyze(name(table), limits=0.02))
    for table in ("scatter", "warm_up"):
        yield diagnosis_report(scara_iso.diagnose(name(table)))
    yield poses_report(scara_iso.diagnose(name("five_poses"), EXAMPLES / "five_poses.toml"))
    yield comparison_report(scara_iso.compare(name("before_repair"), name("after_repair")))
    yield gauge_study_report(scara_iso.gauge_study(name("dial_crossed"), tolerance=0.03))
    yield history_report(scara_iso.history(EXAMPLES / "months"))


@pytest.mark.slow
def test_every_term_above_a_column_is_explained():
    tables = [b for report in documents() for s in report for b in s.blocks if hasattr(b, "header")]
    heads = {re.sub(r"\s*\[.*\]", "", head) for table in tables for head in table.header}
    terms = {re.sub(r"^limit [0-9].*|^RP (of|where) .*", "", head) for head in heads} - PLAIN
    assert len(terms) >= 30
    assert all(find_pages(term) for term in terms)


@pytest.mark.parametrize(
    "term", ["step or linear drift", "evidence", "effect removed", "not identifiable",
             "odd reading", "no known effect", "traced to the joints"],
)  # fmt: skip
def test_a_term_of_the_answers_is_explained(term):
    assert find_pages(term)


def test_every_other_name_leads_to_a_page_and_none_to_two():
    names = [*SAME, *(name for names in WORDS for name in names)]
    assert all(find_pages(name) for name in names)
    assert len({*names, *(page.code for page in pages())}) == len(names) + len(
        {page.code for page in pages()}
    )


def test_without_a_code_all_are_listed(capsys):
    assert main(["explain"]) == 0
    out = capsys.readouterr().out
    tasks = [" ".join(task.split("\n")[1:]) for task in out.split("\n\n")]
    listed = {" ".join(name.split()) for task in tasks for name in task.split(",")}
    assert {page.code for page in pages()} <= listed
    assert {names[0] for names in WORDS} <= listed
    assert len(out.splitlines()) < 50
    assert main(["explain", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert [page["code"] for page in document["pages"]] == [page.code for page in pages()]


def test_a_code_of_a_characteristic_and_an_effect_has_both_pages(capsys):
    assert main(["explain", "compliance", "--json"]) == 0
    kinds = [page["kind"] for page in json.loads(capsys.readouterr().out)["pages"]]
    assert kinds == ["characteristic", "effect on readings"]


def test_an_unknown_code_names_the_nearest(capsys):
    assert main(["explain", "course-resolution"]) == 2
    assert "did you mean coarse-resolution" in capsys.readouterr().err
    assert main(["explain", "coarse"]) == 2
    assert "did you mean coarse-resolution" in capsys.readouterr().err


def test_an_effect_of_a_users_file_has_its_page(capsys):
    file = str(ROOT / "examples" / "my_effects.toml")
    assert main(["explain", "cooled-while-open", "--effects", file, "--json"]) == 0
    (page,) = json.loads(capsys.readouterr().out)["pages"]
    assert "abs(k - closed)" in page["title"]
    assert any("the guard door stood open" in text for text in page["text"])
    assert [p["name"] for p in page["parameters"]] == ["closed", "size"]
    assert main(["explain", "--effects", file]) == 0
    assert "cooled_while_open" in capsys.readouterr().out
    assert main(["explain", "cooled_while_open"]) == 2


@pytest.mark.parametrize("code", [t for t in TEXTS if not t.startswith("-") and "\0" not in t])
def test_a_hostile_code_does_no_harm(code, capsys):
    assert main(["explain", code]) == 2
    err = capsys.readouterr().err
    assert len(err) < 1000
    assert not {"\x1b", "\u202e", "\x9b", "\r"} & set(err)


def test_the_findings_say_how_to_read_more(capsys):
    assert main(["analyze", "examples/fum_scara_table1.csv", "--full"]) == 0
    assert "scara-iso explain CODE" in capsys.readouterr().out


def test_a_term_of_several_words_needs_no_quotes(capsys):
    assert main(["explain", "not", "provable"]) == 0
    assert "not provable: " in capsys.readouterr().out


@pytest.mark.parametrize(
    ("asked", "code"),
    [
        ("two levels", "contact_side"),
        ("two levels, contact side", "contact_side"),
        ("89 %", "probability"),
        ("89", "probability"),
    ],
)
def test_words_and_percentages_of_the_first_line_are_explained(asked, code):
    assert [page.code for page in find_pages(asked)] == [code]


@pytest.mark.parametrize("place", [*ARM_PLACES, "joint 4", "everywhere"])
def test_every_place_of_an_effect_is_explained(place):
    (page,) = find_pages(place)
    assert page.title.startswith("Where an effect acts")


@pytest.mark.parametrize("said", ["remarks to read", "SIMULATED", "the dial", "mean"])
def test_what_a_screen_prints_has_a_page(said):
    assert find_pages(said)
