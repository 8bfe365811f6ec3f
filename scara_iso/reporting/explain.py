"""The page of every finding, characteristic and effect: what it means and what to do.

Words that stand on the screens and are no finding, characteristic or effect.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from inspect import cleandoc
from typing import Annotated, Literal

from scara_iso import effects
from scara_iso.base.errors import UsageError
from scara_iso.base.plugins import find_modules
from scara_iso.base.published import publish
from scara_iso.comparison import PAGES
from scara_iso.effects import Effect, GearEffect, OwnEffect
from scara_iso.iso9283 import BEYOND_DIALS, characteristics, checks, in_brief
from scara_iso.reporting.blocks import Block, Report, Section, Table, Text

KIND = "word of the screens"
SAME: Mapping[str, str] = {
    "eq. 2": "RP",
    "eq. 3": "RP",
    "eq. 4": "RP",
    "eq. 5": "RP",
    "eq. 6": "RP",
    "l_bar": "RP",
    "S_l": "RP",
    "repeatability": "RP",
    "7.2.2": "RP",
    "accuracy": "AP",
    "7.2.1": "AP",
    "eq. 23": "RP_rss",
    "rss": "RP_rss",
    "root sum of squares": "RP_rss",
    "three sigma": "RP_a",
    "3 s": "RP_a",
    "± 3 s": "RP_a",
    "division": "resolution",
    "6 s of t": "Cg",
    "odd reading": "gross-reading",
    "no known effect": "nothing to explain",
    "u/rp": "u",
    "u/3 s": "u",
}
"""Other names of a page, by the code of the page."""

_TEXT = """
XY, XYZ, radial
RP in a plane, or in space
RP of ISO 9283 7.2.2 with l_j the distance of visit j to the barycentre in the plane XY, or in XYZ.
The paper's figure of a plane is another, eq. 23 (RP_rss): the root of the sum of squares of the
axes' RP. A limit XY is one of the radial RP; XY_eq23 is the paper's.

interval, 95 % interval, confidence interval
The range that contains the true figure in about 95 of 100 tests
RP of thirty cycles is an estimate: another test of the same robot gives another. About 95 of 100
tests give an interval that contains the robot's long-run RP. Four times the cycles halve its width.
If the readings drifted (finding trend), the interval does not hold: find the cause first.

not provable, pass, fail, verdict, limit
Verdicts on a limit: pass, fail, not provable
pass: the whole 95 % interval is at most the limit. fail: all of it is above. not provable: the
limit lies in the interval, so these cycles prove neither; the answer states how many would. The
exit code is 0 for pass, 1 for the others. With `decision=simple` the figure alone decides.

probability, rivals
How likely an effect is among those known
Once structure is detected, each known effect gets a probability by how well it explains the
readings. Below 90 % read it as "or": its rivals fit nearly as well. A name is a cause to check, not
a proof.

p, p value
p-value: probability of at least this much if there is only scatter
The share of random orders of the cycles (in a comparison: of random exchanges between the runs)
that differ as much as what was found. At most 0.05 is taken as shown.

nothing to explain, nothing besides scatter, explained, unexplained, found, suspected
Verdicts of a diagnosis: explained, unexplained, nothing to explain
nothing to explain: the readings look like scatter in any order; an effect too small for so few
cycles does not show (`design=` of diagnose states how small). explained: there is more than
scatter, and a known effect fits; suspected: it predicts unseen cycles no better. unexplained: there
is more than scatter, and no known effect fits. Its course is learned and drawn; look at what
happened at its bends, repeat the test, or add an effect of your own.

held out, unseen, cycles that the model has not seen, error, error before, error after
Error on cycles that the model has not seen
The effect is chosen and fitted on some of the cycles, and the error is measured on the others: a
model that only follows chance gains nothing. In the unit of the axis, before and after the effect
is in the model.

expected in a repeat test, next test, prediction interval
RP expected in a repeat test of 30 cycles, with its 95 % prediction interval
The completed model (effects, scatter, rounding) predicts a new test of the same machine, whose
scatter differs from run to run by some 25 %. In about 95 of 100 its RP lies inside.

