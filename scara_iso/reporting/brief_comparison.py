"""A comparison in short: what changed, by how much, what next, one table and the picture."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from scara_iso.comparison import Comparison, Contrast, ContrastVerdict, Pair, poses_in_common
from scara_iso.iso9283 import Analysis, Conformity, Finding, LimitCheck
from scara_iso.reporting.blocks import (
    Block,
    Cell,
    Headline,
    NextStep,
    Report,
    Section,
    Strip,
    Table,
    Text,
)
from scara_iso.reporting.brief import cautions, figure_said, first_three, simulated
from scara_iso.reporting.characteristics import characteristics_table
from scara_iso.reporting.comparison import (
    CHANGED,
    SAID,
    SAME_TWICE,
    U_of_change,
    caution,
    ends_said,
    figure_name,
    is_copy,
    is_live,
    ratio_said,
    strips_of,
)
from scara_iso.reporting.digits import rounded
from scara_iso.reporting.limits import VERDICTS

_MOST_ROWS, _MOST_AXES = 8, 1
_SIDES = ("before", "after")
_WHAT_ELSE = "what else than scatter is in it"


def comparison_brief(comparison: Comparison, tables: Sequence[str]) -> Report:
    """Return a comparison in ten to twenty lines for each pair.

    ``tables`` are as a command line names them, each with the options that read it.
    """
    sections: list[Section] = list(_limits(comparison))
    for pair, table in zip(comparison.pairs, tables[1:], strict=True):
        sections += _pair(pair, (tables[0], table))
    seen = "p, cycles needed, what these cycles can show, every mean and course: `full=`"
    return (*sections, Section("", (Text(seen, "quiet"),)))


def _limits(comparison: Comparison) -> Iterator[Section]:
    """Yield what the robots' exchangeability comes to, the gravest verdict first."""
    order = (Conformity.FAIL, Conformity.NOT_PROVABLE, Conformity.PASS)
    held = [one.limit for one in comparison.characteristics if one.limit is not None]
    said: list[Block] = [
        Text(f"{VERDICTS[one.verdict].upper()}: {_against(one)}", "strong")
        for one in sorted(held, key=lambda one: order.index(one.verdict))
    ]
    if not said and comparison.characteristics:
        said.append(characteristics_table(comparison.characteristics))
    if said:
        yield Section("", tuple(said))


def _against(check: LimitCheck) -> str:
    said = figure_said(check.figure, check.RP, check.interval, "mm", limit=check.limit)
    return f"{said} against {check.limit:.15g}"


def _pair(pair: Pair, tables: tuple[str, str]) -> Iterator[Section]:
    doubts = [*simulated(pair.after.run), *caution(pair), *cautions(_of_runs(pair.findings))]
    head = first_three([*_answer(pair), *doubts], _next(pair, tables))
    name = pair.after.run.origin.source
    yield Section("", head, name)
    rows = _rows(pair)
    header = ("", "before", "after", "change", "95 % interval", "change is")
    doubtful = any(one.doubts for one in (*pair.spreads, *pair.means))
    note = "*: read it with the lines marked !" if doubtful else ""
    yield Section("", (Table(header, rows, note),), name)
    strips = _strips(pair)
    yield Section("", strips, name)


def _of_runs(findings: Sequence[Finding]) -> list[Finding]:
    """Return the findings with the run that each is about beside its axis."""
    sides = [(one, one.message.partition(":")[0]) for one in findings]
    return [
        replace(one, axis=f"{one.axis or ''} {side}".strip()) if side in _SIDES else one
        for one, side in sides
    ]


def _answer(pair: Pair) -> Iterator[Block]:
    """Yield a line on RP and one on the means, the largest changes first."""
    live = [one for one in (*pair.spreads, *pair.means) if is_live(one)]
    if is_copy(pair):
        yield Text(SAME_TWICE[0].upper() + SAME_TWICE[1:], "bad")
        return
    if not live:
        yield Text("Nothing is compared: one of the dials stood still", "bad")
        return
    yield Headline(_changes("RP", pair.spreads, pair))
    if pair.means:
        yield Text("   ".join(_changes("mean", pair.means, pair)))


