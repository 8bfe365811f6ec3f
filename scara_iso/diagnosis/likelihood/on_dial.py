"""What the dial and heavy tails change in a choice: its evidence, and how sure a name may be.

The evidence of `evidence` takes readings for exact and scatter for Gaussian. Of each effect the
likeliest forms are compared again by `rounded`, and its evidence changed in their ratio. The
largest likelihoods of the same forms say which effects are within RIVAL_BIC of the best one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from scara_iso.diagnosis.likelihood.evidence import LARGEST_LOG, Views
from scara_iso.diagnosis.likelihood.hypothesis_set import HypothesisSet
from scara_iso.diagnosis.likelihood.rounded import (
    DialCourse,
    DialLikelihoods,
    course_of,
    fitted_courses,
    scatter_alone,
)
from scara_iso.diagnosis.tuning import (
    ALIKE,
    AMPLITUDES,
    DIAL_FORMS,
    FEWEST_MOVED,
    HEAVY_SHARE,
    LEAST_OF_RIVALS,
    LEAST_ON_DIAL,
    NEIGHBOURS,
    RIVAL_BIC,
    RIVAL_BIC_OF_NEIGHBOURS,
    UNKNOWN,
)
from scara_iso.effects import Shape
from scara_iso.run import FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class DialReadings:
    """Residual readings (n, axes), half a division of each (n, axes), and the known scatter.

    ``known`` (axes,) is 0 where the scatter is not known; ``half`` 0 where there is no dial.
    """

    values: FloatArray
    half: FloatArray
    known: FloatArray

    def fitted(
        self, basis: FloatArray, courses: Sequence[DialCourse], least: float = LEAST_ON_DIAL
    ) -> list[DialLikelihoods]:
        """Return the likelihoods of courses, then of scatter alone, for each axis."""
        every = [*courses, scatter_alone(len(self.values))]
        return [
            fitted_courses(
                self.values[:, a], self.half[:, a], basis, every, float(self.known[a]), least
            )
            for a in range(self.values.shape[1])
        ]


@dataclass(frozen=True, eq=False, slots=True)
class Seen:
    """A course of an effect, and its BIC (families,) against scatter alone."""

    effect: str
    course: DialCourse
    bic: FloatArray

    def numbers_beyond(self, other: Seen) -> float:
        """Return how many numbers more it fits than one that it resembles, else 0."""
        if self.course.random or other.course.random:
            return 0
        shared = self.course.columns.T @ other.course.columns
        if not shared.size or np.linalg.norm(shared, 2) < ALIKE:
            return 0
        return max(0.0, self.course.numbers - other.course.numbers)

    def passes_for_any(self, other: Seen) -> bool:
        """Return whether it is a random course of no name, and chance has not drawn ``other``."""
        drawn = other.course.random or other.course.hidden
        return self.effect == UNKNOWN and self.course.random and not drawn

    def of_gross_ones(self, other: Seen) -> bool:
        """Return whether it moves a few readings as one, and ``other`` fewer of the same."""
        mine, theirs = self.course.moved, other.course.moved
        as_one = self.course.coefficients < mine.sum() < FEWEST_MOVED
        return bool(as_one and 0 < theirs.sum() < mine.sum() and (theirs <= mine).all())


@dataclass(frozen=True, eq=False, slots=True)
class OnDial:
    """What rounding and tails change.

    ``log_change`` of each effect's evidence, and of its forms that were ``compared`` (by amplitude
    and member); what was ``seen``; ``log_gaussian`` (axes,), the share of the Gaussian family in
    scatter alone; ``log_cycles``, the logarithm of their number.
    """

    log_change: Mapping[str, float]
    compared: Mapping[tuple[int, int], float]
    seen: Sequence[Seen]
    log_gaussian: FloatArray
    readings: DialReadings
    basis: FloatArray

    def near(self, best: str, finer: Sequence[tuple[str, DialCourse]] = ()) -> dict[str, float]:
        """Return other effects near the best one in BIC, and by how much they are behind.

        Under either family; ``finer`` are shapes of effects between those that were seen. A course
        that resembles the best and fits more numbers comes near whatever is true, and must be so
        much nearer. A random course of no name is a rival of what chance has drawn only, one of
        several levels of all. Where the best moves fewer readings than FEWEST_MOVED, what moves
        one of them is near: they may be gross, one by one.
        """
        seen = self._freely_fitted(finer)
        own = [one for one in seen if one.effect == best]
        if not own:
            return {}
        number = float(np.log(len(self.basis)))
        mine = min(own, key=lambda one: float(one.bic.min()))
        least = np.min([one.bic for one in own], axis=0)
        likely = [one for one in own if (one.bic - least).min() <= RIVAL_BIC]
        apart: dict[str, float] = {}
        for one in seen:
            if one.effect == best or one.passes_for_any(mine):
                continue
            d = float((one.bic - least).min()) + number * one.numbers_beyond(mine)
            if any(form.of_gross_ones(one) for form in likely):
                d = min(d, RIVAL_BIC)
            apart[one.effect] = min(d, apart.get(one.effect, np.inf))
        return {name: d for name, d in apart.items() if d <= self._within()}

    def _within(self) -> float:
        """Return the distance of near rivals: farther where all readings are neighbours."""
        across, division = np.ptp(self.readings.values, axis=0), 2 * self.readings.half.max(axis=0)
        neighbours = bool(np.all(across < NEIGHBOURS * division))
        return RIVAL_BIC_OF_NEIGHBOURS if neighbours else RIVAL_BIC

    def _freely_fitted(self, finer: Sequence[tuple[str, DialCourse]]) -> list[Seen]:
        """Return what was seen, the shapes as large, and their scatter as small, as may be."""
        shapes = [one for one in self.seen if one.course.coefficients]
        shapes += [Seen(name, course, np.zeros(2)) for name, course in finer]
        if not shapes:
            return list(self.seen)
        free = [one.course.as_large_as_may_be for one in shapes]
        bic = _bic(free, self.readings.fitted(self.basis, free, LEAST_OF_RIVALS))
        others = [one for one in self.seen if not one.course.coefficients]
        return others + [replace(one, bic=b) for one, b in zip(shapes, bic, strict=True)]


def on_dial(
    hypotheses: HypothesisSet,
    views: Views,
    log_evidence: FloatArray,
    log_bf: FloatArray,
    readings: DialReadings,
    beside: Sequence[tuple[str, DialCourse]] = (),
) -> OnDial:
    """Return what changes in ``log_evidence`` (amplitudes, members) of a set.

    ``log_bf`` (amplitudes, members, views) are the Bayes factors that it comes from; ``beside`` are
    courses of effects that are no members, which may be near as well.
    """
    top = _likeliest(hypotheses, log_evidence)
    places = [place for own in top.values() for place in own]
    larger = [hypotheses.amplified(factor) for factor, _ in AMPLITUDES]
    courses = [course_of(larger[a], i) for a, i in places] + [course for _, course in beside]
    by_axis = readings.fitted(hypotheses.basis, courses)
    mixed = np.stack([fitted.mixed for fitted in by_axis], axis=1)
    mixed = mixed[[*range(len(places)), -1]]
    plain = np.array([log_bf[a, i, : views.axes] for a, i in places])
    change = _together(mixed[:-1] - mixed[-1]) - _together(
        np.minimum(plain, LARGEST_LOG / views.axes)
    )
    compared = dict(zip(places, change.tolist(), strict=True))
    effects = [hypotheses.members[i].effect for _, i in places] + [name for name, _ in beside]
    return OnDial(
        {name: _ratio(log_evidence, own, compared) for name, own in top.items()},
        compared,
        [Seen(*one) for one in zip(effects, courses, _bic(courses, by_axis), strict=True)],
        np.array([f.marginal[-1, 0] + np.log(1 - HEAVY_SHARE) - f.mixed[-1] for f in by_axis]),
        readings,
        hypotheses.basis,
    )


def _likeliest(
    hypotheses: HypothesisSet, log_evidence: FloatArray
) -> dict[str, list[tuple[int, int]]]:
    """Return amplitude and member of each effect's likeliest forms, each member once.

    Of no name, the likeliest shape is among them.
    """
    best = log_evidence.argmax(axis=0)
    top: dict[str, list[tuple[int, int]]] = {}
    shaped = False
    for i in np.argsort(-log_evidence.max(axis=0), kind="stable").tolist():
        member = hypotheses.members[i]
        first = not shaped and member.effect == UNKNOWN and isinstance(member.form, Shape)
        own = top.setdefault(member.effect, [])
        if first or len(own) < DIAL_FORMS:
            own.append((int(best[i]), i))
        shaped = shaped or first
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
    gain = np.stack(
        [
            2 * np.where(random, f.at_best[:-1] - f.at_best[-1], f.largest[:-1] - f.largest[-1])
            for f in by_axis
        ]
    )
    gain = gain - width * np.log(n)
    least = gain.max(axis=0)
    taking_part = np.where(gain > 0, gain, 0).sum(axis=0)
    chosen = np.array([[c.parameters] for c in courses]) * np.log(n)
    return np.asarray(chosen - np.where(least > 0, taking_part, least))
