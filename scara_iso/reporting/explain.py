"""The page of every finding, characteristic and effect: what it means and what to do."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from inspect import cleandoc
from itertools import groupby
from typing import Annotated, Literal

from scara_iso import effects
from scara_iso.comparison import PAGES
from scara_iso.effects import Effect, GearEffect, OwnEffect
from scara_iso.errors import UsageError
from scara_iso.iso9283 import BEYOND_DIALS, characteristics, checks, in_brief
from scara_iso.plugins import find_modules
from scara_iso.published import publish
from scara_iso.reporting.blocks import Block, Report, Section, Table, Text
from scara_iso.reporting.glossary import KIND, SAME, WORDS

_CODE = re.compile(r"`+([^`]+)`+")
_MOST_NEAR = 3
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

    ``-``, ``_`` and a blank are the same. Raises `UsageError` with the nearest codes.
    """
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
    near = _holding(wanted, every) or [known[name] for name in get_close_matches(wanted, known)]
    remedy = f"did you mean {' or '.join(near)}?" if near else "scara-iso explain lists all codes"
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
    said = (Text(f"{page.code}: {page.title}", "strong"), *map(Text, page.text))
    yield Section("", (*said, Text(page.kind, "quiet")))
    if page.parameters:
        yield Section("parameters", tuple(_parameters(page)))


def list_report(found: Iterable[Page]) -> Report:
    """Return all codes with their titles, by kind."""
    return (
        *(
            Section(_heading(kind), tuple(Text(f"{page.code}: {page.title}") for page in same))
            for kind, same in groupby(found, key=lambda page: page.kind)
        ),
        Section("words of the screens", (Text(", ".join(names[0] for names in WORDS)),)),
    )


def _heading(kind: str) -> str:
    noun, _, rest = kind.partition(" ")
    return f"{noun}s {rest}".strip()


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
    title = "What of ISO 9283 no dial measures, by clause"
    return Page("beyond-dials", "characteristic", title, tuple(text), ())


def _effect(effect: Effect | GearEffect, doc: str) -> Page:
    title, *text = _paragraphs(doc)
    kind = "effect on readings" if isinstance(effect, Effect) else "effect on a reversal"
    said = (*text, f"Cause: {effect.cause}.", f"To confirm: {effect.confirm_by}.")
    given = tuple(publish(ExplainedParameter, one) for one in effect.parameters)
    return Page(effect.name, kind, title, said, given)


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
