"""The reading was taken before the arm had come to rest.

The stabilisation time is measured first: it fixes how long the arm stands at a pose before its
reading. State both, ``# dwell: 2 s`` and ``# stabilisation_time: 0.8 s``, to have them compared.
"""

from __future__ import annotations

from collections.abc import Iterator

from scara_iso.iso9283.checks._stated import SECONDS, first
from scara_iso.iso9283.results import Finding, Measured

CODE = "short-dwell"
BRIEF = "read before at rest"
_DWELL = {"dwell", "dwell_s", "dwell_time", "dwell_time_s"}
_NEEDED = {
    "stabilisation_time",
    "stabilisation_time_s",
    "stabilization_time",
    "stabilization_time_s",
    "settling_time",
    "settling_time_s",
}
_RULE = "ISO 9283 6.10: the stabilisation time fixes the dwell"


def check(measured: Measured) -> Iterator[Finding]:
    """Yield a warning for a dwell shorter than the stabilisation time that is stated."""
    dwell, needed = first(measured.run, _DWELL), first(measured.run, _NEEDED)
    for line in (dwell, needed):
        if line is not None and line.value(SECONDS) is None:
            yield Finding(
                CODE, "info", f"{line}: no time that can be compared", advice="write 0.8 s"
            )
    if dwell is None or needed is None:
        return
    stood, least = dwell.value(SECONDS), needed.value(SECONDS)
    if stood is not None and least is not None and stood < least:
        yield Finding(CODE, "warning", f"{dwell} is shorter than {needed}", rule=_RULE)