def _changes(what: str, contrasts: Sequence[Contrast], pair: Pair) -> tuple[str, ...]:
    changed = [one for one in contrasts if one.verdict in CHANGED and is_live(one)]
    if not changed:
        before, after = pair.before.cycles.used, pair.after.cycles.used
        cycles = f"{before}" if before == after else f"{before} and {after}"
        live = [one for one in contrasts if is_live(one)]
        whole = next((one for one in live if one.figure == "XY"), live[0] if live else None)
        least = [_values(whole)] if whole is not None else []
        return (f"{what}: no change that {cycles} cycles can show", *least)
    first, *others = [_changed(one) for one in sorted(changed, key=lambda one: one.p_value)]
    return (f"{what}: {first}", *others)


def _changed(one: Contrast) -> str:
    """Return a change that is shown, with the way it goes."""
    if one.ratio is None or one.ratio_interval is None:
        return _values(one)
    way = "better" if one.verdict is ContrastVerdict.LESS else "worse"
    return _values(one, f" {way}")


def _values(one: Contrast, way: str = "") -> str:
    U = U_of_change(one)
    if one.ratio is None or one.ratio_interval is None:
        between = str(ends_said(one.difference_interval, U, sign="+")).replace("..", ", ")
        return f"{figure_name(one)} {rounded(one.difference, U, sign='+')} {one.unit} [{between}]"
    ratio, ends = ratio_said(one)
    values = f"{rounded(one.before, U)} to {rounded(one.after, U)} {one.unit}"
    between = str(ends).replace("..", ", ")
    return f"{figure_name(one)}{way} {values}, {ratio} [{between}]"


def _next(pair: Pair, tables: tuple[str, str]) -> NextStep:
    before, after = tables
    if is_copy(pair):
        return NextStep(f"scara-iso analyze {after}", "is this the table you mean?")
    worse = any(one.verdict is ContrastVerdict.MORE and is_live(one) for one in pair.spreads)
    if worse or _drifts(pair.after):
        return NextStep(f"scara-iso diagnose {after}", _WHAT_ELSE)
    if _drifts(pair.before):
        return NextStep(f"scara-iso diagnose {before}", _WHAT_ELSE)
    return NextStep(f"scara-iso report {after}", "the report to sign")


def _drifts(analysis: Analysis) -> bool:
    return any(finding.code == "trend" for finding in analysis.findings)


def _rows(pair: Pair) -> tuple[tuple[Cell, ...], ...]:
    planar = any(one.figure == "XY" for one in pair.spreads)
    shown = [one for one in pair.spreads if not (planar and one.figure == "XYZ")]
    shown.sort(key=lambda one: one.verdict not in CHANGED)
    return tuple(map(_row, shown[:_MOST_ROWS]))


def _row(one: Contrast) -> tuple[Cell, ...]:
    U = U_of_change(one)
    return (
        f"RP {figure_name(one)} [{one.unit}]",
        rounded(one.before, U),
        rounded(one.after, U),
        rounded(one.difference, U, sign="+"),
        ends_said(one.difference_interval, U, sign="+"),
        SAID[one.verdict] + ("*" if one.doubts else ""),
    )


def _strips(pair: Pair) -> tuple[Block, ...]:
    """Return before and after of the axes that changed, else of the first ones."""
    every = list(dict.fromkeys(one.figure for one in pair.means))
    changed = [one.figure for one in (*pair.spreads, *pair.means) if one.verdict in CHANGED]
    axes = [name for name in every if name in changed] or every
    poses = poses_in_common(pair.before, pair.after)[0]
    strips: tuple[Strip, ...] = tuple(strips_of(poses, axes[:_MOST_AXES]))
    return strips
