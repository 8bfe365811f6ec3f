"""What each dialect makes of the bytes that its maker's manual shows."""

from __future__ import annotations

import json
from collections.abc import Iterator
from importlib.resources.abc import Traversable
from typing import Any

from scara_iso.recorder import (
    Decoder,
    DeviceNotice,
    Event,
    Garbage,
    InstrumentFault,
    Reading,
    find_dialects,
)
from scara_iso.validation.references import references
from scara_iso.validation.result import ReferenceCheck


def stream_checks() -> Iterator[ReferenceCheck]:
    """Yield one check for each recorded stream, and one for a dialect without any."""
    dialects = find_dialects()
    for folder in sorted(_folders(), key=lambda one: one.name):
        for file in sorted(folder.iterdir(), key=lambda one: one.name):
            if file.name.endswith(".bin"):
                beside = folder.joinpath(f"{file.name.removesuffix('.bin')}.json")
                stated = json.loads(beside.read_text(encoding="utf-8"))
                events = Decoder(dialects[folder.name]).feed(file.read_bytes())
                yield ReferenceCheck(
                    "streams",
                    f"{folder.name}/{file.name}",
                    stated["source"],
                    _said(stated["events"]),
                    _said([_as_stated(event) for event in events]),
                )


def _folders() -> Iterator[Traversable]:
    yield from (one for one in references("streams").iterdir() if one.is_dir())


def _said(events: list[dict[str, Any]]) -> str:
    """Return the events in words, one behind the other."""
    return "; ".join(
        " ".join(str(value) for value in ("garbage",) if event.get("garbage"))
        or " ".join(f"{key} {value}" for key, value in event.items() if value is not None)
        for event in events
    )


def _as_stated(event: Event) -> dict[str, Any]:
    match event:
        case Reading(text, unit, channel, mode):
            return {"reading": text, "unit": unit, "channel": channel, "mode": mode}
        case InstrumentFault(code=code, channel=channel):
            return {"fault": code, "channel": channel}
        case DeviceNotice(unit=unit):
            return {"notice": unit}
        case Garbage():
            return {"garbage": True}
