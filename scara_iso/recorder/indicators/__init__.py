"""Digital indicators on a serial line: one small file for each dialect; no port, clock or thread.

A module of this folder, or one named by the entry-point group ``scara_iso.indicators``, holds a
constant ``DIALECT``, or ``DIALECTS`` where a family has variants.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import replace
from difflib import get_close_matches
from types import MappingProxyType, ModuleType

from scara_iso.base.errors import UsageError
from scara_iso.base.plugins import find_modules
from scara_iso.recorder.indicators._dialect import (
    Decoder as Decoder,
    DeviceNotice as DeviceNotice,
    Dialect as Dialect,
    Event as Event,
    Garbage as Garbage,
    InstrumentFault as InstrumentFault,
    LinePulse as LinePulse,
    LineSettings as LineSettings,
    Parity as Parity,
    Reading as Reading,
    diagnose_parity as diagnose_parity,
)
from scara_iso.recorder.indicators._grammar import LineGrammar, line_dialect
from scara_iso.recorder.indicators.generic import make_generic as make_generic

KEYBOARD = line_dialect(
    key="keyboard",
    instruments="a person at the keyboard, or an indicator whose cable types its readings",
    line="9600 8N1",
    reading=rb" *(?P<sign>[+-]?)(?P<digits>[0-9]{1,5}[.,][0-9]{1,6}) *",
    form="{number}",
    fill=" ",
    units={None: ""},
    longest_frame=32,
    digits=6,
    decimals=(3, 1, 2, 4, 5),
    source="none: the grammar is this program's",
    confidence="low",
    unverified=("the digits: a line typed has no parity and no checksum",),
)
"""What is typed, or comes as key presses: a number with its point or comma, alone on its line.

No plug-in of this folder, since no instrument sends it on a serial line: it may have any number of
digits, so a lost one leaves no trace but the number of decimals.
"""
_WHOLE = rb" *(?P<sign>[+-]?)(?P<digits>[0-9]{1,5}([.,][0-9]{1,6})?) *"
WHOLE = replace(KEYBOARD, parse=LineGrammar(reading=_WHOLE, form="", units={}).parser())
"""The same in a unit as small as a division, such as um: 412 lacks no point."""


def find_dialects() -> Mapping[str, Dialect]:
    """Return every dialect by its key; `UsageError` where two claim the same key."""
    found: dict[str, Dialect] = {}
    for module in find_modules(sys.modules[__name__], "scara_iso.indicators"):
        for dialect in _dialects(module):
            if dialect.key in found:
                raise UsageError(
                    f"two dialects are called {dialect.key!r}",
                    where=module.__name__,
                    remedy="uninstall one of the packages that bring it",
                )
            found[dialect.key] = dialect
    return MappingProxyType(found)


def _dialects(module: ModuleType) -> tuple[Dialect, ...]:
    return tuple(getattr(module, "DIALECTS", None) or (module.DIALECT,))


def check_shape(module: ModuleType) -> None:
    """Raise `AttributeError` or `TypeError` unless a module has a ``DIALECT`` or ``DIALECTS``."""
    if not all(isinstance(dialect, Dialect) for dialect in _dialects(module)):
        raise TypeError("DIALECT is not a Dialect")


def find_dialect(key: str) -> Dialect:
    """Return the dialect called ``key``; `UsageError` names the known ones otherwise."""
    known = {**find_dialects(), KEYBOARD.key: KEYBOARD}
    if key not in known:
        begun = [name for name in sorted(known) if key and name.startswith(key.lower())]
        close = begun or get_close_matches(key, known, n=1)
        raise UsageError(
            f"unknown driver {key!r}",
            remedy=(f"did you mean {close[0]}? " if close else "")
            + f"known: {', '.join(sorted(known))}",
        )
    return known[key]
