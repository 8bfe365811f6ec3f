"""Fuzz, throughput and memory of the decoders, over every dialect found.

    python benchmarks/decode.py [--streams 1000000] [--seed 0]

A stream is five frames of random values of one instrument, damaged once by one of `DAMAGES`. No
reading may come out that was not sent in a whole frame ("invented"), and every frame that the
damage did not touch must come out ("lost"), in the same order, however the stream is cut.

Without a checksum in the frame some damage cannot be told: a digit that turns into another digit; a
gap of exactly one frame's length, which joins two halves; junk that brings a line end and the right
first bytes with it. `DAMAGES` has none of these.
"""

from __future__ import annotations

import argparse
import random
import time
import tracemalloc
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from decimal import Decimal
from itertools import product

from scara_iso.recorder.indicators import Decoder, Dialect, Reading, find_dialects

FRAMES = 5
_LINE_ENDS = b"\r\n\x8a\x8d"
_NO_LINE_END = bytes(byte for byte in range(256) if byte not in _LINE_ENDS)
_FOREIGN = bytes(byte for byte in range(32) if byte not in _LINE_ENDS) + b"#$%&*!@\x7f"

Key = tuple[str, str | None, str | None]
Damaged = tuple[bytes, set[int]]
"""A damaged stream, and the numbers of the frames that it still holds untouched."""


@dataclass
class Tally:
    """What the fuzz of one dialect counted."""

    streams: int = 0
    untouched: int = 0
    accepted: int = 0
    invented: int = 0
    lost: int = 0
    wrong_parity: int = 0
    parity_streams: int = 0
    problems: list[str] = field(default_factory=list)


def make_pool(
    dialect: Dialect, rng: random.Random, *, unit: str | None, places: int, count: int = 200
) -> list[tuple[Key, bytes]]:
    """Return distinct readings with ``places`` decimals, and the frames that carry them."""
    largest = 10 ** min(dialect.digits, 3 + places) - 2
    count = min(count, largest)
    values = rng.sample(range(-largest, largest), count)
    texts = [f"{Decimal(value).scaleb(-places):f}" for value in values]
    frames = [dialect.compose(text, unit, dialect.channel) for text in texts]
    return [
        ((text, unit, dialect.channel), frame) for text, frame in zip(texts, frames, strict=True)
    ]


def make_pools(dialect: Dialect, rng: random.Random) -> list[list[tuple[Key, bytes]]]:
    """Return a pool for every unit and number of decimals, the usual ones first."""
    return [
        make_pool(dialect, rng, unit=unit, places=places)
        for unit, places in product(dialect.units, dialect.decimals)
    ]


def _touched(frames: list[bytes], start: int, end: int) -> set[int]:
    """Return the frames that own a byte from ``start`` up to ``end``, or lie just before it."""
    touched, at = set(), 0
    for number, frame in enumerate(frames):
        if at < end and start < at + len(frame):
            touched.add(number)
        at += len(frame)
    return touched


def _replace(frames: list[bytes], start: int, end: int, new: bytes) -> Damaged:
    """Put ``new`` in place of the bytes from ``start`` to ``end``."""
    data = b"".join(frames)
    # Bytes put between two frames stand in front of the second one.
    touched = _touched(frames, start, max(end, start + 1))
    if start < end < len(data):
        # Where the last byte of a line end is missing, the next frame may be glued to it.
        touched |= _touched(frames, end, end + 1)
    return data[:start] + new + data[end:], set(range(len(frames))) - touched


def lost(rng: random.Random, frames: list[bytes]) -> Damaged:
    """Lose fewer bytes than one frame has, anywhere, line ends included."""
    count = rng.randrange(1, min(map(len, frames)))
    start = rng.randrange(sum(map(len, frames)) - count)
    return _replace(frames, start, start + count, b"")


def truncated(rng: random.Random, frames: list[bytes]) -> Damaged:
    """End the stream within a frame."""
    data = b"".join(frames)
    end = rng.randrange(1, len(data))
    return data[:end], set(range(len(frames))) - _touched(frames, end, len(data))


def junk(rng: random.Random, frames: list[bytes]) -> Damaged:
    """Put 1 to 80 bytes without a line end anywhere."""
    start = rng.randrange(sum(map(len, frames)))
    return _replace(frames, start, start, bytes(rng.choices(_NO_LINE_END, k=rng.randint(1, 80))))


