"""What every test may ask for."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the program does; before numpy

import numpy as np
import pytest
from budget import WHOLE
from hypothesis import settings
from once import once

from scara_iso.diagnosis import closed_loop, poses
from scara_iso.diagnosis.next_test import planning
from scara_iso.render.formats import html, xlsx

# no deadline: a busy machine fails no test
settings.register_profile("whole", deadline=None, max_examples=WHOLE)  # of .ci/run
settings.register_profile("quick", deadline=None, max_examples=WHOLE // 4)
settings.load_profile("quick")


@pytest.fixture
def rng():
    """Return a generator with a fixed seed."""
    return np.random.default_rng(20261121)


@pytest.fixture(autouse=True, scope="session")
def each_diagnosis_and_picture_once():
    """Compute what is costly once, however many tests look at what is shown of it."""
    costly = [
        (closed_loop, "diagnose_readings"), (poses, "diagnose_poses"),
        (planning, "smallest_effects"), (html, "picture"), (xlsx, "picture_png"),
    ]  # fmt: skip
    with pytest.MonkeyPatch.context() as patch:
        for module, name in costly:
            patch.setattr(module, name, once(getattr(module, name)))
        yield
