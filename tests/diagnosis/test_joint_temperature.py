"""A drift that the temperature of one joint explains names that joint, beside other effects too."""

import numpy as np
import pytest

from scara_iso import diagnose
from scara_iso.commands import main
from scara_iso.run import Axis, Run


def table(poses):
    chance, cycles = np.random.default_rng(3), np.arange(31)
    warm = 25 + 3 * np.sin(cycles / 4) + chance.normal(0, 0.1, 31)
    other = 24 + chance.normal(0, 0.3, 31)
    lines = ["# unit: mm", f"cycle,{'pose,' * (len(poses) > 1)}X,time_s,T1_C,T2_C"]
    for k in cycles:
        for at, (pose, slope) in enumerate(poses.items()):
            name = f"{pose}," * (len(poses) > 1)
            reading = slope * (warm[k] - 25) + chance.normal(0, 0.003)
            time = 90 * k + 30 * at
            lines.append(f"{k + 1},{name}{reading:.3f},{time},{warm[k]:.1f},{other[k]:.1f}")
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("poses", [{"P1": 0.006}, {"P1": 0.004, "P2": 0.006, "P3": 0.005}])
def test_the_joint_whose_temperature_explains_a_drift_is_named(poses, tmp_path, capsys):
    path = tmp_path / "run.csv"
    path.write_text(table(poses))
    assert main(["diagnose", str(path)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "Found: covariate" in said
    assert "column T1_C (temperature of joint 1)" in said
    assert "T2_C" not in said


@pytest.mark.slow
@pytest.mark.parametrize(
    ("other", "course"),
    [("step", lambda j: 0.02 * (j > 12) + 0.02 * np.sin(j / 7)),
     ("step", lambda j: 0.02 * (j > 28) + 0.012 * np.sin(j / 7)),
     ("linear_drift", lambda j: 0.00075 * j + 0.016 * np.sin(j / 7))],
)  # fmt: skip
def test_a_recorded_column_and_another_effect_are_no_third_one(other, course):
    j, right = np.arange(40), 0
    for seed in range(4):
        rng = np.random.default_rng(seed)
        readings = {n: s * course(j) + rng.normal(0, 0.003, 40) for n, s in (("X", 1), ("Y", 0.5))}
        axes = {n: Axis(n, x.round(3), resolution=0.001) for n, x in readings.items()}
        run = Run(j + 1, axes, covariates={"temperature_C": 20 + 2 * np.sin(j / 7)})
        found = [one.effect for one in diagnose(run, cycles=40, all_count=True).effects]
        right += sorted(found) == sorted(["temperature", other])
    assert right >= 3
