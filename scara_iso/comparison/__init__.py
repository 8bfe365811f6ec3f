"""Two runs of one robot, and more: what differs by more than chance and the dial explain."""

from typing import TYPE_CHECKING

from scara_iso.faces import face

if TYPE_CHECKING:
    from scara_iso.comparison.decision import MOST_CYCLES as MOST_CYCLES
    from scara_iso.comparison.matching import PAGES as PAGES, poses_in_common as poses_in_common
    from scara_iso.comparison.pairs import SEED as SEED, compare as compare
    from scara_iso.comparison.published import (
        PublishedComparison as PublishedComparison,
        published_comparison as published_comparison,
    )
    from scara_iso.comparison.result import (
        Comparison as Comparison,
        Contrast as Contrast,
        ContrastVerdict as ContrastVerdict,
        Ends as Ends,
        Pair as Pair,
    )
    from scara_iso.comparison.robots import (
        exchangeability as exchangeability,
        refuse_limits as refuse_limits,
    )
    from scara_iso.comparison.spreads import spread as spread
else:
    __getattr__ = face(__name__)
