"""What the shape of a table tells, in whatever language its headings are."""

import re

import numpy as np
import pytest

from scara_iso.base.errors import DataError
from scara_iso.run.pose_columns import pose_column
from scara_iso.tables import read_table

RNG = np.random.default_rng(9283)
X, Y = (np.round(at + 0.005 * RNG.standard_normal(31), 3) for at in (0.812, 0.353))


def rows(*columns, delimiter=","):
    return "".join(delimiter.join(map(str, row)) + "\n" for row in zip(*columns, strict=True))


def table(head, *columns, above=""):
    return f"{above}{head}\n{rows(*columns)}".encode()


def refused(data, **options):
    with pytest.raises(DataError) as error:
        read_table(data, **options)
    return error.value


@pytest.mark.parametrize(
    "heading", ["P{}{}", "P{}/{}", "{1}@P{0}", "{1}P{0}", "位置{} {}", "姿勢{}{}", "{1} (P{0})"]
)
def test_a_pose_and_an_axis_need_nothing_between_them(heading):
    names = [f"{heading.format(pose, axis)} [mm]" for pose in (1, 2) for axis in "XY"]
    run = read_table(table(",".join(["cycle", *names]), range(1, 32), X, Y, Y, X))
    assert [str(label) for label, _ in run.rows_by_pose()] == ["P1", "P2"]
    assert run.axes["X"].readings.tolist() == [*X, *Y]
    assert run.axes["Y"].readings.tolist() == [*Y, *X]


def test_a_unit_behind_the_pose_is_that_of_its_axis():
    run = read_table(table("cycle,X_P1_um,X_P2_um", range(1, 32), 1000 * X, 1000 * Y))
    assert run.axes["X"].readings == pytest.approx([*X, *Y], abs=1e-12)


def test_axes_with_numbers_of_no_pose_are_runs_side_by_side():
    error = refused(table("cycle,1X [mm],1Y [mm],2X [mm],2Y [mm]", range(1, 32), X, Y, Y, X))
    assert "head them P1_X" in error.remedy


def test_columns_of_a_frame_that_name_a_pose_each_are_refused():
    for name in ("P2X", "X@P2", "XP2"):
        with pytest.raises(DataError):
            pose_column(["cycle", name])


def test_advice_names_no_axis_that_the_heading_does_not():
    data = table("count,Fall X,Fall Y,other", range(1, 32), X, Y, X + Y)
    columns = re.findall("`columns=([^`]+)`", refused(data).remedy)
    assert columns == ["cycle,X,Y,-"]
    assert list(read_table(data, unit="mm", columns=columns[0]).axes) == ["X", "Y"]


def test_a_column_of_another_axis_is_not_read_as_the_stated_one():
    data = table("cycle,P1X [mm],P1Y [mm],P2X [mm]", range(1, 32), X, Y, X + 1)
    error = refused(data, columns="cycle,X,Y,Z")
    assert [(fault.line, fault.column) for fault in error.faults] == [(1, 4)]


LONG = "Zyklus;Achse;Messwert\n" + "".join(
    f"{n};{axis};{value:.3f}\n".replace(".", ",")
    for axis, values in (("X", X), ("Y", Y))
    for n, value in enumerate(values, 1)
)
BOTH = "Nr;X/Y [mm]\n" + "".join(
    f"{n};{x:.3f} / {y:.3f}\n".replace(".", ",")
    for n, (x, y) in enumerate(zip(X, Y, strict=True), 1)
)


@pytest.mark.parametrize("data", [LONG, BOTH])
@pytest.mark.parametrize("columns", ["-,X", "-,X,-", "-,-,X", "cycle,X", "X,-,-", "-,X,-,-"])
def test_stated_columns_part_no_row_at_its_decimal_comma(data, columns):
    refused(data.encode(), unit="mm", columns=columns)


def test_a_row_for_each_axis_and_two_numbers_in_a_cell_are_to_be_columns():
    assert "names the axis of each row" in refused(LONG.encode()).remedy
    assert "names the axis of each row" in refused(LONG.replace(",", ".").encode()).remedy
    assert "'X/Y [mm]' heads two axes" in refused(BOTH.encode()).remedy
    error = refused(LONG.replace("X", "Z").encode(), unit="mm", columns="-,-,Y")
    assert "names the axis of each row" in str(error)
