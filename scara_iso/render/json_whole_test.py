"""The states of a test's parts as a JSON object."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from scara_iso.acceptance import (
    Condition,
    Folder,
    PartState,
    lacking,
    seconds_a_cycle,
    seconds_left,
)
from scara_iso.iso9283 import Analysis, Beside, Finding
from scara_iso.render.json import (
    FINDING,
    analysis_json,
    characteristic_json,
    each,
    limits_json,
    plain,
)


class OfCondition(Protocol):
    """A condition and the parts of it that are missing."""

    @property
    def condition(self) -> Condition:
        """Velocity and load."""

    @property
    def missing(self) -> Sequence[str]:
        """Parts by name."""


def conditions_json(
    source: str,
    conditions: Sequence[OfCondition],
    analyses: Sequence[Analysis | None],
    beside: Beside,
) -> dict[str, Any]:
    """Return the JSON object of ``analyze`` of a test's folder.

    With one condition it is that of a table, the figures ``beside`` among its own, else
    ``conditions`` holds an object for each, and what is beside them stands beside those.
    """
    if len(conditions) == 1 and analyses[0] is not None:
        analyses = [beside.added_to(analyses[0])]
    documents = [
        {**_analysed(source, one, analysis), "missing": list(one.missing)}
        for one, analysis in zip(conditions, analyses, strict=True)
    ]
    if len(documents) == 1:
        alone = beside_json(beside) if analyses[0] is None else {}
        missing = [*documents[0]["missing"], *beside.missing]
        return {**documents[0], **alone, "missing": missing}
    shared = ("schema", "unit", "source")
    return {
        **{key: documents[0][key] for key in shared},
        "conditions": [
            {"velocity": one.condition.velocity, "load": one.condition.load,
             **{key: value for key, value in document.items() if key not in shared}}
            for one, document in zip(conditions, documents, strict=True)
        ],
        **beside_json(beside),
    }  # fmt: skip


def beside_json(beside: Beside) -> dict[str, Any]:
    """Return the figures and findings of the tests beside the poses; nothing without any."""
    if not beside:
        return {}
    return {
        "characteristics": [characteristic_json(one) for one in beside.characteristics],
        "limits": limits_json(beside.limits),
        "conformity": plain(beside.conformity),
        "findings": each(beside.findings(), FINDING),
        "missing": list(beside.missing),
    }


def _analysed(source: str, one: OfCondition, analysis: Analysis | None) -> dict[str, Any]:
    if analysis is not None:
        return analysis_json(analysis)
    return {
        "schema": "scara-iso/analyze/2",
        "unit": "mm",
        "source": source,
        "read_as": f"no part of the test, {one.condition}",
        "notes": [],
        "metadata": {},
        "cycles": {"read": 0, "discarded": [], "used": 0},
        **dict.fromkeys(("poses", "characteristics", "limits", "deviations"), ()),
        "conformity": None,
        "findings": each([Finding("parts-missing", "warning", "no part is recorded")], FINDING),
    }


def status_json(folder: Folder) -> dict[str, Any]:
    """Return the JSON object of ``test status``, schema ``scara-iso/test-status/1``."""
    following = folder.next
    return {
        "schema": "scara-iso/test-status/1",
        "folder": str(folder.path),
        "robot": folder.test.robot.name,
        "poses": list(folder.test.poses),
        "velocities": list(folder.test.schedule.velocities),
        "loads": list(folder.test.schedule.loads),
        "parts": [_part(state) for state in folder.parts],
        "missing": [lacking(state) for state in folder.parts if state.is_open],
        "not_measured": list(folder.unmeasured),
        "unknown": list(folder.foreign),
        "complete": all(state.is_whole for state in folder.parts),
        "next": None if following is None else following.part.name,
        "seconds_a_cycle": seconds_a_cycle(folder),
        "seconds_left": seconds_left(folder),
    }


def _part(state: PartState) -> dict[str, Any]:
    cycles = not state.part.is_push
    readable = cycles and state.recording is not None and not state.why
    done, wanted = state.recording.cycles if readable and state.recording else (None, None)
    return {
        "part": state.part.name,
        "pose": state.part.pose or None,
        "velocity": state.part.condition.velocity if cycles else None,
        "load": state.part.condition.load if cycles else None,
        "state": state.state,
        "recording": None if state.recording is None else state.recording.table.name,
        "cycles": done,
        "cycles_planned": wanted,
        "deviations": [
            {"code": finding.code, "message": finding.message} for finding in state.deviations
        ],
        "struck": [{"recording": s.recording, "reason": s.reason} for s in state.struck],
        "why": state.why,
    }