better, worse, ratio, not shown, less, more
A change from one run to another
The figure after over the figure before, with its 95 % interval: ×0.5 is half. less, more: beyond
chance and rounding. not shown: an unchanged robot differs as much by chance; the interval says how
much may have changed.

u, uncertainty
Standard uncertainty of one reading
The dial's division over the root of twelve, and what its certificate states, combined (GUM).
U = 2u, the expanded uncertainty of a reading (k = 2).

rms error, model before, model after, completed model, predicted
Measured minus predicted, root mean square
Before: by the model given, else a constant pose. After, completed: with the effects found.

variance, what RP is made of
Shares of the variance of the readings
By the effects found, by rounding to the dial's division, and what is left.

cycles needed, shown here
What so many cycles can show
cycles needed: so many would show this change in 4 of 5 tests. shown here: the smallest change that
these cycles show in 4 of 5 tests.

scatter of, traced to the joints, joint scatter, follows, RP at poses not measured
Standard deviation of each joint's angle, and of what is not a joint
Computed from how the readings of several poses scatter together; it predicts RP at poses that were
not measured.

not identifiable
A parameter that these readings do not determine
Other values fit nearly as well, so no interval is given. The line states what would help.

effect removed, without the effect
RP of the readings with the effect subtracted
What the robot would reach if the cause were cured; the ISO figure itself is the measured one.

evidence
How much more probable the readings are with structure than without
While a recording runs, an alarm is given at 20.

Cg, Cgk
Whether a dial is fine enough for a tolerance, type 1 study
Cg = 0.2 T / (6 s), with T the width of the tolerance and s the scatter of readings of one part.
Cgk = (0.1 T - |bias|) / (3 s). Both are to be 1.33 or more (Bosch booklet 10).

R&R, GRR, EV, AV, PV, TV, ndc, of TV, of variance, squares, mean square, df, F
Parts of the scatter in a gauge study (ANOVA)
EV: repeatability. AV: operators. GRR, R&R: both. PV: parts. TV: all. ndc = 1.41 PV / GRR.

guard band
U of the indicator, on either side of a limit
With simple acceptance, a figure that close to the limit may lie on its other side (ISO 14253-1).

EWMA, CUSUM, charts, alarm, alarms, individuals, moving range
Control charts of one robot over months
Each test is compared with those before it since the last service, in standard errors. A point
outside the limits is an alarm; without a change about one test in 350 gives one in each chart.

q, false discovery rate
p of one of many robots, corrected for their number
Of the robots whose q is at most 0.05, on average at most 5 % are named by chance.

a month, wears, per month, worse than before
How much RP grows in a month, as a share of it
From the tests of the robot over their dates; p is the probability of as much without growth.

observability index, index, joints 1, 2, size to, smallest, which is of, apart, singular
How well poses tell the joints apart
Each joint moves the poses in its own way; the angles between these ways are in degrees: 90 is best,
at 0 two joints move the poses alike. index: 0 where joints cannot be told apart. singular: degrees
of joint 2 from the arm stretched or folded.

travel, smallest travel, as planned
Range of an effect over the test, without scatter
For each effect: the smallest travel that is found in 80 % of such tests.

