"""CSV of `report` and `plan` of a hostile table: what spreadsheets make of it."""

import csv

import pytest
from hostile import FORMULAS, TEXTS, model, table
from office import OFFICE, opened

from scara_iso import read_table
from scara_iso.commands import main
from scara_iso.reporting.shared.digits import printable
from scara_iso.tables.write import text_cell

DELIMITERS = {"de": ";", "en": ","}
WIDE = "\uff1d\uff0b\uff0d\uff20"


def written(folder, name, texts):
    """Return a hostile table, its report and a plan as CSV for that Excel."""
    source = table(folder / "=1+1.xlsx", texts=texts)
    report, plan = folder / "report.csv", folder / "plan.csv"
    spelt = ["--excel-locale", name]
    assert main(["report", str(source), "--cycles", "4", "-o", str(report), *spelt]) == 0
    described = model(folder / "=1+1.toml", "=1+1")
    assert main(["plan", str(described), "-o", str(plan), *spelt]) == 0
    return read_table(source), report, plan


def is_number(cell):
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return False
    return True


@pytest.mark.slow
@pytest.mark.parametrize("name", ["de", "en"])
def test_no_cell_begins_as_a_formula_unless_it_is_a_number(name, tmp_path):
    run, *files = written(tmp_path, name, TEXTS)
    for file in files:
        text = file.read_text(encoding="utf-8-sig")
        cells = [
            c for row in csv.reader(text.splitlines(), delimiter=DELIMITERS[name]) for c in row
        ]
        suspects = [c for c in cells if c.strip()[:1] and c.strip()[0] in "=+-@" + WIDE]
        assert all(map(is_number, suspects))
        assert not [c for c in cells if not c.isprintable()]
        if file.name == "report.csv":
            said = {text_cell(printable(text)) for text in run.metadata.values() if text.strip()}
            assert said - set(cells) <= {text_cell(printable(run.metadata["method"]))}


@pytest.mark.skipif(OFFICE is None, reason="LibreOffice is not installed")
@pytest.mark.parametrize("name", ["de", "en"])
def test_libreoffice_finds_text_numbers_and_no_formula(name, tmp_path):
    run, *files = written(tmp_path, name, FORMULAS)
    report, plan = opened(name, *files)
    assert not [c.value for rows in (report, plan) for row in rows for c in row
                if c.data_type == "f" or c.hyperlink]  # fmt: skip
    texts = {str(c.value).removeprefix("'") for row in report for c in row}
    free = [printable(t).strip() for key, t in run.metadata.items() if key.startswith("free")]
    assert set(free) <= {text.strip() for text in texts}
    raw = [row for row in report if isinstance(row[0].value, int) and row[0].data_type == "n"]
    x = [row[2].value for row in raw]
    assert x[-len(run) :] == pytest.approx(run.axes["X"].readings)
    assert len(plan) > 5
    assert all(isinstance(cell.value, int | float) for row in plan[1:] for cell in row[-6:])
