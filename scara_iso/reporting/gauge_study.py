"""The document of a gauge study: the verdict, what decides it, the figures of each dial."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

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
    Columns,
    Headline,
    NextStep,
    Report,
    Section,
    Table,
    Text,
    answer_lines,
    at_depth,
    tabulated,
)
from scara_iso.reporting.digits import (
    Cell,
    Interval,
    Number,
    figure_cells,
    figure_in_words,
    four_digits,
)
from scara_iso.reporting.limits import STRICTEST, TONES
from scara_iso.reporting.pictures import study_picture

_KINDS = {
    "type-1": "type 1: one part, read again and again",
    "type-2": "type 2: parts by several operators (R&R, ANOVA)",
    "type-3": "type 3: parts, no operators compared (ANOVA)",
    "linearity": "linearity: parts of several known sizes",
    "stability": "stability: one part in several sessions",
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
    answer, remarks, many = list(_verdict(found)), list(_remarks(found)), len(found.axes) > 1
    kinds = [Text(_kind(study), "quiet") for study in found.axes.values()]
    lines = answer_lines([*answer, *kinds], following, answer=len(answer))
    warnings = [text for text in remarks if text.tone == "warn"]
    behind = Text("figures, ANOVA, uncertainty, picture: `full=`", "quiet")
    details = [Section("Remarks", tuple(text for text in remarks if text.tone != "warn"))]
    for name, study in found.axes.items():
        of = f" {name}" if many else ""
        details.append(Section(f"Figures{of}", (*_figures(study), study_picture(study))))
        if study.budget is not None:
            details.append(Section(f"Uncertainty{of}", (_budget(study.budget, study),)))
    how = (
        f"{found.source}: every reading counts, the first too; references are taken as exact. "
        "AIAG MSA 4th ed. and Bosch booklet 10: Cg = 0.2 T / (6 s), Cgk = (0.1 T - |bias|) / (3 s)"
        ", ndc = 1.41 PV / GRR. Intervals 95 %: Student, chi-square, generalized pivots"
    )
    details.append(Section("", tuple(Text(note, "quiet") for note in (*found.notes, how))))
    return (
        Section("", (*lines, *warnings)),
        Section("", (_criteria(found),)),
        Section("", (behind,), depth="more"),
        *at_depth("detail", details),
    )


def _verdict(found: GaugeStudy) -> Iterator[Block]:
    for verdict in STRICTEST:
        checks = [one for one in found.criteria if one.verdict is verdict]
        if checks and (verdict is not Conformity.PASS or found.conformity is Conformity.PASS):
            names = (
                f"{_of_axis(found, one)}{' (conditional)' if one.is_conditional else ''}"
                for one in checks
            )
            yield Text(f"{_WORDING[verdict]}: {', '.join(names)}", TONES[verdict])
    for name, study in found.axes.items():
        yield Headline((f"{name}  {'   '.join(_in_brief(study))}",))


def _of_axis(found: GaugeStudy, one: Criterion) -> str:
    return f"{one.axis} {one.name}" if len(found.axes) > 1 else one.name


def _kind(study: AxisStudy) -> str:
    readings, T = study.readings, study.tolerance
    tolerance = "" if T is None else f", tolerance {T:g} {readings.unit}"
    return f"{readings.axis}: {_KINDS[study.kind.value]}{tolerance}"


def _in_brief(study: AxisStudy) -> Iterator[str]:
    figures, unit = study.figures, study.readings.unit
    match figures:
        case TypeOne():
            for name, of in (("Cg", ""), ("Cgk", ""), ("s", unit), ("bias", unit)):
                value = getattr(figures, name)
                if value is not None:
                    yield figure_in_words(name, value, getattr(figures, f"{name}_interval"), of)
        case Crossed():
            whole = figures.components["GRR"]
            if whole.of_tolerance is not None:
                yield f"R&R {whole.of_tolerance:.1%} of T"
            yield f"R&R {whole.of_study:.1%} of TV"
            yield f"ndc {figures.ndc or 'none'}"
            yield figure_in_words("GRR", whole.sigma, whole.interval, unit)
        case Linearity():
            yield figure_in_words("slope", figures.slope, figures.slope_interval, "")
            yield f"largest bias {figures.largest_bias:.3g} {unit}"
        case Stability():
            yield f"{len(figures.outside)} of {len(figures.sessions)} sessions outside"
            yield f"centre {figures.centre:.6g} {unit}"


def _remarks(found: GaugeStudy) -> Iterator[Text]:
    for one in found.remarks:
        of = f"{one.axis}: " if len(found.axes) > 1 and one.axis else ""
        grave = one.severity == "warning"
        yield Text(f"{'! ' if grave else '- '}{of}{one.message}", "warn" if grave else "plain")


def _criteria(found: GaugeStudy) -> Table:
    columns: Columns[Criterion] = {
        "criterion": lambda one: _of_axis(found, one),
        "": lambda one: _criterion(one)[0],
        "95 % interval": lambda one: _criterion(one)[1],
        "limit": lambda one: Number(
            one.limit,
            ".0%" if one.name in _SHARES else "g",
            mark=">= " if one.at_least else "<= ",
        ),
        "of": lambda one: one.of,
        "verdict": lambda one: "pass, conditional" if one.is_conditional else one.verdict.value,
    }
    rule = (
        "by the figure itself, as the guidelines have it; with `decision=interval` all of the "
        "interval must be on the side of the limit"
        if found.decision is DecisionRule.SIMPLE
        else "by the whole 95 % interval; the guidelines take the figure itself: `decision=simple`"
    )
    return tabulated(found.criteria, columns, rule)


def _criterion(one: Criterion) -> tuple[Cell, Cell]:
    """Return the figure of a criterion and its interval, as shares or whole categories."""
    ends = one.interval or ()
    if one.value is None:
        return "none", ""
    if one.name in _SHARES:
        shares = [Number(end, ".1%") for end in ends]
        return Number(one.value, ".1%"), Interval(*shares) if shares else ""
    if one.name == "ndc":
        whole = [Number(whole_categories(end)) for end in ends]
        return Number(whole_categories(one.value)), Interval(*whole) if whole else ""
    return figure_cells(one.value, one.interval, limit=one.limit)


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
    rows: list[tuple[Cell, ...]] = [
        ("readings", Number(figures.n), "", ""),
        ("mean", four_digits(figures.mean), "", unit),
        ("standard deviation s", *figure_cells(figures.s, figures.s_interval), unit),
    ]
    if figures.bias is not None and figures.reference is not None:
        rows.append(("reference", four_digits(figures.reference), "", unit))
        rows.append(("bias", *figure_cells(figures.bias, figures.bias_interval), unit))
    if figures.t is not None and figures.p_value is not None:
        rows.append(("t of the bias", four_digits(figures.t), "", ""))
        rows.append(("p of the bias", four_digits(figures.p_value), "", ""))
    rows += [
        (name, *figure_cells(value, getattr(figures, f"{name}_interval")), "")
        for name in ("Cg", "Cgk")
        if (value := getattr(figures, name)) is not None
    ]
    return Table(("figure", "", "95 % interval", "in"), tuple(rows))


def _anova(figures: Crossed) -> Table:
    columns: Columns[Any] = {
        "source": lambda one: one.source,
        "squares": lambda one: four_digits(one.squares),
        "df": lambda one: Number(one.freedom),
        "mean square": lambda one: four_digits(one.mean_square),
        "F": lambda one: _or_none(one.F),
        "p": lambda one: _or_none(one.p_value),
    }
    pooled = "part x operator has p above 0.25 and counts as repeatability (AIAG)"
    return tabulated(figures.anova, columns, pooled if figures.interaction_pooled else "")


def _or_none(value: float | None) -> Cell:
    return "" if value is None else four_digits(value)


def _components(figures: Crossed, unit: str) -> Table:
    columns: Columns[tuple[str, Any]] = {
        "standard deviation": lambda one: _COMPONENTS[one[0]],
        "": lambda one: figure_cells(one[1].sigma, one[1].interval)[0],
        "95 % interval": lambda one: figure_cells(one[1].sigma, one[1].interval)[1],
        "in": lambda _: unit,
        "of variance": lambda one: Number(one[1].contribution, ".1%"),
        "of TV": lambda one: Number(one[1].of_study, ".1%"),
    }
    if any(one.of_tolerance is not None for one in figures.components.values()):
        columns = {**columns, "6 s of T": lambda one: Number(one[1].of_tolerance or 0.0, ".1%")}
    ndc = f"number of distinct categories: {figures.ndc or 'none, nothing scatters'}"
    return tabulated(figures.components.items(), columns, ndc)


def _by_ranges(figures: Crossed, unit: str) -> Table:
    ranges = figures.by_ranges
    rows = tuple(
        (_COMPONENTS[name], four_digits(getattr(ranges, name)), unit)
        for name in ("EV", "AV", "GRR", "PV", "TV")
    )
    share = f"R&R {ranges.of_study:.1%} of TV, ndc {ranges.ndc or 'none'}"
    return Table(("by average and range", "", "in"), rows, f"{share}; for comparison only")


def _linearity(figures: Linearity, unit: str) -> Iterator[Table]:
    columns = (figures.references, figures.biases, figures.lower, figures.upper)
    yield Table(
        ("reference", "mean bias", "95 % band of the line", "in"),
        tuple(
            (
                f"{x:.6g}",
                four_digits(bias),
                Interval(Number(low, ".4g"), Number(high, ".4g")),
                unit,
            )
            for x, bias, low, high in zip(*columns, strict=True)
        ),
    )
    slope = figure_cells(figures.slope, figures.slope_interval)
    lines: tuple[tuple[Cell, ...], ...] = (
        ("slope", *slope, _or_none(figures.slope_p_value)),
        ("intercept", four_digits(figures.intercept), "", _or_none(figures.intercept_p_value)),
        ("about the line", four_digits(figures.residual), "", ""),
    )
    yield Table(("line", "", "95 % interval", "p"), lines)


def _stability(figures: Stability, unit: str) -> Table:
    def limits(k: int) -> Interval:
        half = float(figures.half_width[k])
        return Interval(*(Number(figures.centre + side * half, ".6g") for side in (-1, 1)))

    scatters, names = figures.scatters, figures.sessions
    columns: Columns[int] = {
        "session": lambda k: names[k],
        "mean": lambda k: Number(figures.means[k], ".6g"),
        "limits": limits,
        "s": lambda k: "" if scatters is None else four_digits(scatters[k]),
        "in": lambda _: unit,
        "": lambda k: "outside" if names[k] in figures.outside else "",
    }
    note = f"between sessions beyond that scatter: {figures.between:.3g} {unit}"
    return tabulated(range(len(names)), columns, note)


def _budget(budget: Budget, study: AxisStudy) -> Table:
    unit, most = study.readings.unit, f"{budget.limit:.0%}"
    low, high = budget.interval
    parts = [(f"u_{name}", _PARTS[name], four_digits(u), unit) for name, u in budget.parts.items()]
    ends = f"2 u, 95 % interval {low:.2g}..{high:.2g}"
    least = f"tolerance with Q = {most}"
    rows: list[tuple[Cell, ...]] = [
        *parts,
        (f"U_{budget.of}", ends, four_digits(budget.U), unit),
        ("T_min", least, four_digits(budget.smallest_tolerance), unit),
    ]
    if budget.Q is not None and budget.zone is not None:
        rows.append((f"Q_{budget.of}", f"2 U / T, at most {most}", Number(budget.Q, ".1%"), ""))
        if budget.C is not None:
            rows.append((f"C_{budget.of}", "1.33 at least", four_digits(budget.C), ""))
        zone = "where a reading proves conformity"
        rows.append(("T - 2 U", zone, four_digits(budget.zone), unit))
    note = "of repeatabilities and division the largest counts; ISO 14253-1: U off both ends"
    return Table(("VDA 5, ISO 22514-7", "", "", "in"), tuple(rows), note)
