"""Tables whose every figure was summed up elsewhere: one for each characteristic.

``vectors.json`` names the tables, how they are read and what they amount to;
tests/oracles/vectors.py made it, in plain Python that shares nothing with the program.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from scara_iso.comparison import exchangeability
from scara_iso.iso9283 import Characteristic, Counting, analyze, find_characteristics, push_test
from scara_iso.signals import read_loop
from scara_iso.tables import read_table
from scara_iso.validation.references import references
from scara_iso.validation.result import ReferenceCheck

_ARM = 0.25
"""From the joint to the dial of the push test [m]."""


def vector_checks() -> Iterator[ReferenceCheck]:
    """Yield value, u and ends of the interval of each figure, and what has no reference."""
    codes = set()
    for vector in json.loads(references("vectors", "vectors.json").read_text(encoding="utf-8")):
        found = {(one.code, one.pose, one.of): one for one in _characteristics(vector)}
        for figure in vector["figures"]:
            codes.add(figure["code"])
            yield from _compared(vector["name"], figure, found)
    for compute in find_characteristics():
        code = compute.__globals__["CODE"]
        if compute.__module__.startswith("scara_iso.") and code not in codes:
            yield ReferenceCheck("characteristics", code, "", "a reference", "none")


def _compared(
    name: str,
    figure: Mapping[str, Any],
    found: Mapping[tuple[str, str | None, str], Characteristic],
) -> Iterator[ReferenceCheck]:
    one = found.get((figure["code"], figure["pose"], figure["of"]))
    what = " ".join(filter(None, (figure["code"], figure["pose"], figure["of"])))
    ends = None if one is None else one.estimate.interval
    wanted = [("", figure["value"], None if one is None else one.estimate.value)]
    if figure["interval"] is not None:
        low, high = (None, None) if ends is None else ends
        wanted += [(", low", figure["interval"][0], low), (", high", figure["interval"][1], high)]
    if figure["u"] is not None:
        wanted.append((", u", figure["u"], None if one is None else one.estimate.u))
        parts = None if one is None else math.hypot(*one.estimate.parts.values())
        wanted.append((", its parts", figure["u"], parts))
    for part, expected, obtained in wanted:
        yield ReferenceCheck(
            "characteristics",
            f"{name}: {what}{part} [{figure['unit']}]",
            figure["source"],
            expected,
            "not there" if obtained is None else float(obtained),
            figure["tolerance"],
        )


def _characteristics(vector: Mapping[str, Any]) -> Sequence[Characteristic]:
    tables = [references("vectors", name).read_bytes() for name in vector["tables"]]
    if vector["name"].startswith("push"):
        return push_test(read_loop(tables[0]), arm_m=_ARM).characteristics
    analyses = [analyze(read_table(table), Counting(cycles=vector["cycles"])) for table in tables]
    return exchangeability(analyses, {}) if len(analyses) > 1 else analyses[0].characteristics
