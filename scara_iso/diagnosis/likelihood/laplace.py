"""Laplace's method for courses on a dial: many of them, at many scatters, at once.

About the mode of the coefficients, which Newton's steps reach, the logarithm of likelihood times
prior is taken for a parabola (Tierney and Kadane 1986). The model is that of `rounded`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from scara_iso.diagnosis.likelihood.normal import normal_cdf
from scara_iso.diagnosis.tuning import MISFIT
from scara_iso.iso9283 import median
from scara_iso.run import FloatArray, IntArray

WIDTH_OF_SHAPES = 2
"""Columns of a shape; a random course has more."""
_SCATTERS = 6
_NEWTON = 5
_SETTLED = 1e-7
"""Step, in scatters, from which the readings' likelihood is taken for that at the mode."""
_TINY = 1e-300

Distribution = Callable[[FloatArray], tuple[FloatArray, FloatArray, FloatArray]]
"""Of x: tail beyond |x|, density, and the density's slope."""


@dataclass(frozen=True, eq=False, slots=True)
class CoursesOfLikeWidth:
    """Courses of like width: design (c, n, p), prior variance of the last k columns (c, k).

    ``products`` (c, n, p p) are those of any two columns, none where these are many.
    """

    y: FloatArray
    half: FloatArray
    design: FloatArray
    products: FloatArray
    fixed: int
    variances: FloatArray
    scale: FloatArray

    def scatters(self, start: FloatArray, least: float, *, heavy: bool) -> FloatArray:
        """Return scatters to try, (courses, SCATTERS), about that of the Gaussian fit."""
        left = (self.y - (self.design @ start[..., np.newaxis])[..., 0]) / self.scale
        squares = (left**2).sum(axis=1) / (len(self.y) - self.fixed)
        size = median(np.abs(left), axis=1) * 1.3 if heavy else np.sqrt(squares)
        least = max(least, MISFIT * float(self.y.std()))
        low = np.maximum(0.45 * size, least)
        high = np.maximum(2.2 * size, 4 * least)
        part = np.linspace(0, 1, _SCATTERS)
        return np.asarray(low[:, np.newaxis] * (high / low)[:, np.newaxis] ** part)

    def start(self) -> FloatArray:
        """Return coefficients (c, p) for light tails and no dial."""
        at = self.y @ self.design
        at[:, self.fixed :] *= self.variances / (1 + self.variances)
        return np.asarray(at)

    def at(
        self,
        start: FloatArray,
        s: FloatArray,
        distribution: Distribution,
        weight: Callable[[FloatArray], FloatArray],
    ) -> tuple[FloatArray, FloatArray]:
        """Return log evidence and log likelihood (c, S) for scatters s (c, S).

        Newton's steps begin at ``start`` (c, p); a course that has settled takes none further.
        """
        wide = s[:, :, np.newaxis] * self.scale[:, np.newaxis]
        prior = np.zeros((*s.shape, self.design.shape[2]))
        prior[..., self.fixed :] = 1 / (self.variances[:, np.newaxis] * s[..., np.newaxis] ** 2)
        at = np.repeat(start[:, np.newaxis], s.shape[1], axis=1)
        log_p, curvature, least = np.empty((3, *wide.shape))
        moving: slice | IntArray = slice(None)
        for steps in range(_NEWTON + 1):
            own, scatter = self._of(moving), wide[moving]
            left = self.y - at[moving] @ np.swapaxes(own.design, 1, 2)
            log_p[moving], slope, curvature[moving] = _reading(
                left, self.half, scatter, distribution
            )
            if steps == _NEWTON:
                break
            least[moving] = 0.3 * weight(left / scatter) / scatter**2
            weighed = np.maximum(curvature[moving], least[moving])
            step = own._step(at[moving], slope, weighed, prior[moving])
            at[moving] += step
            settled = np.abs(step) < _SETTLED * s[moving, :, np.newaxis]
            still = ~settled.all(axis=(1, 2))
            if not still.any():
                break
            if not still.all():
                moving = np.arange(len(s))[moving][still]
        information = self._information(np.maximum(curvature, self._floor(least, wide)), prior)
        likelihood = log_p.sum(axis=2)
        evidence = likelihood - (prior * at**2).sum(axis=2) / 2
        evidence += np.log(prior[..., self.fixed :]).sum(axis=2) / 2
        evidence -= np.linalg.slogdet(information)[1] / 2
        return evidence, likelihood

    def _of(self, courses: slice | IntArray) -> CoursesOfLikeWidth:
        """Return the group of some of its courses, by number."""
        return replace(
            self,
            design=self.design[courses],
            products=self.products[courses],
            variances=self.variances[courses],
            scale=self.scale[courses],
        )

    def _step(
        self, at: FloatArray, slope: FloatArray, curvature: FloatArray, prior: FloatArray
    ) -> FloatArray:
        """Return Newton's step (c, S, p) by the readings' slope and curvature (c, S, n)."""
        information = self._information(curvature, prior)
        uphill = slope @ self.design - prior * at
        return np.asarray(np.linalg.solve(information, uphill[..., np.newaxis])[..., 0])

    def _floor(self, least: FloatArray, wide: FloatArray) -> FloatArray:
        """Return the curvature of a reading that is taken at least, ``least`` the one on the way.

        A random course moves each reading by itself, and within its division d it is as likely
        anywhere: a box of the width and height that a Gaussian of variance d^2 / (2 pi) has too.
        """
        if self.variances.shape[1] <= WIDTH_OF_SHAPES:
            return 0.03 * least
        return least / 0.3 / (1 + (2 * self.half / wide) ** 2 / (2 * np.pi))

    def _information(self, curvature: FloatArray, prior: FloatArray) -> FloatArray:
        if self.products.size:
            information = (curvature @ self.products).reshape(*prior.shape, -1)
        else:
            turned = np.swapaxes(self.design, 1, 2)[:, np.newaxis]
            information = (turned * curvature[:, :, np.newaxis]) @ self.design[:, np.newaxis]
        return np.asarray(information + prior[..., np.newaxis] * np.eye(prior.shape[-1]))


