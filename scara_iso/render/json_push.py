"""A push test as a JSON object."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scara_iso.iso9283 import published_characteristic, published_limit
from scara_iso.published import Json, to_json
from scara_iso.render.json import picked, plain

if TYPE_CHECKING:
    from scara_iso.iso9283 import PushResult


def push_json(found: PushResult) -> Json:
    """Return the JSON object of ``push``, schema ``scara-iso/push/1``."""
    fit = found.fit
    return {
        "schema": "scara-iso/push/1",
        "unit": "mm",
        "source": found.loop.source,
        "notes": list(found.loop.notes),
        "arm_m": found.arm_m,
        "loops": fit.loops,
        "readings": {"read": len(found.loop.force), "run_in": fit.run_in, "used": fit.readings},
        "force_N": list(fit.ends),
        "residual_mm": fit.residual,
        "misfit_mm": fit.misfit,
        "joint": _figures(found, "joint"),
        "reading": _figures(found, "reading"),
        "characteristics": to_json(tuple(map(published_characteristic, found.characteristics))),
        "limits": to_json(tuple(map(published_limit, found.limits))),
        "conformity": plain(found.conformity),
    }


def _figures(found: PushResult, of: str) -> Json | None:
    figures = {
        one.code: picked(one.estimate, "value unit u interval")
        for one in found.characteristics
        if one.of == of
    }
    return figures or None
