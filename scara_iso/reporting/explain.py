"""The page of every finding, characteristic, effect and term: what it means and what to do."""

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
from scara_iso.effects import Effect, GearEffect, OwnEffect, Parameter
from scara_iso.iso9283 import BEYOND_DIALS, characteristics, checks, in_brief
from scara_iso.reporting.shared.blocks import Report, Section, Text, texts

KIND = "word of the screens"
SAME: Mapping[str, str] = {
    name: code for code, names in texts()["other_names"].items() for name in names
}
"""Other names of a page, by the code of the page."""
WORDS: Mapping[tuple[str, ...], tuple[str, str]] = {
    tuple(term["names"]): (term["title"], " ".join(term["text"].split()))
    for term in texts()["terms"]
}
"""By the names of each: its title and its text."""
_CODE = re.compile(r"`+([^`]+)`+")
_MOST_NEAR = 3
_NEAR = 0.75
"""Alike enough to be meant: ``stpe`` is 0.75 like ``step``."""
_AXIS = re.compile(r" (X|Y|Z|XY|XYZ|theta)$|^(X|Y|Z|XY|XYZ|theta)[ _]")
"""Behind the name of a figure, or before it: ``RP XY``, ``XY_eq23``."""
_PERCENTAGE = re.compile(r"[0-9]{1,3} ?%?")
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
    docs = {one.CODE: one.__doc__ or "" for one in find_modules(checks, "scara_iso.checks")}
    findings = [_page(code, "finding", doc) for code, doc in sorted({**docs, **PAGES}.items())]
    figures = [
        _page(
            one.CODE,
            "characteristic",
            one.__doc__ or "",
            f"Needs {_CODE.sub(_bare, one.NEEDS)}.",
            f"Defined in {f'ISO 9283 {one.CLAUSE}' if one.CLAUSE[:1].isdigit() else one.CLAUSE}.",
        )
        for one in find_modules(characteristics, "scara_iso.characteristics")
    ]
    beyond = [f"{one.clause} {one.name}: {one.why}." for one in BEYOND_DIALS]
    title = "Characteristics of ISO 9283 that dials cannot measure, by clause"
    figures.append(_page("beyond-dials", "characteristic", title, *beyond))
    modules = find_modules(effects, "scara_iso.effects")
    found = [_effect(module.EFFECT, module.__doc__ or "") for module in modules]
    text = "An effect of your own: {}\n\nEach axis has a size of its own."
    found += [_effect(effect, text.format(effect.definition["formula"])) for effect in own]
    return (*findings, *figures, *sorted(found, key=lambda page: page.kind))


def _page(code: str, kind: str, doc: str, *text: str, of: Sequence[Parameter] = ()) -> Page:
    """Return the page of a docstring, code marks only at parameters, and of further texts."""
    title, *parts = (_CODE.sub(_bare, " ".join(p.split())) for p in cleandoc(doc).split("\n\n"))
    given = tuple(publish(ExplainedParameter, one) for one in of)
    return Page(code, kind, title.rstrip("."), (*parts, *text), given)


def _effect(effect: Effect | GearEffect, doc: str) -> Page:
    kind = "effect on readings" if isinstance(effect, Effect) else "effect on a reversal"
    why = f"Cause: {effect.cause}.", f"To confirm: {effect.confirm_by}."
    return _page(effect.name, kind, doc, *why, of=effect.parameters)


def _bare(mark: re.Match[str]) -> str:
    """Return what is marked as code, and as `name=value` where it is a parameter."""
    return f"`{mark[1]}`" if _PARAMETER.fullmatch(mark[1]) else mark[1]


def find_pages(code: str, own: Sequence[OwnEffect] = ()) -> tuple[Page, ...]:
    """Return the pages of a code, of words that stand on the screen, or of a parameter's name.

    Of ``step or linear drift`` those of both. ``-``, ``_`` and a blank are the same. Raises
    `UsageError` with the nearest codes.
    """
    terms = (Page(names[0], KIND, title, (text,), ()) for names, (title, text) in WORDS.items())
    every = (*pages(own), *terms)
    known = {_plain(name): of for name, of in SAME.items()}
    known |= {_plain(name): names[0] for names in WORDS for name in names}
    briefs = ((in_brief(page.code), page.code) for page in every)
    known |= {
        _plain(part): code for text, code in briefs for part in (text, *re.split("[,:] ", text))
    }
    known |= {_plain(page.code): page.code for page in every}
    wanted = "probability" if _PERCENTAGE.fullmatch(code) else _plain(code)
    if found := tuple(page for page in every if page.code == known.get(wanted)):
        return found
    if found := tuple(page for page in every if wanted in (one.name for one in page.parameters)):
        return found
    if len(names := re.split(" or |, ", code)) > 1:
        each = (page for name in names for page in find_pages(name, own))
        return tuple({page.code: page for page in each}.values())
    if (bare := _AXIS.sub("", code).strip()) and bare != code:
        return find_pages(bare, own)
    close = (known[name] for name in get_close_matches(wanted, known, cutoff=_NEAR))
    near = _holding(wanted, every) or list(dict.fromkeys(close))
    remedy = f"did you mean {' or '.join(near)}?" if near else "scara-iso explain lists all of them"
    raise UsageError(f"there is no explanation of {code[:80]!r}", remedy=remedy)


def _holding(wanted: str, every: Iterable[Page]) -> list[str]:
    by_code = [page.code for page in every if wanted and wanted in _plain(page.code)]
    by_title = [page.code for page in every if wanted and wanted in _plain(page.title)]
    return list(dict.fromkeys([*by_code, *by_title]))[:_MOST_NEAR]


def pages_report(found: Iterable[Page]) -> Report:
    """Return the report on the pages of one code."""
    return tuple(section for page in found for section in _sections(page))


def _sections(page: Page) -> Iterator[Section]:
    parts = (Text(f"{page.code}: {page.title}", "strong"), *map(Text, page.text))
    yield Section("", (*parts, Text(page.kind, "quiet")))
    meanings = (
        Text(f"{one.name}{one.unit and f' [{one.unit}]'}: {one.meaning}") for one in page.parameters
    )
    yield Section("parameters" if page.parameters else "", tuple(meanings))


def list_report(found: Iterable[Page]) -> Report:
    """Return what can be explained, by what the reader wants to know."""
    codes: dict[str, list[str]] = {}
    for page in found:
        codes.setdefault(page.kind, []).append(page.code)
    sections = (
        Section(
            one["task"],
            (Text(", ".join([*one.get("terms", []), *codes.get(one.get("kind", ""), [])])),),
        )
        for one in texts()["tasks"]
    )
    return (*sections, Section("", (Text("scara-iso explain TERM says what it means", "quiet"),)))


def _plain(code: str) -> str:
    return "-".join(code.lower().replace("_", " ").split())
