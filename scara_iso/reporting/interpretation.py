"""The diagnosis of every pose in plain words: what was found, how sure, why, and how to tell."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from scara_iso.diagnosis import Diagnosis, Found, Verdict
from scara_iso.reporting.blocks import Block, Facts, Text
from scara_iso.reporting.diagnosis import Failure, diagnosis_in_words, parameters_said, rivals_said
from scara_iso.reporting.digits import p_equals
from scara_iso.reporting.words import words
from scara_iso.tables import listed

_CHANCE = (
    "p: how often scatter alone would look this structured. Where nothing was found, an effect too "
    "small for these cycles may still be there."
)


def interpretation(diagnoses: Mapping[str | None, Diagnosis | Failure]) -> Iterator[Block]:
    """Yield what was found at which poses, and of each effect sizes, cause and test."""
    poses: dict[str, list[str]] = {}
    for pose, found in diagnoses.items():
        poses.setdefault(diagnosis_in_words(found) + _chance(found), []).append(pose or "")
    yield Facts(tuple((listed(at) or "all cycles", said) for said, at in poses.items()))
    yield Text(_CHANCE, "quiet")
    effects: dict[str, list[tuple[str | None, Found]]] = {}
    for pose, found in diagnoses.items():
        if isinstance(found, Diagnosis):
            for one in found.effects:
                effects.setdefault(one.effect, []).append((pose, one))
            if found.verdict is Verdict.UNEXPLAINED and found.candidates:
                yield Text(f"{_at(pose)}nearest: {rivals_said(found.candidates)}")
    for name, places in effects.items():
        yield from _effect(name, places)


def _chance(found: Diagnosis | Failure) -> str:
    return "" if isinstance(found, Failure) else f" ({p_equals(found)})"


def _effect(name: str, places: list[tuple[str | None, Found]]) -> Iterator[Text]:
    yield Text(words(name).capitalize(), "strong")
    for pose, found in places:
        others = f"; not excluded: {rivals_said(found.rivals)}" if found.rivals else ""
        axes = f" on {', '.join(found.axes)}" if found.axes else ""
        sure = f"probability {found.probability:.0%}{others}"
        yield Text(f"{_at(pose)}{parameters_said(found)}{axes}; {sure}")
    one = places[0][1]
    yield Text(f"Cause: {one.cause}.")
    yield Text(f"To confirm: {one.confirm_by}.")


def _at(pose: str | None) -> str:
    return f"{pose}: " if pose else ""
