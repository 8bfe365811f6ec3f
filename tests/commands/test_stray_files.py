"""A folder is its tables: what is none is named with what to do, what is not used is said."""

import pytest

import scara_iso
from scara_iso.base.errors import DataError

ROWS = "".join(f"{k},0.40{k % 7}\n" for k in range(1, 32))


@pytest.fixture
def folder(tmp_path):
    for k in (1, 2):
        rows = ROWS.replace("0.40", f"0.4{k}")
        (tmp_path / f"P{k}.csv").write_text(f"# unit: mm\n# resolution: 0.001\ncycle,X\n{rows}")
    return tmp_path


@pytest.mark.parametrize("kind", [str, lambda path: [str(path)]])
def test_a_stray_file_is_to_be_moved_away(folder, kind):
    (folder / "notes.txt").write_text("checked the clamps\n")
    with pytest.raises(DataError) as error:
        scara_iso.analyze(kind(folder))
    assert error.value.remedy.endswith(f"move files of something else out of {folder}")


def test_tables_in_folders_below_are_said_to_be_unused(folder):
    before = scara_iso.analyze(str(folder))
    (folder / "old").mkdir()
    (folder / "old" / "P3.csv").write_text((folder / "P1.csv").read_text())
    found = scara_iso.analyze(str(folder))
    assert len(found.poses) == len(before.poses) == 2
    assert f"tables in {folder / 'old'}: not used" in found.run.origin.notes
