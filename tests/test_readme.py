"""The README's commands are CI's, its library lines run; what any page shows is the program's."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def blocks(language, text=README):
    return re.findall(rf"```{language}\n(.*?)```", text, flags=re.DOTALL)


def shown():
    """Yield every console block of every page: its command and what it shows of the output."""
    for page in PAGES:
        for k, block in enumerate(blocks("console", page.read_text(encoding="utf-8")), 1):
            command, _, output = block.partition("\n")
            yield pytest.param(command, output.rstrip(), id=f"{page.name}-{k}")


def told_by(command):
    """Return the lines that a command, or several joined by ``|``, write."""
    told = b""
    for part in command.removeprefix("$ ").split(" | "):
        program, *words = part.split()
        assert program == "scara-iso"
        told = subprocess.run(
            [sys.executable, "-m", "scara_iso", *words],
            capture_output=True, check=True, cwd=ROOT, input=told,
            env={**os.environ, "COLUMNS": "80", "PYTHONPATH": str(ROOT)},
        ).stdout  # fmt: skip
    return [line.rstrip() for line in told.decode("utf-8").rstrip().splitlines()]


def test_ci_runs_the_readme_s_commands():
    commands = [block.strip() for block in blocks("sh")]
    assert len(commands) == 2
    ci = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    for command in commands:
        assert f"\n{command}\n" in ci


@pytest.mark.parametrize(("command", "output"), [*shown()])
def test_the_shown_output_is_real(command, output):
    """A line of three points stands for lines that are left out."""
    assert command.startswith("$ scara-iso ")
    told = "\n".join(["", *told_by(command), ""])
    at = 0
    pieces = re.split(r"^\.\.\.$", output, flags=re.MULTILINE)
    for k, piece in enumerate(piece.strip("\n") for piece in pieces):
        found = told.find(f"\n{piece}\n", at) if piece else at
        assert found >= 0, f"not in the output: {piece}"
        assert found == 0 or k > 0, "the output begins otherwise"
        at = found + len(piece) + 1 if piece else at
    assert not pieces[-1].strip() or told[at:] == "\n", "the output goes on"


def test_the_library_lines_run(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    (program,) = blocks("python")
    exec(program, {})  # noqa: S102 - our own README
    assert capsys.readouterr().out.startswith("0.01403646566")


def links():
    for page in PAGES:
        for target in re.findall(r"\]\((?!http)([^)#]+)\)", page.read_text(encoding="utf-8")):
            yield pytest.param(page.parent / target, id=f"{page.name}-{target}")


@pytest.mark.parametrize("target", [*links()])
def test_every_link_leads_somewhere(target):
    assert target.exists()
