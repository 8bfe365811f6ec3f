"""From a `Run` to its figures and what must be said of them: `analyze`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from scara_iso.dial import step_of
from scara_iso.errors import DataError, UsageError
from scara_iso.iso9283.blocks import block_of_rows, every_visit
from scara_iso.iso9283.by_name import Poses
from scara_iso.iso9283.characteristics import find_characteristics, needs
from scara_iso.iso9283.checks import find_checks
from scara_iso.iso9283.conformity import DecisionRule
from scara_iso.iso9283.cycles import AS_THE_TABLE_SAYS, Counting, Rows, UsedCycles, used_cycles
from scara_iso.iso9283.drift import drift_courses
from scara_iso.iso9283.estimates import largest_calibration, reading_uncertainty, scatter_estimates
from scara_iso.iso9283.figures import AxisResult, PoseResult, RadialResult, ThetaAngle
from scara_iso.iso9283.limits import binding, check_limits
from scara_iso.iso9283.other_definitions import definitions
from scara_iso.iso9283.results import Analysis, Cycles, Measured
from scara_iso.iso9283.statistics import (
    SamplingInterval,
    repeatability,
    root_sum_of_squares,
    rp_interval,
    rss_interval,
    standard_deviation,
    three_sigma_interval,
)
from scara_iso.quantities import (
    Dimension,
    Estimate,
    parse_number,
    within_half_a_turn,
)
from scara_iso.run import Axis, FloatArray, Run

_FEWEST_CYCLES = 2


def analyze(
    run: Run,
    counting: Counting = AS_THE_TABLE_SAYS,
    *,
    limits: Mapping[str, float] | None = None,
    decision: str = DecisionRule.INTERVAL.value,
    other_definitions: bool = False,
) -> Analysis:
    """Return RP of every pose, axis and plane of a run, with intervals and findings.

    Paper eq. 2-6 and 23, ISO 9283 7.2.1 and 7.2.2. ``limits`` are in mm (degrees for an
    angle) by figure (``X``, ``XY``...); the key `limits.EVERY_LENGTH` holds for every length.
    ``decision`` is ``interval`` (a limit is kept or broken where the whole 95 % interval says so,
    and not kept on an interval that a finding voids)
    or ``simple`` (RP at most the limit). ``other_definitions`` adds half range, 2 s, 3 s and ISO
    230-2. Raises `DataError` where the run breaks the cycle rule, and `UsageError` for another
    rule or a limit of a figure that the run does not have.
    """
    rule = _rule(decision)
    run = run.unwrapped()
    block = block_of_rows(run)
    if block is None:
        chosen = used_cycles(run, counting)
    else:
        asked = counting.first_cycle_discarded or counting.cycles is not None
        chosen = every_visit(run, block, asked=asked)
    if chosen.used < _FEWEST_CYCLES:
        raise DataError(
            f"{chosen.used} cycle counts: no scatter can be computed",
            where=run.origin.source,
            remedy=f"run {_FEWEST_CYCLES} cycles that count, or more",
        )
    measured = Measured(
        run=run,
        cycles=Cycles(chosen.read, chosen.discarded, chosen.used, all_count=chosen.all_count),
        poses=_pose_results(run, chosen, other_definitions=other_definitions),
        block=block,
    )
    if block is not None:
        measured = replace(measured, drift=tuple(drift_courses(run, measured.poses, block)))
    found = [one for compute in find_characteristics() for one in compute(measured)]
    measured = replace(measured, codes=frozenset(one.code for one in found))
    findings = tuple(finding for check in find_checks() for finding in check(measured))
    held = check_limits(found, limits or {}, findings, decision=rule, needs=needs())
    return Analysis(
        run=run,
        cycles=measured.cycles,
        poses=measured.poses,
        findings=findings,
        limits=binding(held),
        characteristics=held,
        block=block,
        drift=measured.drift,
    )


def _rule(decision: str) -> DecisionRule:
    words = [rule.value for rule in DecisionRule]
    if decision not in words:
        raise UsageError(
            f"decision {decision!r}: no such rule", remedy=f"use one of {', '.join(words)}"
        )
    return DecisionRule(decision)


def _pose_results(run: Run, chosen: UsedCycles, *, other_definitions: bool) -> Poses[PoseResult]:
    missing = dict(zip(chosen.poses, chosen.missing, strict=True))
    found = {
        pose.label: replace(pose, missing=missing[pose.label])
        for rows in chosen.of_equal_length()
        for pose in _results_together(run, rows, other_definitions=other_definitions)
    }
    return Poses(found[label] for label in chosen.poses)


def _results_together(run: Run, chosen: Rows, *, other_definitions: bool) -> tuple[PoseResult, ...]:
    axes = {name: _axis_results(run, axis, chosen) for name, axis in run.axes.items()}
    if other_definitions:
        axes = {name: _with_definitions(run, chosen, found) for name, found in axes.items()}
    planes, spaces = _radial_results(run, chosen, "XY"), _radial_results(run, chosen, "XYZ")
    return tuple(
        PoseResult(
            label=label,
            rows=chosen.rows[k],
            cycle=run.cycle[chosen.rows[k]],
            axes={name: found[k] for name, found in axes.items()},
            XY=planes[k],
            XYZ=spaces[k],
        )
        for k, label in enumerate(chosen.poses)
    )


def _axis_results(run: Run, axis: Axis, chosen: Rows) -> list[AxisResult]:
    readings = axis.readings[chosen.rows]
    positions = readings[:, np.newaxis, :]
    folded = repeatability(positions)
    RP = _estimates(rp_interval, folded.RP, positions, [axis])
    spread = 3 * standard_deviation(readings)
    three_S = _estimates(three_sigma_interval, spread, positions, [axis])
    radius = _theta_radius(run, axis)
    uncertainty = reading_uncertainty(axis)
    return [
        AxisResult(
            name=axis.name,
            dimension=axis.dimension,
            unit=axis.dimension.value,
            readings=readings[k],
            n=readings.shape[1],
            mean=float(folded.mean[k, 0]),
            l_bar=float(folded.l_bar[k]),
            S_l=float(folded.S_l[k]),
            repeatability=RP[k],
            RP=RP[k].value,
            RP_interval=RP[k].interval,
            three_S=three_S[k],
            three_sigma=three_S[k].value,
            three_sigma_interval=three_S[k].interval,
            resolution=axis.resolution,
            uncertainty=uncertainty,
            uncertainty_ratio=_ratio(uncertainty, RP[k].value),
            calibration=axis.uncertainty,
            accuracy=_accuracy(run, axis, chosen.poses[k], float(folded.mean[k, 0])),
            angle=_theta_angle(RP[k].value, three_S[k].value, radius),
        )
        for k in range(len(readings))
    ]


def _ratio(uncertainty: float | None, RP: float) -> float | None:
    return None if uncertainty is None or RP == 0 else uncertainty / RP


def _accuracy(run: Run, axis: Axis, pose: str | None, mean: float) -> float | None:
    """Return mean minus command (7.2.1), where the dial's zero is referred to the command pose."""
    command = run.command_of(axis.name, pose)
    if command is None or not run.dial_zero_is_command:
        return None
    return within_half_a_turn(mean - command) if axis.unit == "deg" else mean - command


