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
from scara_iso.iso9283 import Finding, PoseResult
from scara_iso.reporting.analysis import cautions, simulated, subject_of
from scara_iso.reporting.blocks import (
    Block,
    Columns,
    Headline,
    NextStep,
    Notice,
    Report,
    Section,
    Strip,
    Table,
    Text,
    answer_lines,
    at_depth,
    tabulated,
)
from scara_iso.reporting.digits import (
    Interval,
    Number,
    figure_in_words,
    in_brackets,
    p_value,
    rounded,
)
from scara_iso.reporting.figures import characteristics_table
from scara_iso.reporting.limits import (
    STRICTEST,
    VERDICTS,
    conformity,
    limit_cell,
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
_STILL = "nothing is compared: one of the dials stood still"
_MOST_ROWS, _MOST_AXES = 8, 1
_SIDES = ("before", "after")


def comparison_report(comparison: Comparison, tables: Sequence[str] = ()) -> Report:
    """Return the document of a comparison: for each pair what changed, then every figure.

    ``tables`` are as a command line names them, each with the options that read it.
    """
    sections = [Section("", tuple(_limits(comparison)))]
    for k, pair in enumerate(comparison.pairs):
        following = _next(pair, (tables[0], tables[k + 1])) if tables else None
        sections += _pair_answer(pair, following)
    seen = "p, cycles needed, what these cycles can show, every mean and course: `full=`"
    sections.append(Section("", (Text(seen, "quiet"),), depth="more"))
    return (*sections, *at_depth("detail", _details(comparison)))


def _details(comparison: Comparison) -> Iterator[Section]:
    found = comparison.characteristics
    yield Section("characteristics", (characteristics_table(found),) if found else ())
    yield from table_of_limits([one.limit for one in found if one.limit])
    for one in comparison.runs:
        name = _name(one.run.origin.source)
        for section in table_of_limits(one.limits):
            yield replace(section, heading=f"limits of {name}")
    for pair in comparison.pairs:
        before, after = (_name(one.run.origin.source) for one in (pair.before, pair.after))
        for heading, blocks in (
            (
                f"{after}, compared with {before}: repeatability",
                (*_drifting(pair), *_tables(pair.spreads)),
            ),
            ("mean", _tables(pair.means)),
            ("readings before and after", _strips(pair)),
            ("to be read with it", map(_notice, pair.findings)),
        ):
            yield Section(heading, tuple(blocks), after)
    pairs = len(comparison.pairs)
    shared = f"; the level is shared by {pairs} pairs" if pairs > 1 else ""
    method = (
        f"Cycles are assigned to the two runs at random {comparison.test.shuffles} times "
        "(studentised permutation, fixed seed). The intervals of a pair hold together with 95 %; "
        f"p allows for all its figures{shared}. The dials' rounding is subtracted."
    )
    yield Section("", (Text(method, "quiet"),))


def headline(pair: Pair) -> str:
    """Return what a pair shows, in a sentence or three; a dial that stood still shows nothing."""
    every = (*pair.spreads, *pair.means)
    if is_copy(pair):
        return SAME_TWICE
    if not any(map(is_live, every)):
        return _STILL
    parts = []
    for what, contrasts in (("repeatability", pair.spreads), ("mean", pair.means)):
        changed = [_changed(one) for one in contrasts if one.verdict in CHANGED and is_live(one)]
        parts += [f"{what}: {', '.join(changed)}"] if changed else []
    if any(one.verdict not in CHANGED for one in every if is_live(one)):
        parts += [f"{'else ' if parts else ''}no difference that {_cycles(pair)} cycles can show"]
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
    ratio, ends = ratio_in_words(one)
    return f"{name} {_way(one)} ({ratio}, 95 % interval {ends})"


def _way(one: Contrast) -> str:
    return "better" if one.verdict is ContrastVerdict.LESS else "worse"


def _cycles(pair: Pair) -> str:
    return " and ".join(dict.fromkeys(str(one.cycles.used) for one in (pair.before, pair.after)))


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
    drifting = _names(one for one in (*pair.spreads, *pair.means) if "trend" in one.doubts)
    text = (
        f"{drifting}: readings drift in one of the runs. The test permutes cycles between "
        "the runs as if their order did not matter: diagnose the drift first."
    )
    yield Text(text if drifting else "", "warn")


def _names(contrasts: Iterable[Contrast]) -> str:
    return ", ".join(dict.fromkeys(one.figure for one in contrasts))


def _notice(finding: Finding) -> Notice:
    subject = subject_of(finding).removesuffix(": ")
    return Notice(finding.severity, finding.code, subject, finding.in_full)


_VALUES: Columns[Contrast] = {
    "before": lambda one: rounded(one.before, U_of_change(one)),
    "after": lambda one: rounded(one.after, U_of_change(one)),
    "change": lambda one: rounded(one.difference, U_of_change(one), sign="+"),
    "95 % interval": lambda one: ends_in_words(one.difference_interval, U_of_change(one), sign="+"),
}
_CHANGE: Columns[Contrast] = {
    "change is": lambda one: CHANGE_WORDS[one.verdict] + ("*" if one.doubts else "")
}


def _tables(contrasts: Sequence[Contrast]) -> Iterator[Block]:
    """Yield the figures of each unit, and which changes these cycles can show."""
    of_it = {
        "mean": "means",
        "RP": "RP = l_bar + 3 S_l",
        "three_sigma": "± 3 s of an angle (7.2.2)",
    }
    columns: Columns[Contrast] = {"figure": figure_name, **_VALUES, "p": p_value, **_CHANGE}
    for unit in ("mm", "deg"):
        found = [one for one in contrasts if one.unit == unit]
        if found:
            note = f"in {unit}; {of_it[found[0].quantity]}; p among all figures"
            doubtful = any(one.doubts for one in found)
            note += "; *: read it with the notes below" if doubtful else ""
            yield tabulated(found, columns, note)
    yield _power(contrasts)


def _power(contrasts: Sequence[Contrast]) -> Table:
    note = (
        "Cycles needed: how many in each run would show this change in 4 of 5 tests, if it is the "
        "true one. Shown here: the change that these cycles show in 4 of 5 tests"
    )
    mounted = "; a mean moves also where the indicator was mounted or zeroed again."
    shown: Columns[Contrast] = {"cycles needed": _needed, "shown here": _least}
    if contrasts[0].quantity == "mean":
        return tabulated(contrasts, {"figure": figure_name, **shown}, note + mounted)
    ratio: Columns[Contrast] = {
        "after/before": lambda one: ratio_in_words(one)[0],
        "95 % interval": lambda one: ratio_in_words(one)[1],
    }
    up_or_down = ", as a ratio up or down."
    return tabulated(contrasts, {"figure": figure_name, **ratio, **shown}, note + up_or_down)


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


def ratio_in_words(one: Contrast) -> tuple[Number | str, Interval | str]:
    """Return after over before, and its interval."""
    if not isinstance(one, SpreadContrast):
        return "", ""
    if one.ratio is None:
        return "", ends_in_words(one.ratio_interval, 0.0)
    U = _reach(one.ratio, one.ratio_interval)
    return rounded(one.ratio, U, mark="×"), ends_in_words(one.ratio_interval, U)


def ends_in_words(ends: Ends, U: float, *, sign: str = "") -> Interval:
    """Return an interval to the second digit of U; an end that nothing bounds is ``any``."""
    low, high = ("any" if end is None else rounded(end, U, sign=sign) for end in ends)
    return Interval(low, high)


def _needed(one: Contrast) -> Number | str:
    cycles = one.cycles_needed
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


def _strips_of(poses: Sequence[PoseResult], names: Iterable[str]) -> Iterator[Strip]:
    """Yield the readings of a pose before and after, of the axes that are named."""
    for name in names:
        for pose, when in zip(poses, _SIDES, strict=True):
            axis = pose.axes[name]
            caption = f"{axis.readings.min():.7g} .. {axis.readings.max():.7g} {axis.unit}"
            yield Strip(f"{name} {when}", pose.cycle, axis.readings, caption)


def _strips(pair: Pair) -> Iterator[Block]:
    poses = poses_in_common(pair.before, pair.after)[0]
    yield from _strips_of(poses, dict.fromkeys(one.figure for one in pair.means))
    others = len({one.pose for one in pair.means}) - 1
    yield Text(f"the first pose; `plot=FILE` draws {others} more" if others else "", "quiet")


def _name(source: str) -> str:
    return source or "the first run"


def _limits(comparison: Comparison) -> Iterator[Block]:
    """Yield what the tables come to, and the robots' exchangeability, the gravest verdict first."""
    for one in comparison.runs:
        name = _name(one.run.origin.source)
        yield from (replace(text, text=f"{name}: {text.text}") for text in conformity(one))
    checks = [one.limit for one in comparison.characteristics if one.limit is not None]
    for check in sorted(checks, key=lambda one: STRICTEST.index(one.verdict)):
        figure = (check.figure, check.RP, check.interval, check.unit)
        text = f"{figure_in_words(*figure, limit=check.limit)} against {limit_cell(check)}"
        yield Text(f"{VERDICTS[check.verdict].upper()}: {text}", "strong")
    if not checks and comparison.characteristics:
        yield characteristics_table(comparison.characteristics)


def _pair_answer(pair: Pair, following: NextStep | None) -> Iterator[Section]:
    sides = [(one, one.message.partition(":")[0]) for one in pair.findings]
    named = [
        replace(one, axis=f"{one.axis or ''} {side}".strip()) if side in _SIDES else one
        for one, side in sides
    ]
    doubts = [*simulated(pair.after.run), *caution(pair), *cautions(named)]
    name = pair.after.run.origin.source
    yield Section("", answer_lines([*_answer(pair), *doubts], following), name)
    planar = any(one.figure == "XY" for one in pair.spreads)
    shown = [one for one in pair.spreads if not (planar and one.figure == "XYZ")]
    shown.sort(key=lambda one: one.verdict not in CHANGED)
    doubtful = any(one.doubts for one in (*pair.spreads, *pair.means))
    note = "*: read it with the lines marked !" if doubtful else ""
    columns: Columns[Contrast] = {
        "": lambda one: f"RP {figure_name(one)} [{one.unit}]",
        **_VALUES,
        **_CHANGE,
    }
    yield Section("", (tabulated(shown[:_MOST_ROWS], columns, note),), name)
    every = list(dict.fromkeys(one.figure for one in pair.means))
    changed = [one.figure for one in (*pair.spreads, *pair.means) if one.verdict in CHANGED]
    axes = [name for name in every if name in changed] or every
    poses = poses_in_common(pair.before, pair.after)[0]
    yield Section("", tuple(_strips_of(poses, axes[:_MOST_AXES])), name, depth="more")


def _answer(pair: Pair) -> Iterator[Block]:
    """Yield a line on RP and one on the means, the largest changes first."""
    if is_copy(pair):
        yield Text(SAME_TWICE[0].upper() + SAME_TWICE[1:], "bad")
    elif not any(map(is_live, (*pair.spreads, *pair.means))):
        yield Text(_STILL[0].upper() + _STILL[1:], "bad")
    else:
        yield Headline(_changes("RP", pair.spreads, pair))
        yield Text("   ".join(_changes("mean", pair.means, pair)) if pair.means else "")


def _changes(what: str, contrasts: Sequence[Contrast], pair: Pair) -> tuple[str, ...]:
    live = [one for one in contrasts if is_live(one)]
    changed = [one for one in live if one.verdict in CHANGED]
    if not changed:
        whole = next((one for one in live if one.figure == "XY"), live[0] if live else None)
        least = [] if whole is None else [_values(whole)]
        return (f"{what}: no change that {_cycles(pair)} cycles can show", *least)
    first, *others = [_values(one, f" {_way(one)}") for one in sorted(changed, key=_p)]
    return (f"{what}: {first}", *others)


def _p(one: Contrast) -> float:
    return one.p_value


def _values(one: Contrast, way: str = "") -> str:
    """Return a change with its interval, of scatter with the way it goes."""
    U = U_of_change(one)
    if not isinstance(one, SpreadContrast) or one.ratio is None:
        between = in_brackets(ends_in_words(one.difference_interval, U, sign="+"))
        return f"{figure_name(one)} {rounded(one.difference, U, sign='+')} {one.unit} {between}"
    ratio, ends = ratio_in_words(one)
    values = f"{rounded(one.before, U)} to {rounded(one.after, U)} {one.unit}"
    return f"{figure_name(one)}{way} {values}, {ratio} {in_brackets(ends)}"


def _next(pair: Pair, tables: tuple[str, str]) -> NextStep:
    before, after = tables
    if is_copy(pair):
        return NextStep(f"scara-iso analyze {after}", "is this the table you mean?")
    worse = any(one.verdict is ContrastVerdict.MORE and is_live(one) for one in pair.spreads)
    drift = [any(f.code == "trend" for f in one.findings) for one in (pair.before, pair.after)]
    if worse or any(drift):
        found = after if worse or drift[1] else before
        return NextStep(f"scara-iso diagnose {found}", "what is in it besides scatter")
    return NextStep(f"scara-iso report {after}", "the report to sign")