barycentre
The mean of the attained positions
The point from which the distances l_j of RP are taken (ISO 9283 7.2.2).
"""


def _read(text: str) -> Mapping[tuple[str, ...], tuple[str, str]]:
    entries = [entry.split("\n") for entry in text.strip().split("\n\n")]
    return {tuple(names.split(", ")): (title, " ".join(line)) for names, title, *line in entries}


WORDS = _read(_TEXT)
"""By the names of each: its title and its text."""
_TASKS: Mapping[str, tuple[str, str]] = {
    "What does a figure mean, and how sure is it?": (
        "characteristic",
        "XY, interval, barycentre, u",
    ),
    "Is a limit kept, is a dial good enough?": (
        "",
        "not provable, guard band, cycles needed, Cg, R&R",
    ),
    "What does a warning or a deviation mean?": ("finding", ""),
    "How is a diagnosis to be read?": (
        "",
        (
            "nothing to explain, probability, p, evidence, held out, expected in a repeat test, "
            "effect removed, not identifiable, rms error, variance, scatter of"
        ),
    ),
    "What can move the readings?": ("effect on readings", ""),
    "What can differ in a gear?": ("effect on a reversal", ""),
    "What changed between runs, over months, in a fleet?": ("", "better, EWMA, a month, q"),
    "What will a planned test show?": ("", "observability index, travel"),
}
"""By what a reader wants to know: the kind of its pages, and words of the screens."""


_CODE = re.compile(r"`+([^`]+)`+")
_MOST_NEAR = 3
_AXIS = re.compile(r" (X|Y|Z|XY|XYZ|theta)$")
"""Behind the name of a figure: ``RP XY``."""
_PARAMETER = re.compile(r"[A-Za-z]\w*=\S*")
_KINDS = ("characteristic", "effect on a reversal", "effect on readings", "finding", KIND)


@dataclass(frozen=True, slots=True)
class ExplainedParameter:
    """A parameter of an effect."""

    name: str
    """As it is written: `name=value`."""
    unit: str
    """Empty where it has none; `reading` is that of the axis."""
    meaning: str
    """What it is."""


@dataclass(frozen=True, slots=True)
class Page:
    """What is said of a code."""

    code: str
    """As the screens have it."""
    kind: Annotated[str, ("enum", _KINDS)]
    """What it is the name of."""
    title: str
    """In one line."""
    text: tuple[str, ...]
    """Paragraphs."""
    parameters: tuple[ExplainedParameter, ...]
    """Of an effect."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedPages:
    """``explain``: schema ``scara-iso/explain/1``."""

    schema: Literal["scara-iso/explain/1"]
    """Name and number of this schema."""
    pages: tuple[Page, ...]
    """By kind."""


def pages(own: Sequence[OwnEffect] = ()) -> tuple[Page, ...]:
    """Return the pages: findings, characteristics, effects on readings, on reversals.

    The user's ``own`` effects are effects on readings. A characteristic and an effect may share a
    code: compliance is both.
    """
    modules = find_modules(checks, "scara_iso.checks")
    texts = {module.CODE: module.__doc__ or "" for module in modules}
    texts |= PAGES
    findings = [_finding(code, text) for code, text in sorted(texts.items())]
    figures = [
        _characteristic(module.CODE, module.CLAUSE, module.NEEDS, module.__doc__ or "")
        for module in find_modules(characteristics, "scara_iso.characteristics")
    ]
    figures.append(_beyond_dials())
    found = [
        _effect(module.EFFECT, module.__doc__ or "")
        for module in find_modules(effects, "scara_iso.effects")
    ]
    found += [_effect(effect, _own_text(effect)) for effect in own]
    return (*findings, *figures, *sorted(found, key=lambda page: page.kind))


def find_pages(code: str, own: Sequence[OwnEffect] = ()) -> tuple[Page, ...]:
    """Return the pages of a code, of words that stand on the screen, or of a parameter's name.

    Of ``step or linear drift`` those of both. ``-``, ``_`` and a blank are the same. Raises
    `UsageError` with the nearest codes.
    """
    if " or " in code:
        return tuple(page for name in code.split(" or ") for page in find_pages(name, own))
    every = (*pages(own), *_words())
    known = {_plain(name): of for name, of in SAME.items()}
    known |= {_plain(name): names[0] for names in WORDS for name in names}
    known |= {_plain(in_brief(page.code)): page.code for page in every}
    known |= {_plain(page.code): page.code for page in every}
    wanted = _plain(code)
    if found := tuple(page for page in every if page.code == known.get(wanted)):
        return found
    if found := tuple(page for page in every if wanted in (one.name for one in page.parameters)):
        return found
    if (bare := _AXIS.sub("", code).strip()) and bare != code:
        return find_pages(bare, own)
    near = _holding(wanted, every) or [known[name] for name in get_close_matches(wanted, known)]
    remedy = f"did you mean {' or '.join(near)}?" if near else "scara-iso explain lists all of them"
    raise UsageError(f"nothing on the screens is called {code[:80]!r}", remedy=remedy)


