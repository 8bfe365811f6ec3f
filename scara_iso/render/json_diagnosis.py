"""Diagnoses and designs as JSON objects: the schemas of docs/json.md."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict

from scara_iso.diagnosis import Design, Diagnosis, Found, PlannedRun, RunReversals, Series, Smallest
from scara_iso.render.json import Json, rivals_json
from scara_iso.render.json_backlash import gear_json


def diagnosis_json(diagnosis: Diagnosis) -> Json:
    """Return the JSON object of ``diagnose``, schema ``scara-iso/diagnose/1``."""
    RP = diagnosis.repeatability
    return {
        "schema": "scara-iso/diagnose/1",
        "unit": "mm",
        "verdict": diagnosis.verdict.value,
        "p_value": diagnosis.p_value,
        "p_value_at_floor": diagnosis.p_value_at_floor,
        "effects": [_found(found) for found in diagnosis.effects],
        "candidates": rivals_json(diagnosis.candidates),
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
            "completed": {
                name: {"value": one.value, "interval": [one.low, one.high]}
                for name, one in RP.completed.items()
            },
        },
        "shares": {
            axis: {
                "effects": part.effects,
                "resolution": part.resolution,
                "unexplained": part.unexplained,
            }
            for axis, part in diagnosis.shares.items()
        },
        "series": _series(diagnosis.series),
        "flags": [
            {
                "axis": f.axis,
                "cycle": f.cycle,
                "p_value": f.p_value,
                "p_value_at_floor": f.p_value_at_floor,
            }
            for f in diagnosis.flags
        ],
        "notes": list(diagnosis.notes),
        **({} if diagnosis.reversals is None else {"gear": _gear(diagnosis.reversals)}),
    }


def _series(series: Series) -> Json:
    courses = {
        "measured": series.measured,
        "predicted_before": series.predicted_before,
        "predicted_after": series.predicted_after,
    }
    return {
        "cycle": series.cycle.tolist(),
        **{
            name: {axis: values.tolist() for axis, values in course.items()}
            for name, course in courses.items()
        },
    }


def _gear(found: RunReversals) -> Json:
    return {
        **({"verdict": None} if found.gear is None else gear_json(found.gear)),
        "reversals": [asdict(one) for one in found.reversals],
        "mirrored": found.mirrored,
        "missing": list(found.missing),
        "notes": list(found.notes),
    }


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
        "p_value_at_floor": found.p_value_at_floor,
        "probability": found.probability,
        "share": dict(found.share),
        "rivals": rivals_json(found.rivals),
        "cause": found.cause,
        "confirm_by": found.confirm_by,
        "unidentified": list(found.unidentified),
    }


def design_json(plan: PlannedRun, found: Design) -> Json:
    """Return the JSON object of ``design``, schema ``scara-iso/design/1``."""
    return {
        "schema": "scara-iso/design/1",
        "unit": "mm",
        "cycles": len(plan.conditions),
        "sigma": plan.sigma,
        "resolution": plan.division,
        "columns": list(plan.conditions.covariates),
        "smallest": _smallest(found.smallest),
        "alike": [{"effects": [a.first, a.second], "cosine": a.cosine} for a in found.alike],
        "changes": [{"change": c.change, "smallest": _smallest(c.smallest)} for c in found.changes],
    }


def _smallest(found: Iterable[Smallest]) -> dict[str, float | None]:
    return {one.effect: one.travel for one in found}
