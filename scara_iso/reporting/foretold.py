"""RP as the completed model foretells it: of the next test, and of cycles that no fit saw."""

from __future__ import annotations

from collections.abc import Mapping

from scara_iso.diagnosis import ByAxis, Foretold, Repeatabilities, UnseenRP
from scara_iso.reporting.blocks import Cell, Number, Table
from scara_iso.reporting.digits import U_of_scatter, rounded


def next_test(RP: Repeatabilities, n: int) -> Table:
    """Return what the completed model foretells of the next test beside what was measured."""
    return Table(
        ("RP of the next test", "measured", "completed model", "95 % from", "to"),
        tuple(_row(name, told, (RP.measured,), n) for name, told in RP.completed.items()),
        "completed model: effects, scatter and the dial's rounding; the interval holds the RP of a "
        "new test of 30 cycles, its own sampling included",
    )


def unseen_cycles(RP: UnseenRP) -> Table:
    """Return RP of cycles that no fit saw beside what the model said of it before and after."""
    columns = {"measured": RP.measured, **before_model(RP)}
    beside = tuple(columns.values())
    return Table(
        ("RP of unseen cycles", *columns, "completed model", "95 % from", "to"),
        tuple(_row(name, told, beside, RP.cycles) for name, told in RP.completed.items()),
        f"of {RP.of}: {RP.cycles} cycles that the completed model has not seen",
    )


def before_model(RP: Repeatabilities | UnseenRP) -> Mapping[str, ByAxis]:
    """Return the column of the model before; without a model, which foretells no scatter, none."""
    return {"model before": RP.model_before} if any(RP.model_before.values()) else {}


def _row(name: str, told: Foretold, beside: tuple[ByAxis, ...], n: int) -> tuple[Cell, ...]:
    figures = (*(column[name] for column in beside), told.value, told.low, told.high)
    return (name, *(of_scatter(figure, n) for figure in figures))


def of_scatter(figure: float, n: int) -> Number:
    """Return a figure of n scattering readings to the digits that it has."""
    return rounded(figure, U_of_scatter(figure, n))
