"""What an error or a report calls a parameter, the command line shows as the option that works."""

import pytest

from scara_iso.cli import main
from scara_iso.cli.output import as_options


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
