"""The line of docs/how-to/shell-completion.md makes bash complete commands and options."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "how-to" / "shell-completion.md").read_text(encoding="utf-8")
BASH = shutil.which("bash")


@pytest.mark.skipif(BASH is None, reason="bash is not installed")
@pytest.mark.parametrize(
    ("typed", "completed"),
    [
        (["ana"], ["analyze"]),
        pytest.param(["analyze", "--re"], ["--resolution"], marks=pytest.mark.slow),
        pytest.param(["exp"], ["explain"], marks=pytest.mark.slow),
        pytest.param(["explain", "few"], ["few-levels"], marks=pytest.mark.slow),
        pytest.param(["program", "ra"], ["rapid"], marks=pytest.mark.slow),
        pytest.param(["ports", "--ask", "cdi"], ["cdi-starrett-iq"], marks=pytest.mark.slow),
        pytest.param(
            ["simulate", "m.toml", "--effect", "warm"], ["warm_up:"], marks=pytest.mark.slow
        ),
        pytest.param(
            ["record", "--gauge", "X=cdi"], ["X=cdi-starrett-iq@"], marks=pytest.mark.slow
        ),
    ],
)
def test_bash_completes(typed, completed, tmp_path):
    program = tmp_path / "scara-iso"
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m scara_iso "$@"\n')
    program.chmod(0o755)
    (line,) = re.findall(r"\| bash \|.*\| `(.*)` \|", PAGE)
    script = (
        f"{line}\nCOMP_WORDS=(scara-iso {' '.join(typed)}); COMP_CWORD={len(typed)}\n"
        '_scara_iso_completion scara-iso; printf "%s\\n" "${COMPREPLY[@]}"'
    )
    path = f"{tmp_path}{os.pathsep}{os.environ['PATH']}"
    told = subprocess.run(
        [BASH, "--norc", "-c", script], capture_output=True, check=True, encoding="utf-8",
        env={**os.environ, "PATH": path, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert (told.stdout.split(), told.stderr) == (completed, "")
