"""The gear as JSON: the object of ``backlash``, and a diagnosis of reversals."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scara_iso.render.json import Json, pose_json, rivals_json

if TYPE_CHECKING:
    from scara_iso.diagnosis import GearDiagnosis
    from scara_iso.iso9283 import PoseResult
    from scara_iso.robot import Backlash, Crossing


def backlash_json(
    result: Backlash, actual: PoseResult | None = None, closed: GearDiagnosis | None = None
) -> Json:
    """Return the JSON object of ``backlash``, schema ``scara-iso/backlash/1``.

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
        **({} if actual is None else {"actual": pose_json(actual)}),
        **({} if closed is None else _sweep(closed)),
    }


def _sweep(closed: GearDiagnosis) -> Json:
    return {
        **gear_json(closed),
        "series": {
            "measured": closed.measured.tolist(),
            "predicted_before": closed.predicted_before.tolist(),
            "predicted_after": closed.predicted_after.tolist(),
        },
        "notes": list(closed.notes),
    }


def gear_json(closed: GearDiagnosis) -> Json:
    """Return verdict, effects and error of a diagnosis of reversals."""
    return {
        "verdict": closed.verdict.value,
        "p_value": closed.p_value,
        "p_value_at_floor": closed.p_value_at_floor,
        "effects": [
            {
                "effect": found.effect,
                "joint": found.joint,
                "parameters": dict(found.parameters),
                "intervals": {name: list(ends) for name, ends in found.intervals.items()},
                "p_value": found.p_value,
                "probability": found.probability,
                "rivals": rivals_json(found.rivals),
                "cause": found.cause,
                "confirm_by": found.confirm_by,
            }
            for found in closed.effects
        ],
        "candidates": rivals_json(closed.candidates),
        "error": {
            "before": {"rms": closed.rms_before, "held_out_rms": closed.held_out_before},
            "after": {"rms": closed.rms_after, "held_out_rms": closed.held_out_after},
        },
    }


def _crossing(crossing: Crossing) -> Json:
    return {
        "load_deviation_rad": crossing.load_deviation_rad,
        "inertia_ratio": crossing.inertia_ratio,
        "deviation_mm": crossing.deviation_mm,
    }
