"""The visits as a run: what a dial would have been read as, with the conditions of each visit."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from scara_iso.pose_columns import arrival_labels, number_cycles
from scara_iso.run import FloatArray, Run
from scara_iso.streams.result import Rule, Visit
from scara_iso.transient_columns import overshoot_column, stabilisation_column

_DITHERED = 0.5
"""Scatter over division from which a mean of samples is finer than the division: the rounding error
of Gaussian scatter's mean is then below 1 % of it (Widrow and Kollar 2008, as known)."""
_FINER = 0.01
_MICROSECOND = 6
_LABELLED = ("X", "Y", "Z")
"""Axes along which a direction of approach has a name."""


def table(run: Run, visits: Sequence[Visit], rule: Rule, rate_hz: float) -> tuple[Run, list[str]]:
    """Return the run of the visits, and what was noted on the way.

    The mean of an axis whose samples hardly scatter is rounded to the dial's division, as its
    reading would be; where they scatter by half a division or more the mean is finer, and the
    table states a hundredth of the division.
    """
    pose = np.array([v.pose for v in visits]) if visits[0].pose is not None else None
    axes, notes = {}, []
    for name, axis in run.axes.items():
        readings = np.array([visit.mean[name] for visit in visits])
        division = axis.resolution
        if division is not None:
            scatter = float(np.median([visit.scatter[name] for visit in visits]))
            if scatter >= _DITHERED * division:
                division *= _FINER
                notes.append(f"{name}: the samples scatter over divisions, so the mean is finer")
            places = max(0, math.ceil(-math.log10(division)) + 2)
            readings = np.round(np.round(readings / division) * division, places)
            division = float(f"{division:.6g}")
        axes[name] = replace(axis, readings=readings, resolution=division)
    approach, direction, more = _approach(run, visits)
    covariates = {
        "time_s": np.round([sum(v.averaged) / 2 for v in visits], _MICROSECOND),
        **approach,
        **_means(run, visits),
        **_transients(run, visits),
    }
    metadata = {
        **run.metadata,
        "stream_samples": str(len(run)),
        "stream_rate_hz": f"{rate_hz:.6g}",
        "visit_rule": f"dwell {rule.dwell_s:g} s, window {rule.window_s:.6g} s, still "
        f"{rule.still:g}, band " + " ".join(f"{n} {b:g}" for n, b in rule.band.items()),
    }
    metadata.pop("timestamp_start", None)
    made = Run(
        cycle=number_cycles(None, arrival_labels(pose, direction), len(visits)),
        axes=axes,
        pose=pose,
        covariates=covariates,
        metadata=metadata,
        origin=replace(run.origin, notes=()),
        direction=direction,
    )
    return made, notes + more


def _approach(
    run: Run, visits: Sequence[Visit]
) -> tuple[dict[str, FloatArray], npt.NDArray[np.str_] | None, list[str]]:
    """Return the column of the axis along which every visit arrives, if there is one.

    Where each visit arrives along one axis alone, and not all along the same, the labels of their
    directions (7.2.3) in its place: ``+x`` where the reading of X rose.
    """
    came = {n: np.array([v.approach[n] for v in visits], dtype=float) for n in run.axes}
    labels = [_along_one_axis(visit) for visit in visits]
    known = [label for label in labels if label is not None]
    if len(known) == len(labels) and len({label[1:] for label in known}) > 1:
        said = f"approach is from {', '.join(dict.fromkeys(known))}"
        return {}, np.array(known), [said]
    whole = [name for name, signs in came.items() if np.all(signs != 0)]
    if not whole:
        said = "no axis moves at every arrival: no column approach; `json=True` has each axis"
        return {}, None, [said]
    others = [n for n in came if n != whole[0] and np.any(came[n] != came[whole[0]])]
    said = f"approach is the direction along {whole[0]}"
    notes = [f"{said}; it differs along {', '.join(others)}"] if others else []
    return {"approach": came[whole[0]]}, None, notes


def _along_one_axis(visit: Visit) -> str | None:
    moved = [(name, sign) for name, sign in visit.approach.items() if sign]
    if len(moved) != 1 or moved[0][0] not in _LABELLED:
        return None
    name, sign = moved[0]
    return f"{'+' if sign > 0 else '-'}{name.lower()}"


def _means(run: Run, visits: Sequence[Visit]) -> dict[str, FloatArray]:
    """Return the mean over each visit of what else the stream recorded, such as a temperature."""
    time, found = run.covariates["time_s"], {}
    for name, values in run.covariates.items():
        if name not in ("time_s", "approach"):
            ends = np.searchsorted(time, [v.averaged for v in visits])
            means = [values[first : max(last, first + 1)].mean() for first, last in ends.tolist()]
            found[name] = np.array([float(f"{mean:.9g}") for mean in means])
    return found


def _transients(run: Run, visits: Sequence[Visit]) -> dict[str, FloatArray]:
    """Return the columns that are known for every visit."""
    found = {}
    for name, axis in run.axes.items():
        times = [visit.stabilisation_s[name] for visit in visits]
        beyond = [visit.overshoot[name] for visit in visits]
        if None not in times and None not in beyond:
            found[stabilisation_column(name)] = np.round(np.array(times, dtype=float), 6)
            found[overshoot_column(name, axis.dimension)] = np.round(
                np.array(beyond, dtype=float), 6
            )
    return found
