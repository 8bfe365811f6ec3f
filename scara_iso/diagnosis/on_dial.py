"""What the dial and heavy tails change in a choice: its evidence, and how sure a name may be.

The evidence of `evidence` takes readings for exact and scatter for Gaussian. Of each effect the
likeliest forms are compared again by `rounded`, and its evidence changed in their ratio. The
largest likelihoods of the same forms say which effects are within RIVAL_BIC of the best one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set

import numpy as np

from scara_iso.diagnosis.evidence import LARGEST_LOG, Views
from scara_iso.diagnosis.hypothesis_set import HypothesisSet
from scara_iso.diagnosis.rounded import (
    DialCourse,
    DialLikelihoods,
    course_of,
    fitted_courses,
    scatter_alone,
)
from scara_iso.diagnosis.tuning import AMPLITUDES, DIAL_FORMS, HEAVY_SHARE, RIVAL_BIC, UNKNOWN
from scara_iso.frozen import dataclass
from scara_iso.run import FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class DialReadings:
    """Residual readings (n, axes), half a division of each (n, axes), and the known scatter.

    ``known`` (axes,) is 0 where the scatter is not known; ``half`` 0 where there is no dial.
    """

    values: FloatArray
    half: FloatArray
    known: FloatArray

    def fitted(self, basis: FloatArray, courses: Sequence[DialCourse]) -> list[DialLikelihoods]:
        """Return the likelihoods of courses, then of scatter alone, for each axis."""
        every = [*courses, scatter_alone(len(self.values))]
        return [
            fitted_courses(self.values[:, a], self.half[:, a], basis, every, float(self.known[a]))
            for a in range(self.values.shape[1])
        ]


@dataclass(frozen=True, eq=False, slots=True)
class OnDial:
    """What rounding and tails change.

    ``log_change`` of each effect's evidence, and of its forms that were ``compared`` (by amplitude
    and member); ``bic`` (families,) of its best form against scatter alone, and how many
    ``numbers`` it fits; the effects with ``random`` courses; ``log_gaussian`` (axes,), the share of
    the Gaussian family in scatter alone; ``log_cycles``, the logarithm of their number.
    """

    log_change: Mapping[str, float]
    compared: Mapping[tuple[int, int], float]
    bic: Mapping[str, FloatArray]
    numbers: Mapping[str, int]
    random: Set[str]
    log_gaussian: FloatArray
    log_cycles: float

    def near(self, best: str) -> dict[str, float]:
        """Return other effects within RIVAL_BIC of the best one, and by how much they are behind.

        Under either family. One that fits more numbers comes near whatever it resembles, and must
        be so much nearer. A course of no name is a rival of random ones only.
        """
        if best not in self.bic:
            return {}
        apart = {
            name: float((value - self.bic[best]).min())
            + self.log_cycles * max(0, self.numbers[name] - self.numbers[best])
            for name, value in self.bic.items()
            if name != best and (name != UNKNOWN or best in self.random)
        }
        return {name: d for name, d in apart.items() if d <= RIVAL_BIC}


def on_dial(
    hypotheses: HypothesisSet,
    views: Views,
    log_evidence: FloatArray,
    log_bf: FloatArray,
    readings: DialReadings,
) -> OnDial:
    """Return what changes in ``log_evidence`` (amplitudes, members) of a set.

    ``log_bf`` (amplitudes, members, views) are the Bayes factors that it comes from.
    """
    top = _likeliest(hypotheses, log_evidence)
    places = [place for own in top.values() for place in own]
    larger = [hypotheses.amplified(factor) for factor, _ in AMPLITUDES]
    courses = [course_of(larger[a], i) for a, i in places]
    by_axis = readings.fitted(hypotheses.basis, courses)
    mixed = np.stack([fitted.mixed for fitted in by_axis], axis=1)
    plain = np.array([log_bf[a, i, : views.axes] for a, i in places])
    change = _together(mixed[:-1] - mixed[-1]) - _together(
        np.minimum(plain, LARGEST_LOG / views.axes)
    )
    compared = dict(zip(places, change.tolist(), strict=True))
    bic = _bic(courses, by_axis)
    numbers = [course.parameters + course.coefficients for course in courses]
    of = {name: [places.index(place) for place in own] for name, own in top.items()}
    return OnDial(
        {name: _ratio(log_evidence, own, compared) for name, own in top.items()},
        compared,
        {name: bic[own].min(axis=0) for name, own in of.items()},
        {name: max(numbers[i] for i in own) for name, own in of.items()},
        {name for name, own in of.items() if any(courses[i].random for i in own)},
        np.array([f.marginal[-1, 0] + np.log(1 - HEAVY_SHARE) - f.mixed[-1] for f in by_axis]),
        float(np.log(len(readings.values))),
    )


def _likeliest(
    hypotheses: HypothesisSet, log_evidence: FloatArray
) -> dict[str, list[tuple[int, int]]]:
    """Return amplitude and member of each effect's likeliest forms, each member once."""
    best = log_evidence.argmax(axis=0)
    top: dict[str, list[tuple[int, int]]] = {}
    for i in np.argsort(-log_evidence.max(axis=0)).tolist():
        own = top.setdefault(hypotheses.members[i].effect, [])
        if len(own) < DIAL_FORMS:
            own.append((int(best[i]), i))
    return top


def _together(log_bf: FloatArray) -> FloatArray:
    """Return log Bayes factors (c,) of single ones (c, axes), each axis taking part or not."""
    if log_bf.shape[1] == 1:
        return log_bf[:, 0]
    return np.asarray((np.logaddexp(0, log_bf) - np.log(2)).sum(axis=1))


def _ratio(
    log_evidence: FloatArray,
    own: Sequence[tuple[int, int]],
    compared: Mapping[tuple[int, int], float],
) -> float:
    before = [log_evidence[place] for place in own]
    after = [log_evidence[place] + compared[place] for place in own]
    return float(np.logaddexp.reduce(after) - np.logaddexp.reduce(before))


def _bic(courses: Sequence[DialCourse], by_axis: Sequence[DialLikelihoods]) -> FloatArray:
    """Return the BIC (courses, families) over the axes that take part, at least one.

    Of a random course the likelihood is the marginal one.
    """
    n = len(courses[0].scale)
    width = np.array([[c.coefficients] for c in courses])
    random = np.array([[c.random] for c in courses])
    gain = np.stack([
        2 * np.where(random, f.at_best[:-1] - f.at_best[-1], f.largest[:-1] - f.largest[-1])
        for f in by_axis
    ])  # fmt: skip
    gain = gain - width * np.log(n)
    least = gain.max(axis=0)
    taking_part = np.where(gain > 0, gain, 0).sum(axis=0)
    chosen = np.array([[c.parameters] for c in courses]) * np.log(n)
    return np.asarray(chosen - np.where(least > 0, taking_part, least))
