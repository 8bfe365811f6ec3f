"""Time until a drift test is steady: when a tenth of the drift is left.

The means of the blocks of all axes that are lengths are fitted together as a limit plus an
exponential with one time constant; after 2.303 time constants a tenth of its way is left, and a
tenth of its first rate. This is this tool's criterion: the standard ends the test after 8 h, or
when the drift has become steady. Time counts from the first visit of the table. Given only where
the drift is more than chance and the whole of the time lies within the test; its interval is that
of the profile likelihood of the time constant (divide by 2.303 for the constant itself), and holds
for a drift that is one exponential.
"""

from scara_iso.base.quantities import Estimate
from scara_iso.iso9283.core.results import Characteristic, Characteristics, Measured

CODE = "steady_after"
CLAUSE = "7.6"
NEEDS = (
    "a drift test with times, six blocks or more, that moves by more than chance and goes on "
    "until it is steady"
)


def compute(test: Measured) -> Characteristics:
    """Yield it for each pose of a drift test that comes to rest."""
    for course in test.drift or ():
        fit = course.fit
        if fit is None or fit.steady_interval_h is None or not fit.steady:
            continue
        low, high = ends = fit.steady_interval_h
        u, blocks = (high - low) / 4, len(course.visits)
        estimate = Estimate(fit.steady_after_h, "h", u, {"sampling": u}, ends, blocks, CLAUSE)
        yield Characteristic(CODE, course.pose.label, "".join(fit.axes), estimate, counted="blocks")
