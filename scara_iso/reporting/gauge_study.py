"""The report on a gauge study.

The data of the picture of a gauge study.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np

from scara_iso.gauge import (
    AxisStudy,
    Budget,
    Criterion,
    Crossed,
    GaugeStudy,
    Linearity,
    Stability,
    TypeOne,
    whole_categories,
)
from scara_iso.iso9283 import Conformity, DecisionRule
from scara_iso.reporting.blocks import (
    Block,
    Cell,
    Figure,
    Headline,
    Interval,
    NextStep,
    Number,
    Report,
    Section,
    Table,
    Text,
    answer_lines,
    at_depth,
    figure_cells,
    figure_in_words,
    four_digits,
)
from scara_iso.reporting.picture_data import Chart, Curve


def study_picture(study: AxisStudy) -> Figure:
    """Return the picture of a study: its readings, and what decides."""
    figures, unit, axis = study.figures, study.readings.unit, study.readings.axis
    match figures:
        case TypeOne():
            chart, text = (
                _picture_of_type_1(study, figures),
                "readings in the order in which they were taken",
            )
        case Crossed():
            chart, text = _crossed(figures, unit), "mean of each part by operator"
        case Linearity():
            chart, text = (
                _picture_of_linearity(study, figures),
                "bias over the true value, line and its band",
            )
        case Stability():
            chart, text = (
                _picture_of_stability(figures, unit),
                "means of the sessions, and their limits",
            )
    return Figure(chart, axis, text)


def _picture_of_type_1(study: AxisStudy, figures: TypeOne) -> Chart:
    values = study.readings.values
    levels = {"mean": figures.mean}
    if figures.reference is not None:
        levels["reference"] = figures.reference
        if study.tolerance is not None:
            for sign, name in ((1, "+ 0.1 T"), (-1, "- 0.1 T")):
                levels[f"reference {name}"] = figures.reference + sign * study.tolerance / 10
    points = Curve("readings", np.arange(1.0, len(values) + 1), values, is_line=False)
    return Chart("reading", study.readings.unit, (points,), levels)


def _crossed(figures: Crossed, unit: str) -> Chart:
    means = figures.cells.mean(axis=2)
    x = np.arange(1.0, len(figures.parts) + 1)
    names = figures.operators or ("mean",)
    curves = tuple(Curve(name, x, means[:, k]) for k, name in enumerate(names))
    return Chart("part", unit, curves, {}, figures.parts)


def _picture_of_linearity(study: AxisStudy, figures: Linearity) -> Chart:
    x = np.asarray(study.readings.reference)
    single = Curve("bias of a reading", x, study.readings.values - x, is_line=False)
    middle = (figures.lower + figures.upper) / 2
    at = figures.references
    ends = (Curve("95 % band", at, figures.lower), Curve("", at, figures.upper))
    curves = (single, Curve("line", at, middle), *ends)
    unit = study.readings.unit
    return Chart(f"true value [{unit}]", unit, curves, {"no bias": 0.0})


def _picture_of_stability(figures: Stability, unit: str) -> Chart:
    x = np.arange(1.0, len(figures.means) + 1)
    low, high = figures.centre - figures.half_width, figures.centre + figures.half_width
    curves = (Curve("mean", x, figures.means), Curve("limits", x, low), Curve("", x, high))
    return Chart("session", unit, curves, {"centre": figures.centre}, figures.sessions)


_KINDS = {
    "type-1": "type 1: one part, read again and again",
    "type-2": "type 2: parts by several operators (R&R, ANOVA)",
    "type-3": "type 3: parts, no operators compared (ANOVA)",
    "linearity": "linearity: parts of several known sizes",
    "stability": "stability: one part in several sessions",
}
_TONE: dict[Conformity, Literal["good", "bad", "warn"]] = {
    Conformity.PASS: "good",
    Conformity.FAIL: "bad",
    Conformity.NOT_PROVABLE: "warn",
}
_WORDING = {
    Conformity.PASS: "PASS: good enough",
    Conformity.FAIL: "FAIL: NOT good enough",
    Conformity.NOT_PROVABLE: "NOT PROVABLE with these readings",
}
_SHARES = ("resolution/T", "R&R/T", "Q_MS", "Q_MP")
_COMPONENTS = {
    "EV": "repeatability, EV",
    "AV": "operators, AV",
    "INT": "part x operator",
    "GRR": "R&R, GRR",
    "PV": "parts, PV",
    "TV": "all, TV",
}
_PARTS = {
    "CAL": "calibration",
    "RE": "division",
    "EVR": "repeatability on one part",
    "EVO": "repeatability on parts",
    "BI": "bias",
    "LIN": "linearity",
    "AV": "operators",
    "IA": "part x operator",
}


def gauge_study_report(found: GaugeStudy, following: NextStep | None = None) -> Report:
    """Return the document of a study: the verdict, what decides it, each dial's figures."""
    lines: list[Block] = list(_verdict(found))
    answer = len(lines) - len(found.axes)  # behind it what kind of study each dial has
    warnings = [text for text in _remarks(found) if text.tone == "warn"]
    behind = Text("figures, ANOVA, uncertainty, picture: `full=`", "quiet")
    return (
        Section("", (*answer_lines(lines, following, answer=answer), *warnings)),
        Section("", (_criteria(found),) if found.criteria else ()),
        Section("", (behind,), depth="more"),
        *at_depth("detail", _details(found)),
    )


