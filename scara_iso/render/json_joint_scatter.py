"""Scatter traced to the joints, and RP where nobody measured, as JSON: docs/json.md."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from scara_iso.published import Json
from scara_iso.render.json import picked

if TYPE_CHECKING:
    from scara_iso.diagnosis import FollowedInJoints, JointScatter, PoseLeftOut, ReachMap


def joint_scatter_json(found: JointScatter) -> Json:
    """Return the keys that scatter traced to the joints adds to ``diagnose`` of several poses."""
    return {
        "joint_scatter": {
            name: {**picked(one, "value unit"), "interval": [one.low, one.high],
                   **picked(one, "share")}
            for name, one in found.sources.items()
        },
        "joint_correlation": None if found.together is None else {
            "value": found.together.value,
            "interval": [found.together.low, found.together.high],
            "p_value": found.together.p_value,
        },
        "joint_misfit": {"ratio": found.misfit, "p_value": found.misfit_p_value},
        "predicted_RP": {
            pose: {"value": one.value, "interval": [one.low, one.high]}
            for pose, one in found.predicted_RP.items()
        },
        "left_out": {pose: _beside(one) for pose, one in found.left_out.items()},
        "left_out_rms": found.left_out_rms,
        "held_out": {pose: _beside(one) for pose, one in found.held_out.items()},
        **({} if found.reach is None else {"map": _extremes(found.reach)}),
    }  # fmt: skip


def followed_json(found: Sequence[FollowedInJoints]) -> Json:
    """Return the key that recorded columns add to ``diagnose`` of several poses."""
    return {
        "followed": [
            {
                **picked(one, "effect column misfit_p_value"),
                "sizes": {
                    name: {**picked(size, "value unit"), "interval": [size.low, size.high]}
                    for name, size in one.sizes.items()
                },
            }
            for one in found
        ]
    }


def _beside(one: PoseLeftOut) -> Json:
    predicted = one.predicted
    return {
        **picked(one, "measured effects_removed"),
        "predicted": {"value": predicted.value, "interval": [predicted.low, predicted.high]},
        **picked(one, "error inside rms_before rms_after"),
    }


def _extremes(reach: ReachMap) -> Json:
    ends = {
        name: dict(zip(("x_mm", "y_mm", "RP"), place, strict=True))
        for name, place in (("best", reach.best), ("worst", reach.worst))
    }
    return ends if reach.limit is None else {**ends, **picked(reach, "limit share_kept")}
