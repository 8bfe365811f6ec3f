"""The README's commands are CI's, its output is the program's, its library lines run."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", README, flags=re.DOTALL)


def test_ci_runs_the_readme_s_commands():
    commands = [block.strip() for block in blocks("sh")]
    assert len(commands) == 2
    ci = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    for command in commands:
        assert f"\n{command}\n" in ci


def test_the_shown_output_is_real():
    (shown,) = blocks("console")
    command, _, output = shown.partition("\n")
    assert command.startswith("$ scara-iso ")
    done = subprocess.run(
        [sys.executable, "-m", "scara_iso", *command.split()[2:]],
        capture_output=True, check=True, cwd=ROOT, env={**os.environ, "COLUMNS": "80"},
    )  # fmt: skip
    lines = [line.rstrip() for line in done.stdout.decode("utf-8").rstrip().splitlines()]
    assert lines == output.rstrip().splitlines()


def test_the_library_lines_run(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    (program,) = blocks("python")
    exec(program, {})  # noqa: S102 - our own README
    assert capsys.readouterr().out.startswith("0.01403646566")


@pytest.mark.parametrize("target", re.findall(r"\]\((?!http)([^)]+)\)", README))
def test_every_link_leads_somewhere(target):
    assert (ROOT / target).exists()
