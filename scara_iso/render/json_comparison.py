"""The JSON object of ``compare``, schema ``scara-iso/compare/1``."""

from __future__ import annotations

from scara_iso.comparison import Comparison, Contrast, Pair
from scara_iso.iso9283 import Analysis
from scara_iso.render.json import Json, characteristic_json, finding_json


def comparison_json(comparison: Comparison) -> Json:
    """Return the object; see docs/json.md."""
    found = [characteristic_json(one) for one in comparison.characteristics]
    return {
        "schema": "scara-iso/compare/1",
        "unit": "mm",
        "test": {
            "method": "studentised permutation of centred cycles, single-step maximum",
            "level": 0.05,
            "shuffles": comparison.shuffles,
            "seed": comparison.seed,
        },
        "before": _run(comparison.pairs[0].before),
        "pairs": [_pair(pair) for pair in comparison.pairs],
        **({"characteristics": found} if found else {}),
    }


def _run(analysis: Analysis) -> Json:
    return {
        "source": analysis.run.origin.source,
        "read_as": analysis.run.origin.understood,
        "metadata": dict(analysis.run.metadata),
        "cycles": {"read": analysis.cycles.read, "used": analysis.cycles.used},
    }


def _pair(pair: Pair) -> Json:
    return {
        "after": _run(pair.after),
        "spreads": [_contrast(one) for one in pair.spreads],
        "means": [_contrast(one) for one in pair.means],
        "findings": [finding_json(finding) for finding in pair.findings],
    }


def _contrast(one: Contrast) -> Json:
    spread = {"ratio": one.ratio, "ratio_interval": one.ratio_interval}
    return {
        "pose": one.pose,
        "figure": one.figure,
        "quantity": one.quantity,
        "unit": one.unit,
        "before": one.before,
        "after": one.after,
        "difference": one.difference,
        "difference_interval": one.interval,
        **({} if one.quantity == "mean" else spread),
        "p_value": one.p_value,
        "p_value_at_floor": one.p_value_at_floor,
        "p_value_alone": one.p_value_alone,
        "verdict": one.verdict.value,
        "cycles_needed": one.cycles_needed,
        "smallest_shown": one.smallest_shown,
        "doubts": list(one.doubts),
    }
