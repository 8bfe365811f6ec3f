"""Results as JSON objects: the stable schemas of docs/json.md."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from scara_iso.results import Analysis, AxisResult, LimitCheck, PoseResult, RadialResult
from scara_iso.two_inertia import Backlash, Crossing

if TYPE_CHECKING:
    from scara_iso.diagnosis import Diagnosis, Found, Rival
    from scara_iso.diagnosis.gear import GearDiagnosis
    from scara_iso.plan import Plan
    from scara_iso.run import Run

Json = dict[str, Any]


def to_text(document: Mapping[str, Any]) -> str:
    """Return one line of JSON, all ASCII; NaN and infinity are a programming error."""
    return json.dumps(document, allow_nan=False)


def analysis_json(analysis: Analysis) -> Json:
    """Return the object of ``analyze --json``, schema ``scara-iso/analyze/1``."""
    cycles = analysis.cycles
    return {
        "schema": "scara-iso/analyze/1",
        "unit": "mm",
        "source": analysis.run.origin.source,
        "read_as": analysis.run.origin.understood,
        "notes": list(analysis.run.origin.notes),
        "metadata": dict(analysis.run.metadata),
        "cycles": {
            "read": cycles.read,
            "discarded": list(cycles.discarded),
            "used": cycles.used,
        },
        "poses": [_pose(pose) for pose in analysis.poses],
        "limits": [_limit(check) for check in analysis.limits],
        "deviations": [
            {"rule": f.rule, "code": f.code, "message": f.message} for f in analysis.deviations
        ],
        "findings": [
            {
                "code": f.code,
                "severity": f.severity,
                "axis": f.axis,
                "pose": f.pose,
                "message": f.message,
            }
            for f in analysis.findings
        ],
    }


def _pose(pose: PoseResult) -> Json:
    found: Json = {
        "pose": pose.label,
        "axes": {name: _axis(axis) for name, axis in pose.axes.items()},
    }
    if pose.XY is not None:
        found["XY"] = {"RP_rss": pose.XY.RP_rss, **_radial(pose.XY)}
    if pose.XYZ is not None:
        found["XYZ"] = _radial(pose.XYZ)
    return found


def _axis(axis: AxisResult) -> Json:
    found: Json = {
        "unit": axis.unit,
        "n": axis.n,
        "mean": axis.mean,
        "l_bar": axis.l_bar,
        "S_l": axis.S_l,
        "RP": axis.RP,
        "RP_interval": axis.RP_interval,
        "three_sigma": axis.three_sigma,
        "resolution": axis.resolution,
        "uncertainty": axis.uncertainty,
        "uncertainty_ratio": axis.uncertainty_ratio,
        "accuracy": axis.accuracy,
    }
    if axis.angle is not None:
        found["angle"] = {
            "radius_mm": axis.angle.radius_mm,
            "RP_deg": axis.angle.RP_deg,
            "three_sigma_deg": axis.angle.three_sigma_deg,
        }
    if axis.definitions:
        found["definitions"] = {d.name: d.value for d in axis.definitions}
    return found


def _radial(found: RadialResult) -> Json:
    return {
        "RP_radial": found.RP,
        "RP_radial_interval": found.RP_interval,
        "l_bar": found.l_bar,
        "S_l": found.S_l,
        "uncertainty": found.uncertainty,
        "accuracy": found.accuracy,
    }


def _limit(check: LimitCheck) -> Json:
    return {
        "figure": check.figure,
        "pose": check.pose,
        "RP": check.RP,
        "limit": check.limit,
        "guard": check.guard,
        "inside": check.inside,
        "clear": check.clear,
    }


def backlash_json(
    result: Backlash, actual: PoseResult | None = None, closed: GearDiagnosis | None = None
) -> Json:
    """Return the object of ``backlash --json``, schema ``scara-iso/backlash/1``.

    ``actual`` is a measured pose, given as ``actual`` beside the model; ``closed`` what a measured
    sweep leaves unexplained.
    """
    reflected: Json | None = None
    if result.reflected is not None:
        reflected = {
            "ratio": result.ratio,
            "motor_inertia": result.reflected.motor_inertia,
            **_crossing(result.reflected),
        }
    return {
        "schema": "scara-iso/backlash/1",
        "gap_rad": result.gap_rad,
        **_crossing(result.as_given),
        "arm_m": result.arm_m,
        "free_play_mm": result.free_play_mm,
        "reflected": reflected,
        **({} if actual is None else {"actual": _pose(actual)}),
        **({} if closed is None else _sweep(closed)),
    }


def _sweep(closed: GearDiagnosis) -> Json:
    return {
        "verdict": closed.verdict.value,
        "effects": [
            {
                "effect": found.effect,
                "parameters": dict(found.parameters),
                "intervals": {name: list(ends) for name, ends in found.intervals.items()},
                "p_value": found.p_value,
                "probability": found.probability,
                "rivals": [
                    {"effect": r.effect, "probability": r.probability} for r in found.rivals
                ],
                "cause": found.cause,
                "confirm_by": found.confirm_by,
            }
            for found in closed.effects
        ],
        "error": {
            "before": {"rms": closed.rms_before, "held_out_rms": closed.held_out_before},
            "after": {"rms": closed.rms_after, "held_out_rms": closed.held_out_after},
        },
        "series": {
            "measured": closed.measured.tolist(),
            "predicted_before": closed.predicted_before.tolist(),
            "predicted_after": closed.predicted_after.tolist(),
        },
        "notes": list(closed.notes),
    }


def _crossing(crossing: Crossing) -> Json:
    return {
        "load_deviation_rad": crossing.load_deviation_rad,
        "inertia_ratio": crossing.inertia_ratio,
        "deviation_mm": crossing.deviation_mm,
    }


def run_json(run: Run) -> Json:
    """Return the object of ``simulate --json``, schema ``scara-iso/simulate/1``."""
    return {
        "schema": "scara-iso/simulate/1",
        "unit": "mm",
        "metadata": dict(run.metadata),
        "cycle": run.cycle.tolist(),
        "axes": {
            name: {"unit": a.unit, "resolution": a.resolution, "readings": a.readings.tolist()}
            for name, a in run.axes.items()
        },
        "covariates": {name: values.tolist() for name, values in run.covariates.items()},
    }


def plan_json(plan: Plan) -> Json:
    """Return the object of ``plan --json``, schema ``scara-iso/plan/1``."""
    return {
        "schema": "scara-iso/plan/1",
        "unit": "mm",
        "solid": plan.solid.value,
        "size_mm": list(plan.size_mm),
        "corners": plan.corners.tolist(),
        "plane": plan.plane.value,
        "elbow": plan.elbow.value,
        "diagonal_mm": plan.diagonal_mm,
        "m_mm": plan.m_mm,
        "stroke_limits": plan.stroke_limits,
        "cycles": {"run": plan.conditions.cycles, "used": plan.conditions.used},
        "visits": [dict(row) for row in plan.rows()],
    }


def diagnosis_json(diagnosis: Diagnosis) -> Json:
    """Return the object of ``diagnose --json``, schema ``scara-iso/diagnose/1``."""
    RP, series = diagnosis.repeatability, diagnosis.series
    return {
        "schema": "scara-iso/diagnose/1",
        "unit": "mm",
        "verdict": diagnosis.verdict.value,
        "p_value": diagnosis.p_value,
        "effects": [_found(found) for found in diagnosis.effects],
        "candidates": _rivals(diagnosis.candidates),
        "error": {
            name: {"rms": dict(error.rms), "held_out_rms": dict(error.held_out_rms)}
            for name, error in (
                ("before", diagnosis.error_before),
                ("after", diagnosis.error_after),
            )
        },
        "repeatability": {
            "measured": dict(RP.measured),
            "model_before": dict(RP.model_before),
            "model_after": dict(RP.model_after),
            "with_effect_removed": dict(RP.with_effect_removed),
        },
        "shares": {
            axis: {
                "effects": part.effects,
                "resolution": part.resolution,
                "unexplained": part.unexplained,
            }
            for axis, part in diagnosis.shares.items()
        },
        "series": {
            "cycle": series.cycle.tolist(),
            **{
                name: {axis: values.tolist() for axis, values in course.items()}
                for name, course in (
                    ("measured", series.measured),
                    ("predicted_before", series.predicted_before),
                    ("predicted_after", series.predicted_after),
                )
            },
        },
        "flags": [
            {"axis": f.axis, "cycle": f.cycle, "p_value": f.p_value} for f in diagnosis.flags
        ],
        "notes": list(diagnosis.notes),
    }


def _rivals(rivals: Iterable[Rival]) -> list[Json]:
    return [{"effect": r.effect, "probability": r.probability} for r in rivals]


def _joint(direction: str | None) -> int | None:
    return int(direction[-1]) if direction in ("joint 1", "joint 2") else None


def _found(found: Found) -> Json:
    return {
        "effect": found.effect,
        "axes": list(found.axes),
        "joint": _joint(found.joint),
        "direction": found.joint,
        "angles": dict(found.angles),
        "parameters": {
            name: dict(value) if isinstance(value, Mapping) else value
            for name, value in found.parameters.items()
        },
        "standard_errors": {name: dict(value) for name, value in found.standard_errors.items()},
        "p_value": found.p_value,
        "probability": found.probability,
        "rivals": _rivals(found.rivals),
        "cause": found.cause,
        "confirm_by": found.confirm_by,
        "unidentified": list(found.unidentified),
    }
