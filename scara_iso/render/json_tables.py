"""What was understood of a table as JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scara_iso.published import Json

if TYPE_CHECKING:
    from scara_iso.run import Run


def table_json(run: Run) -> Json:
    """Return the JSON object of ``tables``, schema ``scara-iso/tables/1``."""
    origin = run.origin
    return {
        "schema": "scara-iso/tables/1",
        "source": origin.source,
        "read_as": origin.understood,
        "header_line": origin.header_line,
        "fields": [
            {"field": k, "header": one.header, "kind": one.kind, "name": one.name, "unit": one.unit}
            for k, one in enumerate(origin.fields, start=1)
        ],
        "rows": len(run),
        "lines": [] if run.lines is None else run.lines.tolist(),
        "cycle": run.cycle.tolist(),
        "pose": None if run.pose is None else run.pose.tolist(),
        "axes": {
            name: {
                "unit": axis.unit,
                "resolution": axis.resolution,
                "readings": axis.readings.tolist(),
            }
            for name, axis in run.axes.items()
        },
        "statements": dict(run.metadata),
        "notes": list(origin.notes),
    }