def lines(rng: random.Random, frames: list[bytes]) -> Damaged:
    """Put a line of junk, shorter or longer than the longest frame, between two frames."""
    count = rng.choice((1, 5, 40, 400))
    noise = bytes(rng.choices(_NO_LINE_END, k=count)) + rng.choice((b"\r", b"\n", b"\r\n"))
    at = rng.randrange(len(frames))
    return b"".join([*frames[:at], noise, *frames[at:]]), set(range(len(frames)))


def glued(rng: random.Random, frames: list[bytes]) -> Damaged:
    """Lose the line end between two frames."""
    at = rng.randrange(len(frames) - 1)
    whole = [*frames[:at], frames[at].rstrip(b"\r\n"), *frames[at + 1 :]]
    return b"".join(whole), set(range(len(frames))) - {at, at + 1}


def split(rng: random.Random, frames: list[bytes]) -> Damaged:
    """Put a line end within a frame."""
    at = rng.randrange(len(frames))
    inside = rng.randrange(1, len(frames[at].rstrip(b"\r\n")))
    cut = frames[at][:inside] + rng.choice((b"\r", b"\n", b"\r\n")) + frames[at][inside:]
    return b"".join([*frames[:at], cut, *frames[at + 1 :]]), set(range(len(frames))) - {at}


def repeated(rng: random.Random, frames: list[bytes]) -> Damaged:
    """Send one byte twice."""
    data = b"".join(frames)
    at = rng.randrange(len(data))
    if data[at] in b"\r\n":
        return data[:at] + data[at : at + 1] + data[at:], set(range(len(frames)))
    return _replace(frames, at, at, data[at : at + 1])


def bit_8(rng: random.Random, frames: list[bytes]) -> Damaged:
    """Set bit 8 on some bytes of a frame."""
    at = rng.randrange(len(frames))
    damaged = bytearray(frames[at])
    for place in rng.sample(range(len(damaged)), rng.randint(1, len(damaged))):
        damaged[place] |= 0x80
    return b"".join([*frames[:at], damaged, *frames[at + 1 :]]), set(range(len(frames))) - {at}


def foreign(rng: random.Random, frames: list[bytes]) -> Damaged:
    """Change one byte to one that no frame has in that place."""
    at = rng.randrange(len(frames))
    damaged = bytearray(frames[at])
    damaged[rng.randrange(len(frames[at].rstrip(b"\r\n")))] = rng.choice(_FOREIGN)
    return b"".join([*frames[:at], damaged, *frames[at + 1 :]]), set(range(len(frames))) - {at}


def even_parity(data: bytes) -> bytes:
    """Return ``data`` as a 7E2 line sends it and an 8N1 port receives it."""
    return bytes(byte | (byte.bit_count() % 2) << 7 for byte in data)


def parity(rng: random.Random, frames: list[bytes]) -> Damaged:  # noqa: ARG001 - like the others
    """Put even parity in bit 8 of the whole stream: a 7E2 line read as 8N1."""
    return even_parity(b"".join(frames)), set()


DAMAGES: tuple[Callable[[random.Random, list[bytes]], Damaged], ...] = (
    lost, truncated, junk, lines, glued, split, repeated, bit_8, foreign, parity,
)  # fmt: skip


def judge(sent: list[Key], untouched: set[int], readings: list[Reading], tally: Tally) -> str:
    """Count one stream, and say what is wrong with its readings, or nothing.

    A reading is one that was sent if number and channel are; a unit may be lost with the optional
    end of a frame (None: the session's own unit then holds), never be another one.
    """
    tally.accepted += len(readings)
    tally.untouched += len(untouched)
    at, found = 0, set()
    for reading in readings:
        while at < len(sent) and not _same(sent[at], reading):
            at += 1
        if at == len(sent):
            tally.invented += 1
            return f"invented {reading}"
        found.add(at)
        at += 1
    tally.lost += len(untouched - found)
    return f"lost {[sent[k] for k in untouched - found]}" if untouched - found else ""


def _same(sent: Key, reading: Reading) -> bool:
    text, unit, channel = sent
    same_channel = channel in (reading.channel, None)
    return reading.text == text and same_channel and reading.unit in (unit, None)


