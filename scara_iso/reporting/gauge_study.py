"""The document of a gauge study: the verdict, what decides it, the figures of each dial."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
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
from scara_iso.reporting.pictures import study_picture
from scara_iso.reporting.shared.blocks import (
    Block,
    Columns,
    NextStep,
    Report,
    Section,
    Table,
    Text,
    note,
)
from scara_iso.reporting.shared.digits import (
    FIGURE,
    Cell,
    Ends,
    Interval,
    Number,
    Result,
    four_digits,
    numbers,
    places_that_differ,
    result,
    share,
)
from scara_iso.reporting.shared.limits import VERDICTS

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
_COUNTS: Mapping[str, Callable[[float], int]] = {"ndc": whole_categories, "sessions outside": int}
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
    warnings = [text for text in remarks if text.tone == "warn"]
    behind = Text("figures, ANOVA, uncertainty, picture: `full=`", "quiet")
    details = [Section("Remarks", tuple(text for text in remarks if text.tone != "warn"))]
    for name, study in found.axes.items():
        of = f" {name}" if many else ""
        details.append(Section(f"Figures{of}", (*_figures(study), study_picture(study))))
        if study.budget is not None:
            details.append(Section(f"Uncertainty{of}", (_budget(study.budget, study),)))
    how = f"{found.source}: {note('gauge_study')}"
    unused = tuple(Text(text, "quiet") for text in found.notes)
    details.append(Section("", (*unused, Text(how, "quiet"))))
    return (
        Section.of_answer([*answer, *kinds, *warnings], following, answer=len(answer)),
        Section("", (_criteria(found),)),
        Section("", (*unused, behind), depth="more"),
        *Section.in_detail(details),
    )


def _verdict(found: GaugeStudy) -> Iterator[Block]:
    for verdict, (_, tone) in VERDICTS.items():
        checks = [one for one in found.criteria if one.verdict is verdict]
        if checks and (verdict is not Conformity.PASS or found.conformity is Conformity.PASS):
            names = (
                f"{_of_axis(found, one)}{' (conditional)' if one.is_conditional else ''}"
                for one in checks
            )
            unjudged = _without_bias(found) if verdict is Conformity.PASS else ""
            yield Text(f"{_WORDING[verdict]}: {', '.join(names)}{unjudged}", tone)
    for name, study in found.axes.items():
        first, *others = _in_brief(study)
        yield Text(f"{name}  {first}", "strong", tuple(others))


def _without_bias(found: GaugeStudy) -> str:
    kinds = [one.figures for one in found.axes.values() if isinstance(one.figures, TypeOne)]
    if all(one.bias is not None for one in kinds):
        return ""
    return "; its bias is not judged: state the true value, as '# reference: 5.000 mm'"


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
            of = _of_type_1(figures, unit)
            named = {"Cg": "Cg", "Cgk": "Cgk", "s": "standard deviation s", "bias": "bias"}
            yield from (f"{name} {of[label]}" for name, label in named.items() if of[label])
        case Crossed():
            whole = figures.components["GRR"]
            if whole.of_tolerance is not None:
                yield f"R&R {whole.of_tolerance:.1%} of T"
            yield f"R&R {whole.of_study:.1%} of TV"
            yield f"ndc {figures.ndc or 'none'}"
            yield f"GRR {result(whole.sigma, whole.interval, unit)}"
        case Linearity():
            yield f"slope {_of_line(figures, unit)['slope']}"
            yield f"largest bias {figures.largest_bias:.3g} {unit}"
        case Stability():
            yield f"{len(figures.outside)} of {len(figures.sessions)} sessions outside"
            yield f"centre {figures.centre:.6g} {unit}"


def _figure(value: float | None, ends: Ends = None, unit: str = "") -> Cell:
    if value is None:
        return ""
    return four_digits(value, unit) if ends is None else result(value, ends, unit)


def _of_type_1(found: TypeOne, unit: str) -> dict[str, Cell]:
    return {
        "readings": Number(found.n),
        "mean": _figure(found.mean, None, unit),
        "standard deviation s": _figure(found.s, found.s_interval, unit),
        "reference": _figure(found.reference, None, unit),
        "bias": _figure(found.bias, found.bias_interval, unit),
        "t of the bias": _figure(found.t),
        "p of the bias": _figure(found.p_value),
        "Cg": _figure(found.Cg, found.Cg_interval),
        "Cgk": _figure(found.Cgk, found.Cgk_interval),
    }


def _of_line(found: Linearity, unit: str) -> dict[str, Cell]:
    return {
        "slope": _figure(found.slope, found.slope_interval),
        "p of the slope": _figure(found.slope_p_value),
        "intercept": _figure(found.intercept, None, unit),
        "p of the intercept": _figure(found.intercept_p_value),
        "scatter about the line": _figure(found.residual, None, unit),
    }


def _table_of(figures: Mapping[str, Cell]) -> Table:
    return Table(("", FIGURE), tuple(row for row in figures.items() if row[1]))


def _remarks(found: GaugeStudy) -> Iterator[Text]:
    for one in found.remarks:
        of = f"{one.axis}: " if len(found.axes) > 1 and one.axis else ""
        grave = one.severity == "warning"
        yield Text(f"{'! ' if grave else '- '}{of}{one.message}", "warn" if grave else "plain")


def _criteria(found: GaugeStudy) -> Table:
    columns: Columns[Criterion] = {
        "criterion": lambda one: _of_axis(found, one),
        FIGURE: _criterion,
        "limit": lambda one: Number(
            one.limit,
            ".0%" if one.name in _SHARES else "g",
            mark=">= " if one.at_least else "<= ",
        ),
        "of": lambda one: one.of,
        "verdict": lambda one: "pass, conditional" if one.is_conditional else one.verdict.value,
    }
    simple = found.decision is DecisionRule.SIMPLE
    return Table.of(found.criteria, columns, note("by_figure" if simple else "by_interval"))


def _criterion(one: Criterion) -> Cell:
    if one.value is None:
        return "none"
    if one.name not in (*_SHARES, *_COUNTS):
        return result(one.value, one.interval, limit=one.limit)
    values = [one.value, *(one.interval or ())]
    if one.name in _SHARES:
        places = places_that_differ(values, one.limit, 3) - 2
        value, *between = numbers(values, f".{places}%")
    else:
        value, *between = numbers([_COUNTS[one.name](v) for v in values])
    return Result(value, Interval(*between) if between else None)


def _figures(study: AxisStudy) -> Iterator[Block]:
    figures, unit = study.figures, study.readings.unit
    match figures:
        case TypeOne():
            yield _table_of(_of_type_1(figures, unit))
        case Crossed():
            yield _anova(figures)
            yield _components(figures, unit)
            ranges = figures.by_ranges
            sigmas = {"EV": ranges.EV, "AV": ranges.AV, "GRR": ranges.GRR}
            sigmas |= {"PV": ranges.PV, "TV": ranges.TV}
            rows = tuple((_COMPONENTS[name], four_digits(s, unit)) for name, s in sigmas.items())
            share_of = f"R&R {ranges.of_study:.1%} of TV, ndc {ranges.ndc or 'none'}"
            yield Table(("by average and range", ""), rows, f"{share_of}; for comparison only")
        case Linearity():
            ends = zip(numbers(figures.lower, ".4g"), numbers(figures.upper, ".4g"), strict=True)
            band: dict[str, list[Cell]] = {
                f"reference [{unit}]": [*numbers(figures.references, ".6g")],
                f"mean bias [{unit}]": [four_digits(bias) for bias in figures.biases.tolist()],
                "95 % band of the line": [Interval(*both) for both in ends],
            }
            yield Table.in_columns(band)
            yield _table_of(_of_line(figures, unit))
        case Stability():
            yield _stability(figures, unit)


def _anova(figures: Crossed) -> Table:
    columns: Columns[Any] = {
        "source": lambda one: one.source,
        "squares": lambda one: four_digits(one.squares),
        "df": lambda one: one.freedom,
        "mean square": lambda one: four_digits(one.mean_square),
        "F": lambda one: four_digits(one.F),
        "p": lambda one: four_digits(one.p_value),
    }
    pooled = "part x operator has p above 0.25 and counts as repeatability (AIAG)"
    return Table.of(figures.anova, columns, pooled if figures.interaction_pooled else "")


def _components(figures: Crossed, unit: str) -> Table:
    columns: Columns[tuple[str, Any]] = {
        "standard deviation": lambda row: _COMPONENTS[row[0]],
        FIGURE: lambda row: result(row[1].sigma, row[1].interval, unit),
        "of variance": lambda row: share(row[1].contribution, ".1%"),
        "of TV": lambda row: share(row[1].of_study, ".1%"),
    }
    if any(one.of_tolerance is not None for one in figures.components.values()):
        columns = {**columns, "6 s of T": lambda row: share(row[1].of_tolerance, ".1%")}
    ndc = f"number of distinct categories: {figures.ndc or 'none, nothing scatters'}"
    return Table.of(figures.components.items(), columns, ndc)


def _stability(figures: Stability, unit: str) -> Table:
    ends = [numbers(figures.centre + side * figures.half_width, ".6g") for side in (-1, 1)]
    columns: dict[str, list[Cell]] = {
        "session": [*figures.sessions],
        f"mean [{unit}]": [*numbers(figures.means, ".6g")],
        "limits": [Interval(*both) for both in zip(*ends, strict=True)],
        "": ["outside" if name in figures.outside else "" for name in figures.sessions],
    }
    if figures.scatters is not None:
        columns["s"] = [four_digits(s) for s in figures.scatters]
    between = f"between sessions beyond that scatter: {figures.between:.3g} {unit}"
    return Table.in_columns(columns, between)


def _budget(budget: Budget, study: AxisStudy) -> Table:
    unit, most, between = study.readings.unit, f"{budget.limit:.0%}", budget.interval
    rows: list[tuple[Cell, ...]] = [
        (f"u_{name}", _PARTS[name], four_digits(u, unit)) for name, u in budget.parts.items()
    ]
    ends = "2 u" + (f", 95 % interval {between[0]:.2g}..{between[1]:.2g}" if between else "")
    rows.append((f"U_{budget.of}", ends, four_digits(budget.U, unit)))
    smallest = four_digits(budget.smallest_tolerance, unit)
    rows.append(("T_min", f"tolerance with Q = {most}", smallest))
    if budget.Q is not None and budget.zone is not None:
        rows.append((f"Q_{budget.of}", f"2 U / T, at most {most}", share(budget.Q, ".1%")))
        if budget.C is not None:
            rows.append((f"C_{budget.of}", "1.33 at least", four_digits(budget.C)))
        zone = "where a reading proves conformity"
        rows.append(("T - 2 U", zone, four_digits(budget.zone, unit)))
    most = "of repeatabilities and division the largest counts; ISO 14253-1: U off both ends"
    return Table(("VDA 5, ISO 22514-7", "", ""), tuple(rows), most)
