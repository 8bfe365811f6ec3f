"""Transfers of a wireless link to a stream of bytes, without the copies that a host hands on.

A host that has connected again may hand on each transfer twice (bleak issue 2002): a copy would be
a reading that nobody took.
"""

from __future__ import annotations

import math

COPY_S = 0.05
"""A transfer that comes again within this time is a copy: no link repeats a text as fast [s]."""
SPOILT = b"\xff\x00"
"""Bytes that no frame holds: they make garbage of a line that can be read two ways."""
_ENDS = (b"\r", b"\n")


class Transfers:
    """Joins texts, each ended by CR or LF, from transfers of any length.

    A whole text, or the end of one, that comes again at once is dropped. Where all parts before the
    end came in equal pairs, they may be copies or may be meant: that line is made garbage, and so
    is one that a repeated transfer with an end inside would join.
    """

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._end = b""
        self._at = -math.inf

    def feed(self, data: bytes, now: float) -> bytes:
        """Return what a transfer that arrived at ``now`` [s] adds to the stream."""
        if not data.endswith(_ENDS):
            again = bool(self._parts) and self._parts[-1] == data
            self._parts.append(data)
            return SPOILT + data if again and _has_end(data) else data
        if data == self._end and not self._parts and now - self._at < COPY_S:
            return b""
        parts, self._parts = self._parts, []
        self._end, self._at = data, now
        return SPOILT + data if parts and parts[0::2] == parts[1::2] else data


def _has_end(data: bytes) -> bool:
    return any(end in data for end in _ENDS)
