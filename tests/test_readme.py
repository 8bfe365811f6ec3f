"""The README's commands are CI's, its library lines run; its output is test_docs.py's."""

import re
import tomllib
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
    for command in commands:  # in order, the last with the slow tests too
        assert all(any(done.startswith(step) for done in run) for step in command.split(" && "))


def test_ci_runs_the_slow_tests_that_the_readme_leaves_out():
    ci = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    (tests,) = [line for line in ci.replace("\\\n", "").splitlines() if " -m pytest " in line]
    assert ' -m "not cluster" --hypothesis-profile whole' in tests
    options = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["pytest"]
    assert "not cluster and not slow" in options["ini_options"]["addopts"]


def test_the_library_lines_run(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    (program,) = blocks("python")
    exec(program, {})  # noqa: S102 - our own README
    assert capsys.readouterr().out.startswith("0.01403646566")


def test_who_cites_it_cites_this_version():
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {scara_iso.__version__}\n" in citation
