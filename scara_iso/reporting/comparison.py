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
    MeanHistory,
    Pair,
    SpreadContrast,
    SpreadHistory,
    poses_in_common,
)
from scara_iso.reporting.analysis import (
    by_table,
    can_be_diagnosed,
    cautions,
    notice,
    readings_strip,
)
from scara_iso.reporting.shared.blocks import (
    Columns,
    NextStep,
    Report,
    Section,
    Strip,
    Table,
    Text,
    note,
)
from scara_iso.reporting.shared.digits import Number, Result, p_value, result
from scara_iso.reporting.shared.figures import characteristics_table
from scara_iso.reporting.shared.limits import (
    STRICTEST,
    VERDICTS,
    conformity,
    limit_cell,
    table_of_limits,
)
from scara_iso.reporting.shared.stated import left_unused
from scara_iso.tables import listed

_SAME_TWICE = "the same readings twice: nothing can differ. Is one file a copy of the other?"
_STILL = "nothing is compared: one of the dials stood still"
CHANGED = {ContrastVerdict.LESS: "better", ContrastVerdict.MORE: "worse"}
_WORDING = {
    ContrastVerdict.LESS: "less",
    ContrastVerdict.MORE: "more",
    ContrastVerdict.NOT_SHOWN: "not shown",
    ContrastVerdict.DIAL: "the dial",
}
_MOST_ROWS, _MOST_AXES = 8, 1
_SIDES = ("before", "after")


def comparison_report(
    comparison: Comparison, tables: Sequence[str] = (), limits: str = ""
) -> Report:
    """Return the document of a comparison: for each pair what changed, then every figure.

    ``tables`` are as a command line names them, each with the options that read it, ``limits`` the
    options of limits that a report takes too.
    """
    sections = [Section("", tuple(_limits(comparison)))]
    for k, pair in enumerate(comparison.pairs):
        following = _next(pair, tables[0], tables[k + 1], limits) if tables else None
        sections += _pair_answer(pair, following)
    seen = "p, cycles needed, what these cycles can show, every mean and course: `full=`"
    unused = dict.fromkeys(
        f"{_name(one.run.origin.source)}: {note}"
        for one in comparison.runs
        for note in by_table(left_unused(one.run))
    )
    below = tuple(Text(line, "quiet") for line in (*unused, seen))
    sections.append(Section("", below, depth="more"))
    return (*sections, *Section.in_detail(_details(comparison)))


def _details(comparison: Comparison) -> Iterator[Section]:
    found = comparison.characteristics
    yield Section("characteristics", (characteristics_table(found),))
    yield from table_of_limits([one.limit for one in found if one.limit])
    for one in comparison.runs:
        for section in table_of_limits(one.limits):
            yield replace(section, heading=f"limits of {_name(one.run.origin.source)}")
    for pair in comparison.pairs:
        before, after = (_name(one.run.origin.source) for one in (pair.before, pair.after))
        repeatability = f"{after}, compared with {before}: repeatability"
        yield Section(repeatability, (*_drifting(pair), *_tables(pair.spreads)), after)
        yield Section("mean", tuple(_tables(pair.means)), after)
        yield Section("readings before and after", tuple(_strips(pair)), after)
        yield Section("to be read with it", tuple(map(notice, pair.findings)), after)
    pairs = len(comparison.pairs)
    shared = f"; the level is shared by {pairs} pairs" if pairs > 1 else ""
    method = (
        f"Cycles are assigned to the two runs at random {comparison.test.shuffles} times "
        f"{note('permuted')}{shared}. The dials' rounding is subtracted."
    )
    yield Section("", (Text(method, "quiet"),))


def headline(pair: Pair) -> str:
    """Return what a pair shows, in a sentence or two; a dial that stood still shows nothing."""
    return _void(pair) or "; ".join(
        ", ".join(_changes(what, contrasts, pair))
        for what, contrasts in (("RP", pair.spreads), ("mean", pair.means))
        if contrasts
    )


def _void(pair: Pair) -> str:
    """Return why a pair shows nothing: a copy, or a dial that stood still; empty where it does."""
    same = [finding.axis or "" for finding in pair.findings if finding.code == "same-readings"]
    if {name for names in same for name in names.split(", ")} >= {m.figure for m in pair.means}:
        return _SAME_TWICE
    return "" if any(map(is_live, _every(pair))) else _STILL


def _every(pair: Pair) -> tuple[Contrast, ...]:
    return (*pair.spreads, *pair.means)


def is_live(one: Contrast) -> bool:
    """Say whether the dials moved in both runs."""
    return not {"no-scatter", "stuck-channel"} & set(one.doubts)


