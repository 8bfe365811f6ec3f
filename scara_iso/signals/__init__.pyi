from .force_loop import (
    ForceLoop as ForceLoop,
    LoopFit as LoopFit,
    fit_loop as fit_loop,
    is_loop as is_loop,
    loop_of as loop_of,
    read_loop as read_loop,
)
from .rests import (
    Doubt as Doubt,
    Rule as Rule,
    SegmentedStream as SegmentedStream,
    Visit as Visit,
)
from .visits import Wanted as Wanted, find_visits as find_visits
