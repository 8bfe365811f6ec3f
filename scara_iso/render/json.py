"""Results as JSON objects: the stable schemas of docs/json.md."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from enum import Enum
from operator import attrgetter
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from scara_iso.comparison import Comparison, Contrast
    from scara_iso.diagnosis import SeparatingPlan
    from scara_iso.iso9283 import (
        Analysis,
        AxisResult,
        Characteristic,
        DriftCourse,
        LimitCheck,
        PosePlan,
        PoseResult,
    )
    from scara_iso.reporting import Page
    from scara_iso.run import Run

Json = dict[str, Any]
_HALF = re.compile("[\ud800-\udfff]")
"""Half a character, as a byte of a file's name that is no text; strict readers refuse it."""
FINDING = "code severity axis pose message=said"
LIMIT = (
    "figure pose RP interval limit verdict rule=decision interval_void cycles_wanted guard "
    "inside clear"
)
APART = "angle_deg observability_index smallest_angle_deg between uncertainty"
_RADIAL = (
    "RP_radial=RP RP_radial_interval=RP_interval l_bar S_l uncertainty uncertainty_ratio accuracy"
)


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


def plain(value: Any) -> Any:
    """Return a value as JSON has it: enums by their value, arrays and tuples as lists."""
    if isinstance(value, Mapping):
        return {key: plain(one) for key, one in value.items()}
    if isinstance(value, tuple | list):
        return [plain(one) for one in value]
    if isinstance(value, Enum):
        return value.value
    return value.tolist() if hasattr(value, "tolist") else value


def picked(found: object, keys: str) -> Json:
    """Return attributes of a result in the order of ``keys``, one ``key`` or ``key=attribute``."""
    pairs = (key.partition("=") for key in keys.split())
    return {key: plain(attrgetter(path or key)(found)) for key, _, path in pairs}


def each(found: Iterable[object], keys: str) -> list[Json]:
    """Return what is `picked` of each result."""
    return [picked(one, keys) for one in found]


def analysis_json(analysis: Analysis) -> Json:
    """Return the JSON object of ``analyze``, schema ``scara-iso/analyze/2``."""
    return {
        "schema": "scara-iso/analyze/2",
        "unit": "mm",
        **_source(analysis.run),
        "notes": list(analysis.run.origin.notes),
        "metadata": dict(analysis.run.metadata),
        "cycles": picked(analysis.cycles, "read discarded used"),
        "poses": [pose_json(pose) for pose in analysis.poses],
        "characteristics": [characteristic_json(one) for one in analysis.characteristics],
        **_drift(analysis),
        "limits": limits_json(analysis.limits),
        "conformity": plain(analysis.conformity),
        "deviations": each(analysis.deviations, "rule code message=said"),
        "findings": each(analysis.findings, FINDING),
    }


def _source(run: Run) -> Json:
    return picked(run, "source=origin.source read_as=origin.understood")


def _drift(analysis: Analysis) -> Json:
    """Return the course of each pose of a drift test; nothing of another test."""
    from scara_iso.iso9283 import drift_courses  # noqa: PLC0415 - scipy, for drift tests only

    if analysis.block is None:
        return {}
    courses = drift_courses(analysis.run, analysis.poses, analysis.block)
    return {"drift": [_course(course) for course in courses]}


def _course(course: DriftCourse) -> Json:
    fit = course.fit
    return {
        "pose": course.pose.label,
        "visits": [len(visits) for visits in course.visits],
        "time_h": None if course.hours is None else course.hours.tolist(),
        "mean": {name: means.tolist() for name, means in course.means.items()},
        "fit": None
        if fit is None
        else {
            "time_constant_h": fit.time_constant_h,
            "time_constant_interval_h": fit.interval_h,
            "steady": fit.is_steady,
            "fitted": {name: values.tolist() for name, values in fit.fitted.items()},
        },
    }


def pose_json(pose: PoseResult) -> Json:
    """Return the figures of a pose."""
    found: Json = {
        "pose": pose.label,
        "axes": {name: _axis(axis) for name, axis in pose.axes.items()},
    }
    if pose.XY is not None:
        found["XY"] = picked(pose.XY, f"RP_rss RP_rss_interval {_RADIAL}")
    if pose.XYZ is not None:
        found["XYZ"] = picked(pose.XYZ, _RADIAL)
    return found


