"""The judge of benchmarks/study knows causes that are known, and what came next counts."""

import numpy as np
import pytest

from benchmarks.study import mounts, tables
from benchmarks.study.judge import NOTHING, judged
from benchmarks.study.trial import FALSE, table
from benchmarks.study.windows import repeatability
from scara_iso import Run, analyze
from scara_iso.run import Axis

CLEAR = [cause for cause in FALSE if cause not in (NOTHING, "random_walk", "autocorrelated")]


@pytest.mark.parametrize("cause", CLEAR)
def test_a_cause_is_known_by_its_name_and_by_no_other(cause):
    y, z = table(cause, 2.0, np.random.default_rng(5))
    assert judged(cause, y, z).verdict == "right"
    assert judged(FALSE[cause], y, z).verdict != "right"
    assert judged(NOTHING, y, z).verdict == "wrong"


def test_scatter_alone_is_nothing_and_goes_on(rng):
    y, z = np.rint(rng.normal(0, 1.5, (2, 30)))
    alone = judged(NOTHING, y, z)
    assert alone.verdict != "wrong"
    assert alone.goes_on
    assert judged("contact_side", y, z).verdict != "right"


def test_the_readings_that_come_next_decide_between_a_step_and_a_bump(rng):
    """Three readings of another level at the end of a test may be either."""
    y = np.rint(rng.normal(0, 1, 30) + 8 * (np.arange(30) >= 27))
    stays, returns = (np.rint(level + rng.normal(0, 1, 30)) for level in (8, 0))
    assert judged("step", y, stays).goes_on
    assert not judged("step", y, returns).goes_on
    assert judged("step", y, returns).verdict != "right"


@pytest.mark.slow
def test_a_sine_keeps_its_phase_from_a_short_test_through_the_next_readings(rng):
    """Large against its scatter, as NIST's Lew: a period off by a hundredth would show."""
    for period in rng.uniform(2.4, 12, 12):
        sine = 8 * np.sin(2 * np.pi * (np.arange(50) / period + rng.random()))
        y, z = np.split(np.rint(50 * (sine + rng.normal(0, 1, 50))), [20])
        assert judged("periodic", y, z).verdict == "right"


def test_an_effect_without_a_course_is_not_judged(rng):
    assert judged("temperature", *rng.normal(0, 1, (2, 30))).verdict == "unjudged"


def test_rp_of_the_study_is_that_of_the_program(rng):
    y = rng.normal(0, 0.01, 30)
    run = Run(np.arange(2, 32), {"Z": Axis("Z", y, resolution=0.001)})
    assert repeatability(y) == pytest.approx(analyze(run).poses[0].axes["Z"].RP)


def test_wilsons_interval_is_that_of_his_paper():
    """Of 263 patients 81: Newcombe 1998, table I, method 3."""
    assert tables.wilson(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)


def test_repeatability_of_a_mount_by_the_makers_definition_is_the_makers():
    one = mounts.mount(mounts.FOLDER / "pancake-direct.csv")
    _, _, published, u = mounts.PUBLISHED[one.name]
    assert mounts.inner(one) * 1e6 == pytest.approx(published, abs=u)
