"""The paper's Table I and first joint: what is printed, and what exact sums make of it."""

from __future__ import annotations

from collections.abc import Iterator

from scara_iso.iso9283 import analyze
from scara_iso.robot import first_joint, table_1
from scara_iso.validation.result import ReferenceCheck

_TABLE = "Table I of the paper, summed up in exact fractions (tests/test_repeatability.py)"
_SUMS = {
    "X": (0.0973333, 0.0048889, 0.0030492, 0.0140365, 0.0174988),
    "Y": (0.8053333, 0.0049778, 0.0003383, 0.0059926, 0.0152225),
    "Z": (0.3690000, 0.0067333, 0.0056013, 0.0235373, 0.0265421),
    "theta": (0.4766667, 0.0031111, 0.0016220, 0.0079771, 0.0106674),
}
"""Mean, l_bar, S_l, RP and 3 S [mm], to 5 in the eighth decimal."""
_NAMES = ("mean", "l_bar", "S_l", "RP", "three_sigma")
_GEAR = {
    "gap_rad": (3.490658504e-3, "eq. 18 in 10 digits"),
    "as_given.load_deviation_rad": (-1.947720556e-7, "eq. 16 in 10 digits"),
    "as_given.inertia_ratio": (17921.75472, "eq. 20 in 10 digits"),
    "free_play_mm": (2.443460953, "eq. 22 in 10 digits"),
    "reflected.load_deviation_rad": (-4.273418e-4, "eq. 16 with N² I_m"),
}
_PRINTED = {
    "free_play_mm": (2.44, 0.005, "eq. 22"),
    "as_given.deviation_mm": (1.37e-4, 1e-6, "eq. 21"),
}


def paper_checks() -> Iterator[ReferenceCheck]:
    """Yield the figures of Table I and those of the first joint."""
    pose = analyze(table_1()).poses[0]
    for axis, sums in _SUMS.items():
        for name, expected in zip(_NAMES, sums, strict=True):
            found = float(getattr(pose.axes[axis], name))
            yield ReferenceCheck("paper", f"{name} {axis} [mm]", _TABLE, expected, found, 6e-8)
    if pose.XY is not None and pose.XY.RP_rss is not None:
        for what, expected, found in (
            ("RP XY", 0.0140566, pose.XY.RP),
            ("RP_rss XY", 0.0152622, pose.XY.RP_rss),
        ):
            yield ReferenceCheck("paper", f"{what} [mm]", _TABLE, expected, found, 6e-8)
    gear = first_joint()
    for path, (expected, source) in _GEAR.items():
        yield ReferenceCheck("paper", path, source, expected, _at(gear, path), 1e-6 * abs(expected))
    for path, (expected, apart, equation) in _PRINTED.items():
        name, source = f"{path}, as printed", f"the paper, {equation}"
        yield ReferenceCheck("paper", name, source, expected, _at(gear, path), apart)


def _at(found: object, path: str) -> float:
    for name in path.split("."):
        found = getattr(found, name)
    return float(found)  # type: ignore[arg-type]