def _axis(axis: AxisResult) -> Json:
    found = picked(
        axis,
        "unit n mean l_bar S_l RP RP_interval three_sigma three_sigma_interval resolution "
        "uncertainty uncertainty_ratio accuracy",
    )
    if axis.angle is not None:
        found["angle"] = picked(axis.angle, "radius_mm RP_deg three_sigma_deg")
    if axis.definitions:
        found["definitions"] = {d.name: d.value for d in axis.definitions}
    return found


def characteristic_json(found: Characteristic) -> Json:
    """Return a characteristic's object."""
    return {
        **picked(found, "code clause=estimate.clause pose of"),
        **picked(found.estimate, "value unit u parts interval n"),
        "limit": found.limit
        and picked(found.limit, "limit verdict rule=decision") | _lower(found.limit),
    }


def limits_json(checks: Iterable[LimitCheck]) -> list[Json]:
    """Return the objects of limits; ``lower`` where the smallest value is limited too."""
    return [picked(check, LIMIT) | _lower(check) for check in checks]


def _lower(check: LimitCheck) -> Json:
    return {} if check.lower is None else {"lower": check.lower}


def run_json(run: Run, *, seed: int) -> Json:
    """Return the JSON object of ``simulate``, schema ``scara-iso/simulate/1``."""
    return {
        "schema": "scara-iso/simulate/1",
        "unit": "mm",
        "seed": seed,
        **picked(run, "metadata cycle"),
        "axes": {n: picked(axis, "unit resolution readings") for n, axis in run.axes.items()},
        **picked(run, "covariates"),
    }


def plan_json(plan: PosePlan) -> Json:
    """Return the JSON object of ``plan``, schema ``scara-iso/plan/1``."""
    return {
        "schema": "scara-iso/plan/1",
        "unit": "mm",
        **picked(plan, "solid size_mm corners plane elbow diagonal_mm m_mm stroke_limits"),
        "rated": picked(plan.rated, "load_kg velocity_mm_s"),
        "cycles": picked(plan.conditions, "run=cycles used"),
        "visits": plain(plan.rows()),
    }


def separating_json(plan: SeparatingPlan) -> Json:
    """Return the object of separating poses, schema ``scara-iso/plan-separating/1``."""
    return {
        "schema": "scara-iso/plan-separating/1",
        "unit": "mm",
        **picked(plan, "elbow"),
        "apart": {name: picked(one, APART) for name, one in plan.apart.items()},
        "rated": picked(plan.rated, "load_kg velocity_mm_s"),
        "cycles": picked(plan.conditions, "run=cycles used"),
        "visits": plain(plan.rows()),
    }


def comparison_json(comparison: Comparison) -> Json:
    """Return the JSON object of ``compare``, schema ``scara-iso/compare/1``."""
    found = [characteristic_json(one) for one in comparison.characteristics]
    return {
        "schema": "scara-iso/compare/1",
        "unit": "mm",
        "test": {
            "method": "studentised permutation of centred cycles, single-step maximum",
            "level": 0.05,
            **picked(comparison, "shuffles seed"),
        },
        "before": _compared(comparison.pairs[0].before),
        "pairs": [
            {
                "after": _compared(pair.after),
                "spreads": [_contrast(one) for one in pair.spreads],
                "means": [_contrast(one) for one in pair.means],
                "findings": each(pair.findings, FINDING),
            }
            for pair in comparison.pairs
        ],
        **({"characteristics": found} if found else {}),
    }


def _compared(analysis: Analysis) -> Json:
    cycles = picked(analysis.cycles, "read used")
    return {**_source(analysis.run), **picked(analysis.run, "metadata"), "cycles": cycles}


def _contrast(one: Contrast) -> Json:
    ratio = "" if one.quantity == "mean" else "ratio ratio_interval"
    return picked(
        one,
        f"pose figure quantity unit before after difference difference_interval=interval {ratio} "
        "p_value p_value_at_floor p_value_alone verdict cycles_needed smallest_shown doubts",
    )


def explain_json(pages: Iterable[Page]) -> Json:
    """Return the JSON object of ``explain``, schema ``scara-iso/explain/1``."""
    names = ("name", "unit", "meaning")
    return {
        "schema": "scara-iso/explain/1",
        "pages": [
            {
                **picked(page, "code kind title text"),
                "parameters": [dict(zip(names, row, strict=True)) for row in page.parameters],
            }
            for page in pages
        ],
    }
