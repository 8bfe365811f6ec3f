"""What every test may ask for."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the program does; before numpy

import numpy as np
import pytest
from hypothesis import settings

settings.register_profile("house", deadline=None)  # a busy machine fails no test
settings.load_profile("house")


@pytest.fixture
def rng():
    """Return a generator with a fixed seed."""
    return np.random.default_rng(20261121)
