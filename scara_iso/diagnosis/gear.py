"""The same loop on the gear: measured reversals against eq. 16, and what they lack."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from scara_iso.diagnosis.result import Rival, Verdict
from scara_iso.effects import GearEffect, Sweep, find_gear_effects
from scara_iso.effects._effect import Sizes
from scara_iso.effects._gap import deviation
from scara_iso.errors import DataError
from scara_iso.run import FloatArray

_LEVEL = 0.05
_SIMULATIONS = 999
_FEWEST = 3
_RIVAL = 0.1
_MISFIT_LEVEL = 0.01
_RELATIVE_FLOOR = 1e-6
"""A reversal is not known better than this share of the largest one."""
_ZOOMS, _ZOOMED = 3, 401
_LIGHTEST = 1e-6
"""Candidates lighter than this share of the best one are left out of the finer ones."""


@dataclass(frozen=True, eq=False, slots=True)
class GearFound:
    """An effect on the load deviation; intervals are 95 % and hold for this effect alone."""

    effect: str
    parameters: Mapping[str, float]
    intervals: Mapping[str, tuple[float, float]]
    p_value: float
    probability: float
    rivals: tuple[Rival, ...]
    cause: str
    confirm_by: str


@dataclass(frozen=True, eq=False, slots=True)
class GearDiagnosis:
    """What the two-inertia model leaves unexplained in a sweep; deviations in rad, shape (m,)."""

    verdict: Verdict
    effects: tuple[GearFound, ...]
    rms_before: float
    rms_after: float
    held_out_before: float
    held_out_after: float
    """Leave-one-out; before nothing is fitted, so it is ``rms_before``."""
    measured: FloatArray
    predicted_before: FloatArray
    predicted_after: FloatArray
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False, slots=True)
class _Family:
    """One effect and its predictions (candidates, m)."""

    effect: GearEffect
    candidates: tuple[Sizes, ...]
    predictions: FloatArray


def diagnose_sweep(
    sweep: Sweep,
    measured: FloatArray,
    *,
    uncertainty: FloatArray | None = None,
    seed: int = 9283,
    effects: Sequence[GearEffect] | None = None,
) -> GearDiagnosis:
    """Return what eq. 16 leaves of measured load deviations (m,) in rad, and which effect it is.

    Deviations follow eq. 16's sign (negative); ``uncertainty`` (m,) are standard uncertainties,
    and without them the scatter is taken equal at all reversals and unknown. One effect is
    sought. Raises `DataError` for fewer than 3 reversals.
    """
    if len(measured) < _FEWEST:
        raise DataError(
            f"{len(measured)} reversals cannot be told from chance",
            remedy=f"measure at least {_FEWEST}, at different inertias",
        )
    families = _families(sweep, find_gear_effects() if effects is None else effects)
    before = deviation(sweep.I_m, sweep.I_L, sweep.gap)
    scale = np.ones_like(before) if uncertainty is None else uncertainty
    rng = np.random.default_rng(seed)
    p_value = _p_value(measured, before, families, scale, uncertainty is not None, rng)
    if p_value > _LEVEL:
        return _result(Verdict.NOTHING, (), measured, before, before, None, _notes(sweep, ()))
    known = uncertainty is not None
    weights = _weights(measured, families, scale, known)
    evidence = np.array([w.mean() for w in weights])
    best = int(np.argmax(evidence))
    families[best], weights[best] = _zoomed(
        sweep, measured, families[best], weights[best], scale, known
    )
    found = _found(families, weights, evidence / evidence.sum(), best, p_value)
    after = families[best].predictions[int(np.argmax(weights[best]))]
    misfit = float((((measured - after) / scale) ** 2).sum())
    fits = not known or misfit <= _chi_squared_quantile(max(1, len(measured) - 1), _MISFIT_LEVEL)
    verdict = Verdict.EXPLAINED if fits else Verdict.UNEXPLAINED
    unseen = _left_out(measured, families, scale, known)
    return _result(verdict, (found,), measured, before, after, unseen, _notes(sweep, (found,)))


def _families(sweep: Sweep, effects: Sequence[GearEffect]) -> list[_Family]:
    tried = [(effect, effect.candidates(sweep)) for effect in effects]
    return [
        _Family(effect, values, np.stack([effect.deviation(sweep, v) for v in values]))
        for effect, values in tried
        if values
    ]


def _misfit(measured: FloatArray, predictions: FloatArray, scale: FloatArray) -> FloatArray:
    """Return sums of squares (candidates, ...) of measured (..., m) about predictions."""
    squares = ((measured - predictions) / scale) ** 2
    floor = (_RELATIVE_FLOOR * np.abs(measured / scale).max()) ** 2
    return np.asarray(squares.sum(axis=-1) + floor)


def _log_likelihood(misfit: FloatArray, m: int, known: bool) -> FloatArray:
    """Return log likelihoods; an unknown scatter is integrated out under the prior 1 / scatter."""
    return np.asarray(-misfit / 2 if known else -m / 2 * np.log(misfit))


def _weights(
    measured: FloatArray, families: Sequence[_Family], scale: FloatArray, known: bool
) -> list[FloatArray]:
    """Return each candidate's likelihood, for every family, relative to the largest of all."""
    misfits = [_misfit(measured, family.predictions, scale) for family in families]
    logs = [_log_likelihood(misfit, len(measured), known) for misfit in misfits]
    peak = max(float(log.max()) for log in logs)
    return [np.asarray(np.exp(log - peak)) for log in logs]


