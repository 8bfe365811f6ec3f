"""Two runs of one robot, and more: what differs by more than chance and the dial explain."""

from typing import TYPE_CHECKING

from scara_iso.faces import face

if TYPE_CHECKING:
    from scara_iso.comparison.chance import spread as spread
    from scara_iso.comparison.decision import (
        MOST_CYCLES as MOST_CYCLES,
        Comparison as Comparison,
        Contrast as Contrast,
        ContrastVerdict as ContrastVerdict,
        Ends as Ends,
        Pair as Pair,
    )
    from scara_iso.comparison.pairs import (
        PAGES as PAGES,
        SEED as SEED,
        compare as compare,
        exchangeability as exchangeability,
        poses_in_common as poses_in_common,
        refuse_limits as refuse_limits,
    )
    from scara_iso.comparison.published import (
        PublishedComparison as PublishedComparison,
        published_comparison as published_comparison,
    )
else:
    __getattr__ = face(__name__)
