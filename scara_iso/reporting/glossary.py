"""Words that stand on the screens and are no finding, characteristic or effect."""

from __future__ import annotations

from collections.abc import Mapping

KIND = "word of the screens"
SAME: Mapping[str, str] = {
    "eq. 2": "RP",
    "eq. 3": "RP",
    "eq. 4": "RP",
    "eq. 5": "RP",
    "eq. 6": "RP",
    "l_bar": "RP",
    "S_l": "RP",
    "repeatability": "RP",
    "7.2.2": "RP",
    "accuracy": "AP",
    "7.2.1": "AP",
    "eq. 23": "RP_rss",
    "rss": "RP_rss",
    "root sum of squares": "RP_rss",
    "three sigma": "RP_a",
    "3 s": "RP_a",
    "± 3 s": "RP_a",
    "division": "resolution",
}
"""Other names of a page, by the code of the page."""

_TEXT = """
XY, XYZ, radial
RP in a plane, or in space
RP of ISO 9283 7.2.2 with l_j the distance of visit j to the barycentre in the plane XY, or in XYZ.
The paper's figure of a plane is another, eq. 23 (RP_rss): the root of the sum of squares of the
axes' RP. Where both have a limit, the graver verdict counts.

interval, 95 % interval, confidence interval
The range that holds the true figure in 95 of 100 tests
RP of thirty cycles is an estimate, and another test of the same robot gives another. Of such
intervals, each of its own test, 95 % hold the robot's true figure. More cycles make it narrower,
about with the root of their number. A drift voids it (the finding trend says so): what is decided
by it holds only while the robot drifts likewise.

not provable, pass, fail, verdict, limit
What a limit comes to
pass: the whole 95 % interval is at most the limit. fail: all of it is above. not provable: the
limit lies in the interval, so these cycles prove neither; the answer says how many cycles would
do, where any number does. The exit code is 0 for pass, 1 for the others. With `decision=simple`
the figure alone decides, without its interval.

probability, rivals
How likely an effect is among those known
Given that something besides scatter is there, every known effect gets a probability by how well it
explains the readings. Below 90 % take it as 'or': its rivals fit nearly as well. A name is a cause
to check, no proof.

p, p value
How often chance alone would show as much
The share of random orders of the cycles (in a comparison: of random exchanges between the runs)
that differ as much as what was found. At most 0.05 is taken as shown.

nothing to explain, nothing besides scatter, explained, unexplained, found
What a diagnosis comes to
nothing to explain: the cycles could as well have come in any other order; what is too small for so
few cycles does not show, and `design=` of diagnose says how small that is. explained: there is
more than scatter, and a known effect fits it. unexplained: there is more, and nothing known fits.

held out, unseen, cycles that the model has not seen
Error on cycles that the model has not seen
The cycles are parted; the effect is chosen and fitted on some of them, and the error is taken on
the others, so that a model which only follows chance gains nothing. In the unit of the axis,
before and after the effect is in the model.

if repeated, next test, foretold
RP that another test of 30 cycles would show
What the completed model (effects, scatter and rounding) foretells for a new test; its interval
holds the RP of that one test in 95 of 100, its own sampling included.

better, worse, ratio, not shown, less, more
A change from one run to another
The figure after over the figure before, with its 95 % interval: ×0.5 is half. less, more: beyond
chance and rounding. not shown: an unchanged robot differs as much; the interval says how much may
have changed all the same.

u, uncertainty
Standard uncertainty of one reading
The dial's division over the root of twelve, and what its certificate states, combined (GUM). Twice
it, U, is 95 % of a single reading.

Cg, Cgk
Whether a dial is fine enough for a tolerance, type 1 study
Cg = 0.2 T / (6 s), with T the width of the tolerance and s the scatter of readings of one part.
Cgk = (0.1 T - |bias|) / (3 s). Both are to be 1.33 or more (Bosch booklet 10).

barycentre
The mean of the attained positions
The point from which the distances l_j of RP are taken (ISO 9283 7.2.2).
"""


def _read(text: str) -> Mapping[tuple[str, ...], tuple[str, str]]:
    entries = [entry.split("\n") for entry in text.strip().split("\n\n")]
    return {tuple(names.split(", ")): (title, " ".join(said)) for names, title, *said in entries}


WORDS = _read(_TEXT)
"""By the names of each: its title and its text."""
