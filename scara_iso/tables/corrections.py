"""What a table states of its dials' corrections: ``# correction_X: 0 0; 2 0.001``, and so on."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from scara_iso.base.quantities import parse_number
from scara_iso.run import AXES, Axis, Correction, Run

_KEYS = {
    "correction": "points",
    "correction_zero": "zero",
    "correction_uncertainty": "uncertainty",
    "alignment": "alignment_deg",
    "alignment_uncertainty": "alignment_u_deg",
}
"""Keys of what corrects an axis, with ``_X`` and the like behind, and what of it they state."""
_OF_A_CORRECTION = re.compile(rf"(?i)({'|'.join(_KEYS)})_({'|'.join(AXES)})")
_POSITIVE = ("uncertainty", "alignment_u_deg")
_MOST_NAMED = 5


def is_of_corrections(key: str) -> bool:
    """Return whether a statement corrects the readings of an axis."""
    return _OF_A_CORRECTION.fullmatch(key) is not None


def stated_corrections(correction: Correction, axis: str) -> Iterator[tuple[str, str]]:
    """Yield the statements of a correction, which `corrected` reads back."""
    for key, name in _KEYS.items():
        value = getattr(correction, name)
        if name == "points" and value:
            yield f"{key}_{axis}", "; ".join(f"{x:.12g} {e:.12g}" for x, e in value)
        elif name != "points" and value is not None:
            yield f"{key}_{axis}", f"{value:.12g}"


def corrected(run: Run) -> tuple[Run, list[str]]:
    """Return the run with its readings corrected as its metadata states, and what is wrong.

    The statements go, and ``corrected_X`` says in their place what was done: they are never
    applied twice.
    """
    found, wrong = _read(run.metadata)
    from_zero = run.dial_zero_is_command
    unknown = [
        f"a correction of {axis}, which is not an axis of this table"
        for axis in found
        if axis not in run.axes
    ]
    wrong += unknown
    axes, said = dict(run.axes), {}
    for name, correction in found.items():
        if name in axes:
            faults = [f"{name}: {text}" for text in _faults(correction, axes[name], run)]
            wrong += faults
            if not faults:
                shown = axes[name].readings  # the longest distance measured is its reach
                reach = np.abs(shown).max() if from_zero else np.ptp(shown)
                axes[name] = correction.applied(axes[name], reach=float(reach))
                said[f"corrected_{name}"] = _said(correction, axes[name])
    if not found and not wrong:
        return run, []
    kept = {key: text for key, text in run.metadata.items() if not is_of_corrections(key)}
    return replace(run, axes=axes, metadata={**kept, **said}), wrong


def _read(metadata: Mapping[str, str]) -> tuple[dict[str, Correction], list[str]]:
    found: dict[str, dict[str, object]] = {}
    wrong = []
    names = {axis.lower(): axis for axis in AXES}
    for key, text in metadata.items():
        if (match := _OF_A_CORRECTION.fullmatch(key)) is None:
            continue
        name = _KEYS[match[1].lower()]
        value = _points(text) if name == "points" else parse_number(text)
        if value is None or (name in _POSITIVE and not isinstance(value, tuple) and value <= 0):
            wanted = "'0 0; 2 0.001; 5 -0.002'" if name == "points" else "a number, such as 0.5"
            wrong.append(f"{key}: {text[:40]!r} is not {wanted} (in mm, or degrees)")
        else:
            found.setdefault(names[match[2].lower()], {})[name] = value
    return {axis: Correction(**values) for axis, values in found.items()}, wrong  # type: ignore[arg-type]  # as _KEYS has them


def _points(text: str) -> tuple[tuple[float, float], ...] | None:
    pairs = [[parse_number(cell) for cell in pair.split()] for pair in text.split(";")]
    points = tuple((pair[0], pair[1]) for pair in pairs if len(pair) == 2)
    if len(points) < len(pairs) or any(x is None for pair in pairs for x in pair):
        return None
    return points  # type: ignore[return-value]  # no None among them


def _faults(correction: Correction, axis: Axis, run: Run) -> Iterator[str]:
    yield from correction.faults(axis.dimension)
    if correction.points and correction.zero is None and run.dial_zero_is_command:
        yield (
            "the display was zeroed at the command pose: state where on the certificate's scale "
            f"that was, as '# correction_zero_{axis.name}: 2.5'"
        )
    outside = correction.uncovered(axis)
    if len(outside):
        low, high = correction.points[0][0], correction.points[-1][0]
        zero = f", the display's zero at {correction.zero:g}" if correction.zero is not None else ""
        some = ", ".join(f"{axis.readings[k]:g}" for k in outside[:_MOST_NAMED])
        some += " .." if len(outside) > _MOST_NAMED else ""
        yield (
            f"{len(outside)} readings ({some}) are not "
            f"on the curve from {low:g} to {high:g} {axis.unit}{zero}: nothing is extrapolated"
        )


def _said(correction: Correction, axis: Axis) -> str:
    parts = []
    if correction.points:
        zero = "" if correction.zero is None else f", zeroed at {correction.zero:g}"
        parts.append(f"certificate's curve of {len(correction.points)} points{zero}")
    if correction.alignment_deg is not None:
        parts.append(f"cosine of {correction.alignment_deg:g} deg")
    added = axis.readings - axis.shown
    return f"{' and '.join(parts)}: {added.min():+.3g} .. {added.max():+.3g} {axis.unit}"
