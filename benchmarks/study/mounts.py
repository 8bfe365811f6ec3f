"""Lost motion of six motorized mirror mounts at each target, beside the makers' published figures.

Data and licence: benchmarks/data/mirror_mounts. Each mount goes over its travel five times up and
down; a light spot's place on a detector is read at every target. The angle follows from the fit of
the detector's curve (an inverse error function) to the input, as the makers do; the rest is
`analyze` of a table with a pose for each target and the direction of arrival: RP from either side
(ISO 9283 7.2.2) and vAP (7.2.3), the distance of the two means.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import curve_fit
from scipy.special import erfinv

from benchmarks.study.courses import Array
from benchmarks.study.windows import answer

FOLDER = Path(__file__).parents[1] / "data" / "mirror_mounts"
RANGE, TARGETS, DIVISION = 0.025, 40, 1e-6
"""Half the makers' range [deg], targets looked at, the division stated [deg]."""
PUBLISHED = {
    "cheap-geared": (2763, 116, 490, 19), "cheap-direct": (4420, 590, 2014, 131),
    "pancake-geared": (1620, 768, 1144, 25), "pancake-direct": (1543, 170, 614, 21),
    "newport-dc": (10692, 105, 534, 18), "newport-stepper": (10049, 63, 441, 17),
}  # fmt: skip
"""Backlash and unidirectional repeatability with their 95 % [micro-degrees]."""


@dataclass(frozen=True)
class Mount:
    """Five cycles of one mount: targets and angles [deg], and the way of arriving."""

    name: str
    target: Array
    angle: Array
    rising: Array
    compensated: float
    """Backlash that the controller takes away by itself [deg]."""


@dataclass(frozen=True)
class Found:
    """Over the targets [micro-degrees]."""

    name: str
    lost: Array
    """vAP at each target: lost motion, the distance of the means from below and from above."""
    below: Array
    """RP of arrivals from below."""
    above: Array
    compensated: float
    inner: float
    """The makers' figure from the same angles: inner 95 % of the deviations from each mean."""


def mount(path: Path) -> Mount:
    """Return a mount's recording."""
    text = path.read_text(encoding="utf-8")
    head = {key: float(value) for key, value in re.findall(r"^# (\w+): (\S+)$", text, re.M)}
    mV = np.array([float(line) for line in text.splitlines() if line[:1] not in "#m"])
    per_input = head["input_to_translation"] / head["mirror_lever_m"] * 180 / np.pi
    up = round((head["max_pos"] - head["min_pos"]) / head["step"])
    k = np.arange(len(mV)) % (2 * up)
    target = (head["min_pos"] + np.where(k <= up, k, 2 * up - k) * head["step"]) * per_input
    rising = (k > 0) & (k <= up)
    lever = head["mirror_lever_m"]
    compensated = head["compensated_backlash"] / lever * 180 / np.pi
    return Mount(path.stem, target, _angles(target, mV), rising, compensated)


def _angles(target: Array, mV: Array) -> Array:
    """Return angles (n,) [deg] by the detector's curve, fitted to the targets of both ways."""

    def curve(v: Array, height: float, zero: float, width: float, middle: float) -> Array:
        return width * erfinv(np.clip((v - zero) / height, -0.9999, 0.9999)) + middle

    start = [np.ptp(mV), 0.0, np.ptp(target), 0.0]
    fitted, _ = curve_fit(curve, mV, target, p0=start, maxfev=20_000)
    return curve(mV, *fitted)


def found(one: Mount) -> Found:
    """Return lost motion and RP by side at targets spread over the makers' range."""
    targets = np.unique(np.round(one.target[np.abs(one.target) <= RANGE], 9))
    targets = targets[np.linspace(0, len(targets) - 1, min(TARGETS, len(targets))).astype(int)]
    at = [np.flatnonzero(np.abs(one.target - target) < 1e-8) for target in targets]
    rows = [
        (f"T{t:03}", cycle, "+z" if rising else "-z", round(one.angle[i] / DIVISION) * DIVISION)
        for t, own in enumerate(at)
        for rising in (True, False)
        for cycle, i in enumerate(own[one.rising[own] == rising], 1)
    ]
    values = answer_of(rows)
    by_code = {
        code: np.array([v["value"] * 1e6 for v in values if pick(v)])
        for code, pick in {
            "lost": lambda v: v["code"] == "vAP",
            "below": lambda v: v["code"] == "RP" and str(v["pose"]).endswith("+z"),
            "above": lambda v: v["code"] == "RP" and str(v["pose"]).endswith("-z"),
        }.items()
    }
    return Found(one.name, by_code["lost"], by_code["below"], by_code["above"],
                 one.compensated * 1e6, inner(one) * 1e6)  # fmt: skip


def answer_of(rows: list[tuple[str, int, str, float]]) -> list[dict]:
    """Return the characteristics that `analyze` gives; a degree is written as a millimetre of Z."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "mount.csv")
        head = ["# unit: mm", f"# resolution: {DIVISION:.6f}", "# first_cycle: counts"]
        lines = [f"{pose},{cycle},{way},{z:.6f}" for pose, cycle, way, z in rows]
        text = "\n".join([*head, "pose,cycle,approach,Z", *lines, ""])
        path.write_text(text, encoding="utf-8")
        return answer(["analyze", str(path), "--cycles", "5", "--json"])["characteristics"]


def inner(one: Mount) -> float:
    """Return what holds the inner 95 % of deviations from the mean of each target and side."""
    inside = np.abs(one.target) <= RANGE
    key = np.round(one.target[inside], 9) + np.where(one.rising[inside], 100.0, 0.0)
    _, group = np.unique(key, return_inverse=True)
    angle = one.angle[inside]
    mean = np.bincount(group, angle) / np.bincount(group)
    low, high = np.quantile(angle - mean[group], [0.025, 0.975])
    return float(high - low)


def every() -> Iterator[Found]:
    """Yield what is found of every mount."""
    for name in PUBLISHED:
        yield found(mount(FOLDER / f"{name}.csv"))
