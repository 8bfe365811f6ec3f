"""The recording was stopped before its planned end.

Whoever stops a test when the readings look good, or bad, chooses the result. Fewer cycles than
planned are not a test by ISO 9283. ``resume=True`` of record completes it; if fixture, robot or
indicator had to be touched, start again.
"""

from scara_iso.iso9283.results import Finding, Findings, Measured
from scara_iso.rawfile import LEFT_OUT

CODE = "stopped-early"
BRIEF = "stopped early"


def check(measured: Measured) -> Findings:
    """Yield a warning where the recorder wrote that more cycles were planned than are there."""
    planned = measured.run.metadata.get("cycles_planned", "").strip()
    last = int(measured.run.cycle.max())
    outgrown = LEFT_OUT in measured.run.metadata  # it went on behind the table
    if not outgrown and planned.isdecimal() and len(planned) < 9 and last < int(planned):
        what = (
            f"stopped after {last} of {int(planned)} planned cycles: this is not an ISO 9283 test"
        )
        yield Finding(CODE, "warning", what, rule="ISO 9283 6.9: 30 cycles, as planned")
