"""The JSON object of ``selftest``."""

from __future__ import annotations

import math

from scara_iso.published import Json
from scara_iso.render.json import each, picked
from scara_iso.validation import ReferenceCheck, Validation


def validation_json(found: Validation) -> Json:
    """Return the JSON object of ``selftest``, schema ``scara-iso/selftest/1``."""
    return {
        "schema": "scara-iso/selftest/1",
        "verdict": found.verdict,
        "checks": [_check(check) for check in found.checks],
        "differing": each(found.differing, "group name"),
        **picked(found.installation, "program versions platform hashes"),
    }


def _check(check: ReferenceCheck) -> Json:
    found = picked(check, "group name source expected obtained tolerance passed")
    obtained = check.obtained
    if isinstance(obtained, float) and not math.isfinite(obtained):
        found["obtained"] = str(obtained)
    return found
