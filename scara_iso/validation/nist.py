"""Mean and standard deviation of NIST's univariate sets, against the certified values."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np

from scara_iso.iso9283 import repeatability, standard_deviation
from scara_iso.validation.references import with_ending
from scara_iso.validation.result import ReferenceCheck

_CERTIFIED = re.compile(r"Sample (?:Mean|Standard Deviation).*?:\s*(\S+)\n")
_RULE = re.compile(r"-{5,}\n")
_DIGITS = 1e-13
"""Share of a value that doubles may lose; of a deviation, the readings' digits lost with it."""


def nist_checks() -> Iterator[ReferenceCheck]:
    """Yield mean and standard deviation (n - 1) of each set, as the figures of a pose use them."""
    for file in with_ending("nist_strd", ".dat"):
        text = file.read_text(encoding="ascii")
        readings = np.array([float(row) for row in _RULE.split(text)[-1].split()])
        source = f"NIST StRD, univariate, {file.name}"
        certified = [float(value) for value in _CERTIFIED.findall(text)]
        mean = float(repeatability(readings[np.newaxis]).mean[0])
        S = float(standard_deviation(readings))
        apart = _DIGITS * float(np.abs(readings).max())
        name = file.name.removesuffix(".dat")
        yield ReferenceCheck("NIST StRD", f"{name} mean", source, certified[0], mean, apart)
        yield ReferenceCheck("NIST StRD", f"{name} deviation", source, certified[1], S, 10 * apart)
