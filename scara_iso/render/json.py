"""Results as JSON objects: the stable schemas of docs/json.md."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from scara_iso.diagnosis import Rival
    from scara_iso.iso9283 import (
        Analysis,
        AxisResult,
        Characteristic,
        Finding,
        LimitCheck,
        PosePlan,
        PoseResult,
        RadialResult,
    )
    from scara_iso.reporting import Page
    from scara_iso.run import Run

Json = dict[str, Any]
_HALF = re.compile("[\ud800-\udfff]")
"""Half a character, as a byte of a file's name that is no text; strict readers refuse it."""


def to_text(document: Mapping[str, Any]) -> str:
    r"""Return one line of JSON, all ASCII; NaN and infinity are a programming error.

    Half a character is spelt by its code, ``\udcff``, as wherever text is shown.
    """
    text = json.dumps(document, allow_nan=False)
    if "\\ud" in text:
        said = json.dumps(document, ensure_ascii=False)
        whole = _HALF.sub(lambda half: rf"\\u{ord(half[0]):04x}", said)
        text = json.dumps(json.loads(whole))
    return text


def analysis_json(analysis: Analysis) -> Json:
    """Return the JSON object of ``analyze``, schema ``scara-iso/analyze/2``."""
    cycles = analysis.cycles
    return {
        "schema": "scara-iso/analyze/2",
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
        "poses": [pose_json(pose) for pose in analysis.poses],
        "characteristics": [_characteristic(one) for one in analysis.characteristics],
        "limits": [_limit(check) for check in analysis.limits],
        "conformity": None if analysis.conformity is None else analysis.conformity.value,
        "deviations": [
            {"rule": f.rule, "code": f.code, "message": f.said} for f in analysis.deviations
        ],
        "findings": [finding_json(finding) for finding in analysis.findings],
    }


def finding_json(finding: Finding) -> Json:
    """Return a finding's object."""
    return {
        "code": finding.code,
        "severity": finding.severity,
        "axis": finding.axis,
        "pose": finding.pose,
        "message": finding.said,
    }


def pose_json(pose: PoseResult) -> Json:
    """Return the figures of a pose."""
    found: Json = {
        "pose": pose.label,
        "axes": {name: _axis(axis) for name, axis in pose.axes.items()},
    }
    if pose.XY is not None:
        rss = {"RP_rss": pose.XY.RP_rss, "RP_rss_interval": pose.XY.RP_rss_interval}
        found["XY"] = {**rss, **_radial(pose.XY)}
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
        "three_sigma_interval": axis.three_sigma_interval,
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
        "uncertainty_ratio": found.uncertainty_ratio,
        "accuracy": found.accuracy,
    }


def _characteristic(found: Characteristic) -> Json:
    estimate, check = found.estimate, found.limit
    return {
        "code": found.code,
        "clause": estimate.clause,
        "pose": found.pose,
        "of": found.of,
        "value": estimate.value,
        "unit": estimate.unit,
        "u": estimate.u,
        "parts": dict(estimate.parts),
        "interval": estimate.interval,
        "n": estimate.n,
        "limit": None
        if check is None
        else {"limit": check.limit, "verdict": check.verdict.value, "rule": check.decision.value},
    }


def _limit(check: LimitCheck) -> Json:
    return {
        "figure": check.figure,
        "pose": check.pose,
        "RP": check.RP,
        "interval": check.interval,
        "limit": check.limit,
        "verdict": check.verdict.value,
        "rule": check.decision.value,
        "interval_void": check.interval_void,
        "cycles_wanted": check.cycles_wanted,
        "guard": check.guard,
        "inside": check.inside,
        "clear": check.clear,
    }


def run_json(run: Run, *, seed: int) -> Json:
    """Return the JSON object of ``simulate``, schema ``scara-iso/simulate/1``."""
    return {
        "schema": "scara-iso/simulate/1",
        "unit": "mm",
        "seed": seed,
        "metadata": dict(run.metadata),
        "cycle": run.cycle.tolist(),
        "axes": {
            name: {
                "unit": axis.unit,
                "resolution": axis.resolution,
                "readings": axis.readings.tolist(),
            }
            for name, axis in run.axes.items()
        },
        "covariates": {name: values.tolist() for name, values in run.covariates.items()},
    }


def plan_json(plan: PosePlan) -> Json:
    """Return the JSON object of ``plan``, schema ``scara-iso/plan/1``."""
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


def explain_json(pages: Iterable[Page]) -> Json:
    """Return the JSON object of ``explain``, schema ``scara-iso/explain/1``."""
    return {
        "schema": "scara-iso/explain/1",
        "pages": [
            {
                "code": page.code,
                "kind": page.kind,
                "title": page.title,
                "text": list(page.text),
                "parameters": [
                    {"name": name, "unit": unit, "meaning": meaning}
                    for name, unit, meaning in page.parameters
                ],
            }
            for page in pages
        ],
    }


def rivals_json(rivals: Iterable[Rival]) -> list[Json]:
    """Return effects with their probabilities."""
    return [{"effect": r.effect, "probability": r.probability} for r in rivals]
