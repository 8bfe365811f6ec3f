"""The fuzz of benchmarks/decode.py, short: what is damaged in a way that can be told is never read.

Which damage can be told and which cannot is said there, and in each damage's docstring.
"""

import importlib.util
import random
import re
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import pytest

from scara_iso.recorder.indicators import Dialect, Reading, find_dialect, find_dialects


def load_benchmark() -> ModuleType:
    path = Path(__file__).parents[3] / "benchmarks" / "decode.py"
    spec = importlib.util.spec_from_file_location("decode_benchmark", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


decode = load_benchmark()


def seeded(seed: int) -> random.Random:
    return random.Random(seed)  # noqa: S311 - repeatable, no secret


@pytest.mark.parametrize("dialect", find_dialects().values(), ids=lambda dialect: dialect.key)
def test_no_reading_is_invented_and_none_lost(dialect: Dialect) -> None:
    tally = decode.fuzz(dialect, 500, seeded(9283))
    assert tally.problems == []
    assert (tally.invented, tally.lost, tally.wrong_parity) == (0, 0, 0)
    assert tally.accepted >= tally.untouched > 500


def sloppy(line: bytes) -> tuple[Reading, ...]:
    found = re.search(rb"([+-]?\d+\.\d+)", line)
    return (Reading(found[1].decode().lstrip("+0"), None, None, None, line),) if found else ()


def test_the_fuzz_finds_a_parser_that_searches_for_a_number() -> None:
    tally = decode.fuzz(replace(find_dialect("stream-4800"), parse=sloppy), 500, seeded(1))
    assert tally.invented > 0
    assert tally.problems


def test_the_fuzz_finds_a_parser_that_loses_readings() -> None:
    opto = find_dialect("opto-rs232")
    deaf = replace(opto, parse=lambda line: opto.parse(line) if b"7" not in line else ())
    pool = decode.make_pools(opto, seeded(1))[0]
    frames = [frame for _, frame in pool]
    assert any(b"7" in frame for frame in frames)
    tally = decode.Tally()
    key, frame = next((key, frame) for key, frame in pool if b"7" in frame)
    events = deaf.parse(frame.rstrip(b"\r"))
    assert decode.judge([key], {0}, list(events), tally).startswith("lost")


@pytest.mark.parametrize("key", ["opto-rs232", "keyence-dlrs1a", "starrett-spc"])
def test_memory_is_bounded_however_long_the_stream(key: str) -> None:
    dialect = find_dialect(key)
    frames = [frame for _, frame in decode.make_pools(dialect, seeded(1))[0]]
    assert decode.peak_memory(dialect, frames * 50) < 16_384
    assert decode.peak_memory(dialect, (b"x" * 1000 for _ in range(2_000))) < 16_384
