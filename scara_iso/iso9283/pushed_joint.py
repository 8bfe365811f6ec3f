"""A push test: lost motion, friction width, stiffness and compliance, each with its interval."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias, cast

import numpy as np

from scara_iso.base.displayed import Displayed
from scara_iso.base.errors import UsageError
from scara_iso.base.published import INTERNAL, Count, Interval, Size, fill, publish, row_of
from scara_iso.base.quantities import Estimate, rounding_uncertainty
from scara_iso.iso9283.core.figures import (
    EVERY_LENGTH,
    Conformity,
    DecisionRule,
    Limit,
    Millimetres,
)
from scara_iso.iso9283.core.limits import check_limits
from scara_iso.iso9283.core.results import Characteristic, LimitCheck, gravest
from scara_iso.iso9283.core.statistics import even_estimate
from scara_iso.run import frame_of
from scara_iso.signals import ForceLoop, LoopFit, fit_loop

if TYPE_CHECKING:
    import pandas as pd

COMPLIANCE = "10"
"""Clause of the static compliance."""
_NO_CLAUSE = "push test"
_SHORTEST_ARM_M, _LONGEST_ARM_M = 0.001, 10.0
"""No SCARA reaches as far: an arm that does was stated in mm."""
_DITHERED = 0.5
"""Residual over division from which rounding averages out; benchmarks/push.py."""
_PER = 100.0
"""Newtons to which a compliance is referred: mm/100 N."""


PushUnit: TypeAlias = Literal["mm", "mm/100 N", "N", "arcmin", "N m", "N m/arcmin"]
ForceEnds: TypeAlias = Annotated[Interval, ("unit", "N")]


@dataclass(frozen=True, slots=True, kw_only=True)
class PushFigure:
    """A figure of the loop."""

    value: Size
    """In `unit`."""
    unit: PushUnit
    """Of value, u and interval."""
    u: Size
    """Standard uncertainty."""
    interval: Interval | None
    """95 %; null for a stiffness whose compliance may be none."""


PushCode: TypeAlias = Literal[
    "lost_motion",
    "friction_width",
    "hysteresis",
    "deflection",
    "friction_torque",
    "stiffness",
    "compliance",
    "friction_force",
]
"""`scara-iso explain` explains each."""
Figures: TypeAlias = Mapping[PushCode, PushFigure]


@dataclass(frozen=True, slots=True)
class PushReadings:
    """How many readings the loop has."""

    read: Count
    """Readings in the table."""
    run_in: Count
    """Before the first end of the loop, not counted."""
    used: Count
    """Readings that count."""


def _figures(characteristics: Sequence[Characteristic], of: str) -> Figures:
    return {
        cast("PushCode", one.code): publish(PushFigure, one.estimate)
        for one in characteristics
        if one.of == of
    }


@dataclass(frozen=True, eq=False, kw_only=True)
class PushResult(Displayed):
    """``push`` of a force loop."""

    schema: Literal["scara-iso/push/1"] = "scara-iso/push/1"
    """Name and number of this schema."""
    unit: Literal["mm"] = "mm"
    """Of every length."""
    loop: ForceLoop = field(metadata=INTERNAL)
    """Force [N] and reading [mm], as they were read."""
    fit: LoopFit = field(metadata=INTERNAL)
    """The loop's two branches and what is left beside them."""
    source: str = field(init=False)
    """The file."""
    notes: tuple[str, ...] = field(init=False)
    """How it was read."""
    arm_m: Annotated[float, ("unit", "m"), ("exclusiveMinimum", 0)] | None
    """From the joint to the dial and to the force; null where not stated."""
    loops: Count = field(init=False)
    """Number of loops."""
    readings: PushReadings = field(init=False)
    """For all loops."""
    force_N: ForceEnds = field(init=False)  # noqa: N815 - newton
    """Lowest and highest."""
    residual_mm: Millimetres = field(init=False)
    """Standard deviation of what is left beside the model."""
    misfit_mm: Millimetres | None = field(init=False)
    """What all loops repeat and the model does not, rms; null where that is chance."""
    joint: Figures | None = field(init=False)
    """Null without an arm."""
    reading: Figures = field(init=False)
    """Of the dial, by the same codes."""
    characteristics: tuple[Characteristic, ...]
    """Every figure of the test."""
    limits: tuple[LimitCheck, ...] = field(init=False)
    """One for each figure that was held against a limit."""
    conformity: Conformity | None = field(init=False)
    """Of all limits together, the gravest; null where none was given."""

    def __post_init__(self) -> None:
        fit, figures = self.fit, self.characteristics
        limits = tuple(one.limit for one in figures if one.limit is not None)
        fill(
            self,
            source=self.loop.source,
            notes=self.loop.notes,
            loops=fit.loops,
            readings=PushReadings(len(self.loop.force), fit.run_in, fit.readings),
            force_N=fit.ends,
            residual_mm=fit.residual,
            misfit_mm=fit.misfit,
            joint=None if self.arm_m is None else _figures(figures, "joint"),
            reading=_figures(figures, "reading"),
            limits=limits,
            conformity=gravest(one.verdict for one in limits),
        )

    def __repr__(self) -> str:
        of_it = self.loop.source or "a force loop"
        return f"<PushResult of {of_it}: {self.fit.loops} loops, {self.fit.readings} readings>"

    def to_frame(self) -> pd.DataFrame:
        """Return the figures as a pandas table: code, of, and what `Estimate` publishes."""
        rows = [
            {"code": one.code, "of": one.of, **row_of(one.estimate)} for one in self.characteristics
        ]
        return frame_of(rows, {})

    def estimate(self, code: str, of: str) -> Estimate:
        """Return a figure, such as ``("lost_motion", "joint")``; raises `KeyError`."""
        return {(one.code, one.of): one.estimate for one in self.characteristics}[code, of]


