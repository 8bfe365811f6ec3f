"""A published class says which keys its JSON object has, and no number in it is NaN."""

import json
import math
from copy import copy
from dataclasses import fields, replace
from pathlib import Path

import pytest

from docs.json_schema import schema
from scara_iso import Analysis, analyze, read_table
from scara_iso.base.published import fill, to_json, to_text
from scara_iso.reporting.shared.blocks import Table

EXAMPLES = Path(__file__).parents[1] / "examples"


@pytest.fixture(scope="module")
def analysis():
    return analyze(read_table(EXAMPLES / "fum_scara_table1.csv"))


def objects(found):
    """Yield a published object and those within it, each with its JSON."""
    if isinstance(found, tuple):
        for one in found:
            yield from objects(one)
    elif hasattr(found, "items"):
        yield from objects(tuple(found.values()))
    elif hasattr(found, "__dataclass_fields__"):
        yield found
        yield from objects(tuple(getattr(found, field.name) for field in fields(found)))


def test_a_required_key_is_always_there_and_another_is_never_null(analysis):
    made = schema("analyze", Analysis)["$defs"]
    met = [one for one in objects(analysis) if type(one).__name__ in made]
    assert len({type(one) for one in met}) > 6
    for one in met:
        keys, described = to_json(one), made[type(one).__name__]
        assert set(described["required"]) <= set(keys) <= set(described["properties"])
        assert not [key for key in keys if keys[key] is None and key not in described["required"]]


@pytest.mark.parametrize("wrong", [math.nan, math.inf])
@pytest.mark.parametrize("figure", ["mean", "RP", "uncertainty"])
def test_a_figure_that_is_no_number_is_an_error_and_no_null(analysis, figure, wrong):
    pose = analysis.poses[0]
    axes = {**pose.axes, "X": copy(pose.axes["X"])}
    fill(axes["X"], **{figure: wrong})
    broken = replace(analysis, poses=type(analysis.poses)([replace(pose, axes=axes)]))
    assert json.loads(to_text(to_json(analysis)))
    with pytest.raises(ValueError, match="not JSON compliant"):
        to_text(to_json(broken))


@pytest.mark.parametrize("row", [("X",), ("X", "1", "2")])
def test_a_row_of_another_width_than_the_header_is_refused(row):
    with pytest.raises(ValueError, match="cells for 2 columns"):
        Table(("axis", "RP"), (("Y", "3"), row))


def test_a_table_by_name_has_every_column_of_any_row_and_loses_no_cell():
    table = Table.by_name([{"axis": "X", "mean": "1"}, {"axis": "XY", "RP": "2"}])
    assert table.header == ("axis", "mean", "RP")
    assert table.rows == (("X", "1", ""), ("XY", "", "2"))
