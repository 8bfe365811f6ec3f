"""The reading was taken before the arm had come to rest.

The stabilisation time is measured first: it fixes how long the arm stands at a pose before its
reading. State both, ``# dwell: 2 s`` and ``# stabilisation_time: 0.8 s``, to have them compared.
"""

from scara_iso.iso9283.checks._stated import SECONDS, first
from scara_iso.iso9283.core.results import Finding, Findings, Measured

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


def check(measured: Measured) -> Findings:
    """Yield a warning for a dwell shorter than the stabilisation time that is stated."""
    lines = [first(measured.run, keys) for keys in (_DWELL, _NEEDED)]
    times = [None if line is None else line.value(SECONDS) for line in lines]
    for line, time in zip(lines, times, strict=True):
        if line is not None and time is None:
            yield line.unclear(CODE, "time", "0.8 s")
    stood, least = times
    if stood is not None and least is not None and stood < least:
        dwell, needed = lines
        yield Finding(CODE, "warning", f"{dwell} is shorter than {needed}", rule=_RULE)
