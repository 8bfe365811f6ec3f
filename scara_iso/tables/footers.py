"""The words that begin a row of a summary: mean, s, Cpk, tolerance."""

from __future__ import annotations

import re

_FOOTERS = """
mean means average averages avg mittel mittelwert mw mittelw arith moyenne std stdev stddev sd
stdabw standard standardabweichung standardabw sigma variance varianz var min minimum max maximum
range spannweite median mode cp cpk cm cmk pp ppk cg cgk repeatability wiederholgenauigkeit
wiederholpräzision rp ap count anzahl total sum summe usl lsl ucl lcl nominal sollwert target
tolerance toleranz result results ergebnis rms
stabw stabwn stabwa stdv cv rsd kurtosis skewness
"""
_WORDS = frozenset(_FOOTERS.split())
_SHORT = frozenset(["s", "n", "r", "x̄", "x̅", "xbar", "σ", "μ", "µ", "ø", "2s", "3s", "6s"])
_FIRST_WORD = re.compile(r"[^\W_]+[\u0304\u0305]?")


def names_a_footer(label: str, *, short: bool = False) -> bool:
    """Return whether a label begins as a footer's; ``short``: also as ``s`` or ``n``."""
    match = _FIRST_WORD.search(label.lower())
    word = match[0] if match else ""
    return word in _WORDS or (short and word in _SHORT)
