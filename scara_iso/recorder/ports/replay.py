"""A recorded stream as a port: ``replay:FILE``, a file of bytes or a raw file of ``record``.

A raw file gives the readings of its table again, at their recorded times or one for each request:
not what was struck out, refused, or sent before the first cycle. A file of bytes has no times: its
lines come one second apart, or one for each request.
"""

from __future__ import annotations

import math
import re
from collections import deque
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.files import open_file, read_file
from scara_iso.rawfile import History, Timeline, Tour, is_raw_file, read_history, read_records
from scara_iso.recorder.indicators import Decoder, Dialect, LinePulse, Reading
from scara_iso.recorder.ports.port import PULSE, Clock, Port, split_options

OPTIONS = {
    "pace": "1 for the recorded timing, 0 (default) for as fast as possible",
    "gauge": "axis to replay out of a raw file with several",
}
LINE_SPACING_S = 1.0
"""Time between two lines of a file of bytes, which records none [s]."""
ANSWER_S = 0.02
_LARGEST = 64 * 2**20
_TAPE = "name the .raw.jsonl of a recording, or a file of what an indicator sent"
_LINE = re.compile(rb"[^\r\n]*(?:\r\n|\r|\n)|[^\r\n]+$")


class ReplayPort(Port):
    """Sends what a file recorded; ``asked`` says that the session will send requests.

    Raises `NoInputError` where the file is not there, `DataError` where it holds nothing, and
    `UsageError` for another driver than the recording's.
    """

    def __init__(
        self, address: str, dialect: Dialect, *, axis: str, clock: Clock, asked: bool
    ) -> None:
        name, options = split_options(address.removeprefix("replay:"), OPTIONS)
        self.address = self.identity = address
        recorded = self._load(path := Path(name), dialect, options.get("gauge", axis))
        if not recorded:
            raise DataError("holds no readings", where=str(path), remedy=_TAPE)
        self._clock = clock
        self._request = (dialect.request or PULSE) if asked and dialect.asks else None
        begun = clock.now()
        frames = [(begun + time, data) for time, data in recorded]
        self._answers = deque(frames if self._request else ())
        self._due_frames = deque(() if self._request else sorted(frames, key=lambda one: one[0]))
        clock.watch(self._due)

    @property
    def ended(self) -> bool:
        """Whether everything recorded was sent."""
        return not self._due_frames and not self._answers

    def read(self) -> bytes:
        """Return the frame whose time has come."""
        return b"" if self._due() > self._clock.now() else self._due_frames.popleft()[1]

    def write(self, data: bytes) -> None:
        """Send the next frame in answer to a request."""
        if self._answers and data == self._request:
            self._due_frames.append((self._clock.now() + ANSWER_S, self._answers.popleft()[1]))

    def pulse(self, pulse: LinePulse) -> None:  # noqa: ARG002 - any pulse is a request
        """Take the pulse as the request it is."""
        self.write(PULSE)

    def _due(self) -> float:
        return self._due_frames[0][0] if self._due_frames else math.inf

    def _load(self, path: Path, dialect: Dialect, axis: str) -> list[tuple[float, bytes]]:
        """Return the frames that a file holds at their times [s], in the order of the visits."""
        if not _is_tape(path):
            lines = _LINE.findall(read_file(path, _LARGEST))
            return [(LINE_SPACING_S * k, line) for k, line in enumerate(lines, 1)]
        try:
            return self._of_tape(path, dialect, axis)
        except (KeyError, TypeError, ValueError, AttributeError, ArithmeticError) as error:
            raise DataError(
                f"is not a raw file of record ({error})", where=str(path), remedy=_TAPE
            ) from error

    def _of_tape(self, path: Path, dialect: Dialect, axis: str) -> list[tuple[float, bytes]]:
        """Return the frames that became readings of the table.

        A reading is stored behind the bytes that brought it: its frame is the last with its text.
        """
        confirmed = stated = True
        found: dict[int, tuple[float, bytes]] = {}
        tour = Tour()
        frames: dict[str, bytes] = {}
        for time, record in _of_axis(path, axis, dialect.key):
            match record:
                case {"event": "session", "gauges": gauges}:
                    decoder, frames = Decoder(dialect), {}
                    tour = tour if tour.poses else Tour(tuple(record.get("poses", ())))
                    self.unit = gauges[axis]["unit"] or self.unit
                    self.simulated |= gauges[axis]["simulated"]
                    stated = gauges[axis].get("unit_confirmed") is not False
                case {"event": "unit"}:
                    stated = True
                case {"event": "in", "hex": str(text)}:
                    heard = decoder.feed(bytes.fromhex(text))
                    frames |= {e.text: e.raw for e in heard if isinstance(e, Reading)}
                case {"event": "stored", "cycle": int(cycle), "text": str(text), "at": float(at)}:
                    if text not in frames:
                        raise DataError(
                            f"the bytes of cycle {cycle}, axis {axis}, are missing",
                            where=str(path),
                            remedy="`rebuild=True` makes the table of what was stored",
                        )
                    stored = time - float(record["t"]) + at, frames[text] + dialect.terminator
                    found[tour.visit(cycle, record.get("pose"))] = stored
                    self.unit = str(record["unit"])
                    confirmed &= stated
                    frames.clear()
                case {"event": "void", "cycle": int(cycle), "axes": [*axes]} if axis in axes:
                    found.pop(tour.visit(cycle, record.get("pose")), None)
        self.unit_confirmed = confirmed and stated and self.unit is not None
        return [found[visit] for visit in sorted(found)]


