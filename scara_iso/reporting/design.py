"""The report on a planned test: what it will find, what it cannot tell apart, what helps."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from scara_iso.diagnosis import (
    Alike,
    ChangeOfPoses,
    Design,
    DesignOfPoses,
    PlannedPosesTest,
    PlannedRun,
    PosesApart,
    Smallest,
)
from scara_iso.reporting.blocks import Cell, Number, Report, Section, Table, Text
from scara_iso.reporting.digits import decimals
from scara_iso.reporting.words import words

_MICRO = 1e6


def design_report(plan: PlannedRun, found: Design) -> Report:
    """Return the smallest effects, with the gain of each change of plan beside them."""
    return (
        Section("", tuple(_head(plan))),
        Section("smallest travel found in 80 % of tests [mm]", (_table(plan, found),)),
        Section("cannot be told apart", tuple(_alike(found.alike))),
    )


def _head(plan: PlannedRun) -> list[Text]:
    columns = ", ".join(plan.conditions.covariates) or "none"
    return [
        Text("what this test will be able to tell", "strong"),
        Text(
            f"{len(plan.conditions)} cycles, scatter {plan.sigma:g} mm, dial {plan.division:g} mm, "
            f"columns: {columns}"
        ),
        Text("travel: lowest to highest reading of an effect, without scatter", "quiet"),
    ]


def _table(plan: PlannedRun, found: Design) -> Table:
    columns = [found.smallest, *(change.smallest for change in found.changes)]
    names = list(dict.fromkeys(one.effect for column in columns for one in column))
    places = decimals([plan.sigma])
    rows = tuple(
        (words(name), *(_travel(column, name, places) for column in columns)) for name in names
    )
    letters = [chr(ord("a") + k) for k in range(len(found.changes))]
    notes = "; ".join(f"{k}: {c.change}" for k, c in zip(letters, found.changes, strict=True))
    return Table(("effect", "as planned", *letters), rows, notes)


def _travel(column: Sequence[Smallest], name: str, places: int) -> Number | str:
    for one in column:
        if one.effect == name:
            return "-" if one.travel is None else Number(one.travel, f".{places}f")
    return ""


def _alike(pairs: Sequence[Alike]) -> list[Text]:
    if not pairs:
        return [Text("every pair of effects has shapes that differ")]
    return [Text(f"{words(a.first)} and {words(a.second)} (cosine {a.cosine:.2f})") for a in pairs]


def design_of_poses_report(plan: PlannedPosesTest, found: DesignOfPoses) -> Report:
    """Return the smallest effects in the joints, and what would help, the largest gain first."""
    return (
        Section("", tuple(_head_of_poses(plan, found.apart))),
        Section("smallest travel in a joint found in 80 % of tests [µrad]", (_in_joints(found),)),
        Section("what would help, the largest gain first", (_helps(found),)),
        Section("cannot be told apart", tuple(_alike(found.alike))),
    )


def _head_of_poses(plan: PlannedPosesTest, apart: PosesApart) -> Iterator[Text]:
    *joints, dial = plan.sources.items()
    scatter = ", ".join(f"{name} {value * _MICRO:.1f} µrad" for name, value in joints)
    steps = " and ".join(f"{step:g}" for step in dict.fromkeys(plan.division))
    seen = ", ".join(f"{name} to {value * _MICRO:.1f} µrad" for name, value in plan.sigma.items())
    columns = ", ".join(plan.conditions.covariates) or "none"
    yield Text("what this test will be able to tell of the joints", "strong")
    yield Text(f"{len(plan.conditions)} cycles at {', '.join(plan.joints_deg)}; columns: {columns}")
    yield Text(f"scatter: {scatter}, dials {dial[1]:.2g} mm beside their division of {steps} mm")
    yield Text(f"so the poses of one cycle show {seen}")
    yield Text(
        f"joints 1 and 2 are {apart.angle_deg:.0f} degrees apart beside the scatter; nearest are "
        f"{' and '.join(apart.between)}, by {apart.smallest_angle_deg:.0f} degrees"
    )


def _in_joints(found: DesignOfPoses) -> Table:
    first = next(iter(found.smallest.values()))
    micro = {
        joint: tuple(replace(s, travel=s.travel and s.travel * _MICRO) for s in smallest)
        for joint, smallest in found.smallest.items()
    }
    rows = tuple(
        (words(one.effect), *(_travel(column, one.effect, 1) for column in micro.values()))
        for one in first
    )
    return Table(("effect", *micro), rows)


def _helps(found: DesignOfPoses) -> Table:
    now = Number(found.apart.angle_deg, ".0f")
    rows: list[tuple[Cell, ...]] = [("as planned", *("" for _ in found.smallest), now)]
    lettered = {chr(ord("a") + k): one for k, one in enumerate(found.changes)}
    rows += [
        (
            letter,
            *(Number(share - 1, "+.0%") for share in one.size_needed.values()),
            Number(one.apart.angle_deg, ".0f"),
        )
        for letter, one in lettered.items()
    ]
    said = "; ".join(f"{letter}: {_said(one)}" for letter, one in lettered.items())
    note = (
        f"{said}. Size of an effect in a joint that is found and told from the other joint, "
        "against the plan; up to 3 % of it is chance of the simulation; apart: degrees"
    )
    return Table(("change", *found.smallest, "apart"), tuple(rows), note)


def _said(one: ChangeOfPoses) -> str:
    adds = ", ".join(map(words, one.adds))
    return f"{one.change} (tells {adds} besides)" if adds else one.change
