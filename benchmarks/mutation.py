"""Would the tests notice? A seeded sample of mutants of a package, and which survive its tests.

    python benchmarks/mutation.py --of iso9283 --mutants 100 --seed 1 [--jobs 1] [--seconds 30]

A place in the code is drawn first and a change of it second: a comparison, a sign, a number, a
condition, a returned value, an argument left out. Wording, annotations and imports are no places.
Each test is run once on the code as it is, which tells what lines it runs and how long it takes.
A mutant meets the tests that run its line, those in the folder of its package and then all others,
the quickest first, until one fails or each of both took so many seconds of processor. Tests that do
not end have noticed it. Those of README's command are asked, not those marked slow. No file is
written in the work tree: a mutant lives in a process of its own, which has the libraries at hand
and imports ours anew. Programs that a test starts do not see it.
"""

from __future__ import annotations

import argparse
import ast
import copy
import hashlib
import importlib.machinery
import importlib.util
import json
import multiprocessing
import os
import random
import re
import resource
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from types import CodeType

import pytest
from hypothesis import Phase, settings

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "scara_iso"
TESTS = ROOT / "tests"
LIBRARIES = ("numpy", "scipy.optimize", "scipy.stats", "pandas", "hypothesis.extra.numpy", "rich",
             "typer.testing", "python_calamine", "openpyxl")  # fmt: skip
EVERYWHERE = ("test_goldens.py", "test_library.py", "test_reference.py")
"""Tests of all that commands and functions say: they are asked beside a package's own."""
_OPENING = 0.1
"""Seconds of processor that a file of tests takes before its first test."""
KEPT_MAPS = Path(tempfile.gettempdir()) / "scara-iso-mutation"
QUIETLY = ("-q", "--assert=plain", "--hypothesis-seed=1", "--hypothesis-profile=mutants",
           "-p", "no:cacheprovider", "-p", "no:xdist", "-o", "addopts=",
           "-m", "not cluster and not slow")  # fmt: skip

# --- mutants


@dataclass(frozen=True)
class Mutant:
    """One change at one place: the node of a module that so many nodes come before."""

    module: str
    node: int
    change: int
    line: int
    end: int
    in_function: bool
    was: str
    now: str

    def __str__(self) -> str:
        line = (ROOT / self.module).read_text(encoding="utf-8").splitlines()[self.line - 1]
        return f"{self.module}:{self.line}: {line.strip()}\n    {self.was}  ->  {self.now}"


SWAPPED: dict[type[ast.AST], tuple[type[ast.AST], ...]] = {
    ast.Lt: (ast.LtE, ast.GtE), ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE), ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,), ast.NotEq: (ast.Eq,), ast.Is: (ast.IsNot,), ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,), ast.NotIn: (ast.In,), ast.And: (ast.Or,), ast.Or: (ast.And,),
    ast.Add: (ast.Sub,), ast.Sub: (ast.Add,), ast.Mult: (ast.Div,), ast.Div: (ast.Mult,),
    ast.FloorDiv: (ast.Div, ast.Mult), ast.Mod: (ast.Mult,), ast.Pow: (ast.Mult,),
    ast.BitAnd: (ast.BitOr,), ast.BitOr: (ast.BitAnd,),
}  # fmt: skip


def changes_of(node: ast.AST) -> Iterator[ast.AST]:
    """Yield what a node may be changed to."""
    yield from _other_operators(node)
    match node:
        case ast.Constant(bool(value)):
            yield ast.Constant(not value)
        case ast.Constant(int(value) | float(value)):
            yield from (ast.Constant(other) for other in (value + 1, value - 1))
        case ast.If(test) | ast.While(test) | ast.IfExp(test):
            yield _with(node, test=ast.UnaryOp(ast.Not(), test))
        case ast.comprehension(ifs=[test, *others]):
            yield _with(node, ifs=[ast.UnaryOp(ast.Not(), test), *others])
        case ast.Return(value) if value and not _is_none(value):
            yield ast.Return(ast.Constant(None))
        case ast.Call(keywords=keywords):
            for given in keywords:
                yield _with(node, keywords=[other for other in keywords if other is not given])