def _details(found: GaugeStudy) -> Iterator[Section]:
    if remarks := tuple(text for text in _remarks(found) if text.tone != "warn"):
        yield Section("Remarks", remarks)
    for name, study in found.axes.items():
        of = f" {name}" if len(found.axes) > 1 else ""
        yield Section(f"Figures{of}", (*_figures(study), study_picture(study)))
        if study.budget is not None:
            yield Section(f"Uncertainty{of}", tuple(_budget(study.budget, study)))
    yield Section("", tuple(_how(found)))


def _verdict(found: GaugeStudy) -> Iterator[Block]:
    for verdict in (Conformity.FAIL, Conformity.NOT_PROVABLE, Conformity.PASS):
        checks = [one for one in found.criteria if one.verdict is verdict]
        if checks and (verdict is not Conformity.PASS or found.conformity is Conformity.PASS):
            many = len(found.axes) > 1
            text = ", ".join(
                (f"{one.axis} {one.name}" if many else one.name)
                + (" (conditional)" if one.is_conditional else "")
                for one in checks
            )
            yield Text(f"{_WORDING[verdict]}: {text}", _TONE[verdict])
    for name, study in found.axes.items():
        yield Headline((f"{name}  {'   '.join(_in_brief(study))}",))
    for study in found.axes.values():
        T = (
            ""
            if study.tolerance is None
            else f", tolerance {study.tolerance:g} {study.readings.unit}"
        )
        yield Text(f"{study.readings.axis}: {_KINDS[study.kind.value]}{T}", "quiet")


def _in_brief(study: AxisStudy) -> Iterator[str]:
    figures, unit = study.figures, study.readings.unit
    match figures:
        case TypeOne():
            for name, of in (("Cg", ""), ("Cgk", ""), ("s", unit), ("bias", unit)):
                value = getattr(figures, name)
                if value is not None:
                    text = figure_in_words(name, value, getattr(figures, f"{name}_interval"), of)
                    yield " ".join(text.split())
        case Crossed():
            whole = figures.components["GRR"]
            if whole.of_tolerance is not None:
                yield f"R&R {whole.of_tolerance:.1%} of T"
            yield f"R&R {whole.of_study:.1%} of TV"
            yield f"ndc {figures.ndc or 'none'}"
            yield figure_in_words("GRR", whole.sigma, whole.interval, unit)
        case Linearity():
            yield figure_in_words("slope", figures.slope, figures.slope_interval, "").strip()
            yield f"largest bias {figures.largest_bias:.3g} {unit}"
        case Stability():
            yield f"{len(figures.outside)} of {len(figures.sessions)} sessions outside"
            yield f"centre {figures.centre:.6g} {unit}"


def _remarks(found: GaugeStudy) -> Iterator[Text]:
    many = len(found.axes) > 1
    for one in found.remarks:
        of = f"{one.axis}: " if many and one.axis else ""
        grave = one.severity == "warning"
        yield Text(f"{'! ' if grave else '- '}{of}{one.message}", "warn" if grave else "plain")