def _caution(pair: Pair) -> Iterator[Text]:
    if still := _names(one for one in _every(pair) if not is_live(one)):
        no_repair = "all readings of one run are the same. That does not show a repair"
        yield Text(f"{still}: {no_repair}: did the dial touch, or is it too coarse?", "warn")
    if any(one.verdict is ContrastVerdict.DIAL for one in _every(pair)):
        yield Text("'the dial': rounding alone can make this difference: use a finer one", "warn")


def _drifting(pair: Pair) -> Iterator[Text]:
    drifting = _names(one for one in _every(pair) if "trend" in one.doubts)
    yield Text(f"{drifting}: {note('drifting')}" if drifting else "", "warn")


def _names(contrasts: Iterable[Contrast]) -> str:
    return ", ".join(dict.fromkeys(one.figure for one in contrasts))


def _alike(one: Contrast, value: float) -> Number:
    """Return a value to the place to which the change is shown; scatter is never shown as none."""
    spec = change(one).value.spec.lstrip("+")
    none = isinstance(one, SpreadContrast) and value and not float(f"{value:{spec}}")
    return Number(value, ".2g" if none else spec)


def change(one: Contrast, unit: str = "") -> Result:
    """Return a difference with its interval."""
    return result(one.difference, one.difference_interval, unit, sign="+")


def ratio(one: Contrast) -> Result | str:
    """Return after over before, with its interval; of a ratio that is not known, the interval."""
    if not isinstance(one, SpreadContrast):
        return ""
    if one.ratio is None:
        return str(result(0.0, one.ratio_interval).interval)
    return result(one.ratio, one.ratio_interval, mark="×")


_VALUES: Columns[Contrast] = {
    "before": lambda one: _alike(one, one.before),
    "after": lambda one: _alike(one, one.after),
    "change [95 % interval]": change,
}
_VERDICT: Columns[Contrast] = {
    "change is": lambda one: _WORDING[one.verdict] + ("*" if one.doubts else "")
}


def _tables(contrasts: Sequence[Contrast]) -> Iterator[Table]:
    of_it = {
        "mean": "means",
        "RP": "RP = l_bar + 3 S_l",
        "three_sigma": "± 3 s of an angle (7.2.2)",
    }
    columns: Columns[Contrast] = {"figure": figure_name, **_VALUES, "p": p_value, **_VERDICT}
    for unit in ("mm", "deg"):
        found = [one for one in contrasts if one.unit == unit]
        if found:
            doubtful = any(one.doubts for one in found)
            below = f"in {unit}; {of_it[found[0].quantity]}; p among all figures"
            below += "; *: read it with the notes below" * doubtful
            yield Table.of(found, columns, below)
    yield _power(contrasts)


def _power(contrasts: Sequence[Contrast]) -> Table:
    of_means = contrasts[0].quantity == "mean"
    columns: Columns[Contrast] = {
        "figure": figure_name,
        **({} if of_means else {"after/before [95 % interval]": ratio}),
        "cycles needed": _needed,
        "shown here": _least,
    }
    mounted = "; a mean moves also where the indicator was mounted or zeroed again."
    return Table.of(
        contrasts, columns, note("power") + (mounted if of_means else ", as a ratio up or down.")
    )


def figure_name(one: Contrast | SpreadHistory | MeanHistory) -> str:
    """Return ``X``, or ``P1 X`` of several poses."""
    return one.figure if one.pose is None else f"{one.pose} {one.figure}"


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


def _strips_of(pair: Pair, names: Iterable[str]) -> Iterator[Strip]:
    poses = poses_in_common(pair.before, pair.after)[0]
    for name in names:
        for pose, when in zip(poses, _SIDES, strict=True):
            yield readings_strip(pose, name, f"{name} {when}")


def _strips(pair: Pair) -> Iterator[Strip | Text]:
    yield from _strips_of(pair, dict.fromkeys(one.figure for one in pair.means))
    others = len({one.pose for one in pair.means}) - 1
    yield Text(f"the first pose; `plot=FILE` draws {others} more" if others else "", "quiet")


def _name(source: str) -> str:
    return source or "the first run"


def _limits(comparison: Comparison) -> Iterator[Text | Table]:
    for one in comparison.runs:
        name = _name(one.run.origin.source)
        yield from (replace(text, text=f"{name}: {text.text}") for text in conformity(one))
    checks = [one.limit for one in comparison.characteristics if one.limit is not None]
    for check in sorted(checks, key=lambda one: STRICTEST.index(one.verdict)):
        figure = result(check.RP, check.interval, check.unit, limit=check.limit)
        text = f"{check.figure} {figure} against {limit_cell(check)}"
        yield Text(f"{VERDICTS[check.verdict][0].upper()}: {text}", "strong")
    if not checks:
        yield characteristics_table(comparison.characteristics)


