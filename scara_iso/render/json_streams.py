"""The visits of a stream as a JSON object."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING

from scara_iso.iso9283 import published_characteristic
from scara_iso.published import Json, to_json

if TYPE_CHECKING:
    from scara_iso.streams import StreamVisits


def visits_json(found: StreamVisits) -> Json:
    """Return the JSON object of ``visits``, schema ``scara-iso/visits/1``."""
    return {
        "schema": "scara-iso/visits/1",
        "unit": "mm",
        "source": found.run.origin.source,
        "read_as": found.run.origin.understood,
        "samples": found.samples,
        "rate_hz": found.rate_hz,
        "sha256": found.run.metadata.get("stream_sha256"),
        "rule": asdict(found.rule),
        "units": {name: axis.unit for name, axis in found.run.axes.items()},
        "visits": [
            {"visit": k, "cycle": int(cycle), **asdict(visit)}
            for k, (visit, cycle) in enumerate(
                zip(found.visits, found.run.cycle.tolist(), strict=True), 1
            )
        ],
        "doubts": [asdict(doubt) for doubt in found.doubts],
        "notes": list(found.notes),
        "characteristics": to_json(tuple(map(published_characteristic, found.characteristics))),
    }
