"""What ``simulate`` publishes of a run: schema ``scara-iso/simulate/1``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, cast

from scara_iso.base.published import Count, Size, Unit, publish
from scara_iso.iso9283 import AxisName
from scara_iso.run import FloatArray, Run


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class SimulatedAxis:
    """The readings of one axis."""

    unit: Unit
    """Of readings and resolution."""
    resolution: Size | None
    """Smallest step of the dial; null where the model states none."""
    readings: FloatArray
    """One for each row."""


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class PublishedRun:
    """``simulate`` of a model."""

    schema: Literal["scara-iso/simulate/1"]
    """Name and number of this schema."""
    unit: Literal["mm"]
    """Of every length."""
    seed: Count
    """Of everything drawn."""
    metadata: Mapping[str, str]
    """What the table states."""
    cycle: tuple[int, ...]
    """Of each row."""
    axes: Mapping[AxisName, SimulatedAxis]
    """By name."""
    covariates: Mapping[str, FloatArray]
    """Other columns, by name."""


def published_run(run: Run, *, seed: int) -> PublishedRun:
    """Return what ``simulate`` says."""
    return PublishedRun(
        schema="scara-iso/simulate/1",
        unit="mm",
        seed=seed,
        metadata=run.metadata,
        cycle=tuple(run.cycle.tolist()),
        axes={cast(AxisName, n): publish(SimulatedAxis, axis) for n, axis in run.axes.items()},
        covariates=run.covariates,
    )