def fuzz(dialect: Dialect, streams: int, rng: random.Random) -> Tally:
    """Damage ``streams`` streams of ``dialect`` and count what its decoder makes of them."""
    tally, pools = Tally(), make_pools(dialect, rng)
    damages = [d for d in DAMAGES if not (dialect.bit_8_undefined and d in (bit_8, parity))]
    for number in range(streams):
        damage = damages[number % len(damages)]
        chosen = rng.sample(pools[number // len(damages) % len(pools)], FRAMES)
        data, untouched = damage(rng, [frame for _, frame in chosen])
        cut = rng.randrange(len(data) + 1)
        decoder = Decoder(dialect)
        events = [*decoder.feed(data[:cut]), *decoder.feed(data[cut:])]
        readings = [event for event in events if isinstance(event, Reading)]
        wrong = judge([key for key, _ in chosen], untouched, readings, tally)
        if events != Decoder(dialect).feed(data):
            wrong = f"cut at {cut} changes the events"
        if damage is parity:
            tally.parity_streams += 1
            tally.wrong_parity += len(readings)
        if wrong and len(tally.problems) < 10:
            tally.problems.append(f"{dialect.key} {damage.__name__}: {wrong} in {data!r}")
    tally.streams += streams
    return tally


def throughput(
    dialect: Dialect, rng: random.Random, *, frames: int = 50_000
) -> tuple[float, float]:
    """Return MB/s and readings/s of a whole stream fed in chunks of 64 KiB; the best of three."""
    pool = [frame for _, frame in make_pools(dialect, rng)[0]]
    data = b"".join(rng.choices(pool, k=frames))
    times = []
    for _ in range(3):
        decoder, count = Decoder(dialect), 0
        start = time.process_time()
        for at in range(0, len(data), 65536):
            count += len(decoder.feed(data[at : at + 65536]))
        times.append(time.process_time() - start)
        if count != frames:
            raise RuntimeError(f"{dialect.key}: {count} events from {frames} frames")
    return len(data) / min(times) / 1e6, frames / min(times)


def peak_memory(dialect: Dialect, chunks: Iterable[bytes]) -> int:
    """Return the peak of memory, in bytes, while a decoder is fed ``chunks``."""
    decoder = Decoder(dialect)
    tracemalloc.start()
    for chunk in chunks:
        decoder.feed(chunk)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak


def print_fuzz(dialects: list[Dialect], streams: int, rng: random.Random) -> int:
    """Print a row for each dialect; return how many streams went wrong (ten named each)."""
    share = -(-streams // len(dialects))
    head = "dialect", "streams", "untouched", "accepted", "lost", "invented", "parity"
    print(("{:22}" + "{:>11}" * 6).format(*head))
    total: Counter[str] = Counter()
    for dialect in dialects:
        t = fuzz(dialect, share, rng)
        row = (t.streams, t.untouched, t.accepted, t.lost, t.invented)
        print(("{:22}" + "{:>11,}" * 6).format(dialect.key, *row, t.wrong_parity))
        print(*t.problems, sep="\n", end="\n" * bool(t.problems))
        total.update(
            streams=t.streams, lost=t.lost, invented=t.invented, parity=t.wrong_parity,
            parity_streams=t.parity_streams, problems=len(t.problems),
        )  # fmt: skip
    print(", ".join(f"{name} {count:,}" for name, count in total.items()), end="\n\n")
    return total["problems"]


def print_memory(dialect: Dialect, rng: random.Random) -> None:
    """Print the peaks over eight hours at ten readings a second, and over endless junk."""
    frames = [frame for _, frame in make_pools(dialect, rng)[0]]
    for count in (2_880, 28_800, 288_000):
        peak = peak_memory(dialect, (rng.choice(frames) for _ in range(count)))
        print(f"peak memory over {count:,} readings: {peak / 1024:.1f} KiB")
    peak = peak_memory(dialect, (b"x" * 4096 for _ in range(16_000)))
    print(f"peak memory over 65 MB without a line end, in 4 KiB chunks: {peak / 1024:.1f} KiB")


def main() -> int:
    """Run the three benchmarks; 1 if a stream went wrong."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("--streams", type=int, default=1_000_000, help="damaged streams in all")
    options.add_argument("--seed", type=int, default=0)
    given = options.parse_args()
    rng = random.Random(given.seed)  # noqa: S311 - a repeatable fuzz, no secret
    dialects = list(find_dialects().values())
    problems = print_fuzz(dialects, given.streams, rng)
    print(f"{'dialect':22}{'MB/s':>11}{'readings/s':>14}")
    for dialect in dialects:
        rate, readings = throughput(dialect, rng)
        print(f"{dialect.key:22}{rate:>11.1f}{readings:>14,.0f}")
    print()
    print_memory(dialects[0], rng)
    return 1 if problems else 0


if __name__ == "__main__":
    raise SystemExit(main())