class ReplayLine(Port):
    """The robot of a raw file: it says the visits of the table again, each with its numbers.

    Its lines come so much before their readings as an answer takes. Raises as `ReplayPort`.
    """

    def __init__(self, address: str, clock: Clock) -> None:
        self.address = self.identity = address
        name, _ = split_options(address.removeprefix("replay:"), OPTIONS)
        history = read_history(Path(name))
        history.check()
        self._clock = clock
        self._lines = deque(_visits_of(history))
        clock.watch(self._due)

    @property
    def ended(self) -> bool:
        """Whether every visit was said."""
        return not self._lines

    def read(self) -> bytes:
        """Return the next line whose time has come."""
        due = self._lines and self._lines[0][0] <= self._clock.now()
        return self._lines.popleft()[1] if due else b""

    def _due(self) -> float:
        """Return when the next line comes; one that waits for its turn does not stop the clock."""
        ahead = self._lines and self._lines[0][0] > self._clock.now()
        return self._lines[0][0] if ahead else math.inf


def _visits_of(history: History) -> Iterator[tuple[float, bytes]]:
    for visit, time in sorted(history.times.items()):
        if history.present(visit):
            cycle, pose = history.tour.place(visit)
            words = ["AT", pose or history.header["metadata"].get("pose", "P1"), f"cycle={cycle}"]
            for name, column in history.covariates.items():
                words += [f"{name}={column[visit]:.12g}"] if visit in column else []
            yield time - ANSWER_S, f"{' '.join(words)}\n".encode("ascii", "replace")


def replayed_poses(address: str) -> tuple[str, ...]:
    """Return the poses of a raw file that is to be replayed; none where it names none."""
    if not address.startswith("replay:"):
        return ()
    path = Path(split_options(address.removeprefix("replay:"), OPTIONS)[0])
    if not _is_tape(path):
        return ()
    records = (record for _, record in read_records(path) if record)
    first = next((one for one in records if one["event"] == "session"), {})
    return tuple(map(str, first.get("poses", ())))


def _is_tape(path: Path) -> bool:
    with open_file(path) as file:
        return is_raw_file(file.read(16))


def _of_axis(path: Path, axis: str, dialect: str) -> Iterator[tuple[float, dict[str, Any]]]:
    """Yield the records of one axis with their time, sessions one behind the other."""
    timeline = Timeline()
    for record in filter(None, (record for _, record in read_records(path))):
        if record["event"] == "session":
            axes = record.get("gauges", {})
            if axis not in axes:
                raise UsageError(
                    f"no gauge {axis} was recorded, only {', '.join(axes)}",
                    where=str(path),
                    remedy=f"replay:{path}?gauge={next(iter(axes), 'X')}",
                )
            if (recorded := axes[axis]["dialect"]) != dialect:
                raise UsageError(
                    f"{axis} was recorded by {recorded}, not {dialect}",
                    where=str(path),
                    remedy=f"give {axis}={recorded}@replay:{path}",
                )
        time = timeline.at(record)
        if record["event"] in ("session", "void") or record.get("axis") == axis:
            yield time, record