def _criteria(found: GaugeStudy) -> Table:
    rows = tuple(_criterion(one, many=len(found.axes) > 1) for one in found.criteria)
    rule = (
        "by the figure itself, as the guidelines have it; with `decision=interval` all of the "
        "interval must be on the side of the limit"
        if found.decision is DecisionRule.SIMPLE
        else "by the whole 95 % interval; the guidelines take the figure itself: `decision=simple`"
    )
    return Table(("criterion", "", "95 % interval", "limit", "of", "verdict"), rows, rule)


def _criterion(one: Criterion, *, many: bool) -> tuple[Cell, ...]:
    name = f"{one.axis} {one.name}" if many else one.name
    sign = ">=" if one.at_least else "<="
    spec = ".0%" if one.name in _SHARES else "g"
    limit = Number(one.limit, spec, mark=f"{sign} ")
    if one.value is None:
        return name, "none", "", limit, one.of, _word(one)
    if one.name in _SHARES:
        value: Cell = Number(one.value, ".1%")
        ends: Cell = Interval(*(Number(x, ".1%") for x in one.interval)) if one.interval else ""
    elif one.name == "ndc":
        value = Number(whole_categories(one.value))
        whole = [Number(whole_categories(end)) for end in one.interval or ()]
        ends = Interval(*whole) if whole else ""
    else:
        value, ends = figure_cells(one.value, one.interval, limit=one.limit)
    return name, value, ends, limit, one.of, _word(one)


def _word(one: Criterion) -> str:
    return "pass, conditional" if one.is_conditional else one.verdict.value


def _figures(study: AxisStudy) -> Iterator[Block]:
    figures, unit = study.figures, study.readings.unit
    match figures:
        case TypeOne():
            yield _type_1(figures, unit)
        case Crossed():
            yield _anova(figures)
            yield _components(figures, unit)
            yield _by_ranges(figures, unit)
        case Linearity():
            yield from _linearity(figures, unit)
        case Stability():
            yield _stability(figures, unit)


def _type_1(figures: TypeOne, unit: str) -> Table:
    rows: list[tuple[Cell, ...]] = [("readings", Number(figures.n), "", "")]
    rows.append(("mean", four_digits(figures.mean), "", unit))
    rows.append(("standard deviation s", *figure_cells(figures.s, figures.s_interval), unit))
    if figures.bias is not None and figures.reference is not None:
        rows.append(("reference", four_digits(figures.reference), "", unit))
        rows.append(("bias", *figure_cells(figures.bias, figures.bias_interval), unit))
    if figures.t is not None and figures.p_value is not None:
        rows.append(("t of the bias", four_digits(figures.t), "", ""))
        rows.append(("p of the bias", four_digits(figures.p_value), "", ""))
    for name in ("Cg", "Cgk"):
        value, ends = getattr(figures, name), getattr(figures, f"{name}_interval")
        if value is not None:
            rows.append((name, *figure_cells(value, ends), ""))
    return Table(("figure", "", "95 % interval", "in"), tuple(rows))


def _anova(figures: Crossed) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for one in figures.anova:
        tests: tuple[Cell, Cell] = ("", "")
        if one.F is not None and one.p_value is not None:
            tests = (four_digits(one.F), four_digits(one.p_value))
        squares, mean_square = four_digits(one.squares), four_digits(one.mean_square)
        rows.append((one.source, squares, Number(one.freedom), mean_square, *tests))
    pooled = "part x operator has p above 0.25 and counts as repeatability (AIAG)"
    header = ("source", "squares", "df", "mean square", "F", "p")
    return Table(header, tuple(rows), pooled if figures.interaction_pooled else "")


def _components(figures: Crossed, unit: str) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for name, one in figures.components.items():
        shares: list[Cell] = [Number(one.contribution, ".1%"), Number(one.of_study, ".1%")]
        if one.of_tolerance is not None:
            shares.append(Number(one.of_tolerance, ".1%"))
        sigma, ends = figure_cells(one.sigma, one.interval)
        rows.append((_COMPONENTS[name], sigma, ends, unit, *shares))
    header = ("standard deviation", "", "95 % interval", "in", "of variance", "of TV")
    last = ("6 s of T",) if len(rows[0]) > len(header) else ()
    ndc = f"number of distinct categories: {figures.ndc or 'none, nothing scatters'}"
    return Table((*header, *last), tuple(rows), ndc)


