"""No report is lost under another table's, or under another number, in any format."""

import io
import shutil
import zipfile
from pathlib import Path

import pytest

import scara_iso
from scara_iso.base.errors import CannotCreateError
from scara_iso.commands import main
from scara_iso.commands.evidence import REGISTER

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    for name in ("scatter", "warm_up"):
        shutil.copy(EXAMPLES / f"{name}.csv", tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def report(table, output, *more):
    return main(["report", f"{table}.csv", "-o", output, *more])


@pytest.mark.parametrize("ending", ["html", "md", "csv", "xlsx", "json", "dfq"])
def test_another_table_s_report_stays(folder, capsys, ending):
    page = folder / f"r.{ending}"
    assert report("scatter", page.name) == 0
    first = page.read_bytes()
    assert report("warm_up", page.name) == 73
    assert "of another table" in capsys.readouterr().err
    assert page.read_bytes() == first
    assert report("scatter", page.name) == 0
    assert report("warm_up", page.name, "--replace") == 0
    assert page.read_bytes() != first
    assert report("scatter", page.name) == 73


def test_a_number_is_one_table_s_in_all_its_formats(folder, capsys):
    number = ("--meta", "report_number=17")
    assert report("scatter", "a.md", *number) == report("scatter", "a.csv", *number) == 0
    assert report("warm_up", "b.md", *number) == 73
    assert "number 17 is that of a.csv, of another table" in capsys.readouterr().err
    assert not (folder / "b.md").exists()
    assert report("scatter", "a.md", "--meta", "report_number=18") == 73
    assert "is report 17" in capsys.readouterr().err
    assert report("warm_up", "b.md", *number, "--replace") == 0
    for name in ("a.md", "a.csv", "b.md"):
        (folder / name).unlink()
    assert report("warm_up", "c.md", *number) == 0, "the others are gone"


def test_a_report_without_a_number_is_not_written_over_by_one_that_has_it(folder, capsys):
    """It may hold a verdict, which a report without the limit would replace in silence."""
    number = ("--meta", "report_number=R2")
    assert report("scatter", "a.md", "--limit", "XY=0.1") == report("scatter", "a.md") == 0
    first = (folder / "a.md").read_bytes()
    assert report("scatter", "a.md", *number) == 73
    assert "is a report without a number" in capsys.readouterr().err
    assert (folder / "a.md").read_bytes() == first
    assert report("scatter", "a.md", *number, "--replace") == 0
    assert report("scatter", "a.md") == 73, "nor the other way"


def test_a_report_without_an_entry_is_known_by_its_text(folder):
    page = folder / "r.md"
    page.write_text("my notes", encoding="utf-8")
    assert report("scatter", page.name) == 73, "no report of scara-iso"
    page.unlink()
    assert report("scatter", page.name) == 0
    (folder / REGISTER).write_text("[not json", encoding="utf-8")
    assert report("scatter", page.name) == 0, "its text names the table"
    (folder / REGISTER).unlink()
    assert report("warm_up", page.name) == 73


def packed(content, damage=b"", flags=0):
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as parts:
        parts.writestr("scara-iso", content)
    data = made.getvalue()
    if flags:
        at = data.index(b"PK\x01\x02") + 8
        data = data[:at] + bytes([flags]) + data[at + 1 :]
    return data.replace(b"scara-iso", damage, 1) if damage else data


@pytest.mark.parametrize(
    "there",
    [
        lambda: packed("a", b"other-nam"), lambda: packed("a", flags=1),
        lambda: packed(b"0" * 300_000_000), lambda: b"PK\x05\x06",
    ],
    ids=["damaged", "encrypted", "bomb", "no parts"],
)  # fmt: skip
def test_a_file_that_is_no_report_is_not_written_over(folder, there):
    data = there()
    (folder / "r.xlsx").write_bytes(data)
    assert report("scatter", "r.xlsx") == 73
    assert (folder / "r.xlsx").read_bytes() == data


@pytest.mark.parametrize(
    "register",
    ['{"r.md": {"tables": 7, "number": 1}}', '{"r.md": {"tables": [[1]], "number": {}}}', "[[1]]",
     '{"r.md": 1}', "[" * 100_000],
)  # fmt: skip
def test_a_register_that_is_none_stops_no_report(folder, register):
    (folder / "r.md").write_text("notes", encoding="utf-8")
    (folder / REGISTER).write_text(register, encoding="utf-8")
    assert report("scatter", "r.md") in (0, 73)


@pytest.mark.parametrize(
    ("one", "another"), [("a11.csv", "1.csv"), ("feb/run.csv", "jan/run.csv"), ("b/a.csv", "a.csv")]
)
@pytest.mark.parametrize("whole", [False, True])
def test_a_name_within_another_is_another(folder, one, another, whole):
    for name, table in ((one, "scatter"), (another, "warm_up")):
        (folder / name).parent.mkdir(exist_ok=True)
        shutil.copy(f"{table}.csv", name)
    here = folder if whole else Path()
    assert main(["report", str(here / one), "-o", "r.md"]) == 0
    assert main(["report", str(here / another), "-o", "r.md"]) == 73
    assert main(["report", str(here / one), "-o", "r.md"]) == 0


def test_tables_of_one_name_in_two_folders_are_two(folder, monkeypatch):
    for where, table in (("jan", "scatter"), ("feb", "warm_up")):
        (folder / where).mkdir()
        shutil.copy(f"{table}.csv", f"{where}/run.csv")
    for where, code in (("jan", 0), ("feb", 73), ("jan", 0)):
        monkeypatch.chdir(folder / where)
        assert main(["report", "run.csv", "-o", "../r.md"]) == code


def test_the_library_keeps_them_too(folder):
    scara_iso.report("scatter.csv", to="r.md")
    with pytest.raises(CannotCreateError, match="of another table"):
        scara_iso.report("warm_up.csv", to="r.md")
    scara_iso.report("warm_up.csv", to="r.md", replace=True)
    scara_iso.report("warm_up.csv").write("r.md")
    with pytest.raises(CannotCreateError):
        scara_iso.report("scatter.csv").write("r.md")


@pytest.mark.parametrize("key", ["indicator_X", "operator_2", "operator_name", "robot_number"])
def test_a_key_that_says_more_than_a_field_is_free(folder, key):
    assert report("scatter", "r.md", "--meta", f"{key}=3") == 0
