"""From the samples of a stream to a run of visits: what a dial would have read, and when."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.quantities import Dimension
from scara_iso.run import (
    Axis,
    FloatArray,
    Run,
    arrival_labels,
    number_cycles,
    overshoot_column,
    stabilisation_column,
)
from scara_iso.signals.doubts import (
    Samples,
    Stay,
    join,
    label,
    long_rests,
    of_other_thresholds,
    sort,
)
from scara_iso.signals.rests import (
    Doubt,
    Motion,
    Rest,
    Rule,
    SegmentedStream,
    Visit,
    arrive,
    find_rests,
    middle,
    motion,
    plateaus,
    still_of,
)

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
    axes, finer = {}, []
    for name, axis in run.axes.items():
        readings = np.array([visit.mean[name] for visit in visits])
        division = axis.resolution
        if division is not None:
            scatter = float(np.median([visit.scatter[name] for visit in visits]))
            if scatter >= _DITHERED * division:
                division *= _FINER
                finer.append(name)
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
    text = f"{', '.join(finer)}: the samples scatter over divisions, so the mean is finer"
    return made, [text] * bool(finer) + more


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


SLOWEST_HZ = 50.0
"""Sampling rate from which stabilisation time and overshoot are read (iso_test: at least 50 Hz)."""
_ALMOST = 1 - 1e-6
_WINDOWS_IN_DWELL = 5
_FEWEST_SAMPLES = 20
_SCATTERS_IN_BAND = 5.0  # 500 samples of Gaussian scatter leave it once in 3000 rests
_NONE = 1e-6
"""A range that is none, where no division is stated [mm or deg]."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """What the user states of a stream; see `Rule`. Raises `UsageError` for what is not a size."""

    dwell_s: float = 1.0
    still: float | None = None
    band: float | None = None
    poses: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name, value in (("dwell", self.dwell_s), ("still", self.still), ("band", self.band)):
            if value is not None and not 0 < value < math.inf:
                raise UsageError(f"`{name}={value:g}`: not above zero", remedy="correct it")
        if not all(name.strip() for name in self.poses):
            raise UsageError(
                f"`poses={','.join(self.poses)}`: a rest without a name",
                remedy="name each in its order, - for one that is not a pose: `poses=P1,-`",
            )


def find_visits(run: Run, wanted: Wanted) -> SegmentedStream:
    """Return the visits of a stream: a run with a row for each sample and the covariate time_s.

    Raises `DataError` where time is missing or goes back, nothing moves or rests, or levels clearly
    differ and no pose says which is which.
    """
    stream = _stream(run, wanted.dwell_s)
    interval = float(np.median(np.diff(stream.time)))
    found = motion(stream.time, stream.lengths, wanted.dwell_s / _WINDOWS_IN_DWELL)
    still, notes = _still(run, found, wanted, interval)
    stays = join(stream, find_rests(found, still), wanted.dwell_s / 2, still)
    rests, doubts, pauses = sort(stream, stays, wanted.dwell_s, still)
    if not rests:
        raise _no_visit(run, wanted, still, doubts)
    begun = stays[0] if stays[0].first == 0 else None
    kept, labels, remarks = label(stream, rests, wanted.poses, still, begun)
    notes += remarks
    notes += [f"{pauses} rests shorter than half the dwell are not listed"] if pauses else []
    rule = Rule(
        dwell_s=wanted.dwell_s,
        window_s=float(f"{(found.window - 1) * interval:.9g}"),
        samples_in_window=found.window,
        still=still,
        still_stated=wanted.still is not None,
        band={name: wanted.band or _band(axis, kept) for name, axis in run.axes.items()},
        band_stated=wanted.band is not None,
    )
    fast = 1 / interval >= SLOWEST_HZ * _ALMOST
    before = {stay: stays[k - 1].last if k else 0 for k, stay in enumerate(stays)}
    pairs = zip(kept, labels, strict=True)
    read = [_visit(stream, one, before[one], rule, pose, fast=fast) for one, pose in pairs]
    if not fast:
        notes.append(f"{1 / interval:.3g} Hz: stabilisation time and overshoot need 50 Hz or more")
    made, more = table(run, [visit for visit, _ in read], rule, 1 / interval)
    doubts += long_rests(stream, kept)
    doubts += of_other_thresholds(stream, found, rests, wanted.dwell_s, still)
    doubts += [_missing(stream, gap) for gap in found.gaps] + [doubt for _, doubt in read if doubt]
    return SegmentedStream(
        run=made,
        visits=tuple(visit for visit, _ in read),
        doubts=tuple(sorted(doubts, key=lambda doubt: doubt.start)),
        rule=rule,
        samples=len(stream.time),
        rate_hz=1 / interval,
        notes=(*notes, *more),
    )


def _no_visit(run: Run, wanted: Wanted, still: float, doubts: Sequence[Doubt]) -> DataError:
    seen = f"; {doubts[0].message} ({doubts[0].start:.3f} s)" if doubts else ""
    return DataError(
        f"no rest of {wanted.dwell_s:g} s or more within {still:g}{seen}",
        where=run.origin.source,
        remedy="state the shortest rest that is a visit as `dwell=0.5`, or `still=` larger",
    )


def _missing(stream: Samples, gap: int) -> Doubt:
    lasts = stream.at(gap + 1) - stream.at(gap)
    message = f"samples are missing for {lasts:.3g} s: what happened then is not known"
    return stream.doubt("missing-samples", Rest(gap, gap + 1), message)


def _stream(run: Run, dwell_s: float) -> Samples:
    time = run.covariates.get("time_s")
    where = run.origin.source
    if time is None:
        raise DataError(
            "no time: a stream needs the column time_s, or timestamp",
            where=where,
            remedy="name the column of seconds time_s",
        )
    if len(time) < _FEWEST_SAMPLES:
        raise DataError(
            f"{len(time)} samples are not a stream",
            where=where,
            remedy=f"record {_FEWEST_SAMPLES} samples or more",
        )
    back = np.flatnonzero(np.diff(time) <= 0)
    if len(back):
        line = int(back[0]) + 1 if run.lines is None else int(run.lines[back[0] + 1])
        raise DataError(
            f"time does not rise at {len(back)} samples, first in line {line}",
            where=where,
            remedy="give each sample its own time, in their order",
        )
    if dwell_s > (lasts := float(time[-1] - time[0])):
        raise UsageError(
            f"`dwell={dwell_s:g}`: the stream lasts {lasts:.3g} s",
            where=where,
            remedy="state the seconds for which the robot stood at each pose, at the least",
        )
    axes = {name: axis.readings for name, axis in run.axes.items()}
    lengths = [a.readings for a in run.axes.values() if a.dimension is Dimension.LENGTH]
    unit = Dimension.LENGTH if lengths else Dimension.ANGLE
    return Samples(time, axes, lengths or list(axes.values()), unit.value, run.pose, where)


def _still(run: Run, found: Motion, wanted: Wanted, interval: float) -> tuple[float, list[str]]:
    """Return the threshold, and what other thresholds would find."""
    if wanted.still is not None:
        return wanted.still, []
    stated = [axis.resolution for axis in run.axes.values() if axis.resolution is not None]
    ranked = plateaus(found, max(stated, default=_NONE), round(wanted.dwell_s / interval))
    if not ranked:
        raise DataError(
            "rest and motion cannot be told apart: the number of rests follows every threshold",
            where=run.origin.source,
            remedy="record rest and motion, or state `still=0.01`, the largest range at rest",
        )
    others = [
        f"`still=` from {one.low:.2g} to {one.high:.2g} would find {one.rests} "
        f"rest{'s' * (one.rests != 1)}, not {ranked[0].rests}"
        for one in ranked[1:]
    ]
    return still_of(ranked[0]), others


def _band(axis: Axis, kept: Sequence[Stay]) -> float:
    """Return the half width of the limit band that the scatter at rest gives."""
    inner = [middle(stay.rests[-1].first, stay.last) for stay in kept]
    scatter = np.median([axis.readings[begin : end + 1].std(ddof=1) for begin, end in inner])
    band = max(_SCATTERS_IN_BAND * float(scatter), 2 * (axis.resolution or _NONE))
    return float(f"{band:.2g}")


def _visit(
    stream: Samples, stay: Stay, before: int, rule: Rule, pose: str | None, *, fast: bool
) -> tuple[Visit, Doubt | None]:
    """Return the visit of a stay, and a doubt where an axis never settles.

    ``before`` ends the rest before it.

    Its reading is the mean of the middle half, from where every axis keeps the band.
    """
    begin, end = middle(stay.first, stay.last)
    inside = np.concatenate([np.arange(r.first, r.last + 1) for r in stay.rests])
    inside = inside[(inside >= begin) & (inside <= end)]
    whole = slice(before, end + 1)
    arrivals = {
        name: arrive(
            stream.time[whole],
            values[whole],
            stay.first - before,
            float(values[inside].mean()),
            rule.band[name],
        )
        for name, values in stream.axes.items()
    }
    late = [name for name, arrival in arrivals.items() if arrival.settled is None]
    settled = max([stay.first, *(before + a.settled for a in arrivals.values() if a.settled)])
    inside = inside[inside >= settled]
    visit = Visit(
        start=stream.at(stay.first),
        settled=stream.at(settled),
        end=stream.at(stay.last),
        averaged=(stream.at(int(inside[0])), stream.at(int(inside[-1]))),
        samples=len(inside),
        mean={name: float(v[inside].mean()) for name, v in stream.axes.items()},
        scatter={name: float(v[inside].std(ddof=1)) for name, v in stream.axes.items()},
        approach={name: arrival.direction for name, arrival in arrivals.items()},
        stabilisation_s={n: a.stabilisation_s if fast else None for n, a in arrivals.items()},
        overshoot={n: a.overshoot if fast else None for n, a in arrivals.items()},
        pose=pose,
    )
    message = f"{', '.join(late)} leaves the limit band beyond the middle of the rest"
    return visit, stream.doubt("does-not-settle", stay, message, counted=True) if late else None
