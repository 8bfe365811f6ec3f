"""Reversals in a run: half the distance between the approaches, by payload, against the gears."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from scara_iso.base.errors import DataError
from scara_iso.base.quantities import Dimension, rounding_uncertainty
from scara_iso.diagnosis.gears import Reversals, diagnose_reversals
from scara_iso.diagnosis.sweeps import GearDiagnosis, Reversal, RunReversals
from scara_iso.diagnosis.verdict import SEED, Verdict
from scara_iso.effects import Conditions, Sweep
from scara_iso.robot import Model, lever_mm, predict, sweep_of
from scara_iso.run import FloatArray, IntArray, Run, step_of

_LISTED = 5
_FEWEST = 3
_COARSE = 0.5
"""Scatter under this share of a division leaves the rounding of a mean unaveraged."""


def diagnose_sweep(
    sweep: Sweep, measured: FloatArray, *, uncertainty: FloatArray | None = None, seed: int = SEED
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
    planar = (name for name in ("X", "Y") if name in run.axes)
    names = [name for name in planar if run.axes[name].dimension is Dimension.LENGTH]
    if not {"approach", "payload_kg"} <= run.covariates.keys() or not names:
        return None
    halves = _halves(run, model, names)
    left_out = sorted(set(run.covariates["payload_kg"].tolist()) - set(halves.payload.tolist()))
    listed = ", ".join(f"{p:g}" for p in left_out[:_LISTED]) + ", .." * (len(left_out) > _LISTED)
    notes = [f"payload {listed} kg: approached from one side only, left out"] if left_out else []
    missing = tuple(_missing(model, len(halves.payload)))
    too_few = halves.degrees <= len(names)  # their covariance is all but singular
    if too_few:
        notes.append("no scatter can be told: approach each payload several times from both sides")
    if missing or too_few:
        return RunReversals(halves.reversals(), None, missing, notes=tuple(notes))
    return _compared(halves, model, notes, seed=seed)


class _Halves(NamedTuple):
    """Halves of the distance between the approaches, ``half`` (axes, payloads) [mm].

    ``counts`` (payloads, 2) are the cycles of each side. The readings scatter about the mean of
    their payload and approach by ``covariance`` (axes, axes), not below the rounding, with
    ``degrees`` of freedom; ``rounding`` (axes,) is the variance of a mean that averaging does not
    lower: of rounding without enough scatter.
    """

    names: Sequence[str]
    payload: FloatArray
    counts: IntArray
    half: FloatArray
    covariance: FloatArray
    rounding: FloatArray
    degrees: int

    def uncertainty(self, directions: FloatArray) -> FloatArray:
        """Return the standard uncertainty (d, payloads) along unit vectors (d, axes)."""
        each = np.einsum("da,ab,db->d", directions, self.covariance, directions)
        rounding = directions**2 @ self.rounding
        of_means = np.outer(each, (1 / self.counts).sum(axis=1)) + 2 * rounding[:, np.newaxis]
        return np.asarray(np.sqrt(of_means) / 2)

    def reversals(self, *predicted: FloatArray) -> tuple[Reversal, ...]:
        """Return them by axis and then payload; ``predicted`` (axes, payloads) before and after."""
        values = np.stack([self.half, self.uncertainty(np.eye(len(self.names))), *predicted])
        return tuple(
            Reversal(name, payload, tuple(self.counts[k].tolist()), *values[:, a, k].tolist())
            for a, name in enumerate(self.names)
            for k, payload in enumerate(self.payload.tolist())
        )


def _halves(run: Run, model: Model, names: Sequence[str]) -> _Halves:
    expected = predict(model, Conditions(run.cycle, run.covariates), reversal=False).axes
    known = [expected[name].readings if name in expected else 0.0 for name in names]
    left = np.stack([run.axes[n].readings - k for n, k in zip(names, known, strict=True)])
    payload, side = run.covariates["payload_kg"], np.sign(run.covariates["approach"])
    parts = {
        p: [left[:, (payload == p) & (side == s)] for s in (1, -1)] for p in np.unique(payload)
    }
    parts = {p: both for p, both in parts.items() if all(part.size for part in both)}
    within = [part - part.mean(axis=1, keepdims=True) for both in parts.values() for part in both]
    degrees = sum(part.shape[1] - 1 for part in within)
    squares = sum((part @ part.T for part in within), np.zeros((len(names), len(names))))
    covariance = squares / max(degrees, 1)
    variance = covariance.diagonal()
    steps = np.array([step_of(run.axes[name]) for name in names])
    rounding = np.array([rounding_uncertainty(step) ** 2 for step in steps])
    halves = [(plus.mean(axis=1) - minus.mean(axis=1)) / 2 for plus, minus in parts.values()]
    return _Halves(
        names=names,
        payload=np.array([*parts], dtype=np.float64),
        counts=np.reshape([part.shape[1] for both in parts.values() for part in both], (-1, 2)),
        half=np.stack(halves, axis=1) if halves else np.empty((len(names), 0)),
        covariance=covariance + np.diag(np.maximum(rounding - variance, 0.0)),
        rounding=np.where(np.sqrt(variance) < _COARSE * steps, rounding, 0.0),
        degrees=degrees,
    )


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


def _compared(halves: _Halves, model: Model, notes: list[str], *, seed: int) -> RunReversals:
    """Return the reversals against eq. 16, along directions in which the scatter is uncorrelated.

    A dial's scatter that comes from a joint is common to X and Y.
    """
    turned, payloads = np.linalg.eigh(halves.covariance)[1].T, len(halves.payload)
    levers = {
        joint: turned @ [lever_mm(model, joint)[name] / 2 for name in halves.names]
        for joint in model.gearboxes
    }
    each = np.tile(halves.payload, len(turned))
    data = Reversals(
        measured=(turned @ halves.half).ravel(),
        sweeps={joint: sweep_of(model, joint, each) for joint in levers},
        levers={joint: np.repeat(lever, payloads) for joint, lever in levers.items()},
        group=np.tile(np.arange(payloads), len(turned)),
        uncertainty=halves.uncertainty(turned).ravel(),
        degrees=halves.degrees,
    )
    before = data.predict()[0]
    mirrored = float(data.measured @ before) < 0
    sign = -1.0 if mirrored else 1.0
    gear = diagnose_reversals(replace(data, measured=sign * data.measured), seed=seed, sides=2)
    after = gear.series.predicted_after
    after = sign * after if gear.verdict is Verdict.EXPLAINED else after
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
    by_axis = [turned.T @ values.reshape(len(turned), -1) for values in (before, after)]
    return RunReversals(halves.reversals(*by_axis), gear, (), mirrored, (*notes, *gear.notes))
