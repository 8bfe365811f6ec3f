"""Figures against the limits that a user gives.

A limit is kept where the whole 95 % interval of the figure is at most the limit, and broken where
all of it is above; else these cycles prove neither. An interval that a finding voids (a drift) is
marked: what is decided by it holds only while the robot drifts in the same way. Simple acceptance
(RP at most the limit) is used only on request.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from statistics import NormalDist

from scara_iso.base.errors import UsageError
from scara_iso.base.quantities import Estimate, Unit, size_in, which_unit
from scara_iso.iso9283.core.figures import EVERY_LENGTH, Conformity, DecisionRule, Limit
from scara_iso.iso9283.core.results import Characteristic, Finding, LimitCheck
from scara_iso.run import AXES, Run

MOST_CYCLES = 100_000
"""Stands for that many cycles and more."""
_AXES_OF = {"XY": ("X", "Y"), "XYZ": ("X", "Y", "Z")}
_ORDER = (*AXES, "", "XY", "XYZ")
_POWER = 1.3  # of a mean, 4 of 5 tests prove it
_TO_HOLD, _TO_PROVE = NormalDist().inv_cdf(0.975), NormalDist().inv_cdf(0.975) + 0.84
"""Standard errors that an interval reaches, and that 4 of 5 tests need to lie off the limit."""
_BEYOND = {False: 2.0, True: 10.0}
"""Of scatter, by whether the limit is above: times the error's square, what a proof needs beside
that (benchmarks/conformity.py, Gaussian scatter)."""


def check_limits(
    characteristics: Sequence[Characteristic],
    limits: Mapping[str, Limit],
    findings: Sequence[Finding] = (),
    *,
    decision: DecisionRule = DecisionRule.INTERVAL,
    needs: Mapping[str, str] | None = None,
    units: Mapping[str, Unit] | None = None,
) -> tuple[Characteristic, ...]:
    """Return the characteristics, each with its comparison with the limit that holds for it.

    ``limits`` by name (`Characteristic.limited_by`), in the figure's unit or, as text, with their
    own; a figure with a sign is held by its size. ``findings`` of the same poses say which
    intervals are void, ``needs`` what a characteristic asks of a test, by its code, ``units`` in
    which other unit an axis was given. Raises `UsageError` for a limit that is not positive and
    finite, of what the run does not have, or a bare one where a table is in another unit.
    """
    _refuse_unknown(characteristics, limits, needs or {})
    void = {(one.pose, one.axis) for one in findings if one.voids_interval}

    def checked(found: Characteristic) -> Characteristic:
        name = next((name for name in found.limited_by if name in limits), None)
        if name is None:
            return found
        axes, poses = _AXES_OF.get(found.of, (found.of,)), found.between or (found.pose,)
        given_in = next((units[axis] for axis in axes if units and axis in units), None)
        ends = [limit_in(e, found.estimate.unit, name, given_in) for e in _ends(limits[name])]
        is_void = any((pose, axis) in void for pose in poses for axis in axes)
        return replace(found, limit=_check(found, ends, decision, is_void=is_void))

    return tuple(map(checked, characteristics))


def _refuse_unknown(
    characteristics: Sequence[Characteristic], limits: Mapping[str, Limit], needs: Mapping[str, str]
) -> None:
    names = {name for one in characteristics for name in one.limited_by}
    unknown = sorted(set(limits) - {EVERY_LENGTH} - names)
    if unknown:
        code = unknown[0].partition(":")[0]
        why = "this table has no such figure"
        if code in {one.code for one in characteristics}:
            why = "this figure takes no limit" if unknown[0] == code else "it has none at this pose"
        elif code in needs:
            why += f"; it needs {needs[code]}"
        there = f"it has {', '.join(_plain_names(characteristics))}"
        raise UsageError(f"`limit={unknown[0]}=...`: {why}", remedy=there)
    if EVERY_LENGTH in limits and EVERY_LENGTH not in names:
        name = _plain_names(characteristics)[0]
        unit = next(one.estimate.unit for one in characteristics if name in one.limited_by)
        raise UsageError(
            f"`limit={said(limits[EVERY_LENGTH])}` is a length, and this table has none of RP",
            remedy=f"name the figure, as in `limits={name}=0.05` ({unit})",
        )


def checks_of(characteristics: Iterable[Characteristic]) -> tuple[LimitCheck, ...]:
    """Return the comparisons by pose and figure, those between poses last."""
    ordered = sorted(characteristics, key=_between_poses)
    poses = list(dict.fromkeys(one.pose for one in ordered))
    ordered.sort(key=lambda one: (poses.index(one.pose), _rank(one.of)))
    return tuple(one.limit for one in ordered if one.limit is not None)


def _between_poses(one: Characteristic) -> bool:
    return not one.name.startswith(one.of)


def _rank(of: str) -> int:
    return _ORDER.index(of) if of in _ORDER else len(AXES)


def _plain_names(characteristics: Iterable[Characteristic]) -> list[str]:
    found = sorted(characteristics, key=lambda one: (_between_poses(one), _rank(one.of)))
    ranks = range(max((len(one.limited_by) for one in found), default=0))
    names = (name for k in ranks for one in found for name in one.limited_by[k : k + 1])
    return list(dict.fromkeys(name for name in names if name and ":" not in name))


def said(limit: Limit) -> str:
    """Return a limit as it is given: ``0.24``, ``20um``, or ``0.2..0.24``."""
    return "..".join(end if isinstance(end, str) else f"{end:g}" for end in _ends(limit))


def _ends(limit: Limit) -> Sequence[float | str]:
    return limit if isinstance(limit, tuple) else (limit,)


def limit_in(given: float | str, unit: str, name: str, given_in: Unit | None) -> float:
    """Return a limit in ``unit``; ``given_in`` is another unit in which the readings were given.

    Raises `UsageError` where it has a unit of another kind, or none where that can be read two
    ways.
    """
    option = f"limit={name}" if name else "limit"
    if not isinstance(given, str):
        if given_in is not None and unit == given_in.base_name:
            raise which_unit(option, given, given_in)
        return float(given)
    size = size_in(given, unit)
    if size is None:
        raise UsageError(f"`{option}={given}`: this figure is in {unit}", remedy=f"use {unit}")
    return size


def limit_of_plane(given: float | str, run: Run) -> float:
    """Return a limit of RP in XY in mm; raises as `check_limits`."""
    given_in = next((run.stated_units[axis] for axis in "XY" if axis in run.stated_units), None)
    limit = limit_in(given, "mm", "XY", given_in)
    _refuse_none([limit])
    return limit


def _refuse_none(ends: Sequence[float]) -> None:
    least = ends[0] if len(ends) > 1 else 0.0
    if not (math.isfinite(ends[-1]) and 0 <= least < ends[-1]):
        raise UsageError(
            f"`limit={'..'.join(f'{end:g}' for end in ends)}`: not a positive, finite length",
            remedy="write it in mm, as `limits=0.02`",
        )


def _check(
    found: Characteristic, ends: Sequence[float], decision: DecisionRule, *, is_void: bool
) -> LimitCheck:
    _refuse_none(ends)
    estimate = _size(found.estimate)
    check = LimitCheck(
        figure=found.name,
        code=found.code,
        RP=estimate.value,
        limit=ends[-1],
        lower=ends[0] if len(ends) > 1 else None,
        guard=None if found.reading_u is None else 2 * found.reading_u,
        pose=found.pose,
        interval=estimate.interval,
        decision=decision,
        cycles_wanted=None,
        unit=estimate.unit,
        interval_void=is_void,
    )
    if check.verdict is not Conformity.NOT_PROVABLE:
        return check
    near = min(reversed(ends), key=lambda end: abs(end - estimate.value))
    return replace(check, cycles_wanted=_cycles_wanted(found, estimate, near))


def _size(estimate: Estimate) -> Estimate:
    """Return an estimate without its sign."""
    value, ends = abs(estimate.value), estimate.interval
    if ends is not None:
        near = 0.0 if ends[0] <= 0 <= ends[1] else min(map(abs, ends))
        ends = (near, max(map(abs, ends)))
    return replace(estimate, value=value, interval=ends)


def _cycles_wanted(found: Characteristic, estimate: Estimate, limit: float) -> int | None:
    """Return how many cycles bring the interval's end to the limit in most tests, if any do.

    Standard errors shrink with the root of their number, of a mean itself, of scatter of its
    logarithm; what the indicator adds does not. Where the lower end is 0 the dial hides the scatter
    from however many.
    """
    value, interval = estimate.value, estimate.interval
    added = estimate.parts.get("reading", 0.0) if found.of_means else found.calibration
    U, room = 2 * (added or 0.0), abs(limit - value)
    if interval is None or room <= U or (interval[0] == 0 and not found.of_means):
        return None
    above = limit > value
    end = interval[1] if above else interval[0]
    reach, room = math.sqrt(max((end - value) ** 2 - U**2, 0.0)), math.sqrt(room**2 - U**2)
    if found.of_means:
        times = _POWER * reach / room
    else:
        side, beyond = (1.0 if above else -1.0), _BEYOND[above]
        reach, room = (abs(math.log1p(side * part / value)) for part in (reach, room))
        times = _error(reach, _TO_HOLD, side * beyond) / _error(room, _TO_PROVE, beyond)
    return math.ceil(min(estimate.n * times**2, MOST_CYCLES))


def _error(reach: float, z: float, beyond: float) -> float:
    """Return the standard error whose z-fold and ``beyond``-fold square are a reach together."""
    return 2 * reach / (z + math.sqrt(max(z**2 + 4 * beyond * reach, 0.0)))
