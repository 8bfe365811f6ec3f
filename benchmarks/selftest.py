"""Would the self test notice? One number of the program is changed at a time, and it is run.

    python benchmarks/selftest.py [--changes 60] [--seed 1] [--write]

Each change is one literal of the computing modules, 1 % larger (a whole one by 1), in a copy of the
package. Numbers of messages, of indices and of refusals are left as they are. The references of the
diagnosis and of the recorder, which take longest, are left out.
Prints the table of benchmarks/results/tests.md.
"""

from __future__ import annotations

import argparse
import ast
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from page import RESULTS, put

ROOT = Path(__file__).parents[1]
MODULES = (
    "quantities", "iso9283/statistics", "iso9283/estimates", "iso9283/barycentres",
    "iso9283/drift", "iso9283/arrivals", "iso9283/cycles", "iso9283/analysis",
    "iso9283/pushed_joint", "robot/two_inertia", "force_loop/fit",
    "iso9283/characteristics/rd", "iso9283/characteristics/ad", "iso9283/characteristics/drp",
)  # fmt: skip
QUICK = (
    "from scara_iso.commands.selftest import GROUPS, validate; import sys; "
    "checks = list(validate({n: g for n, g in GROUPS.items() if n != 'diagnosis'})); "
    "print([c.name for c in checks if not c.passed][:2]); "
    "sys.exit(any(not c.passed for c in checks))"
)
Place = tuple[str, int, int, int]


def numbers(module: str) -> Iterator[Place]:
    """Yield each literal that computes: module, line, first and last column."""
    tree = ast.parse((ROOT / "scara_iso" / f"{module}.py").read_text(encoding="utf-8"))
    passed_over = (ast.Subscript, ast.JoinedStr, ast.Raise)
    idle = {id(n) for p in ast.walk(tree) if isinstance(p, passed_over) for n in ast.walk(p)}
    for node in ast.walk(tree):
        plain = isinstance(node, ast.Constant) and type(node.value) in (int, float)
        if plain and id(node) not in idle and node.value not in (0, -1):
            yield module, node.lineno, node.col_offset, node.end_col_offset or 0


def changed(text: str) -> str:
    """Return another number."""
    return str(int(text) + 1) if text.isdecimal() else repr(float(text) * 1.01)


def copied(folder: str) -> None:
    """Put a copy of the package into ``folder``, beside the references of the tests."""
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "scara_iso", Path(folder) / "scara_iso", ignore=ignored)
    (Path(folder) / "tests").symlink_to(ROOT / "tests")


def is_red(folder: str) -> bool:
    """Return whether a reference is not met by the package in ``folder``."""
    environment = {**os.environ, "PYTHONPATH": folder, "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(
        [sys.executable, "-c", QUICK], env=environment, cwd=folder, capture_output=True,
        check=False, timeout=600,
    )  # fmt: skip
    return done.returncode != 0


def noticed(place: Place) -> tuple[bool, str]:
    """Say whether the self test is red where the number at ``place`` is changed, and the line."""
    module, line, begin, end = place
    with tempfile.TemporaryDirectory() as folder:
        copied(folder)
        path = Path(folder) / "scara_iso" / f"{module}.py"
        lines = path.read_text(encoding="utf-8").split("\n")
        old = lines[line - 1].encode()  # columns are counted in bytes
        number = changed(old[begin:end].decode()).encode()
        lines[line - 1] = (old[:begin] + number + old[end:]).decode()
        path.write_text("\n".join(lines), encoding="utf-8")
        red = is_red(folder)
    return red, f"`{module}` {line}: `{lines[line - 1].strip()}`"


def main() -> None:
    """Print how many changes are noticed, and those that are not."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--changes", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--write", action="store_true", help="write the table into the page")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        copied(folder)
        if is_red(folder):
            raise SystemExit("the package is red as it is: nothing can be noticed")
    places = [place for module in MODULES for place in numbers(module)]
    rng = random.Random(options.seed)  # noqa: S311 - a sample
    chosen = rng.sample(places, min(options.changes, len(places)))
    seen, missed = 0, []
    for place in sorted(chosen):
        red, said = noticed(place)
        seen += red
        if not red:
            missed.append(said)
        print("red  " if red else "green", said, flush=True)
    rows = [
        "| numbers in the computing modules | changed | red |", "|---|---|---|",
        f"| {len(places)} | {len(chosen)} | {seen} |", "", "Not noticed:", "",
        *(f"* {said}" for said in missed),
    ]  # fmt: skip
    print("\n".join(rows))
    if options.write:
        page = RESULTS / "tests.md"
        page.write_text(put(page.read_text("utf-8"), "selftest", "\n".join(rows)), "utf-8")


if __name__ == "__main__":
    main()
