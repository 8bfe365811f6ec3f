"""A fast sensor's stream to visits: rest distinguished from motion by a stated rule, doubts listed.

`find_visits` takes a `Run` with a row for each sample and gives one with a row for each visit.
"""

from typing import TYPE_CHECKING

from scara_iso.base.faces import face

if TYPE_CHECKING:
    from scara_iso.streams.published import published_visits as published_visits
    from scara_iso.streams.rests import (
        Doubt as Doubt,
        Rule as Rule,
        StreamVisits as StreamVisits,
        Visit as Visit,
    )
    from scara_iso.streams.visits import Wanted as Wanted, find_visits as find_visits
else:
    __getattr__ = face(__name__)
