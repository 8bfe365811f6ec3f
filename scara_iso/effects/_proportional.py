"""Effects through a recorded column: the readings follow it."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from scara_iso.effects._conditions import Conditions, is_open
from scara_iso.effects._effect import Direction, KnownCourse, as_column
from scara_iso.effects._parameter import Grid, Parameter
from scara_iso.run import FloatArray


def centred(values: FloatArray) -> FloatArray:
    """Return recorded values less their mean, so that the pose stays that of the whole test."""
    return np.asarray(values - values.mean())


def proportional(  # noqa: PLR0913 - what the contract asks of an effect
    *,
    name: str,
    of: str,
    size: Parameter,
    cause: str,
    confirm_by: str,
    recorded: str = "",
    by: Callable[[FloatArray], FloatArray] = centred,
    direction: Direction = Direction.FREE,
    by_flank: bool = False,
    weight: float = 1.0,
) -> KnownCourse:
    """Return the effect of a column: the readings move by ``size`` times ``by`` of its values.

    ``of`` names the column; a pattern such as ``temperature*`` leaves it to the parameter
    ``column``, whose symbol and meaning ``recorded`` gives as ``T: the recorded temperature``.
    """
    symbol, _, meaning = recorded.partition(": ")
    which = Parameter(
        "column", symbol, "", meaning, text=True, grid=lambda conditions: Grid(conditions.named(of))
    )
    return KnownCourse(
        name=name,
        parameters=(which, size) if is_open(of) else (size,),
        needs=(of,),
        cause=cause,
        confirm_by=confirm_by,
        direction=direction,
        by_flank=by_flank,
        weight=weight,
        columns=partial(_followed, by) if is_open(of) else partial(_followed, by, column=of),
    )


def _followed(
    by: Callable[[FloatArray], FloatArray], conditions: Conditions, *, column: str
) -> FloatArray:
    return as_column(by(conditions.covariates[column]))