def _zoomed(
    sweep: Sweep,
    measured: FloatArray,
    family: _Family,
    weight: FloatArray,
    scale: FloatArray,
    known: bool,
) -> tuple[_Family, FloatArray]:
    """Return a family of one parameter on ever finer candidates where its weight lies."""
    for _ in range(_ZOOMS):
        if len(family.effect.parameters) != 1 or len(family.candidates) < 3:
            break
        name = family.effect.parameters[0].name
        values = np.array([candidate[name] for candidate in family.candidates])
        inside = np.flatnonzero(weight > _LIGHTEST * weight.max())
        ends = values[[max(inside[0] - 1, 0), min(inside[-1] + 1, len(values) - 1)]]
        finer = tuple({name: float(v)} for v in np.linspace(ends[0], ends[1], _ZOOMED))
        predictions = np.stack([family.effect.deviation(sweep, v) for v in finer])
        family = _Family(family.effect, finer, predictions)
        (weight,) = _weights(measured, [family], scale, known)
    return family, weight


def _p_value(
    measured: FloatArray,
    before: FloatArray,
    families: Sequence[_Family],
    scale: FloatArray,
    known: bool,
    rng: np.random.Generator,
) -> float:
    """Return how often eq. 16 with Gaussian scatter alone fits some effect as much better."""
    residual = (measured - before) / scale
    size = 1.0 if known else float(np.sqrt((residual**2).mean()))
    drawn = before + scale * size * rng.normal(size=(_SIMULATIONS, len(measured)))
    observed = _gain(measured[np.newaxis], before, families, scale, known)[0]
    simulated = _gain(drawn, before, families, scale, known)
    return float((1 + (simulated >= observed).sum()) / (1 + _SIMULATIONS))


def _gain(
    readings: FloatArray, before: FloatArray, families: Sequence[_Family], scale: FloatArray,
    known: bool,
) -> FloatArray:  # fmt: skip
    """Return the log likelihood gained by the best candidate of any effect, shape (readings,)."""
    m = readings.shape[1]
    alone = _log_likelihood(_misfit(readings, before, scale), m, known)
    every = np.concatenate([family.predictions for family in families]) / scale
    scaled = readings / scale
    cross = scaled @ every.T
    misfit = (scaled**2).sum(axis=1)[:, None] - 2 * cross + (every**2).sum(axis=1)
    floor = (_RELATIVE_FLOOR * np.abs(scaled).max()) ** 2
    best = _log_likelihood(np.maximum(misfit, 0).min(axis=1) + floor, m, known)
    return np.asarray(best - alone)


def _found(
    families: Sequence[_Family],
    weights: Sequence[FloatArray],
    probability: FloatArray,
    best: int,
    p_value: float,
) -> GearFound:
    effect, candidates = families[best].effect, families[best].candidates
    names = [parameter.name for parameter in effect.parameters]
    ranked = sorted(range(len(families)), key=lambda i: -probability[i])
    rivals = [i for i in ranked[1:] if probability[i] >= _RIVAL * probability[best]]
    return GearFound(
        effect=effect.name,
        parameters=dict(candidates[int(np.argmax(weights[best]))]),
        intervals={name: _interval(candidates, weights[best], name) for name in names},
        p_value=p_value,
        probability=float(probability[best]),
        rivals=tuple(Rival(families[i].effect.name, float(probability[i])) for i in rivals),
        cause=effect.cause,
        confirm_by=effect.confirm_by,
    )


def _interval(candidates: Sequence[Sizes], weight: FloatArray, name: str) -> tuple[float, float]:
    share = np.cumsum(weight) / weight.sum()
    low, high = np.searchsorted(share, [0.025, 0.975])
    return candidates[int(low)][name], candidates[min(int(high), len(candidates) - 1)][name]


def _left_out(
    measured: FloatArray, families: Sequence[_Family], scale: FloatArray, known: bool
) -> float:
    """Return the root mean square error at each reversal, effect and value chosen without it."""
    errors = []
    for i in range(len(measured)):
        seen = np.arange(len(measured)) != i
        part = [_Family(f.effect, f.candidates, f.predictions[:, seen]) for f in families]
        weights = _weights(measured[seen], part, scale[seen], known)
        best = int(np.argmax([w.mean() for w in weights]))
        value = families[best].predictions[int(np.argmax(weights[best])), i]
        errors.append(measured[i] - value)
    return float(np.sqrt(np.mean(np.square(errors))))


def _notes(sweep: Sweep, found: Sequence[GearFound]) -> tuple[str, ...]:
    notes = []
    if len(np.unique(np.round(sweep.I_L / sweep.I_m, 12))) < 2:
        notes.append(
            "one ratio of inertias only: effects that scale the deviation cannot be told apart; "
            "vary the inertia of the payload"
        )
    if sweep.torque is None:
        notes.append("no torque_Nm column: wind-up was not tried")
    notes += [f"{f.effect} or {r.effect}: {f.confirm_by}" for f in found for r in f.rivals]
    return tuple(notes)


def _result(
    verdict: Verdict,
    found: tuple[GearFound, ...],
    measured: FloatArray,
    before: FloatArray,
    after: FloatArray,
    unseen: float | None,
    notes: tuple[str, ...],
) -> GearDiagnosis:
    rms_before = float(np.sqrt(((measured - before) ** 2).mean()))
    rms_after = float(np.sqrt(((measured - after) ** 2).mean()))
    held = rms_before if unseen is None else unseen
    return GearDiagnosis(
        verdict, found, rms_before, rms_after, rms_before, held, measured, before, after, notes
    )


def _chi_squared_quantile(nu: int, level: float) -> float:
    """Return the upper ``level`` quantile (Wilson and Hilferty 1931)."""
    z = NormalDist().inv_cdf(1 - level)
    return float(nu * (1 - 2 / (9 * nu) + z * (2 / (9 * nu)) ** 0.5) ** 3)
