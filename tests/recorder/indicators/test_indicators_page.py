"""docs/indicators.md names keys and patterns that work, and no dialect lacks its cable."""

import re
from pathlib import Path

from scara_iso.recorder.indicators import (
    Decoder,
    Reading,
    find_dialects,
    make_generic,
)

PAGE = (Path(__file__).parents[3] / "docs" / "indicators.md").read_text(encoding="utf-8")


def test_the_keys_in_the_commands_are_known() -> None:
    keys = re.findall(r'--gauge "?[A-Z]=([a-z0-9-]+)[?@]', PAGE)
    assert keys
    assert set(keys) <= {*find_dialects(), "keyboard"}


def test_every_dialect_of_ours_says_which_cable() -> None:
    assert [key for key, one in find_dialects().items() if not one.cable] == []


def test_the_pattern_on_the_page_reads_its_line() -> None:
    pattern = next(line.strip() for line in PAGE.splitlines() if line.startswith("    (?P<value>"))
    (event,) = Decoder(make_generic(pattern)).feed(b"+001.234 mm\r")
    assert isinstance(event, Reading)
