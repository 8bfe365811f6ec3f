"""Diagnoses, designs and gears as JSON objects: the schemas of docs/json.md."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from scara_iso.published import Json
from scara_iso.render.json import APART, picked

if TYPE_CHECKING:
    from scara_iso.diagnosis import (
        Design,
        DesignOfPoses,
        PlannedPosesTest,
        PlannedRun,
        Smallest,
    )


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
