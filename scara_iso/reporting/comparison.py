"""The document of a comparison: what changed first, then every figure with its interval."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from scara_iso.comparison import (
    MOST_CYCLES,
    Comparison,
    Contrast,
    ContrastVerdict,
    Ends,
    Pair,
    SpreadContrast,
    poses_in_common,
)
from scara_iso.iso9283 import Analysis, Finding, LimitCheck, PoseResult
from scara_iso.reporting.analysis import cautions, simulated
from scara_iso.reporting.blocks import (
    Block,
    Cell,
    Headline,
    Interval,
    NextStep,
    Notice,
    Number,
    Report,
    Section,
    Strip,
    Table,
    Text,
    answer_lines,
    at_depth,
    figure_in_words,
    p_value,
    rounded,
)
from scara_iso.reporting.figure_tables import characteristics_table
from scara_iso.reporting.limits import (
    STRICTEST,
    VERDICTS,
    conformity,
    limit_cell,
    limits,
    table_of_limits,
)

SAME_TWICE = "the same readings twice: nothing can differ. Is one file a copy of the other?"
CHANGED = (ContrastVerdict.LESS, ContrastVerdict.MORE)
CHANGE_WORDS = {
    ContrastVerdict.LESS: "less",
    ContrastVerdict.MORE: "more",
    ContrastVerdict.NOT_SHOWN: "not shown",
    ContrastVerdict.DIAL: "the dial",
}


def comparison_report(comparison: Comparison, tables: Sequence[str] = ()) -> Report:
    """Return the document of a comparison: for each pair what changed, then every figure.

    ``tables`` are as a command line names them, each with the options that read it.
    """
    sections: list[Section] = list(_limits(comparison))
    for k, pair in enumerate(comparison.pairs):
        following = _next(pair, (tables[0], tables[k + 1])) if tables else None
        sections += _pair_answer(pair, following)
    seen = "p, cycles needed, what these cycles can show, every mean and course: `full=`"
    sections.append(Section("", (Text(seen, "quiet"),), depth="more"))
    return (*sections, *at_depth("detail", _details(comparison)))


def _details(comparison: Comparison) -> Iterator[Section]:
    if comparison.characteristics:
        yield Section("characteristics", (characteristics_table(comparison.characteristics),))
    yield from table_of_limits([c.limit for c in comparison.characteristics if c.limit])
    for one in comparison.runs:
        name = _name(one.run.origin.source)
        yield from (replace(section, heading=f"limits of {name}") for section in limits(one))
    for pair in comparison.pairs:
        name = _name(pair.after.run.origin.source)
        yield from (replace(section, one_of=name) for section in _pair(pair))
    yield Section("", (Text(_method(comparison), "quiet"),))


def headline(pair: Pair) -> str:
    """Return what a pair shows, in a sentence or three; a dial that stood still shows nothing."""
    every = (*pair.spreads, *pair.means)
    if is_copy(pair):
        return SAME_TWICE
    if not any(map(is_live, every)):
        return "nothing is compared: one of the dials stood still"
    parts = []
    for what, contrasts in (("repeatability", pair.spreads), ("mean", pair.means)):
        changed = [_changed(one) for one in contrasts if one.verdict in CHANGED and is_live(one)]
        parts += [f"{what}: {', '.join(changed)}"] if changed else []
    if any(one.verdict not in CHANGED for one in every if is_live(one)):
        parts += [f"{'else ' if parts else ''}no difference that {_cycles(pair)} can show"]
    return "; ".join(parts)


def is_copy(pair: Pair) -> bool:
    """Say whether every reading of the axes in common is the same in both runs."""
    same = [finding.axis or "" for finding in pair.findings if finding.code == "same-readings"]
    return {name for names in same for name in names.split(", ")} >= {m.figure for m in pair.means}


def is_live(one: Contrast) -> bool:
    """Say whether the dials moved in both runs."""
    return not {"no-scatter", "stuck-channel"} & set(one.doubts)


def _changed(one: Contrast) -> str:
    name = one.figure if one.pose is None else f"{one.figure} at {one.pose}"
    if not isinstance(one, SpreadContrast) or one.ratio is None:
        return f"{name} {rounded(one.difference, U_of_change(one), sign='+')} {one.unit}"
    way = "better" if one.verdict is ContrastVerdict.LESS else "worse"
    return f"{name} {way} ({', 95 % interval '.join(map(str, ratio_in_words(one)))})"


def _cycles(pair: Pair) -> str:
    before, after = pair.before.cycles.used, pair.after.cycles.used
    return f"{before} cycles" if before == after else f"{before} and {after} cycles"


def _pair(pair: Pair) -> Iterator[Section]:
    before, after = (_name(one.run.origin.source) for one in (pair.before, pair.after))
    yield Section(f"{after}, compared with {before}", tuple(_drifting(pair)))
    yield Section("repeatability", tuple(_tables(pair.spreads)))
    yield Section("mean", tuple(_tables(pair.means)))
    yield Section("readings before and after", tuple(_strips(pair)))
    notices = [
        Notice(f.severity, f.code, _subject(f.pose, f.axis), f.in_full) for f in pair.findings
    ]
    if notices:
        yield Section("to be read with it", tuple(notices))


def caution(pair: Pair) -> Iterator[Block]:
    """Yield what a difference must not be taken for."""
    every = (*pair.spreads, *pair.means)
    still = _names(one for one in every if not is_live(one))
    if still:
        text = (
            f"{still}: all readings of one run are the same. That does not show a repair: did the"
        )
        yield Text(f"{text} dial touch, or is it too coarse?", "warn")
    if any(one.verdict is ContrastVerdict.DIAL for one in every):
        text = "'the dial': rounding alone can make this difference: use a finer one"
        yield Text(text, "warn")


def _drifting(pair: Pair) -> Iterator[Block]:
    every = (*pair.spreads, *pair.means)
    drifting = _names(one for one in every if "trend" in one.doubts)
    if drifting:
        yield Text(
            f"{drifting}: readings drift in one of the runs. The test permutes cycles between "
            "the runs as if their order did not matter: diagnose the drift first.",
            "warn",
        )


def _names(contrasts: Iterable[Contrast]) -> str:
    return ", ".join(dict.fromkeys(one.figure for one in contrasts))


def _tables(contrasts: Sequence[Contrast]) -> Iterator[Block]:
    for unit in ("mm", "deg"):
        of_unit = [one for one in contrasts if one.unit == unit]
        if of_unit:
            yield _figures(of_unit, unit)
    yield _power(contrasts)


def _figures(contrasts: Sequence[Contrast], unit: str) -> Table:
    rows = [
        (
            figure_name(one),
            rounded(one.before, U_of_change(one)),
            rounded(one.after, U_of_change(one)),
            rounded(one.difference, U_of_change(one), sign="+"),
            ends_in_words(one.difference_interval, U_of_change(one), sign="+"),
            p_value(one),
            CHANGE_WORDS[one.verdict] + ("*" if one.doubts else ""),
        )
        for one in contrasts
    ]
    parts = {
        "mean": "means",
        "RP": "RP = l_bar + 3 S_l",
        "three_sigma": "± 3 s of an angle (7.2.2)",
    }
    note = f"in {unit}; {parts[contrasts[0].quantity]}; p among all figures"
    note += "; *: read it with the notes below" if any(one.doubts for one in contrasts) else ""
    return Table(
        ("figure", "before", "after", "change", "95 % interval", "p", "change is"),
        tuple(rows),
        note,
    )


def _power(contrasts: Sequence[Contrast]) -> Table:
    means = contrasts[0].quantity == "mean"
    rows = [
        (
            figure_name(one),
            *(ratio_in_words(one) if isinstance(one, SpreadContrast) else ()),
            _needed(one.cycles_needed),
            _least(one),
        )
        for one in contrasts
    ]
    note = (
        "Cycles needed: how many in each run would show this change in 4 of 5 tests, if it is the "
        "true one. Shown here: the change that these cycles show in 4 of 5 tests"
    )
    note += (
        "; a mean moves also where the indicator was mounted or zeroed again."
        if means
        else ", as a ratio up or down."
    )
    ratio = () if means else ("after/before", "95 % interval")
    return Table(("figure", *ratio, "cycles needed", "shown here"), tuple(rows), note)


def figure_name(one: Contrast) -> str:
    """Return ``X``, or ``P1 X`` of several poses."""
    return one.figure if one.pose is None else f"{one.pose} {one.figure}"


def U_of_change(one: Contrast) -> float:  # noqa: N802 - GUM's symbol
    """Return U of a difference, half of its interval."""
    return _reach(one.difference, one.difference_interval)


def _reach(figure: float, ends: Ends) -> float:
    """Return how far the ends of an interval are from its figure, 0 where nothing bounds it."""
    distances = [abs(end - figure) for end in ends if end is not None]
    return sum(distances) / max(len(distances), 1)


def ratio_in_words(one: SpreadContrast) -> tuple[Number | str, Interval]:
    """Return after over before, and its interval."""
    if one.ratio is None:
        return "", ends_in_words(one.ratio_interval, 0.0)
    U = _reach(one.ratio, one.ratio_interval)
    return rounded(one.ratio, U, mark="×"), ends_in_words(one.ratio_interval, U)


def ends_in_words(ends: Ends, U: float, *, sign: str = "") -> Interval:
    """Return an interval to the second digit of U; an end that nothing bounds is ``any``."""
    low, high = ("any" if end is None else rounded(end, U, sign=sign) for end in ends)
    return Interval(low, high)


def _needed(cycles: int | None) -> Number | str:
    if cycles is None:
        return ""
    if cycles >= MOST_CYCLES:
        return f"> {MOST_CYCLES - 1}"
    magnitude = 10 ** max(math.floor(math.log10(cycles)) - 1, 0)
    return Number(math.ceil(cycles / magnitude) * magnitude)


def _least(one: Contrast) -> Number | str:
    if one.smallest_shown is None:
        return "none"
    if one.quantity == "mean":
        return Number(one.smallest_shown, ".2g", one.unit)
    return Number(one.smallest_shown, ".2f", mark="×")


def strips_of(poses: Sequence[PoseResult], names: Iterable[str]) -> Iterator[Strip]:
    """Yield the readings of a pose before and after, of the axes that are named."""
    for name in names:
        for pose, when in zip(poses, ("before", "after"), strict=True):
            axis = pose.axes[name]
            caption = f"{axis.readings.min():.7g} .. {axis.readings.max():.7g} {axis.unit}"
            yield Strip(f"{name} {when}", pose.cycle, axis.readings, caption)


def _strips(pair: Pair) -> Iterator[Block]:
    poses = poses_in_common(pair.before, pair.after)[0]
    yield from strips_of(poses, dict.fromkeys(one.figure for one in pair.means))
    others = len({one.pose for one in pair.means}) - 1
    if others:
        yield Text(f"the first pose; `plot=FILE` draws {others} more", "quiet")


def _method(comparison: Comparison) -> str:
    pairs = len(comparison.pairs)
    shared = f"; the level is shared by {pairs} pairs" if pairs > 1 else ""
    return (
        f"Cycles are assigned to the two runs at random {comparison.test.shuffles} times "
        "(studentised permutation, fixed seed). The intervals of a pair hold together with 95 %; "
        f"p allows for all its figures{shared}. The dials' rounding is subtracted. Method: "
        "docs/compare.md"
    )


def _subject(pose: str | None, axis: str | None) -> str:
    return ", ".join(part for part in (pose, axis) if part)


def _name(source: str) -> str:
    return source or "the first run"


_MOST_ROWS, _MOST_AXES = 8, 1
_SIDES = ("before", "after")
_WHAT_ELSE = "what else than scatter is in it"


def _limits(comparison: Comparison) -> Iterator[Section]:
    """Yield what the tables come to, and the robots' exchangeability, the gravest verdict first."""
    lines: list[Block] = [
        replace(text, text=f"{_name(one.run.origin.source)}: {text.text}")
        for one in comparison.runs
        for text in conformity(one)
    ]
    checks = [one.limit for one in comparison.characteristics if one.limit is not None]
    lines += [
        Text(f"{VERDICTS[one.verdict].upper()}: {_against(one)}", "strong")
        for one in sorted(checks, key=lambda one: STRICTEST.index(one.verdict))
    ]
    if not checks and comparison.characteristics:
        lines.append(characteristics_table(comparison.characteristics))
    if lines:
        yield Section("", tuple(lines))