def _reading(
    left: FloatArray, half: FloatArray, wide: FloatArray, distribution: Distribution
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return log likelihood of each reading, its slope in the mean, and minus its curvature.

    ``left`` is how far it is from the mean, ``wide`` its scatter.
    """
    a, b = (left - half) / wide, (left + half) / wide
    tail_a, fa, slope_a = distribution(a)
    tail_b, fb, slope_b = distribution(b)
    across = (a < 0) & (b > 0)
    p = np.maximum(np.where(across, 1 - tail_a - tail_b, np.abs(tail_a - tail_b)), _TINY)
    scale = p * wide
    slope = (fa - fb) / scale
    return np.log(p), slope, slope**2 - (slope_b - slope_a) / (scale * wide)


def _gaussian(x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    density = np.exp(-0.5 * x**2) / np.sqrt(2 * np.pi)
    return normal_cdf(-np.abs(x)), density, -x * density


def _student(x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return Student's t with 4 degrees of freedom in closed form."""
    u = 1 / (1 + x**2 / 4)
    root = np.sqrt(u)
    at = np.abs(x) * root
    density = 0.375 * u**2 * root
    return 0.5 - 0.375 * at * (1 - at**2 / 12), density, -1.25 * x * u * density


def _even(x: FloatArray) -> FloatArray:
    return np.ones_like(x)


def _heavy(x: FloatArray) -> FloatArray:
    return np.asarray(1.25 / (1 + x**2 / 4))


FAMILIES: tuple[tuple[Distribution, Callable[[FloatArray], FloatArray]], ...] = (
    (_gaussian, _even),
    (_student, _heavy),
)
