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
from robots import close_all

from scara_iso.base.errors import ScaraIsoError
from scara_iso.commands import main
from scara_iso.diagnosis import closed_loop, planning, poses
from scara_iso.render.formats import html, xlsx

# no deadline: a busy machine fails no test
settings.register_profile("whole", deadline=None, max_examples=WHOLE)  # of .ci/run
settings.register_profile("quick", deadline=None, max_examples=WHOLE // 4)
settings.load_profile("quick")


def pytest_xdist_auto_num_workers():
    """Return one worker more than cores: tests wait for processes and ports."""
    return (os.cpu_count() or 1) + 1


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


@pytest.fixture(autouse=True, scope="session")
def no_wait_for_the_platter():
    """Let a sync check its file and not wait: what is lost without it no test of one machine sees.

    tests/support/disks.py logs each sync, and plays what a power cut leaves.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(os, "fsync", os.fstat)
        yield


OF_VALUES = {  # modules that refuse values: their caller, or the signature, says what to do
    "base.quantities", "commands.app", "commands.operator.guide", "diagnosis.engine.residual",
    "rawfile.records", "recorder.indicators._grammar", "recorder.indicators.generic", "robot.arm",
    "run.runs",
}  # fmt: skip


@pytest.fixture(autouse=True, scope="session")
def every_error_says_what_to_do():
    """Fail where the package raises an error of its own without a remedy."""
    made = ScaraIsoError.__init__

    def say(self, what, **options):
        frame = sys._getframe(1)
        while frame.f_globals["__name__"] == ScaraIsoError.__module__:
            frame = frame.f_back
        by = frame.f_globals["__name__"]
        of_value = by.removeprefix("scara_iso.") in {by, *OF_VALUES}
        assert options.get("remedy") or of_value, f"{by}: {what!r}, and what is to be done?"
        made(self, what, **options)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ScaraIsoError, "__init__", say)
        yield


@pytest.fixture
def folder(tmp_path_factory):
    """Return a folder whose name, which messages repeat, says nothing of the case."""
    return tmp_path_factory.mktemp("t")


@pytest.fixture
def call(capsys):
    """Return a function that runs the command and gives exit code, output and errors."""

    def run(*argv):
        code = main([str(word) for word in argv])
        return code, *capsys.readouterr()

    return run


@pytest.fixture
def closed():
    """Close every line of a simulated controller behind a test."""
    yield
    close_all()


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