def _other_operators(node: ast.AST) -> Iterator[ast.AST]:
    match node:
        case ast.Compare(left, [operator, *others], values):
            for other in SWAPPED[type(operator)]:
                yield ast.Compare(left, [other(), *others], values)
        case ast.BinOp(left, operator, right) if not _is_none(right):
            for other in SWAPPED.get(type(operator), ()):
                yield ast.BinOp(left, other(), right)
        case ast.BoolOp(operator, values):
            yield ast.BoolOp(SWAPPED[type(operator)][0](), values)
        case ast.UnaryOp(ast.Not() | ast.USub(), operand):
            yield operand
        case ast.Break() | ast.Continue():
            yield ast.Continue() if isinstance(node, ast.Break) else ast.Break()


def _with(node: ast.AST, **fields: object) -> ast.AST:
    other = copy.copy(node)
    for name, value in fields.items():
        setattr(other, name, value)
    return other


def _is_none(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and node.value is None


Slot = tuple[ast.AST, str, int | None]
"""Where a node hangs: its parent, the field of it, and the index where the field is a list."""


def places_of(tree: ast.AST) -> Iterator[tuple[Slot, ast.AST, ast.AST, bool]]:
    """Yield each node that is no wording: slot, node, statement, whether in a function."""
    stack: list[tuple[Slot, ast.AST, ast.AST, bool]] = [((tree, "", None), tree, tree, False)]
    while stack:
        slot, node, statement, inside = stack.pop()
        yield slot, node, statement, inside
        for name, value in ast.iter_fields(node):
            listed = isinstance(value, list)
            for k, child in enumerate(value if listed else [value]):
                if isinstance(child, ast.AST) and not _is_left_out(name, child):
                    below = inside or (isinstance(node, ast.FunctionDef) and name == "body")
                    own = child if isinstance(child, ast.stmt | ast.excepthandler) else statement
                    stack.append(((node, name, k if listed else None), child, own, below))


def _is_left_out(field: str, child: ast.AST) -> bool:
    match child:
        case ast.JoinedStr() | ast.Import() | ast.ImportFrom() | ast.keyword(arg="strict"):
            return True
        case ast.If(ast.Name("TYPE_CHECKING")) | ast.Assign([ast.Name("__all__")]):
            return True
        case ast.Call(ast.Name("cast" | "dataclass")):
            return True
    return field in ("annotation", "returns")


def _shown(node: ast.AST) -> str:
    if isinstance(node, ast.If | ast.While):
        return f"{type(node).__name__.lower()} {ast.unparse(node.test)}:"
    return ast.unparse(node)


@cache
def mutants_at_each_place(module: str) -> list[list[Mutant]]:
    """Return the mutants of a module, a list for each place."""
    places = []
    for k, (_, node, statement, inside) in enumerate(places_of(_parsed(module))):
        begin = node if hasattr(node, "lineno") else statement
        end = getattr(node, "test", begin)
        mutants = [
            Mutant(module, k, n, begin.lineno, end.end_lineno, inside, _shown(node), _shown(change))
            for n, change in enumerate(changes_of(node))
        ]
        if mutants:
            places.append(mutants)
    return places


def _parsed(module: str) -> ast.Module:
    return ast.parse((ROOT / module).read_text(encoding="utf-8"))


def mutated(mutant: Mutant) -> ast.Module:
    """Return the module with the change made."""
    tree = _parsed(mutant.module)
    (parent, field, k), node, _, _ = list(places_of(tree))[mutant.node]
    change = ast.copy_location(list(changes_of(node))[mutant.change], node)
    if k is None:
        setattr(parent, field, change)
    else:
        getattr(parent, field)[k] = change
    return ast.fix_missing_locations(tree)


def sample_of(modules: Sequence[str], mutants: int, seed: int) -> list[Mutant]:
    """Draw places of the modules, and one change of each."""
    rng = random.Random(seed)  # noqa: S311 - a sample
    places = [place for module in modules for place in mutants_at_each_place(module)]
    return [rng.choice(place) for place in rng.sample(places, min(mutants, len(places)))]


# --- tests


@dataclass(frozen=True)
class Traced:
    """What a test runs on the code as it is, and its seconds of processor."""

    test: str
    seconds: float
    lines: dict[str, set[int]]


class _Tracing:
    """A plugin of pytest that follows which lines each test runs."""

    def __init__(self) -> None:
        self.traced: list[tuple[str, float]] = []
        self.failed: set[str] = set()
        from coverage import Coverage  # noqa: PLC0415 - a benchmark beside this file has its name

        self.coverage = Coverage(data_file=None, config_file=False, include=[f"{PACKAGE}/*"])

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        self.coverage.switch_context(item.nodeid)
        begin = time.process_time()
        outcome = yield
        self.traced.append((item.nodeid, time.process_time() - begin))
        return outcome

    @pytest.hookimpl(wrapper=True)
    def pytest_runtestloop(self) -> Iterator[None]:
        self.coverage.start()
        outcome = yield
        self.coverage.stop()
        return outcome

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self.failed.add(report.nodeid)

    def result(self) -> list[dict[str, object]]:
        """Return for each test that passed its name, seconds and lines of modules."""
        data = self.coverage.get_data()
        lines: dict[str, dict[str, list[int]]] = {}
        for path in data.measured_files():
            module = str(Path(path).relative_to(ROOT))
            for line, tests in data.contexts_by_lineno(path).items():
                for test in tests:
                    lines.setdefault(test, {}).setdefault(module, []).append(line)
        return [
            {"test": test, "seconds": seconds, "lines": lines.get(test, {})}
            for test, seconds in self.traced
            if test not in self.failed
        ]


class _Chosen:
    """A plugin of pytest that runs the tests of a list in its order."""

    def __init__(self, tests: Sequence[str]) -> None:
        self.order = {test: k for k, test in enumerate(tests)}

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        kept = [item for item in items if item.nodeid in self.order]
        items[:] = sorted(kept, key=lambda item: self.order[item.nodeid])


def tests_traced(files: Sequence[Path], jobs: int) -> list[Traced]:
    """Return the tests of the files that pass on the code as it is."""
    with _pool(jobs) as pool:
        found = [entry for entries in pool.map(_traced, files) for entry in entries]
    return [
        Traced(entry["test"], entry["seconds"], {m: set(ls) for m, ls in entry["lines"].items()})
        for entry in found
    ]


def _traced(file: Path) -> list[dict[str, object]]:
    """Return what the tests of a file run, from the last time if nothing has changed since."""
    whole = hashlib.sha256(file.read_bytes())
    for path in sorted(PACKAGE.rglob("*.py")):
        whole.update(path.read_bytes())
    kept = KEPT_MAPS / f"{file.stem}-{whole.hexdigest()[:20]}.json"
    if not kept.exists():
        KEPT_MAPS.mkdir(exist_ok=True)
        _in_a_process(partial(_trace, file, kept), 1200)
    if not kept.exists():
        sys.exit(f"{file}: its tests did not come to an end; run them alone")
    return json.loads(kept.read_text())


def _trace(file: Path, kept: Path) -> int:
    tracing = _Tracing()
    code = pytest.main([*QUIETLY, str(file)], plugins=[tracing])
    kept.write_text(json.dumps(tracing.result()))
    return int(code)


def rounds_for(mutant: Mutant, tests: Sequence[Traced], seconds: float) -> list[list[str]]:
    """Return the tests that run a mutant's line: those of its room's folder, then all others.

    The quickest stand first, and each round has as many as the time allows. What is run at import
    is of all tests of its room, and of those that run anything of its module.
    """
    line = range(mutant.line, mutant.end + 1)
    rounds: tuple[list[Traced], list[Traced]] = [], []
    for test in sorted(tests, key=lambda test: test.seconds):
        lines = test.lines.get(mutant.module, set())
        own = test.test.startswith(f"tests/{_room(mutant)}/")
        known = own or lines or Path(test.test.partition("::")[0]).name in EVERYWHERE
        if not lines.isdisjoint(line) if mutant.in_function else known:
            rounds[not own].append(test)
    return [_in_time(tests, seconds) for tests in rounds]


def _in_time(tests: Sequence[Traced], seconds: float) -> list[str]:
    """Return as many tests as the time allows, that of opening their files among it."""
    chosen: list[str] = []
    files: set[str] = set()
    for test in tests:
        file = test.test.partition("::")[0]
        seconds -= test.seconds + (file not in files) * _OPENING
        if seconds < 0 and chosen:
            break
        files.add(file)
        chosen.append(test.test)
    return chosen


# --- trial


class _Changed(importlib.machinery.SourceFileLoader):
    """Loads one module changed; it stands before the finder of all others."""

    mutant: Mutant

    @classmethod
    def find_spec(cls, name: str, *_: object) -> importlib.machinery.ModuleSpec | None:
        """Return the changed module's place, and leave every other to others."""
        folder = name.replace(".", "/")
        if cls.mutant.module not in (f"{folder}.py", f"{folder}/__init__.py"):
            return None
        file = str(ROOT / cls.mutant.module)
        return importlib.util.spec_from_file_location(name, file, loader=cls(name, file))

    def get_code(self, _: str) -> CodeType:
        """Return the changed code, which no file holds."""
        return compile(mutated(self.mutant), self.path, "exec")


def survives(mutant: Mutant, rounds: Sequence[Sequence[str]], seconds: float) -> bool:
    """Return whether the tests pass with the mutant in the place of its module."""
    for tests in rounds:
        if tests and _in_a_process(partial(_run, mutant, tests), int(4 * seconds + 20)):
            return False
    unseen = "" if any(rounds) else " (no test runs it)"
    print(f"survives{unseen}: {mutant}", flush=True)
    return True


def _run(mutant: Mutant, tests: Sequence[str]) -> int:
    _Changed.mutant = mutant
    sys.meta_path.insert(0, _Changed)
    files = dict.fromkeys(test.partition("::")[0] for test in tests)
    return int(pytest.main([*QUIETLY, "-x", *files], plugins=[_Chosen(tests)]))


def _in_a_process(work: Callable[[], int], seconds: int) -> int:
    """Return the status of work done in a process that may take so many seconds of processor."""
    child = os.fork()
    if child:
        return os.waitpid(child, 0)[1]
    status = 1
    try:
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
        silent = os.open(os.devnull, os.O_RDWR)
        for stream in (0, 1, 2):
            os.dup2(silent, stream)
        status = work()
    finally:
        os._exit(status)


def _pool(jobs: int) -> ProcessPoolExecutor:
    return ProcessPoolExecutor(jobs, multiprocessing.get_context("fork"))


def _warm() -> None:
    """Import the libraries that tests want, and nothing of ours."""
    os.chdir(ROOT)
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    os.environ["PYTEST_ADDOPTS"] = ""
    sys.path[0] = str(ROOT)
    for name in LIBRARIES:
        importlib.import_module(name)
    sys.pycache_prefix = str(KEPT_MAPS / "bytecode")  # for all mutants, not beside the code
    sys.dont_write_bytecode = False
    settings.register_profile("mutants", deadline=None, database=None, max_examples=25,
                              phases=(Phase.explicit, Phase.generate))  # fmt: skip


def test_files(of: str) -> list[Path]:
    """Return the files of tests that name a package (all, for the whole), and the goldens."""
    dotted = r"\W+(import\W+)?".join(of.removesuffix(".py").split("/"))
    named = re.compile(rf"scara_iso\W+(import\W.*\b)?{dotted}\b" if of else "")
    return [
        file
        for file in sorted(TESTS.rglob("test_*.py"))
        if file.name in EVERYWHERE or named.search(file.read_text(encoding="utf-8"))
    ]


def main() -> None:
    """Draw the mutants, run the tests on each, print score and survivors."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--of", default="", help="package or module: iso9283, tables/numbers.py")
    options.add_argument("--mutants", type=int, default=400)
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--jobs", type=int, default=1)
    options.add_argument("--seconds", type=float, default=30, help="of tests for each mutant")
    options.add_argument("--tests", nargs="*", type=Path, help="instead of those that name it")
    asked = options.parse_args()
    _warm()
    folder = PACKAGE / asked.of
    files = [folder] if folder.is_file() else sorted(folder.rglob("*.py"))
    sample = sample_of([str(f.relative_to(ROOT)) for f in files], asked.mutants, asked.seed)
    chosen = [file.resolve() for file in asked.tests or test_files(asked.of)]
    tests = tests_traced(chosen, asked.jobs)
    print(f"{len(sample)} mutants, seed {asked.seed}; {len(tests)} tests of {len(chosen)} files")
    with _pool(asked.jobs) as pool:
        rounds = [rounds_for(mutant, tests, asked.seconds) for mutant in sample]
        outcomes = list(pool.map(survives, sample, rounds, [asked.seconds] * len(sample)))
    _print_scores(sample, outcomes)


def _print_scores(sample: list[Mutant], outcomes: list[bool]) -> None:
    tried = Counter(_room(mutant) for mutant in sample)
    alive = Counter(_room(m) for m, survived in zip(sample, outcomes, strict=True) if survived)
    print("\n| package | mutants | noticed | % |\n|---|---|---|---|")
    for room, count in [*sorted(tried.items()), ("together", len(sample))]:
        noticed = count - (alive[room] if room in tried else alive.total())
        print(f"| {room} | {count} | {noticed} | {100 * noticed / count:.0f} |")


def _room(mutant: Mutant) -> str:
    return mutant.module.split("/")[1].removesuffix(".py")


if __name__ == "__main__":
    main()
