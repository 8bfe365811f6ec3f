"""The recording was interrupted, or a gauge changed.

Since then the dial may stand elsewhere, or show another unit. Compare the readings before and
after the quoted cycle, or measure again.
"""

import re
from collections.abc import Mapping

from scara_iso.iso9283.core.results import Finding, Findings, Measured

CODE = "recording-disturbed"
BRIEF = "the recording was disturbed"
_NOTED = re.compile(r"record_\d+_(resumed|changed)")
_CYCLE = re.compile(r"before cycle (\d{1,9})")
_MOST = 5


def check(measured: Measured) -> Findings:
    """Yield a warning that quotes what the recorder noted."""
    found = _noted(measured.run.metadata)
    lines = [f"resumed {text}" if what == "resumed" else text for what, text in found]
    if lines:
        more = f"; {len(lines) - _MOST} more" if len(lines) > _MOST else ""
        yield Finding(CODE, "warning", "; ".join(lines[:_MOST]) + more)


def resumed_before(metadata: Mapping[str, str]) -> tuple[int, ...]:
    """Return the cycles before which a recording was resumed."""
    found = (_CYCLE.match(text) for what, text in _noted(metadata) if what == "resumed")
    return tuple(int(one[1]) for one in found if one)


def _noted(metadata: Mapping[str, str]) -> list[tuple[str, str]]:
    found = ((_NOTED.fullmatch(key), text) for key, text in metadata.items())
    return [(one[1], text) for one, text in found if one]
