"""Languages of a report: a file of this folder adds one, label by label.

Labels are headings, columns, names of fields, verdicts and the sentences of page 1, with {#} where
one word or number stands, and {} for more. Numbers, names and findings stay as they are, and what
has no label in a file stays English.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import replace
from importlib.resources import files
from itertools import zip_longest

from scara_iso.base.errors import UsageError
from scara_iso.reporting.shared.blocks import (
    Block,
    Facts,
    Figure,
    Report,
    Section,
    Signature,
    Table,
    Text,
)
from scara_iso.reporting.shared.digits import Result
from scara_iso.reporting.shared.limits import VERDICTS

ENGLISH = "en"
_ENDING = ".toml"
_BETWEEN = re.compile(r"(: |; |, | \[| at pose | at (?=P[0-9]|[+-][xyz]))")
_SENTENCES = re.compile(r"(?<=[.]) (?=[A-Z]|[0-9]+ [a-z])")
_LISTED = re.compile(r"(, | and )")
_HOLES = re.compile(r"\\?\{\\?#?\\?\}")
_WORD = re.compile(r"\b(?!theta\b|deg\b)[a-z]{3,}\b")
"""Of a language: no name and no unit."""
_SIZE = re.compile(r"[0-9.,]+(?: \S+)?")
_VERDICT, _IN_WORDS = "verdict", "conditions"
_NOT_STATED = "Not stated: "
_OF_VERDICTS = {tone for _, tone in VERDICTS.values()}


def known_languages() -> tuple[str, ...]:
    """Return the languages of a report, English first."""
    names = (file.name for file in files(__name__).iterdir() if file.name.endswith(_ENDING))
    return (ENGLISH, *sorted(name.removesuffix(_ENDING) for name in names))


def labels_of(language: str) -> Mapping[str, str]:
    """Return the labels of a language by the English ones; `UsageError` names the others."""
    if language not in known_languages():
        raise UsageError(
            f"`language={language}`: a report is not written in it",
            remedy=f"use one of {', '.join(known_languages())}",
        )
    if language == ENGLISH:
        return {}
    text = files(__name__).joinpath(f"{language}{_ENDING}").read_text("utf-8")
    return tomllib.loads(text)


def translated(report: Report, labels: Mapping[str, str]) -> Iterator[Section]:
    """Yield the sections with their labels in another language; the first is page 1."""
    for k, section in enumerate(report):
        blocks = tuple(_block(block, labels, on_page_1=k == 0) for block in section.blocks)
        yield replace(section, heading=in_parts(section.heading, labels), blocks=blocks)


def in_parts(text: str, labels: Mapping[str, str]) -> str:
    """Return a text whose labels, whole or between signs, are in another language.

    A text that begins with no label stays as it is: a sentence of two languages helps nobody.
    """
    if not labels or text in labels:
        return labels.get(text, text)
    if filled := _filled(text, labels) or _listed(text, labels):
        return filled
    sentences = _SENTENCES.split(text)
    if len(sentences) > 1:
        return " ".join(in_parts(one, labels) for one in sentences)
    first, *others = _BETWEEN.split(text)
    begun = _filled(first, labels) or _begun(first, labels)
    return text if begun == first else begun + "".join(_part(one, labels) for one in others)


def _listed(text: str, labels: Mapping[str, str]) -> str:
    """Return a list of labels, ``30 cycles, 8 blocks and 121 readings``; else nothing."""
    parts = _LISTED.split(text)
    filled = [_filled(one, labels) for one in parts[::2]]
    if len(parts) == 1 or not all(filled):
        return ""
    between = [one.replace("and", labels["and"]) for one in parts[1::2]]
    return "".join(map("".join, zip_longest(filled, between, fillvalue="")))


def _filled(text: str, labels: Mapping[str, str]) -> str:
    """Return the longest label with holes that fits a text, filled in parts too; else nothing."""
    if text in labels:
        return labels[text]
    for label in sorted(filter(_HOLES.search, labels), key=len, reverse=True):
        if found := re.fullmatch(_HOLES.sub(_filling, re.escape(label)), text):
            parts = [in_parts(one, labels) for one in found.groups()]
            return re.sub(_HOLES, "{}", labels[label]).format(*parts)
    return ""


def _filling(hole: re.Match[str]) -> str:
    """Return what may stand in a hole: one word in ``{#}``, else all within a sentence."""
    return r"(\S+)" if "#" in hole[0] else f"((?:(?!{_SENTENCES.pattern}).)+?)"


def _part(part: str, labels: Mapping[str, str]) -> str:
    """Return a label, alone or with a size behind it: ``limit 0.02 mm``."""
    if filled := _filled(part, labels):
        return filled
    if part.endswith(".") and (whole := part.removesuffix(".")) in labels:
        return f"{labels[whole]}."
    label, size = _first_label(part, labels)
    return labels[label] + size if label and _SIZE.fullmatch(size.strip()) else part


def _begun(part: str, labels: Mapping[str, str]) -> str:
    """Return a label, also behind the name of an axis or before names and numbers of its own."""
    words = part.split(" ")
    if (rest := " ".join(words[1:])) in labels and not _WORD.search(words[0]):
        return f"{words[0]} {labels[rest]}"
    label, rest = _first_label(part, labels)
    return part if _WORD.search(rest) else labels.get(label, "") + rest


def _first_label(part: str, labels: Mapping[str, str]) -> tuple[str, str]:
    """Return the longest label that a text begins with, and what stands behind it."""
    words = part.split(" ")
    every = (" ".join(words[:k]) for k in range(len(words), 0, -1))
    label = next((begin for begin in every if begin in labels), "")
    return label, part.removeprefix(label)


def _block(block: Block, labels: Mapping[str, str], *, on_page_1: bool) -> Block:
    match block:
        case Text(text=text, tone=tone):
            known = on_page_1 or tone in _OF_VERDICTS or text.startswith(_NOT_STATED)
            phrase = in_parts(text, labels) if known else labels.get(text, text)
            return replace(block, text=phrase)
        case Table():
            return _table(block, labels)
        case Facts(rows=rows, heading=heading):
            named = tuple(
                (in_parts(name, labels), in_parts(text, labels) if name == _IN_WORDS else text)
                for name, text in rows
            )
            return replace(block, heading=in_parts(heading, labels), rows=named)
        case Figure(title=title):
            return replace(block, title=in_parts(title, labels))
        case Signature(lines=lines):
            parted = (line.partition(": ") for line in lines)
            return replace(
                block, lines=tuple(f"{in_parts(a, labels)}{b}{name}" for a, b, name in parted)
            )
    return block


def _table(table: Table, labels: Mapping[str, str]) -> Table:
    rows = tuple(
        tuple(
            replace(cell, verdict=in_parts(cell.verdict, labels))
            if isinstance(cell, Result)
            else in_parts(cell, labels)
            if isinstance(cell, str) and (head == _VERDICT or cell == "limit")
            else cell
            for head, cell in zip(table.header, row, strict=True)
        )
        for row in table.rows
    )
    header = tuple(in_parts(head, labels) for head in table.header)
    return replace(table, header=header, rows=rows, note=in_parts(table.note, labels))
