"""requirements.lock fits pyproject.toml: all that is needed, in versions that fit, by hashes."""

import re
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[1]
EXTRAS = ("ble", "dask", "fleet", "pdf")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
LOCK = (ROOT / "requirements.lock").read_text(encoding="utf-8").replace("\\\n", " ").splitlines()
NEEDED = [
    *PROJECT["dependencies"],
    *(one for extra in EXTRAS for one in PROJECT["optional-dependencies"][extra]),
]


@pytest.mark.parametrize("needed", NEEDED)
def test_what_is_needed_is_locked_in_versions_that_fit(needed):
    wanted = Requirement(needed)
    locked = [Requirement(line.partition("--hash")[0]) for line in LOCK]
    own = [one for one in locked if canonicalize_name(one.name) == canonicalize_name(wanted.name)]
    assert own, "run .ci/lock"
    for one in own:
        assert wanted.specifier.contains(str(one.specifier).removeprefix("==")), "run .ci/lock"


def test_every_line_is_one_version_by_its_hashes_and_names_no_index():
    assert all(re.match(r"[\w.-]+==\S+ .*--hash=sha256:[0-9a-f]{64}", line) for line in LOCK)
    assert not re.search(r"https?:|--index|--find-links|--extra", "\n".join(LOCK))
