"""Would the tests notice? A seeded sample of mutants of the core, and which survive its tests.

    python benchmarks/mutation.py [--mutants 400] [--seed 1] [--only NAME] [--jobs 2]

Cosmic Ray makes the mutants. A place in the code is drawn first and a change of it second, so that
one sum with eleven possible replacements does not count eleven times. What changes nothing but an
annotation is no mutant. Tests that fail on the code as it is would notice anything: they are run
first, and nothing is counted where they fail. The survivors are printed with their line.
"""

from __future__ import annotations

import argparse
import ast
import random
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from queue import Queue

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names

ROOT = Path(__file__).parents[1]
_DIAGNOSIS = "tests/test_diagnosis_parts.py tests/test_diagnosis.py"
_RECORDER = (
    "tests/test_tampering.py tests/test_session.py tests/test_record_cli.py "
    "tests/test_durability.py"
)
TESTS = {
    "scara_iso/robot/two_inertia.py": "tests/test_two_inertia.py",
    "scara_iso/iso9283/analysis.py": "tests/test_analysis.py tests/test_checks.py "
    "tests/test_cli.py",
    "scara_iso/iso9283/cycles.py": "tests/test_iso9283.py tests/test_analysis.py",
    "scara_iso/iso9283/statistics.py": "tests/test_repeatability.py tests/test_analysis.py",
    "scara_iso/acquisition/recorder/recording.py": _RECORDER,
    "scara_iso/acquisition/recorder/history.py": f"tests/test_history.py {_RECORDER}",
    "scara_iso/diagnosis/evidence.py": f"tests/test_choice.py {_DIAGNOSIS}",
    "scara_iso/diagnosis/fit.py": f"tests/test_fit.py {_DIAGNOSIS}",
    "scara_iso/diagnosis/search.py": f"tests/test_search.py {_DIAGNOSIS}",
    "scara_iso/diagnosis/choice.py": f"tests/test_choice.py {_DIAGNOSIS}",
    "scara_iso/tables/locale.py": "tests/tables",
    "scara_iso/tables/numbers.py": "tests/tables",
    "scara_iso/acquisition/indicators/_decoder.py": "tests/indicators",
    "scara_iso/acquisition/indicators/_dialect.py": "tests/indicators",
    "scara_iso/acquisition/indicators/_grammar.py": "tests/indicators",
    "scara_iso/acquisition/indicators/opto_rs232.py": "tests/indicators",
}
"""The core and its tests: the quick ones first, for the first failure ends the run."""
LONGEST = 300.0
"""Seconds after which tests that do not end have noticed the mutant."""


@dataclass(frozen=True)
class Mutant:
    """One change of one file."""

    module: str
    line: int
    operator: str
    source: str

    def __str__(self) -> str:
        return f"{self.module}:{self.line} {self.operator.removeprefix('core/')}"


class _Bare(ast.NodeTransformer):
    """Takes annotations away."""

    def visit_arg(self, node: ast.arg) -> ast.arg:
        node.annotation = None
        return node

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        node.returns = None
        return self.generic_visit(node)

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.AST:
        node.annotation = ast.Constant(None)
        return self.generic_visit(node)


def _meaning(source: str) -> str:
    return ast.dump(_Bare().visit(ast.parse(source)))


Change = tuple[str, int]
"""Name of an operator, and which of the places in a module that it can change."""


def places_of(module: str) -> list[tuple[str, int, list[Change]]]:
    """Return each place of a module that can be changed: module, line and its possible changes."""
    places: dict[tuple[int, int], list[Change]] = {}
    nodes = list(ast_nodes(get_ast((ROOT / module).read_text(encoding="utf-8"))))
    for name in sorted(operator_names()):
        if get_operator(name).arguments():
            continue  # it wants names of variables of this code
        operator = get_operator(name)()
        found = (start for node in nodes for start, _ in operator.mutation_positions(node))
        for occurrence, start in enumerate(found):
            places.setdefault(start, []).append((name, occurrence))
    return [(module, start[0], changes) for start, changes in sorted(places.items())]


