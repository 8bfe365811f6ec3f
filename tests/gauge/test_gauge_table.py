"""What is stated of a gauge study: in its table, and by whoever asks for it."""

import pytest

import scara_iso
from scara_iso.base.errors import UsageError

HEAD = "# unit: mm\n# resolution: 0.001\n# tolerance: 0.04\n"
TABLE = HEAD + "cycle,X\n" + "".join(f"{k},{5 + 0.001 * (k % 4):.3f}\n" for k in range(1, 31))


def test_a_tolerance_may_be_stated_twice_and_not_in_two_ways():
    alone, twice = (scara_iso.gauge_study(TABLE.encode(), tolerance=t) for t in (None, 0.04))
    assert twice.axes["X"].figures == alone.axes["X"].figures
    with pytest.raises(UsageError, match="the tolerance is stated in two ways") as caught:
        scara_iso.gauge_study(TABLE.encode(), tolerance=0.05)
    assert caught.value.remedy == "leave one"