def _pair_answer(pair: Pair, following: NextStep | None) -> Iterator[Section]:
    sides = [(one, one.message.partition(":")[0]) for one in pair.findings]
    named = [
        replace(one, axis=f"{one.axis or ''} {side}".strip()) if side in _SIDES else one
        for one, side in sides
    ]
    doubts = [Text(pair.after.run.simulated, "bad"), *_caution(pair), cautions(named)]
    name = pair.after.run.origin.source
    yield Section.of_answer([*_answer(pair), *doubts], following, name)
    planar = any(one.figure == "XY" for one in pair.spreads)
    shown = [one for one in pair.spreads if not (planar and one.figure == "XYZ")]
    shown.sort(key=lambda one: one.verdict not in CHANGED)
    doubtful = any(one.doubts for one in _every(pair))
    columns: Columns[Contrast] = {
        "": lambda one: f"RP {figure_name(one)} [{one.unit}]",
        **_VALUES,
        **_VERDICT,
    }
    below = "*: read it with the lines marked !" if doubtful else ""
    left = sum(one.verdict in CHANGED for one in shown[_MOST_ROWS:])
    more = Text(f"and {left} more" if left else "", "quiet")
    yield Section("", (Table.of(shown[:_MOST_ROWS], columns, below), more), name)
    every = list(dict.fromkeys(one.figure for one in pair.means))
    changed = [one.figure for one in _every(pair) if one.verdict in CHANGED]
    axes = [name for name in every if name in changed] or every
    yield Section("", tuple(_strips_of(pair, axes[:_MOST_AXES])), name, depth="more")


def _answer(pair: Pair) -> Iterator[Text]:
    if void := _void(pair):
        yield Text(void[0].upper() + void[1:], "bad")
    else:
        others = "".join(_others(pair.spreads))
        first, *parts = _changes("RP", pair.spreads, pair)
        yield Text(f"{first}{others}", "strong", () if others else tuple(parts))
        first, *parts = _changes("mean", pair.means, pair)
        yield Text(first, parts=tuple(parts))


def _changed(contrasts: Sequence[Contrast]) -> list[Contrast]:
    """Return what changed, the surest first."""
    found = (one for one in contrasts if one.verdict in CHANGED and is_live(one))
    return sorted(found, key=lambda one: one.p_value)


def _others(contrasts: Sequence[Contrast]) -> Iterator[str]:
    """Yield by name what changed besides the surest: none is left out for want of room."""
    for verdict, way in CHANGED.items():
        if named := [figure_name(x) for x in _changed(contrasts)[1:] if x.verdict is verdict]:
            yield f"; {listed(named)} {way}"


def _changes(what: str, contrasts: Sequence[Contrast], pair: Pair) -> tuple[str, ...]:
    live = [one for one in contrasts if is_live(one)]
    if changed := _changed(contrasts):
        first, *others = (_values(one, f" {CHANGED[one.verdict]}") for one in changed)
        return (f"{what}: {first}", *others)
    used = dict.fromkeys(str(one.cycles.used) for one in (pair.before, pair.after))
    whole = next((one for one in live if one.figure == "XY"), live[0] if live else None)
    least = [] if whole is None else [_values(whole)]
    return (f"{what}: no change that {' and '.join(used)} cycles can show", *least)


def _values(one: Contrast, way: str = "") -> str:
    if not isinstance(one, SpreadContrast) or one.ratio is None:
        return f"{figure_name(one)} {change(one, one.unit)}"
    before, after = (_alike(one, value) for value in (one.before, one.after))
    return f"{figure_name(one)}{way} {before} to {after} {one.unit}, {ratio(one)}"


def _next(pair: Pair, before: str, after: str, limits: str) -> NextStep | None:
    if _void(pair) == _SAME_TWICE:
        return NextStep(f"scara-iso analyze {after}", "is this the table you mean?")
    worse = any(one.verdict is ContrastVerdict.MORE and is_live(one) for one in pair.spreads)
    drift = [any(f.code == "trend" for f in one.findings) for one in (pair.before, pair.after)]
    run, found = (pair.after, after) if worse or drift[1] else (pair.before, before)
    if (worse or any(drift)) and can_be_diagnosed(run):
        return NextStep(f"scara-iso diagnose {found}", "what is in it besides scatter")
    if any(one.verdict in CHANGED and is_live(one) for one in _every(pair)):
        line = " ".join(filter(None, (f"scara-iso report {after}", limits)))
        return NextStep(line, "the report to sign")
    return None
