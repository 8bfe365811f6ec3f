"""Recorded streams, made from the sources' own examples, give the events written beside them."""

import json
import re
from pathlib import Path

import pytest

from scara_iso.recorder.indicators import (
    Decoder,
    DeviceNotice,
    Event,
    Garbage,
    InstrumentFault,
    Reading,
    find_dialects,
)

STREAMS = Path(__file__).parents[2] / "fixtures" / "streams"
DIALECTS = find_dialects()
RECORDED = sorted(STREAMS.glob("*/*.bin"))

every_stream = pytest.mark.parametrize(
    "path", RECORDED, ids=lambda path: f"{path.parent.name}/{path.stem}"
)


def decode(path: Path, *chunks: bytes) -> list[Event]:
    decoder = Decoder(DIALECTS[path.parent.name])
    return [event for chunk in chunks for event in decoder.feed(chunk)]


def as_json(event: Event) -> dict[str, object]:
    match event:
        case Reading(text, unit, channel, mode):
            return {"reading": text, "unit": unit, "channel": channel, "mode": mode}
        case InstrumentFault(code=code, channel=channel):
            return {"fault": code, "channel": channel}
        case DeviceNotice(unit=unit):
            return {"notice": unit}
        case Garbage():
            return {"garbage": True}


@every_stream
def test_the_events_are_those_of_the_source(path: Path) -> None:
    beside = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
    assert beside["source"]
    assert [as_json(event) for event in decode(path, path.read_bytes())] == beside["events"]


@every_stream
def test_a_cut_at_any_byte_changes_nothing(path: Path) -> None:
    data = path.read_bytes()
    whole = decode(path, data)
    for at in range(len(data)):
        assert decode(path, data[:at], data[at:]) == whole
    assert decode(path, *(data[at : at + 1] for at in range(len(data)))) == whole


@every_stream
@pytest.mark.parametrize("before", [b"\0", b"\n", b"\r\n\0\0", b"\0" * 1000])
def test_nuls_and_line_ends_before_a_frame_are_skipped(path: Path, before: bytes) -> None:
    data = path.read_bytes()
    assert decode(path, before + data) == decode(path, data)


@every_stream
def test_junk_longer_than_a_frame_costs_its_own_line_and_no_other(path: Path) -> None:
    data, longest = path.read_bytes(), DIALECTS[path.parent.name].longest_frame
    junk = b"+" * (longest + 1)
    spoilt, *others = decode(path, junk + data)
    after = data[min(data.index(end) for end in (b"\r", b"\n", b"\x8d") if end in data) + 1 :]
    assert isinstance(spoilt, Garbage)
    assert len(spoilt.raw) == longest
    assert others == decode(path, after)
    assert decode(path, junk + b"\r" + data)[1:] == decode(path, data)


@every_stream
def test_glued_lines_give_no_reading(path: Path) -> None:
    lines = [line for line in path.read_bytes().replace(b"\n", b"\r").split(b"\r") if line]
    for at in range(len(lines) - 1):
        glued = decode(path, lines[at] + lines[at + 1] + b"\r")
        assert not [event for event in glued if isinstance(event, Reading)]


@every_stream
def test_nothing_is_parsed_from_the_half_frame_at_the_end(path: Path) -> None:
    line = re.split(rb"[\r\n\0]", path.read_bytes().rstrip(b"\r\n"))[-1]
    decoder = Decoder(DIALECTS[path.parent.name])
    if not line.isascii():
        pytest.skip("a wrong parity leaves no half frame: its line ends are ends all the same")
    assert decoder.feed(line) == []
    assert decoder.drop_partial() == Garbage(f"{len(line)} bytes of a line that never ended", line)
    assert decoder.drop_partial() is None
    assert decoder.feed(b"\r\n") == []


def test_every_dialect_has_a_stream() -> None:
    assert {recorded.parent.name for recorded in RECORDED} >= set(DIALECTS)
