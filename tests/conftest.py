"""What every test may ask for."""

import os
import subprocess
import sys
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the program does; before numpy

import numpy as np
import pytest
from budget import WHOLE
from hypothesis import settings
from once import once

from scara_iso.diagnosis import closed_loop, planning, poses
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


SIMULATOR = Path(__file__).parent / "support" / "simulator.py"


@pytest.fixture
def instrument():
    """Return a function that starts an instrument and returns its device."""
    processes = []

    def start(*answers):
        process = subprocess.Popen(
            [sys.executable, SIMULATOR, *answers], stdout=subprocess.PIPE, text=True
        )
        processes.append(process)
        return process.stdout.readline().strip()

    yield start
    for process in processes:
        process.kill()
        process.wait()
        process.stdout.close()
