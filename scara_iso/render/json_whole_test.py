"""The conditions of a test as a JSON object."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Protocol

from scara_iso.acceptance import Condition
from scara_iso.iso9283 import (
    Analysis,
    Beside,
    BesidePoses,
    ConditionAnalysis,
    Finding,
    FolderAnalysis,
    PublishedAnalysis,
    PublishedCycles,
    published_analysis,
    published_characteristic,
    published_finding,
    published_limit,
)
from scara_iso.published import publish, to_json


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
    found = [
        replace(_analysed(source, one, analysis), missing=tuple(one.missing))
        for one, analysis in zip(conditions, analyses, strict=True)
    ]
    if len(found) == 1:
        alone = beside_json(beside) if analyses[0] is None else {}
        missing = [*conditions[0].missing, *beside.missing]
        return {**to_json(found[0]), **alone, "missing": missing}
    each = tuple(
        publish(ConditionAnalysis, document, velocity=at.velocity, load=at.load)
        for at, document in zip((one.condition for one in conditions), found, strict=True)
    )
    return {**to_json(publish(FolderAnalysis, found[0], conditions=each)), **beside_json(beside)}


def beside_json(beside: Beside) -> dict[str, Any]:
    """Return the figures and findings of the tests beside the poses; nothing without any."""
    if not beside:
        return {}
    found = BesidePoses(
        characteristics=tuple(map(published_characteristic, beside.characteristics)),
        limits=tuple(map(published_limit, beside.limits)),
        conformity=beside.conformity,
        findings=tuple(map(published_finding, beside.findings())),
        missing=beside.missing,
    )
    document: dict[str, Any] = to_json(found)
    return document


def _analysed(source: str, one: OfCondition, analysis: Analysis | None) -> PublishedAnalysis:
    if analysis is not None:
        return published_analysis(analysis)
    missing = Finding("parts-missing", "warning", "no part is recorded")
    return PublishedAnalysis(
        schema="scara-iso/analyze/2",
        unit="mm",
        source=source,
        read_as=f"no part of the test, {one.condition}",
        notes=(),
        metadata={},
        cycles=PublishedCycles(read=0, discarded=(), used=0),
        poses=(),
        characteristics=(),
        limits=(),
        conformity=None,
        deviations=(),
        findings=(published_finding(missing),),
    )
