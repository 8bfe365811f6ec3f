"""The same loop on the gear: measured reversals against eq. 16, and what they lack."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from scara_iso.base.errors import DataError
from scara_iso.base.published import Probability
from scara_iso.diagnosis.naming.choice import Choice, posterior
from scara_iso.diagnosis.reversals.fit import (
    Family,
    Fitted,
    Joint,
    Reversals,
    fit_family,
    pair_families,
    single_families,
)
from scara_iso.diagnosis.reversals.significance import (
    FLOOR,
    misfits,
    p_value_of_scatter,
    second_p_value,
    wanders,
)
from scara_iso.diagnosis.reversals.unknown import unknown_families
from scara_iso.diagnosis.tuning import FURTHER_LEVEL, LEVEL, SEED, UNKNOWN
from scara_iso.diagnosis.verdict import Rival, Verdict
from scara_iso.effects import GearEffect, Sweep, find_gear_effects
from scara_iso.run import FloatArray

_FEWEST = 3


@dataclass(frozen=True, eq=False, slots=True)
class GearFound:
    """An effect on the load deviation; intervals are 95 %, over all effects that were found."""

    effect: str
    """Name of the effect; `explain` takes it."""
    joint: Joint
    """Number of the joint; None for a sweep of one gear."""
    parameters: Mapping[str, float]
    """By name, in the units that the effect's page states."""
    intervals: Mapping[str, tuple[float, float]]
    """95 %, by the name of the parameter."""
    p_value: Probability
    """Chance of as much in scatter alone."""
    probability: Probability
    """Of the effects found, together."""
    rivals: tuple[Rival, ...]
    """Other effects that fit as well, likeliest first."""
    cause: str
    """What usually causes it."""
    confirm_by: str
    """The experiment that confirms it."""


@dataclass(frozen=True, eq=False, slots=True)
class GearDiagnosis:
    """What the two-inertia model leaves unexplained of reversals, shape (m,), in their unit."""

    verdict: Verdict
    """Whether something is left, and whether effects explain it."""
    p_value: float
    """Chance of as much left in scatter alone."""
    p_value_at_floor: bool
    """No simulation came as far: the chance is at most the p-value."""
    effects: tuple[GearFound, ...]
    """At most two."""
    candidates: tuple[Rival, ...]
    """Nearest effects where the verdict is that none fits."""
    rms_before: float
    """Root mean square of what eq. 16 leaves."""
    rms_after: float
    """Of what eq. 16 with the effects leaves."""
    held_out_before: float
    """Of groups that the fit did not see, by eq. 16."""
    held_out_after: float | None
    """Each group (a reversal; a payload) left out in turn; None where there is one only."""
    measured: FloatArray
    """Shape (m,)."""
    predicted_before: FloatArray
    """By eq. 16, shape (m,)."""
    predicted_after: FloatArray
    """With the effects, shape (m,)."""
    notes: tuple[str, ...] = ()
    """What could not be tried, one line each."""


def diagnose_sweep(
    sweep: Sweep,
    measured: FloatArray,
    *,
    uncertainty: FloatArray | None = None,
    seed: int = SEED,
    effects: Sequence[GearEffect] | None = None,
) -> GearDiagnosis:
    """Return what eq. 16 leaves of measured load deviations (m,) in rad, and which effect it is.

    Deviations follow eq. 16's sign (negative); ``uncertainty`` (m,) are standard uncertainties.
    Without them the scatter is unknown and may grow with the deviation. Raises `DataError` for
    fewer than 3 reversals.
    """
    if len(measured) < _FEWEST:
        raise DataError(
            f"{len(measured)} reversals cannot be told from chance",
            remedy=f"measure at least {_FEWEST}, at different inertias",
        )
    data = Reversals(
        measured,
        {None: sweep},
        {None: np.ones(len(measured))},
        np.arange(len(measured)),
        uncertainty,
    )
    found = diagnose_reversals(data, seed=seed, effects=effects)
    without = "no torque_Nm column: wind-up was not tried"
    return replace(found, notes=(*found.notes, without)) if sweep.torque is None else found


def diagnose_reversals(
    data: Reversals, *, seed: int, effects: Sequence[GearEffect] | None = None, sides: int = 1
) -> GearDiagnosis:
    """Return what eq. 16 leaves of reversals, and which effects it is; two at the most.

    ``sides`` is 2 where the sign of the reversals was chosen to suit the model.
    """
    singles = single_families(data, find_gear_effects() if effects is None else effects)
    before = data.predict()
    rng = np.random.default_rng(seed)
    chance = p_value_of_scatter(data, before, [*singles, *unknown_families(data)], rng)
    at_floor, chance = chance <= FLOOR, min(1.0, sides * chance)
    nothing = _as_predicted(data, chance, at_floor=at_floor)
    if chance > LEVEL:
        return replace(nothing, notes=_notes(data, _hidden(data, nothing)))
    families, choice = _chosen(data, singles)
    best = choice.forms[choice.best]
    if choice.best == UNKNOWN or misfits(data, best) or wanders(data, best, rng):
        near = tuple(rival for rival in choice.ranked if rival.effect != UNKNOWN)[:3]
        return replace(
            nothing, verdict=Verdict.UNEXPLAINED, candidates=near, notes=_notes(data, ())
        )
    found = _found(best, choice, chance)
    unseen = _left_out(data, families)
    return replace(
        _explained(nothing, data, found, best),
        held_out_after=unseen,
        notes=_notes(data, _settled_by(choice)),
    )