def _by_ranges(figures: Crossed, unit: str) -> Table:
    ranges = figures.by_ranges
    pairs = (
        ("EV", ranges.EV),
        ("AV", ranges.AV),
        ("GRR", ranges.GRR),
        ("PV", ranges.PV),
        ("TV", ranges.TV),
    )
    rows = tuple((_COMPONENTS[name], four_digits(value), unit) for name, value in pairs)
    share = f"R&R {ranges.of_study:.1%} of TV, ndc {ranges.ndc or 'none'}"
    return Table(("by average and range", "", "in"), rows, f"{share}; for comparison only")


def _linearity(figures: Linearity, unit: str) -> Iterator[Table]:
    rows: list[tuple[Cell, ...]] = []
    for x, bias, low, high in zip(
        figures.references, figures.biases, figures.lower, figures.upper, strict=True
    ):
        band, places = Interval(Number(low, ".4g"), Number(high, ".4g")), four_digits(bias)
        rows.append((f"{x:.6g}", places, band, unit))
    yield Table(("reference", "mean bias", "95 % band of the line", "in"), tuple(rows))
    slope = figure_cells(figures.slope, figures.slope_interval)
    lines: list[tuple[Cell, ...]] = [("slope", *slope, _p(figures.slope_p_value))]
    lines.append(("intercept", four_digits(figures.intercept), "", _p(figures.intercept_p_value)))
    lines.append(("about the line", four_digits(figures.residual), "", ""))
    yield Table(("line", "", "95 % interval", "p"), tuple(lines))


def _p(value: float | None) -> Cell:
    return "" if value is None else four_digits(value)


def _stability(figures: Stability, unit: str) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for k, name in enumerate(figures.sessions):
        half = float(figures.half_width[k])
        limits = Interval(*(Number(figures.centre + side * half, ".6g") for side in (-1, 1)))
        scatter: Cell = "" if figures.scatters is None else four_digits(figures.scatters[k])
        out = "outside" if name in figures.outside else ""
        rows.append((name, Number(figures.means[k], ".6g"), limits, scatter, unit, out))
    note = f"between sessions beyond that scatter: {figures.between:.3g} {unit}"
    return Table(("session", "mean", "limits", "s", "in", ""), tuple(rows), note)


def _budget(budget: Budget, study: AxisStudy) -> Iterator[Block]:
    unit = study.readings.unit
    rows: list[tuple[Cell, ...]] = [
        (f"u_{name}", _PARTS[name], four_digits(part), unit) for name, part in budget.parts.items()
    ]
    low, high = budget.interval
    rows.append(
        (f"U_{budget.of}", f"2 u, 95 % interval {low:.2g}..{high:.2g}", four_digits(budget.U), unit)
    )
    rows.append(
        (
            "T_min",
            f"tolerance with Q = {budget.limit:.0%}",
            four_digits(budget.smallest_tolerance),
            unit,
        )
    )
    if budget.Q is not None and budget.zone is not None:
        rows.append(
            (f"Q_{budget.of}", f"2 U / T, at most {budget.limit:.0%}", Number(budget.Q, ".1%"), "")
        )
        if budget.C is not None:
            rows.append((f"C_{budget.of}", "1.33 at least", four_digits(budget.C), ""))
        rows.append(
            ("T - 2 U", "where a reading proves conformity", four_digits(budget.zone), unit)
        )
    yield Table(
        ("VDA 5, ISO 22514-7", "", "", "in"),
        tuple(rows),
        "of repeatabilities and division the largest counts; ISO 14253-1: U off both ends",
    )


def _how(found: GaugeStudy) -> Iterator[Text]:
    yield from (Text(note, "quiet") for note in found.notes)
    yield Text(
        f"{found.source}: every reading counts, the first too; references are taken as exact. "
        "AIAG MSA 4th ed. and Bosch booklet 10: Cg = 0.2 T / (6 s), Cgk = (0.1 T - |bias|) / (3 s)"
        ", ndc = 1.41 PV / GRR. Intervals 95 %: Student, chi-square, generalized pivots",
        "quiet",
    )
