"""docs/nomenclature.md names what the code has; a figure is on it or on the page of the fields."""

import re
from dataclasses import fields
from importlib import import_module
from pathlib import Path

import pytest

from scara_iso.iso9283.figures import AxisResult, RadialResult
from scara_iso.iso9283.results import Cycles
from scara_iso.robot.two_inertia import Backlash, Crossing

DOCS = Path(__file__).parents[1] / "docs"
NAMES = re.findall(r"`(\w+(?:\.\w+)+)`", (DOCS / "nomenclature.md").read_text(encoding="utf-8"))
FIELDS = (DOCS / "reference" / "fields.md").read_text(encoding="utf-8")
SHOWN_AS = {AxisResult: "PublishedAxis", RadialResult: "SpaceFigures"}


@pytest.mark.parametrize("name", NAMES)
def test_every_name_on_the_page_is_in_the_code(name):
    module, *attributes = name.split(".")
    found = import_module(f"scara_iso.{module}")
    for attribute in attributes:
        assert hasattr(found, attribute) or attribute in getattr(found, "__dataclass_fields__", {})
        found = getattr(found, attribute, None)


@pytest.mark.parametrize("result", [AxisResult, RadialResult, Cycles, Backlash, Crossing])
def test_every_figure_of_a_result_is_on_the_page_or_among_the_fields(result):
    module = result.__module__.split(".")[1]
    on_page = {name.rpartition(".")[2] for name in NAMES if f"{module}.{result.__name__}." in name}
    _, _, below = FIELDS.partition(f"### {SHOWN_AS.get(result)}\n")
    published = set(re.findall(r"^\| `(\w+)`", below.partition("###")[0], re.MULTILINE))
    assert {field.name for field in fields(result)} <= on_page | published