def push_test(
    loop: ForceLoop,
    *,
    arm_m: float | None = None,
    limits: Mapping[str, Limit] | None = None,
    decision: DecisionRule = DecisionRule.INTERVAL,
) -> PushResult:
    """Return what a force loop says of a joint; ``arm_m`` from the joint to dial and force [m].

    ``limits`` by code, in arcmin of the joint, with ``_mm`` behind in mm of the reading; the empty
    name is the lost motion of the joint. A pair is the smallest and the largest. Raises
    `UsageError` for values that make no sense, `DataError` as `fit_loop`.
    """
    if arm_m is not None and not _SHORTEST_ARM_M <= arm_m <= _LONGEST_ARM_M:
        raise UsageError(
            f"`arm={arm_m:g}`: not the length of an arm in metres",
            remedy=f"state it in m, from {_SHORTEST_ARM_M:g} to {_LONGEST_ARM_M:g}: "
            "250 mm are `arm=0.25`",
        )
    fit = fit_loop(loop)
    found = _of_reading(loop, fit)
    found += [] if arm_m is None else list(_of_joint(found, arm_m))
    found = [replace(one, counted="readings") for one in found]
    held = check_limits(found, limits or {}, decision=decision)
    return PushResult(loop=loop, fit=fit, arm_m=arm_m, characteristics=held)


def compliance_estimate(loop: ForceLoop, fit: LoopFit) -> Estimate:
    """Return the displacement per force [mm/100 N]."""
    apart = _between_readings(loop, fit)
    known = None if apart is None else apart / float(np.ptp(fit.ends))  # at the ends of the loop
    found = _estimate(fit, (1.0, 0.0, 0.0), fit.compliance, known, COMPLIANCE)
    return found.scaled(_PER, f"mm/{_PER:g} N")


