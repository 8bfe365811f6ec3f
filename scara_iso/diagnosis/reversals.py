"""Reversals from readings: half the distance between the approaches, per payload, on the gear."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from scara_iso.diagnosis.gear import GearDiagnosis, diagnose_reversals
from scara_iso.diagnosis.gear_fit import Reversals
from scara_iso.diagnosis.result import Verdict
from scara_iso.effects import Conditions
from scara_iso.model.parts import Model
from scara_iso.model.predict import lever_mm, predict, sweep_of
from scara_iso.quantities import Dimension, rounding_uncertainty
from scara_iso.run import FloatArray, Run

_PLANE = ("X", "Y")
_COARSE = 0.5
"""Scatter under this share of a division leaves the rounding of a mean unaveraged."""


@dataclass(frozen=True, slots=True)
class Reversal:
    """Half the distance between the two approaches, of one axis at one payload."""

    axis: str
    payload_kg: float
    cycles: tuple[int, int]
    """How many arrived with approach +1, and -1."""
    half_width_mm: float
    """Mean of approach +1 less mean of approach -1, over 2; known effects subtracted."""
    uncertainty_mm: float
    """Standard uncertainty; the scatter is pooled over payloads and approaches."""
    predicted_before_mm: float | None = None
    """By eq. 16 and the gear effects that the model declares; None where it cannot say."""
    predicted_after_mm: float | None = None


@dataclass(frozen=True, eq=False, slots=True)
class RunReversals:
    """The reversals of a run, and what the model's gears leave of them."""

    reversals: tuple[Reversal, ...]
    gear: GearDiagnosis | None
    """In mm; None where the model lacks what the comparison needs."""
    missing: tuple[str, ...] = ()
    """Fields of the model file that it lacks."""
    mirrored: bool = False
    """Whether the load rests on the other side than in the model, so that sizes were compared."""
    notes: tuple[str, ...] = ()


def diagnose_run_reversals(run: Run, model: Model, *, seed: int) -> RunReversals | None:
    """Return the reversals of a run by payload against the model's gears.

    None without the columns ``approach`` and ``payload_kg`` or an axis of the plane.
    """
    names = [name for name in _PLANE if name in run.axes]
    names = [name for name in names if run.axes[name].dimension is Dimension.LENGTH]
    if not {"approach", "payload_kg"} <= run.covariates.keys() or not names:
        return None
    found, degrees = _reversals(run, model, names)
    left_out = sorted(set(run.covariates["payload_kg"].tolist()) - {r.payload_kg for r in found})
    notes = [f"payload {p:g} kg was approached from one side only: left out" for p in left_out]
    missing = tuple(_missing(model, len({r.payload_kg for r in found})))
    if not found or degrees < 1:
        notes.append("no scatter can be told: approach each payload several times from both sides")
    if missing or not found or degrees < 1:
        return RunReversals(found, None, missing, notes=tuple(notes))
    return _compared(found, degrees, model, notes, seed=seed)


def _reversals(run: Run, model: Model, names: Sequence[str]) -> tuple[tuple[Reversal, ...], int]:
    """Return the reversals that both approaches show, and the degrees of freedom of the scatter."""
    expected = predict(model, Conditions(run.cycle, run.covariates), reversal=False)
    payload, side = run.covariates["payload_kg"], np.sign(run.covariates["approach"])
    pairs = [(p, (payload == p) & (side > 0), (payload == p) & (side < 0))
             for p in np.unique(payload)]  # fmt: skip
    pairs = [(p, plus, minus) for p, plus, minus in pairs if plus.any() and minus.any()]
    parts = [part for _, plus, minus in pairs for part in (plus, minus)]
    degrees = sum(int(part.sum()) for part in parts) - len(parts)
    found = []
    for name in names:
        readings = run.axes[name].readings
        known = expected.axes.get(name)
        left = readings if known is None else readings - known.readings
        within = [left[part] - left[part].mean() for part in parts]
        scatter = float(np.sqrt(sum((w**2).sum() for w in within) / max(degrees, 1)))
        for p, plus, minus in pairs:
            counts = int(plus.sum()), int(minus.sum())
            half = float(left[plus].mean() - left[minus].mean()) / 2
            u = _uncertainty(scatter, run.axes[name].resolution, counts)
            found.append(Reversal(name, float(p), counts, half, u))
    return tuple(found), degrees


def _uncertainty(scatter: float, resolution: float | None, counts: tuple[int, int]) -> float:
    """Return the standard uncertainty of half the difference of two means of rounded readings."""
    rounding = 0.0 if resolution is None else rounding_uncertainty(resolution)
    kept = rounding if resolution is not None and scatter < _COARSE * resolution else 0.0
    scatter = max(scatter, rounding)
    return float(np.sqrt(sum(scatter**2 / n + kept**2 for n in counts)) / 2)


def _missing(model: Model, payloads: int) -> Iterator[str]:
    if model.arm is None:
        yield from ("robot.link_1_mm", "robot.link_2_mm")
    if model.joints_deg is None:
        yield "pose.joint_deg"
    if not model.gearboxes:
        yield "gearbox.joint_1"
    for joint, gear in model.gearboxes.items():
        if payloads > 1 and gear.payload_kg is None:
            yield f"gearbox.joint_{joint}.payload_kg"


def _compared(
    found: tuple[Reversal, ...], degrees: int, model: Model, notes: list[str], *, seed: int
) -> RunReversals:
    data = _data(found, degrees, model)
    before = data.predict()
    mirrored = float(data.measured @ before) < 0
    sign = -1.0 if mirrored else 1.0
    gear = diagnose_reversals(replace(data, measured=sign * data.measured), seed=seed, sides=2)
    if mirrored and gear.verdict is not Verdict.NOTHING:
        notes.append(
            "the load rests on the other side of the pose than in the model, ahead of it: "
            "the sizes of the reversals are compared"
        )
    notes += [
        f"wind-up at joint {joint} was not tried: the model lacks gearbox.joint_{joint}.friction, "
        "the torque that holds the gear wound up"
        for joint, box in model.gearboxes.items()
        if box.friction is None
    ]
    compared = tuple(
        replace(one, predicted_before_mm=float(b), predicted_after_mm=float(a))
        for one, b, a in zip(found, before, _signed(sign, gear), strict=True)
    )
    return RunReversals(compared, gear, (), mirrored, (*notes, *gear.notes))


def _signed(sign: float, gear: GearDiagnosis) -> FloatArray:
    after = gear.predicted_after
    return np.asarray(sign * after if gear.verdict is Verdict.EXPLAINED else after)


def _data(found: tuple[Reversal, ...], degrees: int, model: Model) -> Reversals:
    payload = np.array([one.payload_kg for one in found])
    levers = {joint: lever_mm(model, joint) for joint in model.gearboxes}
    return Reversals(
        measured=np.array([one.half_width_mm for one in found]),
        sweeps={joint: sweep_of(model, joint, payload) for joint in levers},
        levers={
            joint: np.array([lever[one.axis] / 2 for one in found])
            for joint, lever in levers.items()
        },
        group=np.unique(payload, return_inverse=True)[1].astype(np.int64),
        uncertainty=np.array([one.uncertainty_mm for one in found]),
        degrees=degrees,
    )
