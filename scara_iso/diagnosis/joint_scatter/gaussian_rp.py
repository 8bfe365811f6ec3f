"""RP that Gaussian scatter in the plane has in a test of n cycles: 7.2.2 by the law of distances.

A position in the plane is rho (cos phi, sin phi) stretched by the two standard deviations a and b:
rho is Rayleigh distributed, phi uniform, and the moments of the distance are those of rho times
those of sqrt(a2 cos2 phi + b2 sin2 phi).
"""

from __future__ import annotations

import math

import numpy as np

from scara_iso.run import FloatArray

_ANGLES = 24
_RAYLEIGH = (math.sqrt(math.pi / 2), 2.0, 3 * math.sqrt(math.pi / 2), 8.0)
"""Moments of rho: 1st to 4th."""
_TINY = 1e-60


def gaussian_rp(covariance: FloatArray, n: int) -> tuple[FloatArray, FloatArray]:
    """Return expected RP (...) and its relative standard error in one test of n cycles.

    ``covariance`` (..., 2, 2) is that of X and Y, in mm2; RP is in mm. The expectation is right to
    1 % from eight cycles on, the error, of the influence function, as n grows.
    """
    about_barycentre = (1 - 1 / n) * covariance
    mean, second, third, fourth = _moments(about_barycentre)
    variance = second - mean**2
    sd = np.sqrt(variance)
    skewness = (third - 3 * mean * second + 2 * mean**3) / sd**3
    kurtosis = (fourth - 4 * mean * third + 6 * mean**2 * second - 3 * mean**4) / sd**4
    S_l = sd * (1 - (kurtosis - 1 + 2 / (n - 1)) / (8 * n))  # second order of E sqrt(S_l^2)
    RP = mean + 3 * S_l
    influence = 1 + 3 * skewness + 2.25 * (kurtosis - 1)
    return RP, sd * np.sqrt(influence / (n - 1)) / RP


def _moments(covariance: FloatArray) -> tuple[FloatArray, ...]:
    """Return the 1st to the 4th moment (...) of the distance from the mean."""
    node, weight = np.polynomial.legendre.leggauss(_ANGLES)
    phi = (node + 1) * math.pi / 4
    b, a = np.moveaxis(np.linalg.eigvalsh(covariance), -1, 0)[..., np.newaxis]
    stretch = np.sqrt(np.maximum(a * np.cos(phi) ** 2 + b * np.sin(phi) ** 2, _TINY))
    return tuple(rho * stretch**power @ weight / 2 for power, rho in enumerate(_RAYLEIGH, start=1))
