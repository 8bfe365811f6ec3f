"""Reversals in a run: half the distance between the approaches, by payload, against the gears."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from scara_iso.base.errors import DataError
from scara_iso.base.quantities import Dimension, rounding_uncertainty
from scara_iso.diagnosis.gears import Reversals, diagnose_reversals
from scara_iso.diagnosis.sweeps import GearDiagnosis, Reversal, RunReversals
from scara_iso.diagnosis.tuning import SEED
from scara_iso.diagnosis.verdict import Verdict
from scara_iso.effects import Conditions, Sweep
from scara_iso.robot import Model, lever_mm, predict, sweep_of
from scara_iso.run import FloatArray, Run

_PLANE = ("X", "Y")
_LISTED = 5
_FEWEST = 3
_COARSE = 0.5
"""Scatter under this share of a division leaves the rounding of a mean unaveraged."""


def diagnose_sweep(
    sweep: Sweep,
    measured: FloatArray,
    *,
    uncertainty: FloatArray | None = None,
    seed: int = SEED,
) -> GearDiagnosis:
    """Return what eq. 16 leaves of measured load deviations (m,) in rad, and which effect it is.

    Deviations follow eq. 16's sign (negative); ``uncertainty`` (m,) are standard uncertainties.
    Without them the scatter is unknown and may grow with the deviation. Raises `DataError` for
    fewer than 3 reversals.
    """
    m = len(measured)
    if m < _FEWEST:
        raise DataError(
            f"{m} reversals cannot be told from chance",
            remedy=f"measure at least {_FEWEST}, at different inertias",
        )
    data = Reversals(measured, {None: sweep}, {None: np.ones(m)}, np.arange(m), uncertainty)
    found = diagnose_reversals(data, seed=seed)
    without = "no torque_Nm column: wind-up was not tried"
    return replace(found, notes=(*found.notes, without)) if sweep.torque is None else found


def diagnose_run_reversals(run: Run, model: Model, *, seed: int) -> RunReversals | None:
    """Return the reversals of a run by payload against the model's gears.

    None without the columns ``approach`` and ``payload_kg`` or an axis of the plane.
    """
    names = [name for name in _PLANE if name in run.axes]
    names = [name for name in names if run.axes[name].dimension is Dimension.LENGTH]
    if not {"approach", "payload_kg"} <= run.covariates.keys() or not names:
        return None
    found, scatter = _reversals(run, model, names)
    left_out = sorted(set(run.covariates["payload_kg"].tolist()) - {r.payload_kg for r in found})
    listed = ", ".join(f"{p:g}" for p in left_out[:_LISTED]) + ", .." * (len(left_out) > _LISTED)
    notes = [f"payload {listed} kg: approached from one side only, left out"] if left_out else []
    missing = tuple(_missing(model, len({r.payload_kg for r in found})))
    if not found or scatter.degrees < 1:
        notes.append("no scatter can be told: approach each payload several times from both sides")
    if missing or not found or scatter.degrees < 1:
        return RunReversals(found, None, missing, notes=tuple(notes))
    return _compared(found, scatter, model, notes, seed=seed)


@dataclass(frozen=True, eq=False, slots=True)
class _Scatter:
    """Scatter of the readings about the mean of their payload and approach."""

    covariance: FloatArray
    """Of the axes, (a, a); not below the rounding."""
    kept: FloatArray
    """Variance of a mean that averaging does not lower, (a,): rounding without enough scatter."""
    degrees: int

    def of_half_width(self, direction: FloatArray, counts: tuple[int, int]) -> float:
        """Return the standard uncertainty along a unit vector (a,), by the cycles of each side."""
        each, kept = direction @ self.covariance @ direction, direction**2 @ self.kept
        return float(np.sqrt(sum(each / n + kept for n in counts)) / 2)


def _reversals(
    run: Run, model: Model, names: Sequence[str]
) -> tuple[tuple[Reversal, ...], _Scatter]:
    """Return the reversals that both approaches show, by axis and then payload, and the scatter."""
    expected = predict(model, Conditions(run.cycle, run.covariates), reversal=False).axes
    known = [expected[name].readings if name in expected else 0.0 for name in names]
    left = np.stack([run.axes[n].readings - k for n, k in zip(names, known, strict=True)])
    payload, side = run.covariates["payload_kg"], np.sign(run.covariates["approach"])
    both = [
        (p, (payload == p) & (side > 0), (payload == p) & (side < 0)) for p in np.unique(payload)
    ]
    both = [(p, plus, minus) for p, plus, minus in both if plus.any() and minus.any()]
    scatter = _scatter(run, names, left, [part for _, *parts in both for part in parts])
    found = [
        Reversal(
            axis=name,
            payload_kg=float(p),
            cycles=(counts := (int(plus.sum()), int(minus.sum()))),
            half_width_mm=float(row[plus].mean() - row[minus].mean()) / 2,
            uncertainty_mm=scatter.of_half_width(direction, counts),
            predicted_before_mm=None,
            predicted_after_mm=None,
        )
        for name, row, direction in zip(names, left, np.eye(len(names)), strict=True)
        for p, plus, minus in both
    ]
    return tuple(found), scatter


def _scatter(
    run: Run, names: Sequence[str], left: FloatArray, parts: Sequence[npt.NDArray[np.bool_]]
) -> _Scatter:
    within = [left[:, part] - left[:, part].mean(axis=1, keepdims=True) for part in parts]
    degrees = sum(part.shape[1] - 1 for part in within)
    covariance = np.zeros((len(names), len(names)))
    covariance += sum(part @ part.T for part in within) / max(degrees, 1)
    divisions = np.array([run.axes[name].resolution or 0.0 for name in names])
    rounding = rounding_uncertainty(1.0) ** 2 * divisions**2
    variance = covariance.diagonal().copy()
    kept = np.where(np.sqrt(variance) < _COARSE * divisions, rounding, 0.0)
    covariance += np.diag(np.maximum(rounding - variance, 0.0))
    return _Scatter(covariance, kept, degrees)


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
    found: tuple[Reversal, ...], scatter: _Scatter, model: Model, notes: list[str], *, seed: int
) -> RunReversals:
    turned = np.linalg.eigh(scatter.covariance)[1].T
    data = _data(found, scatter, turned, model)
    before = data.predict()[0]
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
        for one, b, a in zip(
            found, _by_axis(before, turned), _by_axis(_signed(sign, gear), turned), strict=True
        )
    )
    return RunReversals(compared, gear, (), mirrored, (*notes, *gear.notes))


def _signed(sign: float, gear: GearDiagnosis) -> FloatArray:
    after = gear.series.predicted_after
    return np.asarray(sign * after if gear.verdict is Verdict.EXPLAINED else after)


def _by_axis(values: FloatArray, turned: FloatArray) -> FloatArray:
    """Return values by direction and payload as values by axis and payload."""
    return np.asarray((turned.T @ values.reshape(len(turned), -1)).ravel())


def _data(
    found: tuple[Reversal, ...], scatter: _Scatter, turned: FloatArray, model: Model
) -> Reversals:
    """Return the reversals along directions (a, a) in which the scatter is not correlated.

    A dial's scatter that comes from a joint is common to X and Y.
    """
    names = list(dict.fromkeys(one.axis for one in found))
    halves = np.array([one.half_width_mm for one in found]).reshape(len(names), -1)
    payload = np.array([one.payload_kg for one in found])
    counts = [one.cycles for one in found[: halves.shape[1]]]
    levers = {
        joint: turned @ [lever_mm(model, joint)[name] / 2 for name in names]
        for joint in model.gearboxes
    }
    return Reversals(
        measured=(turned @ halves).ravel(),
        sweeps={joint: sweep_of(model, joint, payload) for joint in levers},
        levers={joint: np.repeat(lever, halves.shape[1]) for joint, lever in levers.items()},
        group=np.unique(payload, return_inverse=True)[1].astype(np.int64),
        uncertainty=np.array([scatter.of_half_width(d, n) for d in turned for n in counts]),
        degrees=scatter.degrees,
    )
