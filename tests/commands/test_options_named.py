"""What an error or a report calls a parameter, the command line shows as the option that works."""

import re

import pytest

from scara_iso.commands import COMMANDS, main
from scara_iso.commands.shared.output import as_options


@pytest.mark.parametrize(
    ("said", "shown"),
    [
        ("leave `unit=` out", "leave --unit out"),
        ("say `unit=mm`", "say --unit mm"),
        ("say `allow_gaps=True`", "say --allow-gaps"),
        ("`decimal=,` or `decimal=.`", "--decimal , or --decimal ."),
        ("name it: `pose=P 1`", "name it: --pose 'P 1'"),
        ("`sheet='Run 2'`", "--sheet 'Run 2'"),
        ("`gauge=X=opto-rs232@sim:`", "--gauge X=opto-rs232@sim:"),
        ("`metadata=operator=A`, `limits=0.02`", "--meta operator=A, --limit 0.02"),
        ("a line `# unit: mm` and `Run`", "a line `# unit: mm` and `Run`"),
    ],
)
def test_a_parameter_becomes_an_option(said, shown):
    assert as_options(said) == shown


def test_errors_name_the_option(tmp_path, capsys):
    table = tmp_path / "run.csv"
    table.write_text("# unit: mm\ncycle,X\n1,0.1\n2,0.2\n3,0.1\n")
    assert main(["analyze", str(table), "--unit", "inch"]) == 65
    assert "leave --unit out" in capsys.readouterr().err


def test_pages_of_findings_name_the_option(capsys):
    assert main(["explain", "missing-cycles"]) == 0
    assert "With --allow-gaps the cycles" in capsys.readouterr().out


@pytest.mark.parametrize("words", [[], ["analyze"], ["test", "new"]])
def test_help_may_be_a_word(words, capsys):
    assert main([*words, "--help"]) == 0
    wanted = capsys.readouterr().out
    assert main(["help", *words]) == 0
    assert capsys.readouterr().out == wanted


@pytest.mark.parametrize(
    ("command", "name", "code"),
    [("report", "out.html", 66), ("history", "out.md", 66), ("simulate", "out.csv", 2)],
)
def test_a_file_to_be_written_that_stands_where_one_is_read(command, name, code, capsys):
    assert main([command, "examples/fum_scara.toml", name]) == code
    assert f"did you mean -o {name}?" in capsys.readouterr().err


@pytest.mark.parametrize("words", [["report", "out.html"], ["report", "a.csv", "out.csv"]])
def test_a_table_that_is_not_there_is_no_file_to_be_written(words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(words) == 66
    assert "-o" not in capsys.readouterr().err


def test_help_of_no_command(capsys):
    assert main(["help", "nosuch"]) == 2
    assert "No such command 'nosuch'" in capsys.readouterr().err


@pytest.mark.parametrize("command", COMMANDS)
def test_help_has_no_words_of_programmers_and_groups_what_belongs_together(command, capsys):
    assert main([command, "--help"]) == 0
    out = capsys.readouterr().out
    assert not re.search(r"<(str|float|int|path)\b(?! *\|)[^|]*>", out)
    if "--all-count" in out:
        options = re.findall(r"^  --(?:unit|resolution|decimal|sheet|columns)\b", out, re.MULTILINE)
        assert ("How a table is read:" in out) == (len(options) > 1)
        assert out.index("Which cycles count:") < out.index("--all-count")


@pytest.mark.parametrize(
    ("argv", "said"),
    [(["--Im", "2,65e-4"], "'2,65e-4' is not a number"), (["--arm", "x"], "'x' is not a number")],
)
def test_a_number_that_is_none_is_called_so(argv, said, capsys):
    assert main(["backlash", "--IL", "3", "--arcmin", "3", *argv]) == 2
    assert said in capsys.readouterr().err