def drawn(modules: Sequence[str], rng: random.Random) -> Iterator[Mutant]:
    """Yield one mutant for each place of the modules that can be changed, in random order."""
    places = [place for module in modules for place in places_of(module)]
    rng.shuffle(places)
    for module, line, changes in places:
        source = (ROOT / module).read_text(encoding="utf-8")
        for name, occurrence in rng.sample(changes, len(changes)):
            mutated = mutate_code(source, get_operator(name)(), occurrence)
            if mutated and _parses(mutated) and _meaning(mutated) != _meaning(source):
                yield Mutant(module, line, name, mutated)
                break


def _parses(source: str) -> bool:
    try:
        ast.parse(source)
    except SyntaxError:
        return False
    return True


def survives(mutant: Mutant, tree: Path) -> bool:
    """Return whether the module's tests pass in a copy of the tree that holds the mutant."""
    path = tree / mutant.module
    original = path.read_text(encoding="utf-8")
    path.write_text(mutant.source, encoding="utf-8")
    try:
        done = subprocess.run(
            [sys.executable, "-B", "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider",
             "-p", "no:randomly", *TESTS[mutant.module].split()],
            cwd=tree, capture_output=True, timeout=LONGEST, check=False,
            env={"PYTHONPATH": str(tree), "PATH": "/usr/bin:/bin", "HOME": str(tree)},
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return False
    finally:
        path.write_text(original, encoding="utf-8")
    return done.returncode == 0


def _copy(to: Path) -> Path:
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, check=True)
    for name in listed.stdout.decode().splitlines():
        (to / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, to / name)
    return to


def main() -> None:
    """Draw the mutants, run the tests on each, print score and survivors."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--mutants", type=int, default=400)
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--only", default="", help="modules whose path holds this")
    options.add_argument("--jobs", type=int, default=2)
    asked = options.parse_args()
    rng = random.Random(asked.seed)  # noqa: S311 - a sample
    modules = [module for module in TESTS if asked.only in module]
    sample = list(islice(drawn(modules, rng), asked.mutants))
    print(f"{len(sample)} mutants, seed {asked.seed}", flush=True)
    with tempfile.TemporaryDirectory() as scratch:
        trees: Queue[Path] = Queue()
        for k in range(asked.jobs):
            trees.put(_copy(Path(scratch) / str(k)))
        _check_unchanged({mutant.module for mutant in sample}, trees.queue[0])

        def tried(mutant: Mutant) -> bool:
            tree = trees.get()
            try:
                alive = survives(mutant, tree)
            finally:
                trees.put(tree)
            if alive:
                print(f"survives: {mutant}", flush=True)
            return alive

        with ThreadPoolExecutor(asked.jobs) as pool:
            outcomes = list(pool.map(tried, sample))
    _print_scores(sample, outcomes)


def _check_unchanged(modules: Iterable[str], tree: Path) -> None:
    """End the program where the tests of a module fail on the module as it is."""
    for module in sorted(modules):
        source = (ROOT / module).read_text(encoding="utf-8")
        if not survives(Mutant(module, 0, "none", source), tree):
            sys.exit(f"the tests of {module} fail without a mutant: {TESTS[module]}")


def _print_scores(sample: list[Mutant], outcomes: list[bool]) -> None:
    tried = Counter(mutant.module for mutant in sample)
    alive = Counter(m.module for m, survived in zip(sample, outcomes, strict=True) if survived)
    print("\n| module | mutants | noticed | % |\n|---|---|---|---|")
    for module, count in tried.items():
        noticed = count - alive[module]
        print(f"| {module} | {count} | {noticed} | {100 * noticed / count:.0f} |")
    noticed = len(sample) - sum(outcomes)
    print(f"| all | {len(sample)} | {noticed} | {100 * noticed / len(sample):.1f} |")


if __name__ == "__main__":
    main()
