"""The robot was not warmed up before the test.

Gears and motors warm up over the first hour or so, and the arm drifts meanwhile: RP then counts the
drift as scatter. State ``# warm_up: 30 min``; the drift itself is another characteristic (7.6).
"""

from scara_iso.iso9283.checks._stated import SECONDS, stated
from scara_iso.iso9283.core.results import Finding, Findings, Measured

CODE = "cold-start"
BRIEF = "cold robot"
_WARM_UP = {"warm_up", "warm_up_min", "warm_up_time"}
_RULE = "good practice (no clause verified): the robot is warmed up, but for the drift test"


def check(measured: Measured) -> Findings:
    """Yield a warning where it is stated that there was no warm-up, but for a drift test."""
    head = {} if measured.block is not None else measured.run.metadata
    for line in stated(head, _WARM_UP):
        time = line.value(SECONDS)
        if time is None:
            yield line.unclear(CODE, "time", "30 min")
        elif time == 0:
            yield Finding(CODE, "warning", f"{line}: a cold robot drifts", rule=_RULE)