def _words() -> Iterator[Page]:
    for names, (title, text) in WORDS.items():
        yield Page(names[0], KIND, title, (text,), ())


def _holding(wanted: str, every: Iterable[Page]) -> list[str]:
    """Return the codes of the pages whose code holds the word, then of those whose title does."""
    by_code = [page.code for page in every if wanted and wanted in _plain(page.code)]
    by_title = [page.code for page in every if wanted and wanted in _plain(page.title)]
    return list(dict.fromkeys([*by_code, *by_title]))[:_MOST_NEAR]


def pages_report(found: Iterable[Page]) -> Report:
    """Return the report on the pages of one code."""
    return tuple(section for page in found for section in _sections(page))


def _sections(page: Page) -> Iterator[Section]:
    parts = (Text(f"{page.code}: {page.title}", "strong"), *map(Text, page.text))
    yield Section("", (*parts, Text(page.kind, "quiet")))
    if page.parameters:
        yield Section("parameters", tuple(_parameters(page)))


def list_report(found: Iterable[Page]) -> Report:
    """Return what can be explained, by what the reader wants to know."""
    codes: dict[str, list[str]] = {}
    for page in found:
        codes.setdefault(page.kind, []).append(page.code)
    sections = (
        Section(task, (Text(", ".join(filter(None, (names, *codes.get(kind, ()))))),))
        for task, (kind, names) in _TASKS.items()
    )
    return (*sections, Section("", (Text("scara-iso explain NAME says what it means", "quiet"),)))


def _parameters(page: Page) -> Iterator[Block]:
    yield Table(("name", "unit"), tuple((one.name, one.unit or "-") for one in page.parameters))
    for one in page.parameters:
        yield Text(f"{one.name}: {one.meaning}")


def _finding(code: str, doc: str) -> Page:
    title, *text = _paragraphs(doc)
    return Page(code, "finding", title, tuple(text), ())


def _characteristic(code: str, clause: str, needs: str, doc: str) -> Page:
    title, *text = _paragraphs(doc)
    where = f"ISO 9283 {clause}" if clause[:1].isdigit() else clause
    needed = f"Needs {_CODE.sub(_bare, needs)}."
    return Page(code, "characteristic", title, (*text, needed, f"Defined in {where}."), ())


def _beyond_dials() -> Page:
    text = [f"{one.clause} {one.name}: {one.why}." for one in BEYOND_DIALS]
    title = "Characteristics of ISO 9283 that dials cannot measure, by clause"
    return Page("beyond-dials", "characteristic", title, tuple(text), ())


def _effect(effect: Effect | GearEffect, doc: str) -> Page:
    title, *text = _paragraphs(doc)
    kind = "effect on readings" if isinstance(effect, Effect) else "effect on a reversal"
    parts = (*text, f"Cause: {effect.cause}.", f"To confirm: {effect.confirm_by}.")
    given = tuple(publish(ExplainedParameter, one) for one in effect.parameters)
    return Page(effect.name, kind, title, parts, given)


def _own_text(effect: OwnEffect) -> str:
    formula = effect.definition["formula"]
    return f"An effect of your own: {formula}\n\nEach axis has a size of its own."


def _paragraphs(doc: str) -> list[str]:
    """Return the paragraphs of a docstring, each on one line; code marks only at parameters."""
    found = [_CODE.sub(_bare, " ".join(part.split())) for part in cleandoc(doc).split("\n\n")]
    return [found[0].rstrip("."), *found[1:]]


def _bare(mark: re.Match[str]) -> str:
    """Return what is marked as code, and as `name=value` where it is a parameter."""
    return f"`{mark[1]}`" if _PARAMETER.fullmatch(mark[1]) else mark[1]


def _plain(code: str) -> str:
    return "-".join(code.lower().replace("_", " ").split())