def _against(check: LimitCheck) -> str:
    text = figure_in_words(check.figure, check.RP, check.interval, check.unit, limit=check.limit)
    return f"{text} against {limit_cell(check)}"


def _pair_answer(pair: Pair, following: NextStep | None) -> Iterator[Section]:
    doubts = [*simulated(pair.after.run), *caution(pair), *cautions(_of_runs(pair.findings))]
    name = pair.after.run.origin.source
    yield Section("", answer_lines([*_answer(pair), *doubts], following), name)
    header = ("", "before", "after", "change", "95 % interval", "change is")
    doubtful = any(one.doubts for one in (*pair.spreads, *pair.means))
    note = "*: read it with the lines marked !" if doubtful else ""
    yield Section("", (Table(header, _rows(pair), note),), name)
    yield Section("", _brief_strips(pair), name, depth="more")


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
    first, *others = [_brief_change(one) for one in sorted(changed, key=lambda one: one.p_value)]
    return (f"{what}: {first}", *others)


def _brief_change(one: Contrast) -> str:
    """Return a change that is shown, with the way it goes."""
    if not isinstance(one, SpreadContrast) or one.ratio is None:
        return _values(one)
    way = "better" if one.verdict is ContrastVerdict.LESS else "worse"
    return _values(one, f" {way}")


def _values(one: Contrast, way: str = "") -> str:
    U = U_of_change(one)
    if not isinstance(one, SpreadContrast) or one.ratio is None:
        between = str(ends_in_words(one.difference_interval, U, sign="+")).replace("..", ", ")
        return f"{figure_name(one)} {rounded(one.difference, U, sign='+')} {one.unit} [{between}]"
    ratio, ends = ratio_in_words(one)
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
        ends_in_words(one.difference_interval, U, sign="+"),
        CHANGE_WORDS[one.verdict] + ("*" if one.doubts else ""),
    )


def _brief_strips(pair: Pair) -> tuple[Block, ...]:
    """Return before and after of the axes that changed, else of the first ones."""
    every = list(dict.fromkeys(one.figure for one in pair.means))
    changed = [one.figure for one in (*pair.spreads, *pair.means) if one.verdict in CHANGED]
    axes = [name for name in every if name in changed] or every
    poses = poses_in_common(pair.before, pair.after)[0]
    strips: tuple[Strip, ...] = tuple(strips_of(poses, axes[:_MOST_AXES]))
    return strips
