"""docs/reference/ is what docs/generate.py makes of the code."""

import runpy
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[1] / "docs"
GENERATE = runpy.run_path(str(DOCS / "generate.py"))
PAGES = sorted(path.name for path in (DOCS / "reference").iterdir())


@pytest.fixture(scope="module")
def made():
    return GENERATE["reference"]()


@pytest.mark.parametrize("name", PAGES)
def test_a_page_is_up_to_date(name, made):
    text = (DOCS / "reference" / name).read_text(encoding="utf-8")
    assert text == made[name], "run: python docs/generate.py"


@pytest.mark.parametrize(("name", "made"), GENERATE["schemas"]().items())
def test_a_schema_is_up_to_date(name, made):
    text = (DOCS / "schemas" / name).read_text(encoding="utf-8")
    assert text == made, "run: python docs/generate.py"


def test_there_is_no_other_page(made):
    assert PAGES == sorted(made)


def test_the_picture_is_up_to_date():
    drawn = (DOCS / "figures" / "layers.svg").read_text(encoding="utf-8")
    assert drawn == GENERATE["picture"](), "run: python docs/generate.py"


def test_every_package_has_a_layer():
    package = DOCS.parent / "scara_iso"
    there = {path.stem for path in package.iterdir() if (path / "__init__.py").exists()}
    there |= {path.stem for path in package.glob("[!_]*.py")}
    assert {name for layer in GENERATE["layers"]() for name in layer} == there
