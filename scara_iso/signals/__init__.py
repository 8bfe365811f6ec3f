"""What is read of a sensor: samples in time to visits, and forces to and fro to play and spring.

`find_visits` takes a `Run` with a row for each sample and gives one with a row for each visit: rest
is distinguished from motion by a stated rule, and doubts are listed. `read_loop` takes the table of
a push test, `fit_loop` estimates compliance, play and friction.
"""

from typing import TYPE_CHECKING

from scara_iso.base.faces import face

if TYPE_CHECKING:
    from scara_iso.signals.force_loop import (
        ForceLoop as ForceLoop,
        LoopFit as LoopFit,
        fit_loop as fit_loop,
        is_loop as is_loop,
        loop_of as loop_of,
        read_loop as read_loop,
    )
    from scara_iso.signals.rests import (
        Doubt as Doubt,
        Rule as Rule,
        SegmentedStream as SegmentedStream,
        Visit as Visit,
    )
    from scara_iso.signals.visits import Wanted as Wanted, find_visits as find_visits
else:
    __getattr__ = face(__name__)
