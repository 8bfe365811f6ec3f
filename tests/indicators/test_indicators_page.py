"""docs/indicators.md says what the code does: keys, settings, requests, what is not verified."""

import re
from pathlib import Path

import pytest

from scara_iso.acquisition.indicators import (
    Decoder,
    Dialect,
    Reading,
    find_dialects,
    make_generic,
)

PAGE = (Path(__file__).parents[2] / "docs" / "indicators.md").read_text(encoding="utf-8")
ROWS = {
    cells[0].strip("`"): cells[1:]
    for line in PAGE.splitlines()
    if (cells := [cell.strip() for cell in line.strip("|").split("|")])[0].startswith("`")
    and line.startswith("|")
}


def asked_by(dialect: Dialect) -> str:
    if dialect.request_line is not None:
        return f"{dialect.request_line.line.upper()} pulse"
    if dialect.request is None:
        return "sends by itself"
    return f"`{dialect.request.decode('ascii').encode('unicode_escape').decode('ascii')}`"


def test_the_table_has_every_dialect_and_no_other() -> None:
    assert set(ROWS) == set(find_dialects())


@pytest.mark.parametrize("dialect", find_dialects().values(), ids=lambda dialect: dialect.key)
def test_a_row_says_what_the_code_does(dialect: Dialect) -> None:
    instruments, cable, typed, *row = ROWS[dialect.key]
    assert instruments == dialect.instruments
    assert cable
    told = dialect.sends_unit or dialect.unit_request
    assert typed == f"`X={dialect.key}{'' if told else '?unit=mm'}@PORT`"
    stated = "yes" if dialect.sends_unit else "no"
    assert row == [str(dialect.line), asked_by(dialect), stated, dialect.confidence]


@pytest.mark.parametrize("dialect", find_dialects().values(), ids=lambda dialect: dialect.key)
def test_the_page_names_what_is_not_verified(dialect: Dialect) -> None:
    (note,) = [line for line in PAGE.splitlines() if line.startswith(f"* `{dialect.key}` - ")]
    assert dialect.source in note
    assert all(unverified in note for unverified in dialect.unverified)


def test_the_keys_in_the_commands_are_known() -> None:
    keys = re.findall(r'--gauge "?[A-Z]=([a-z0-9-]+)[?@]', PAGE)
    assert keys
    assert set(keys) <= set(find_dialects())


def test_the_pattern_on_the_page_reads_its_line() -> None:
    pattern = next(line.strip() for line in PAGE.splitlines() if line.startswith("    (?P<value>"))
    (event,) = Decoder(make_generic(pattern)).feed(b"+001.234 mm\r")
    assert isinstance(event, Reading)
