"""Would the tests notice? A seeded sample of mutants of the core, and which survive its tests.

    python benchmarks/mutation.py [--mutants 400] [--seed 1] [--only NAME] [--jobs 2]

Cosmic Ray makes the mutants. A place in the code is drawn first and a change of it second, so that
one sum with eleven possible replacements does not count eleven times. What changes nothing but an
annotation is no mutant. Each module has its part of the mutants by its places, drawn by seed and
its own name: the same ones, whatever else is asked for or edited. Tests that fail on the code as it
is would notice anything: they are run first, and nothing is counted where they fail. The survivors
are printed with their line and change.
"""

from __future__ import annotations

import argparse
import ast
import compileall
import difflib
import multiprocessing
import os
import random
import resource
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import islice
from math import ceil
from pathlib import Path
from py_compile import PycInvalidationMode
from queue import Queue

import pytest
from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names

ROOT = Path(__file__).parents[1]
_TABLES = "tests/tables/test_numbers.py tests/tables/test_tables_locale.py"
_PROCEDURE = "tests/test_iso9283.py tests/test_analysis.py tests/test_results.py"
_WIRE = "tests/indicators/test_"
TESTS = {
    "scara_iso/robot/two_inertia.py": "tests/test_two_inertia.py tests/test_results.py",
    "scara_iso/iso9283/analysis.py": _PROCEDURE,
    "scara_iso/iso9283/cycles.py": _PROCEDURE,
    "scara_iso/iso9283/statistics.py": f"tests/test_statistics.py {_PROCEDURE}",
    "scara_iso/acquisition/recorder/recording.py": "tests/test_recording.py tests/test_session.py",
    "scara_iso/acquisition/recorder/history.py": "tests/test_history.py",
    "scara_iso/diagnosis/likelihood/evidence.py": "tests/test_evidence.py tests/test_choice.py",
    "scara_iso/diagnosis/fit.py": "tests/test_fit.py",
    "scara_iso/diagnosis/search.py": "tests/test_search.py",
    "scara_iso/diagnosis/naming/choice.py": "tests/test_choice.py",
    "scara_iso/tables/locale.py": _TABLES,
    "scara_iso/tables/numbers.py": _TABLES,
    "scara_iso/acquisition/indicators/_decoder.py": f"{_WIRE}decoder.py {_WIRE}streams.py",
    "scara_iso/acquisition/indicators/_dialect.py": f"{_WIRE}dialect.py {_WIRE}decoder.py",
    "scara_iso/acquisition/indicators/_grammar.py": f"{_WIRE}grammar.py {_WIRE}opto_rs232.py",
    "scara_iso/acquisition/indicators/opto_rs232.py": f"{_WIRE}opto_rs232.py {_WIRE}faults.py",
}
"""The core and its tests: the quick ones first, for the first failure ends the run."""
LONGEST_CPU, LONGEST = 120, 1800.0
"""Seconds of processor, and of waiting, after which tests that do not end have noticed the mutant;
a busy machine is no reason."""


@dataclass(frozen=True)
class Mutant:
    """One change of one file."""

    module: str
    line: int
    operator: str
    source: str

    def __str__(self) -> str:
        original = (ROOT / self.module).read_text(encoding="utf-8")
        lines = difflib.unified_diff(original.splitlines(), self.source.splitlines(), n=0)
        changed = "\n".join(f"    {line}" for line in list(lines)[3:])
        return f"{self.module}:{self.line} {self.operator.removeprefix('core/')}\n{changed}"


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


Place = tuple[str, int, list[Change]]


def places_of(module: str) -> list[Place]:
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


def sample_of(modules: Sequence[str], mutants: int, seed: int) -> Iterator[Mutant]:
    """Yield for each module its part of at least so many mutants of all modules."""
    places = {module: places_of(module) for module in TESTS}
    whole = sum(map(len, places.values()))
    for module in modules:
        part = ceil(mutants * len(places[module]) / whole)
        rng = random.Random(f"{seed} {module}")  # noqa: S311 - a sample
        yield from islice(drawn(places[module], rng), part)


def drawn(places: Sequence[Place], rng: random.Random) -> Iterator[Mutant]:
    """Yield one mutant for each place that can be changed, in random order."""
    for module, line, changes in rng.sample(places, len(places)):
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
    process = _PROCESSES.Process(target=_run_tests, args=(tree, TESTS[mutant.module].split()))
    process.start()
    process.join(LONGEST)
    process.kill()
    process.join()
    path.write_text(original, encoding="utf-8")
    return process.exitcode == 0


_PROCESSES = multiprocessing.get_context("forkserver")
_PROCESSES.set_forkserver_preload(
    ["__main__", "hypothesis.extra.numpy", "pandas", "scipy.optimize", "scipy.stats"]
)


def _run_tests(tree: Path, tests: Sequence[str]) -> None:
    """Run tests in a process of its own, which has the libraries at hand and nothing of ours."""
    resource.setrlimit(resource.RLIMIT_CPU, (LONGEST_CPU, LONGEST_CPU))
    os.chdir(tree)
    os.environ["PYTHONPATH"] = str(tree)
    sys.path.insert(0, str(tree))
    sys.dont_write_bytecode = True
    silent = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silent, 1)
    os.dup2(silent, 2)
    quietly = [
        "-x",
        "-q",
        "--assert=plain",
        "--hypothesis-seed=1",
        "-p",
        "no:cacheprovider",
        "-p",
        "no:randomly",
        "-m",
        "not cluster",
        "--hypothesis-profile=whole",
    ]
    sys.exit(pytest.main([*quietly, *tests]))


def _copy(to: Path) -> Path:
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, check=True)
    for name in listed.stdout.decode().splitlines():
        (to / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, to / name)
    compileall.compile_dir(
        to / "scara_iso", quiet=1, invalidation_mode=PycInvalidationMode.CHECKED_HASH
    )
    return to


def main() -> None:
    """Draw the mutants, run the tests on each, print score and survivors."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--mutants", type=int, default=400)
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--only", default="", help="modules whose path holds this")
    options.add_argument("--jobs", type=int, default=2)
    asked = options.parse_args()
    modules = [module for module in TESTS if asked.only in module]
    sample = list(sample_of(modules, asked.mutants, asked.seed))
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
