"""The recording was stopped before its planned end.

Whoever stops a test when the readings look good, or bad, chooses the result. Fewer cycles than
planned are not a test by ISO 9283. ``resume=True`` of record completes it; if fixture, robot or
indicator had to be touched, start again. Where the raw file holds more, ``rebuild=`` takes it.
"""

from scara_iso.iso9283.checks._stated import noted
from scara_iso.iso9283.core.results import Finding, Findings, Measured
from scara_iso.rawfile import LEFT_OUT

CODE = "stopped-early"
BRIEF = "stopped early"


def check(measured: Measured) -> Findings:
    """Yield a warning where more cycles were planned, or are in the raw file, than are there."""
    metadata = measured.run.metadata
    yield from (Finding(CODE, "warning", line) for line in noted(measured.run, LEFT_OUT))
    planned = "" if LEFT_OUT in metadata else metadata.get("cycles_planned", "").strip()
    last = int(measured.run.cycle.max())
    if planned.isdecimal() and len(planned) < 9 and last < int(planned):
        what = (
            f"stopped after {last} of {int(planned)} planned cycles: this is not an ISO 9283 test"
        )
        yield Finding(CODE, "warning", what, rule="ISO 9283 6.9: 30 cycles, as planned")
