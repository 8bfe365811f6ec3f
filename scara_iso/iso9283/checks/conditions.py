"""Conditions of the test that the table does not state.

ISO 9283 has load, velocity and ambient conditions stated in the report and held constant during
a test; a figure without its instrument and its calibration cannot be traced. Add them as
``# key: value`` lines at the head of the table, or in the test.toml of a test's folder. What is
stated is compared with rated values and limits by `other-load`, `other-velocity`,
`temperature-limits`, `short-dwell`, `calibration-date`.
"""

from __future__ import annotations

from collections.abc import Iterator

from scara_iso.iso9283.checks._stated import is_said
from scara_iso.iso9283.results import Finding, Measured

CODE = "not-stated"
_CONDITIONS = {
    "load": {"payload", "load", "payload_kg", "load_kg", "payload_percent", "load_percent"},
    "velocity": {"velocity", "speed", "velocity_mm_s", "speed_mm_s", "velocity_percent"},
    "ambient temperature": {"temperature", "temperature_c", "ambient_temperature"},
    "instrument": {"indicator", "instrument", "dial"},
}


def check(measured: Measured) -> Iterator[Finding]:
    """Yield one note that lists what is not stated."""
    run = measured.run
    lines = {key.lower().partition("[")[0]: text for key, text in run.metadata.items()}
    stated = {key for key, text in lines.items() if is_said(text)}
    stated |= {name.lower() for name in run.covariates}
    missing = [condition for condition, keys in _CONDITIONS.items() if not keys & stated]
    missing += [
        k.replace("_", " ") for k, text in lines.items() if text.strip() and k not in stated
    ]
    if missing:
        yield Finding(
            CODE,
            "info",
            f"not stated: {', '.join(missing)}",
            rule="ISO 9283 6.2, 6.3: conditions are stated",
            advice="add '# key: value' lines to the table's head",
        )
