"""Diagnoses, designs and gears as JSON objects: the schemas of docs/json.md."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING

from scara_iso.iso9283 import published_pose
from scara_iso.published import Json, to_json
from scara_iso.render.json import APART, each, picked, plain
from scara_iso.render.json_joint_scatter import followed_json, joint_scatter_json

if TYPE_CHECKING:
    from scara_iso.diagnosis import (
        Design,
        DesignOfPoses,
        Diagnosis,
        DiagnosisOfPoses,
        Foretold,
        Found,
        GearDiagnosis,
        GearFound,
        PlannedPosesTest,
        PlannedRun,
        RunReversals,
        Smallest,
    )
    from scara_iso.iso9283 import PoseResult
    from scara_iso.robot import Backlash

_RIVAL = "effect probability"
_CHANCE = "p_value p_value_at_floor"
_COURSES = "measured predicted_before predicted_after"
_LEAST_PLACE = 0.001
_JOINTS: dict[str, int | str] = {
    "joint 1": 1, "joint 2": 2, "joint 4": 4, "along the arm": "along the arm",
}  # fmt: skip
_CROSSING = "load_deviation_rad inertia_ratio deviation_mm"


def diagnosis_json(diagnosis: Diagnosis) -> Json:
    """Return the JSON object of ``diagnose``, schema ``scara-iso/diagnose/2``."""
    return {"schema": "scara-iso/diagnose/2", "unit": "mm", **_of_one_pose(diagnosis)}


def poses_diagnosis_json(found: DiagnosisOfPoses) -> Json:
    """Return the JSON object of ``diagnose`` on several poses, schema ``scara-iso/diagnose/2``."""
    poses = [{"pose": pose, **_of_one_pose(one)} for pose, one in found.poses.items()]
    for pose in poses:
        del pose["effects"]  # they stand together, each with its poses
    separation = found.separation
    return {
        "schema": "scara-iso/diagnose/2",
        "unit": "mm",
        **picked(found, f"verdict {_CHANCE}"),
        "effects": [_found_at_poses(one) for one in found.effects],
        "candidates": each(found.candidates, _RIVAL),
        "error": _errors(found),
        "joints_apart": separation and picked(separation, "angle_deg observability_index"),
        "poses": poses,
        **({} if found.joint_scatter is None else joint_scatter_json(found.joint_scatter)),
        **(followed_json(found.followed) if found.followed else {}),
        "notes": list(found.notes),
    }


def _found_at_poses(found: Found) -> Json:
    at = found.at_joint
    half = 0.0 if at is None else 2 * at.standard_error
    size = at and {**picked(at, "value unit"), "interval": [at.value - half, at.value + half]}
    return {
        **_found(found),
        "joint": _JOINTS.get(found.joint or ""),
        **picked(found, "direction=place poses joint_candidates"),
        "size_at_joint": size,
        "places": {name: p for name, p in found.places.items() if p >= _LEAST_PLACE},
    }


def _errors(found: Diagnosis | DiagnosisOfPoses) -> Json:
    return {
        "before": picked(found.error_before, "rms held_out_rms"),
        "after": picked(found.error_after, "rms held_out_rms"),
    }


def _of_one_pose(diagnosis: Diagnosis) -> Json:
    RP = diagnosis.repeatability
    return {
        **picked(diagnosis, f"verdict {_CHANCE}"),
        "effects": [_found(found) for found in diagnosis.effects],
        "candidates": each(diagnosis.candidates, _RIVAL),
        "courses": each(diagnosis.courses, "axis words formula held_out_rms p_value"),
        "error": _errors(diagnosis),
        "repeatability": {
            **picked(RP, "measured model_before model_after with_effect_removed"),
            "completed": _foretold(RP.completed),
            "unseen": RP.unseen
            and {
                **picked(RP.unseen, "of cycles measured model_before"),
                "completed": _foretold(RP.unseen.completed),
            },
        },
        "shares": {
            axis: picked(part, "effects resolution unexplained")
            for axis, part in diagnosis.shares.items()
        },
        "series": picked(diagnosis.series, f"cycle {_COURSES}"),
        "flags": each(diagnosis.flags, f"axis cycle {_CHANCE}"),
        "notes": list(diagnosis.notes),
        **({} if diagnosis.reversals is None else {"gear": _gear(diagnosis.reversals)}),
    }


def _foretold(told: Mapping[str, Foretold]) -> Json:
    return {
        name: {"value": one.value, "interval": [one.low, one.high]} for name, one in told.items()
    }


def _found(found: Found) -> Json:
    joint = int(found.joint[-1]) if found.joint in ("joint 1", "joint 2") else None
    return {
        **picked(found, "effect axes"),
        "joint": joint,
        **picked(
            found, f"direction=joint angles parameters standard_errors {_CHANCE} probability share"
        ),
        **_named(found),
        "unidentified": list(found.unidentified),
    }


def _named(found: Found | GearFound) -> Json:
    return {"rivals": each(found.rivals, _RIVAL), **picked(found, "cause confirm_by")}


def _gear(found: RunReversals) -> Json:
    return {
        **({"verdict": None} if found.gear is None else _gear_diagnosis(found.gear)),
        "reversals": [asdict(one) for one in found.reversals],
        **picked(found, "mirrored missing notes"),
    }


def _gear_diagnosis(closed: GearDiagnosis) -> Json:
    return {
        **picked(closed, f"verdict {_CHANCE}"),
        "effects": [
            {
                **picked(found, "effect joint parameters intervals p_value probability"),
                **_named(found),
            }
            for found in closed.effects
        ],
        "candidates": each(closed.candidates, _RIVAL),
        "error": {
            "before": picked(closed, "rms=rms_before held_out_rms=held_out_before"),
            "after": picked(closed, "rms=rms_after held_out_rms=held_out_after"),
        },
    }


def design_json(plan: PlannedRun, found: Design) -> Json:
    """Return the JSON object of ``design``, schema ``scara-iso/design/1``."""
    return {
        "schema": "scara-iso/design/1",
        "unit": "mm",
        "cycles": len(plan.conditions),
        **picked(plan, "sigma resolution=division"),
        "columns": list(plan.conditions.covariates),
        "smallest": _smallest(found.smallest),
        "alike": [{"effects": [a.first, a.second], "cosine": a.cosine} for a in found.alike],
        "changes": [{"change": c.change, "smallest": _smallest(c.smallest)} for c in found.changes],
    }


def design_of_poses_json(plan: PlannedPosesTest, found: DesignOfPoses) -> Json:
    """Return the object of a test of poses that is planned, ``scara-iso/design-poses/1``."""
    return {
        "schema": "scara-iso/design-poses/1",
        "unit": "rad",
        "cycles": len(plan.conditions),
        "poses": list(plan.joints_deg),
        "resolution_mm": list(plan.division),
        "columns": list(plan.conditions.covariates),
        "scatter": {
            name: {"value": value, "unit": "mm" if name == "dial" else "rad"}
            for name, value in plan.sources.items()
        },
        "seen_in_a_cycle": plan.sigma,
        "smallest": {joint: _smallest(own) for joint, own in found.smallest.items()},
        "joints_apart": picked(found.apart, APART),
        "alike": [{"effects": [a.first, a.second], "cosine": a.cosine} for a in found.alike],
        "changes": [
            {
                "change": one.change,
                "smallest": {joint: _smallest(own) for joint, own in one.smallest.items()},
                "joints_apart": picked(one.apart, APART),
                **picked(one, "size_needed adds"),
            }
            for one in found.changes
        ],
    }


def _smallest(found: Iterable[Smallest]) -> dict[str, float | None]:
    return {one.effect: one.travel for one in found}


def backlash_json(
    result: Backlash, actual: PoseResult | None = None, closed: GearDiagnosis | None = None
) -> Json:
    """Return the JSON object of ``backlash``, schema ``scara-iso/backlash/1``.

    ``actual`` is a measured pose, given as ``actual`` beside the model; ``closed`` what a measured
    sweep leaves unexplained.
    """
    reflected = result.reflected and {
        "ratio": result.ratio,
        **picked(result.reflected, f"motor_inertia {_CROSSING}"),
    }
    sweep = closed and {
        **_gear_diagnosis(closed),
        "series": picked(closed, _COURSES),
        "notes": plain(closed.notes),
    }
    return {
        "schema": "scara-iso/backlash/1",
        "gap_rad": result.gap_rad,
        **picked(result.as_given, _CROSSING),
        **picked(result, "arm_m free_play_mm"),
        "reflected": reflected,
        **({} if actual is None else {"actual": to_json(published_pose(actual))}),
        **(sweep or {}),
    }
