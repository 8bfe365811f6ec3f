"""Each package shows one face: other packages import from it and from nothing behind it."""

import ast
import os
import re
import subprocess
import sys
from functools import cache
from importlib import import_module

import pytest
from source import PACKAGE as ROOT, PATHS, nodes_of, tree_of

import scara_iso

GROUND = "base"
"""Its modules are words that every room uses: it needs no face."""
FACES = sorted({path.parent.name for path in ROOT.glob("*/__init__.py")} - {GROUND})
PUBLIC = {name for name in dir(scara_iso) if name.islower()}
BEHIND = {
    (
        "diagnosis.engine.hypotheses",
        "effects.outlier",
    ),  # odd readings are one effect, whichever cycles
    ("reporting.explain", "iso9283.checks"),  # reads the docstrings of the folder
    ("reporting.explain", "iso9283.characteristics"),
}


def module_of(path):
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imported(path):
    """Yield each of our modules that a file imports, below scara_iso."""
    for node in nodes_of(path):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module
            yield from (f"{node.module}.{name.name}" for name in node.names)


@cache
def is_module(name):
    place = ROOT.joinpath(*name.split("."))
    return place.is_dir() or place.with_suffix(".py").exists()


def behind_faces(path):
    """Yield the inner modules of other packages that a file imports."""
    own = module_of(path).split(".")[0] or "commands"  # whose functions are the whole's face
    ours = (name.removeprefix("scara_iso.") for name in imported(path) if "scara_iso." in name)
    for name in ours:
        if "." in name and is_module(name) and name.split(".")[0] not in (own, GROUND):
            yield name


def names_of(face):
    """Return what the page of a face says it shows, its stub where it has one."""
    page = ROOT / face / "__init__.pyi"
    return [
        alias.asname or alias.name
        for node in tree_of(page if page.exists() else page.with_suffix(".py")).body
        if isinstance(node, ast.ImportFrom)
        and (node.level or (node.module or "").startswith(f"scara_iso.{face}."))
        for alias in node.names
    ]


def test_no_module_looks_behind_the_face_of_another_package():
    found = {(module_of(path), name) for path in PATHS for name in behind_faces(path)}
    assert found == BEHIND


@pytest.mark.parametrize("face", FACES)
def test_a_face_has_the_names_it_shows(face):
    package = import_module(f"scara_iso.{face}")
    for name in names_of(face):
        found = getattr(package, name)
        assert type(found) is not type(ast), f"{name} is a module"


@pytest.mark.parametrize("face", FACES)
def test_a_face_shows_nothing_else(face):
    with pytest.raises(AttributeError, match="nothing_of_the_kind"):
        _ = import_module(f"scara_iso.{face}").nothing_of_the_kind


EAGER = {**os.environ, "EAGER_IMPORT": "1"}
"""By which lazy_loader imports every name at once."""


@pytest.mark.parametrize(
    "words", [["-c", "import scara_iso; scara_iso.analyze"], ["-m", "scara_iso", "--version"]]
)
def test_all_names_can_be_imported_at_once(words):
    done = subprocess.run([sys.executable, *words], check=False, capture_output=True, env=EAGER)
    assert (done.returncode, done.stderr) == (0, b"")


def test_no_package_has_the_name_of_a_public_function():
    assert not PUBLIC & {path.name for path in ROOT.iterdir()}
    assert not PUBLIC & {path.stem for path in ROOT.glob("*.py")}


HOOKS = {"check", "check_shape", "compose", "compute", "parse", "render"}
"""What every plugin of a kind defines under the same name."""


def public_definitions(path):
    """Yield the public classes and functions at the top of a file."""
    for node in tree_of(path).body:
        if isinstance(node, ast.ClassDef | ast.FunctionDef) and not node.name.startswith("_"):
            yield node.name


def test_a_name_stands_for_one_thing():
    places = {}
    for path in PATHS:
        for name in public_definitions(path):
            if path.parent.name == "commands" and name in PUBLIC:  # as the user calls it
                continue
            places.setdefault(name, []).append(module_of(path))
    twice = {name: where for name, where in places.items() if len(where) > 1}
    assert {name: where for name, where in twice.items() if name not in HOOKS} == {}


OPTION = re.compile(r"(?<![\w-])--[A-Za-z]")
SCREEN = {"render.terminal"}
"""Shows what the command line has no room for, and how to see it."""


def strings(path):
    for node in nodes_of(path):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value


def test_only_the_command_line_names_its_options():
    naming = {
        module_of(path)
        for path in PATHS
        if "commands" not in path.relative_to(ROOT).parts and any(map(OPTION.search, strings(path)))
    }
    assert naming == SCREEN


PAGE = ROOT.parent / "docs" / "architecture.md"
MODULES = {module_of(path) for path in PATHS}
OTHER = {"__init__", "__init__.pyi", "--rebuild"}
"""What the page names that is no module, folder, file or name of a face."""


@cache
def defined():
    return {module_of(path): {*public_definitions(path)} for path in PATHS}


def stands(span):
    """Say whether a name of the page is there: a module, a file, or a definition in its room."""
    name = span.removeprefix("scara_iso.").replace("/", ".")
    room, _, last = name.rpartition(".")
    return (
        any(f".{module}".endswith(f".{name}") for module in MODULES)
        or any(where.startswith(room) and last in names for where, names in defined().items())
        or (ROOT.parent / span).exists()
    )


def test_the_way_in_names_what_is_there_and_every_room():
    text = PAGE.read_text(encoding="utf-8")
    spans = {span for span in re.findall(r"`([^`]+)`", text) if " " not in span}
    assert {span for span in spans - OTHER if not stands(span)} == set()
    rooms = {path.stem for path in ROOT.iterdir() if not path.name.startswith("_")} - {"py"}
    assert {room for room in rooms if f"`{room}`" not in text} == set()


LONGEST_MODULE, LONGEST_FUNCTION = 500, 40


def functions_of(path):
    """Yield each function, and the lines of its body below the docstring."""
    for node in nodes_of(path):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            first = node.body[min(len(node.body) - 1, ast.get_docstring(node) is not None)]
            yield node.name, node.body[-1].end_lineno - first.lineno + 1


def test_no_module_is_longer_than_its_limit():
    lines = {module_of(path): len(path.read_text("utf-8").splitlines()) for path in PATHS}
    assert {name: count for name, count in lines.items() if count > LONGEST_MODULE} == {}


def test_no_function_is_longer_than_its_limit():
    long = [
        (module_of(path), name, lines)
        for path in PATHS
        for name, lines in functions_of(path)
        if lines > LONGEST_FUNCTION
    ]
    assert long == []
