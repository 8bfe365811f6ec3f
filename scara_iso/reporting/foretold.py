"""RP as the completed model foretells it: of the next test, and of cycles that no fit saw."""

from __future__ import annotations

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
    columns = (RP.measured, RP.model_before)
    return Table(
        ("RP of unseen cycles", "measured", "model before", "completed model", "95 % from", "to"),
        tuple(_row(name, told, columns, RP.cycles) for name, told in RP.completed.items()),
        f"of {RP.of}: {RP.cycles} cycles that the completed model has not seen",
    )


def _row(name: str, told: Foretold, beside: tuple[ByAxis, ...], n: int) -> tuple[Cell, ...]:
    figures = (*(column[name] for column in beside), told.value, told.low, told.high)
    return (name, *(of_scatter(figure, n) for figure in figures))


def of_scatter(figure: float, n: int) -> Number:
    """Return a figure of n scattering readings to the digits that it has."""
    return rounded(figure, U_of_scatter(figure, n))
