"""The name that the guide suggests for a recording."""

from pathlib import Path

import pytest

from scara_iso.commands.operator.guide import _free


@pytest.mark.parametrize(
    ("there", "name"),
    [
        ([], "run.csv"),
        (["run.csv"], "run2.csv"),
        (["run.raw.jsonl"], "run2.csv"),  # its table can be made again
        (["run.csv", "run.raw.jsonl", "run2.csv"], "run3.csv"),
    ],
)
def test_the_first_name_is_suggested_of_which_nothing_is_there(there, name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for one in there:
        Path(one).touch()
    assert _free("run") == Path(name)
