"""Columns that number the rows, or are computed from the readings, are no conditions."""

import numpy as np
import pytest

from scara_iso import read_table
from scara_iso.base.errors import DataError

READINGS = np.round(np.random.default_rng(3).normal([0.512, 0.834], 0.004, (31, 2)), 3)
COUNT = np.arange(1, 32)


def table(heading, values, head=""):
    rows = "".join(f"{v:g},{x:.3f},{y:.3f}\n" for v, (x, y) in zip(values, READINGS, strict=True))
    return f"{head}# unit: mm\n{heading},X,Y\n{rows}".encode()


@pytest.mark.parametrize("heading", ["Medición", "Prova", "Wdh", "Lp.", "番号"])
@pytest.mark.parametrize("numbers", [COUNT[::-1], COUNT + (COUNT > 14), np.roll(COUNT, 5)])
def test_a_count_that_is_not_in_order_is_asked_about_by_any_name(heading, numbers):
    with pytest.raises(DataError, match="numbers the rows"):
        read_table(table(heading, numbers))
    assert len(read_table(table(heading, COUNT))) == 31
    assert len(read_table(table(heading, numbers, f"# covariates: {heading}\n"))) == 31


@pytest.mark.parametrize(
    ("name", "figure"),
    [
        ("Promedio", READINGS.mean(axis=1)),
        ("total", READINGS.sum(axis=1)),
        ("in_um", 1000 * READINGS.mean(axis=1)),
        ("R", np.ptp(READINGS, axis=1)),
        ("d", READINGS[:, 1] - READINGS[:, 0]),
        ("dist", np.hypot(*READINGS.T)),
        ("off", np.hypot(*(READINGS - READINGS.mean(axis=0)).T)),
        ("sd", READINGS.std(axis=1, ddof=1)),
    ],
)
def test_a_figure_of_the_readings_is_no_condition(name, figure):
    with pytest.raises(DataError, match="of the readings beside it"):
        read_table(table(name, np.round(figure, 5)))


def test_a_condition_that_moves_the_readings_is_one():
    warm = 20 + 3 * COUNT / 31 + np.random.default_rng(1).normal(0, 0.02, 31)
    run = read_table(table("oil", np.round(warm, 2)))
    assert "oil" in run.covariates
