"""A gauge study as a JSON object."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scara_iso.published import Json
from scara_iso.render.json import each, picked, plain

if TYPE_CHECKING:
    from scara_iso.measurement_system import AxisStudy, Budget, Crossed, GaugeStudy

_CRITERION = "axis criterion=name of value interval limit at_least verdict"
_TYPE_1 = (
    "n mean s s_interval reference bias bias_interval t p_value Cg Cg_interval Cgk Cgk_interval"
)
_COMPONENT = (
    "sigma interval contribution of_study of_study_interval of_tolerance of_tolerance_interval"
)
_LINEARITY = (
    "n references biases lower upper slope slope_interval slope_p_value intercept "
    "intercept_p_value residual explained largest_bias holds_zero"
)
_STABILITY = (
    "sessions counts means scatters sigma centre half_width scatter_limits outside between trend "
    "trend_p_value"
)
_BUDGET = "of u U interval Q Q_interval Q_limit=limit C smallest_tolerance conformity_zone=zone"


def gauge_study_json(found: GaugeStudy) -> Json:
    """Return the JSON object of ``gauge-study``, schema ``scara-iso/gauge-study/1``."""
    return {
        "schema": "scara-iso/gauge-study/1",
        "source": found.source,
        "notes": list(found.notes),
        "metadata": dict(found.statements),
        "decision": found.decision.value,
        "axes": {name: _axis(one) for name, one in found.axes.items()},
        "criteria": each(found.criteria, _CRITERION),
        "conformity": plain(found.conformity),
        "findings": each(found.remarks, "severity axis message=said"),
    }


def _axis(study: AxisStudy) -> Json:
    from scara_iso.measurement_system import (  # noqa: PLC0415 - numpy, for studies only
        Crossed,
        Linearity,
        TypeOne,
    )

    figures = study.figures
    found = {
        **picked(study, "kind unit=readings.unit readings=readings.values"),
        **picked(study, "resolution=readings.resolution uncertainty=readings.uncertainty"),
        "tolerance": study.tolerance,
    }
    if isinstance(figures, TypeOne):
        found["type_1"] = picked(figures, _TYPE_1)
    elif isinstance(figures, Crossed):
        found["crossed"] = _crossed(figures)
    elif isinstance(figures, Linearity):
        found["linearity"] = picked(figures, _LINEARITY)
    else:
        found["stability"] = picked(figures, _STABILITY)
    found["uncertainty_budget"] = None if study.budget is None else _budget(study.budget)
    return found


def _crossed(figures: Crossed) -> Json:
    return {
        **picked(figures, "parts operators trials"),
        "anova": each(figures.anova, "source=name squares freedom mean_square F p_value"),
        "interaction_pooled": figures.pooled,
        "components": {name: picked(one, _COMPONENT) for name, one in figures.components.items()},
        **picked(figures, "ndc ndc_raw ndc_interval"),
        "by_ranges": picked(figures.ranges, "EV AV GRR PV TV of_study of_tolerance ndc"),
    }


def _budget(budget: Budget) -> Json:
    parts = {f"u_{name}": part for name, part in budget.parts.items()}
    missing = [f"u_{name}" for name in budget.missing]
    return {**picked(budget, _BUDGET), "parts": parts, "missing": missing}
