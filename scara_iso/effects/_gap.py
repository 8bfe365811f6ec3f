"""The load deviation at a reversal, which the gear effects change."""

import numpy as np

from scara_iso.run import FloatArray


def deviation(I_m: FloatArray, I_L: FloatArray, gap: FloatArray) -> FloatArray:
    """Return the load deviation in rad, shape (m,): -2D / (1 + I_L / I_m), paper eq. 16."""
    return np.asarray(-gap * I_m / (I_m + I_L))
