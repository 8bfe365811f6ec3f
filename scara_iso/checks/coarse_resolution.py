"""The dial is too coarse for the figure.

A reading rounded to whole divisions carries a standard uncertainty of resolution / sqrt(12). Where
that (with the indicator's own uncertainty) is more than a quarter of RP, the figure says more about
the dial than about the robot. Measure again with a finer indicator.
"""

from __future__ import annotations

from collections.abc import Iterator

from scara_iso.results import Finding, Measured

CODE = "coarse-resolution"
LARGEST_SHARE = 0.25  # background knowledge of ISO 9283's practice, not verified in the text


def check(measured: Measured) -> Iterator[Finding]:
    """Yield a warning for each axis or plane whose uncertainty is more than 25 % of its RP."""
    for pose in measured.poses:
        for name, figure in pose.figures.items():
            ratio = figure.uncertainty_ratio
            if ratio is not None and ratio > LARGEST_SHARE:
                yield Finding(
                    CODE,
                    "warning",
                    f"the indicator's uncertainty is {ratio:.0%} of RP, more than "
                    f"{LARGEST_SHARE:.0%}: measure with a finer one",
                    name,
                    pose.label,
                )
