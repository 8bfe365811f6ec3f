"""What is stated for a report beside its table, and what of the table it overrides."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace

from scara_iso.base.errors import UsageError
from scara_iso.reporting import Restated
from scara_iso.run import Run
from scara_iso.tables import is_of_axes, is_of_corrections

_KEY = re.compile(r"[A-Za-z][A-Za-z0-9_ -]{0,60}")
_RECORDED = re.compile(
    r"first_cycle.*|corrected_.*|axes_recorded|simulated|cycles_planned|record_.*|recorded|doubts|pose"
)


def restate(run: Run, stated: Mapping[str, str]) -> tuple[Run, tuple[Restated, ...]]:
    """Return the run with ``stated`` in its metadata, and each statement with what it overrides.

    Raises `UsageError` for a key that is no word, that the readings were read with (``unit``), or
    that the recording itself says (``simulated``, what was struck).
    """
    keys = {key: key.strip().lower().replace(" ", "_") for key in stated}
    wrong = [key for key in stated if not _KEY.fullmatch(key.strip())]
    if wrong:
        raise UsageError(f"`meta={wrong[0]}=..`: not a key", remedy="`meta=operator=A. Muster`")
    fixed = [
        key
        for key, k in keys.items()
        if is_of_axes(k) or is_of_corrections(k) or _RECORDED.fullmatch(k)
    ]
    if fixed:
        raise UsageError(
            f"`meta={fixed[0]}=..`: the readings were read or recorded with it",
            remedy="state it in the table, where it can be checked",
        )
    known = {key.lower(): key for key in run.metadata}
    metadata = dict(run.metadata)
    said = []
    for key, text in stated.items():
        name = known.get(keys[key], keys[key])
        before = metadata.get(name)
        if before != text:
            said.append(Restated(name, text, before))
        metadata[name] = text
    return replace(run, metadata=metadata), tuple(said)