def _theta_radius(run: Run, axis: Axis) -> float | None:
    text = run.metadata.get("theta_radius_mm")
    if text is None or axis.name != "theta" or axis.dimension is not Dimension.LENGTH:
        return None
    radius = parse_number(text)
    if radius is None or radius <= 0:
        raise DataError(
            f"theta_radius_mm is {text!r}", where=run.origin.source,
            remedy="give the distance from the axis of rotation to the contact in mm",
        )  # fmt: skip
    return radius


def _theta_angle(RP: float, three_sigma: float, radius: float | None) -> ThetaAngle | None:
    if radius is None:
        return None
    # The paper gives theta as a length and no formula: arc over radius is decided here; chord and
    # tangent differ from it by less than 1e-4 of the figure below one degree.
    return ThetaAngle(radius, math.degrees(RP / radius), math.degrees(three_sigma / radius))


def _with_definitions(run: Run, chosen: Rows, found: Sequence[AxisResult]) -> list[AxisResult]:
    approach = run.covariates.get("approach")
    return [
        replace(
            axis,
            definitions=definitions(axis.readings, None if approach is None else approach[rows]),
        )
        for axis, rows in zip(found, chosen.rows, strict=True)
    ]


def _radial_results(run: Run, chosen: Rows, names: str) -> Sequence[RadialResult | None]:
    axes = [run.axes[name] for name in names if name in run.axes]
    if len(axes) < len(names) or any(axis.dimension is not Dimension.LENGTH for axis in axes):
        return [None] * len(chosen.poses)
    positions = np.stack([axis.readings[chosen.rows] for axis in axes], axis=1)
    folded = repeatability(positions)
    RP = _estimates(rp_interval, folded.RP, positions, axes)
    offsets = [
        [_accuracy(run, axis, pose, mean) for axis, mean in zip(axes, means, strict=True)]
        for pose, means in zip(chosen.poses, folded.mean.tolist(), strict=True)
    ]
    parts = [u for u in map(reading_uncertainty, axes) if u is not None]
    rss = _estimates(
        rss_interval, root_sum_of_squares(positions), positions, axes, clause="paper eq. 23"
    )
    return [
        RadialResult(
            repeatability=RP[k],
            l_bar=float(folded.l_bar[k]),
            S_l=float(folded.S_l[k]),
            root_sum_of_squares=rss[k] if names == "XY" else None,
            # A distance to the barycentre is no less certain than its least certain axis.
            uncertainty=max(parts) if len(parts) == len(axes) else None,
            calibration=largest_calibration(axes),
            accuracy=_distance(offsets[k]),
        )
        for k in range(len(positions))
    ]


def _distance(offsets: Sequence[float | None]) -> float | None:
    known = [offset for offset in offsets if offset is not None]
    return math.hypot(*known) if len(known) == len(offsets) else None


def _estimates(
    interval: SamplingInterval,
    figures: FloatArray,
    positions: FloatArray,
    axes: Sequence[Axis],
    *,
    clause: str = "7.2.2",
) -> list[Estimate]:
    return scatter_estimates(
        interval,
        figures,
        positions,
        steps=[step_of(axis) for axis in axes],
        calibration=largest_calibration(axes),
        unit=axes[0].unit,
        clause=clause,
    )
