"""The README's commands are CI's, its library lines run; its output is test_docs.py's."""

import re
from pathlib import Path

import scara_iso

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", README, flags=re.DOTALL)


def test_ci_runs_the_readme_s_commands():
    commands = [block.strip() for block in blocks("sh")]
    assert len(commands) == 2
    ci = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    run = (step for line in ci.splitlines() for step in line.strip().split(" && "))
    assert all(step in run for command in commands for step in command.split(" && "))  # in order


def test_the_library_lines_run(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    (program,) = blocks("python")
    exec(program, {})  # noqa: S102 - our own README
    assert capsys.readouterr().out.startswith("0.01403646566")


def test_who_cites_it_cites_this_version():
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {scara_iso.__version__}\n" in citation
