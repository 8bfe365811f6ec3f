"""RP and +/- 3 s of many samples at once, each with the standard error of its logarithm."""

from __future__ import annotations

import math

import numpy as np

from scara_iso.iso9283 import GAUSSIAN_ERROR, repeatability, standard_deviation
from scara_iso.run import FloatArray

_TINY = np.finfo(np.float64).tiny


def spread(positions: FloatArray, *, angle: bool) -> tuple[FloatArray, FloatArray]:
    """Return the figure and the standard error of its logarithm; shapes as the samples in front.

    ``positions`` of shape (..., components, n). The figure is RP = l_bar + 3 S_l (paper eq. 2-6,
    ISO 9283 7.2.2), of an ``angle`` +/- 3 s (7.2.2). The sources give no standard error; this is
    the infinitesimal jackknife's, and never smaller than that of Gaussian scatter.
    """
    if angle:
        figure = 3 * standard_deviation(positions[..., 0, :])
        influence = _influence_of_deviation(positions)
        gaussian = math.sqrt(0.5)
    else:
        figure = repeatability(positions).RP
        influence = _influence_of_repeatability(positions)
        gaussian = GAUSSIAN_ERROR[positions.shape[-2]]
    n = positions.shape[-1]
    error = np.sqrt((influence**2).sum(axis=-1) / (n * (n - 1)))
    return figure, np.maximum(error / np.maximum(figure, _TINY), gaussian / math.sqrt(n))


def _influence_of_deviation(positions: FloatArray) -> FloatArray:
    squares = _centred(positions)[..., 0, :] ** 2
    variance = squares.mean(axis=-1, keepdims=True)
    return np.asarray(3 * (squares - variance) / (2 * np.sqrt(np.maximum(variance, _TINY))))


def _influence_of_repeatability(positions: FloatArray) -> FloatArray:
    """Return what each cycle adds to RP: through l_bar, through S_l, and through the barycentre."""
    offset = _centred(positions)
    distance = np.sqrt((offset**2).sum(axis=-2))
    from_mean = distance - distance.mean(axis=-1, keepdims=True)
    variance = (from_mean**2).mean(axis=-1, keepdims=True)
    S_l = np.sqrt(np.maximum(variance, _TINY))
    direction = (offset / np.maximum(distance, _TINY)[..., np.newaxis, :]).mean(axis=-1)
    along = (direction[..., np.newaxis] * offset).sum(axis=-2)
    l_bar = distance.mean(axis=-1, keepdims=True)
    # d RP / d barycentre = (3 l_bar / S_l - 1) times the mean unit vector
    pull = np.where(variance > 0, 3 * l_bar / S_l - 1, 0.0) * along
    return np.asarray(from_mean + 3 * (from_mean**2 - variance) / (2 * S_l) + pull)


def _centred(positions: FloatArray) -> FloatArray:
    shifted = positions - positions[..., :1]
    return np.asarray(shifted - shifted.mean(axis=-1, keepdims=True))
