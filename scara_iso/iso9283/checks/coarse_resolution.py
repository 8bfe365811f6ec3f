"""The dial is too coarse for the figure.

A reading in whole divisions has a standard uncertainty u of resolution / sqrt(12), combined with
that of the indicator. Where U = 2 u is more than a quarter of the figure (RP, of an angle 3 S),
that is largely the dial's. (The text of ISO 9283 was not verified.) Measure again with a finer
indicator.
"""

from scara_iso.iso9283.core.results import Finding, Findings, Measured

CODE = "coarse-resolution"
BRIEF = "dial too coarse"
LARGEST_SHARE = 0.25  # background knowledge of ISO 9283's practice, not verified in the text


def check(measured: Measured) -> Findings:
    """Yield a warning for each axis or plane whose U = 2 u is more than 25 % of its figure."""
    for pose in measured.poses:
        for name, figure in pose.figures.items():
            ratio = figure.expanded_ratio
            if ratio is not None and ratio > LARGEST_SHARE:
                what = (
                    f"the indicator's U = 2 u is {ratio:.0%} of the figure, more than "
                    f"{LARGEST_SHARE:.0%}: measure with a finer one"
                )
                yield Finding(CODE, "warning", what, name, pose.label)
