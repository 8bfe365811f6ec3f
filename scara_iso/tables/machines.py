"""Logs of machines that test their own probe, known by a line of theirs; their numbers are mm.

Klipper's ``PROBE_ACCURACY`` (docs/G-Codes.md, [probe]) and Marlin's ``M48`` (gcode/calibrate/M48)
write lengths in mm and a standard deviation that divides by n: it is shown, and not taken.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

UNIT = "mm"


@dataclass(frozen=True, slots=True)
class Machine:
    """What wrote a log; ``deviation`` is the standard deviation that the log states, with ``line``.

    Both are None and 0 where it states none.
    """

    name: str
    deviation: str | None = None
    line: int = 0

    @property
    def notes(self) -> list[str]:
        """What was understood of it, in words."""
        found = [f"a log of {self.name}: lengths in {UNIT}"]
        if self.deviation is not None:
            found.append(
                f"line {self.line}: its standard deviation {self.deviation} {UNIT} divides by n, "
                "not by n - 1, and is not taken"
            )
        return found


_SIGNATURES = {
    "Klipper PROBE_ACCURACY": (
        re.compile(r"PROBE_ACCURACY at X:[-0-9.]+ Y:[-0-9.]+ Z:[-0-9.]+"),
        re.compile(r"probe accuracy results:.*standard deviation ([0-9.]{1,20})\s*$"),
    ),
    "Marlin M48": (
        re.compile(r"M48 Z-Probe Repeatability Test"),
        re.compile(r"Standard Deviation: ([0-9.]{1,20})\s*$"),
    ),
}


def find_machine(lines: Sequence[str]) -> Machine | None:
    """Return the machine that names itself in a log, None where none or more than one does."""
    found = [
        (name, own)
        for name, (signature, own) in _SIGNATURES.items()
        if any(signature.search(line) for line in lines)
    ]
    if len(found) != 1:
        return None
    name, own = found[0]
    said = [(match[1], k) for k, line in enumerate(lines, 1) if (match := own.search(line))]
    return Machine(name, *said[0]) if said else Machine(name)