def _chosen(data: Reversals, singles: Sequence[Family]) -> tuple[list[Family], Choice[Fitted]]:
    """Return the families that compete, one effect or two, and the choice among their fits."""
    one = [fit_family(data, family) for family in singles]
    rows, conditions = len(data.measured), distinct_conditions(data)
    pairs = [*pair_families(singles, conditions, rows)]
    pairs += unknown_families(data) if min(rows - 1, conditions) >= 2 else []
    two = [fit_family(data, family) for family in pairs]
    if two and second_p_value(data, one, two) <= FURTHER_LEVEL:
        return pairs, _choice(two)
    return list(singles), _choice(one)


def _choice(fits: Sequence[Fitted]) -> Choice[Fitted]:
    ranked = sorted(fits, key=lambda fit: -fit.log_evidence)
    forms: dict[str, Fitted] = {}
    evidence: dict[str, float] = {}
    for fit in ranked:
        name, relative = _label(fit), fit.log_evidence - ranked[0].log_evidence
        forms.setdefault(name, fit)
        evidence[name] = evidence.get(name, 0.0) + float(np.exp(relative))
    return Choice(posterior(evidence), forms)


def _label(fit: Fitted) -> str:
    joints = {term.joint for term in fit.family} - {None}
    if fit.family[0].effect.name == UNKNOWN:
        return UNKNOWN
    return (
        fit.name
        if not joints
        else "+".join(f"{term.effect.name} at joint {term.joint}" for term in fit.family)
    )


def _found(best: Fitted, choice: Choice[Fitted], p_value: float) -> tuple[GearFound, ...]:
    return tuple(
        GearFound(
            effect=term.effect.name,
            joint=term.joint,
            parameters=values,
            intervals=spread,
            p_value=p_value,
            probability=choice.probability[choice.best],
            rivals=choice.rivals,
            cause=term.effect.cause,
            confirm_by=term.effect.confirm_by,
        )
        for term, values, spread in zip(best.family, best.values, best.spread, strict=True)
    )


def _left_out(data: Reversals, families: Sequence[Family]) -> float | None:
    """Return the root mean square error at each group, effect and values chosen without it."""
    groups = np.unique(data.group)
    if len(groups) < 2:
        return None
    errors = []
    for group in groups:
        seen = data.without(int(group))
        fits = [fit_family(seen, family) for family in families]
        best = max(fits, key=lambda fit: fit.log_evidence)
        left = data.measured - data.predict(best.changes)[0]
        errors.append(left[data.group == group])
    return float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))


def distinct_conditions(data: Reversals) -> int:
    """Return how many distinct inertias (and torques) the reversals were measured at."""
    columns = [
        part
        for sweep in data.sweeps.values()
        for part in (sweep.I_L / sweep.I_m, sweep.torque)
        if part is not None
    ]
    return len(np.unique(np.round(np.stack(columns, axis=1), 12), axis=0))


def _settled_by(choice: Choice[Fitted]) -> list[str]:
    """Return one line for each rival: what would tell it from the effects found."""
    best = choice.forms[choice.best].family
    own = {term.effect.name for term in best}
    lines = []
    for rival in choice.rivals:
        family = choice.forms[rival.effect].family
        ways = [t.effect.confirm_by for t in family if t.effect.name not in own]
        ways = ways or [term.effect.confirm_by for term in best]
        lines.append(f"{choice.best} or {rival.effect}: {'; '.join(dict.fromkeys(ways))}")
    return lines


def _hidden(data: Reversals, nothing: GearDiagnosis) -> list[str]:
    """Return a line where a scatter that is not known may hide what eq. 16 lacks."""
    size = float(np.sqrt((nothing.predicted_before**2).mean()))
    if data.uncertainty is not None or nothing.rms_before < size:
        return []
    times = nothing.rms_before / size
    line = (
        f"eq. 16 leaves {times:.2g} times its own prediction, too unevenly to be told from scatter"
    )
    return [f"{line}: give u_rad, or measure each reversal several times"]


def _notes(data: Reversals, settled: Sequence[str]) -> tuple[str, ...]:
    notes = []
    ratios = [len(np.unique(np.round(s.I_L / s.I_m, 12))) for s in data.sweeps.values()]
    if max(ratios) < 2:
        notes.append(
            "one ratio of inertias only: effects that scale the deviation cannot be told apart; "
            "vary the inertia of the payload"
        )
    return (*notes, *settled)


def _as_predicted(data: Reversals, p_value: float, *, at_floor: bool) -> GearDiagnosis:
    before = data.predict()
    rms = float(np.sqrt(((data.measured - before) ** 2).mean()))
    return GearDiagnosis(
        verdict=Verdict.NOTHING,
        p_value=p_value,
        p_value_at_floor=at_floor,
        effects=(),
        candidates=(),
        rms_before=rms,
        rms_after=rms,
        held_out_before=rms,
        held_out_after=rms,
        measured=data.measured,
        predicted_before=before,
        predicted_after=before,
    )


def _explained(
    nothing: GearDiagnosis, data: Reversals, found: tuple[GearFound, ...], fit: Fitted
) -> GearDiagnosis:
    after = data.predict(fit.changes)[0]
    left = float(np.sqrt(((data.measured - after) ** 2).mean()))
    return replace(
        nothing, verdict=Verdict.EXPLAINED, effects=found, rms_after=left, predicted_after=after
    )
