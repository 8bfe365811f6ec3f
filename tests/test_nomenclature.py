"""docs/nomenclature.md names what the code has, and every figure of a result is on it."""

import re
from dataclasses import fields
from importlib import import_module
from pathlib import Path

import pytest

from scara_iso.iso9283.figures import AxisResult, RadialResult
from scara_iso.iso9283.results import Cycles
from scara_iso.robot.two_inertia import Backlash, Crossing

PAGE = Path(__file__).parents[1] / "docs" / "nomenclature.md"
NAMES = re.findall(r"`(\w+(?:\.\w+)+)`", PAGE.read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", NAMES)
def test_every_name_on_the_page_is_in_the_code(name):
    module, *attributes = name.split(".")
    found = import_module(f"scara_iso.{module}")
    for attribute in attributes:
        assert hasattr(found, attribute) or attribute in getattr(found, "__dataclass_fields__", {})
        found = getattr(found, attribute, None)


@pytest.mark.parametrize("result", [AxisResult, RadialResult, Cycles, Backlash, Crossing])
def test_every_figure_of_a_result_is_on_the_page(result):
    module = result.__module__.split(".")[1]
    figures = {f"{module}.{result.__name__}.{field.name}" for field in fields(result)}
    assert figures <= set(NAMES)