def _between_readings(loop: ForceLoop, fit: LoopFit) -> float | None:
    """Return what the dial adds to the difference of two mean readings, as standard uncertainty.

    Rounding counts in full unless the readings scatter over divisions: where the steps of the
    force are whole divisions, all readings of a flank are rounded alike (GUM F.2.2.1, 5.1.2).
    """
    rounded = loop.resolution is not None and fit.residual < _DITHERED * loop.resolution
    parts = [rounding_uncertainty(loop.resolution)] if rounded and loop.resolution else []
    parts += [] if loop.uncertainty is None else [loop.uncertainty]
    return math.sqrt(2) * math.hypot(*parts) if parts else None


def _of_reading(loop: ForceLoop, fit: LoopFit) -> list[Characteristic]:
    c, b, friction = fit.compliance, fit.half_play, fit.friction
    apart, calibration = _between_readings(loop, fit), loop.uncertainty
    slopes = {
        "lost_motion": ((0.0, 2.0, 0.0), 2 * b),
        "friction_width": ((2 * friction, 0.0, 2 * c), 2 * c * friction),
        "hysteresis": ((2 * friction, 2.0, 2 * c), 2 * (b + c * friction)),
    }
    found = []
    for code, (slope, value) in slopes.items():
        one = _estimate(fit, slope, value, apart)
        names = (f"{code}_mm",)
        found.append(Characteristic(code, None, "reading", one, names, calibration=calibration))
    deflection = _estimate(fit, (0.0, 0.0, 0.0), fit.deflection, apart, ends=True)
    stiff = compliance_estimate(loop, fit)
    shift = None if apart is None else apart / (2 * c)  # of a flank, as a force
    force = _estimate(fit, (0.0, 0.0, 1.0), friction, shift, unit="N")
    return [
        *found,
        Characteristic("deflection", None, "reading", deflection, ("deflection_mm",)),
        Characteristic("compliance", None, "reading", stiff, ("compliance",)),
        Characteristic("friction_force", None, "reading", force),
    ]


def _of_joint(found: Sequence[Characteristic], arm_m: float) -> Iterator[Characteristic]:
    """Yield the figures of the joint; the arm is taken as known."""
    per_mm = math.degrees(1 / (1000 * arm_m)) * 60
    by_code = {one.code: one.estimate for one in found}
    for code in ("lost_motion", "friction_width", "hysteresis", "deflection"):
        names = (code, EVERY_LENGTH) if code == "lost_motion" else (code,)
        yield Characteristic(code, None, "joint", by_code[code].scaled(per_mm, "arcmin"), names)
    torque = by_code["friction_force"].scaled(arm_m, "N m")
    yield Characteristic("friction_torque", None, "joint", torque)
    angle = by_code["compliance"].scaled(per_mm / (_PER * arm_m), "arcmin/N m")
    yield Characteristic("stiffness", None, "joint", _inverse(angle))


def _inverse(compliance: Estimate) -> Estimate:
    """Return the stiffness [N m/arcmin]; its interval is that of the compliance, turned over."""
    value, u, interval = compliance.value, compliance.u, compliance.interval
    return replace(
        compliance,
        value=1 / value,
        unit="N m/arcmin",
        u=None if u is None else u / value**2,
        parts={name: part / value**2 for name, part in compliance.parts.items()},
        interval=None if not interval or interval[0] <= 0 else (1 / interval[1], 1 / interval[0]),
        clause=_NO_CLAUSE,
    )


def _estimate(
    fit: LoopFit,
    slope: Sequence[float],
    value: float,
    reading_u: float | None,
    clause: str = _NO_CLAUSE,
    *,
    unit: str = "mm",
    ends: bool = False,
) -> Estimate:
    """Return a function of the fit with ``slope`` by compliance, half play and friction.

    With ``ends`` it is a difference of mean readings at the ends of the loops.
    """
    vector = np.asarray(slope)
    variance = float(vector @ fit.covariance @ vector)
    variance = fit.residual**2 * 2 / fit.loops if ends else variance
    return even_estimate(
        max(value, 0.0),  # a play below none is one of none
        unit,
        sampling=math.sqrt(max(variance, 0.0)),
        reading_u=reading_u,
        freedom=fit.freedom,
        n=fit.readings,
        clause=clause,
        least=0.0,
    )
