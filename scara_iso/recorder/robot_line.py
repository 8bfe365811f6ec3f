"""The robot says when: lines such as ``AT P3`` on a socket or a serial line of its own.

A line that names another pose than the one awaited is not taken, and neither is one that came
while a reading was being taken: the arm had left since. The robot is answered each time:
``OK 5`` when cycle 5 is on the disk, ``NO`` and why for what is refused.
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Callable
from contextlib import suppress

from scara_iso.base.errors import InstrumentError
from scara_iso.recorder.events import (
    Command,
    CycleDone,
    Noticed,
    Operator,
    Said,
    Take,
    Waiting,
)
from scara_iso.recorder.journal import Journal
from scara_iso.recorder.ports import DevicePort, SocketLine

_LINE = re.compile(rb"([^\r\n]*)[\r\n]+")
_AT = re.compile(r"AT\s+([A-Za-z][A-Za-z0-9_]{0,20})", re.IGNORECASE)
_LONGEST = 1000


class RobotSays:
    """An operator that the robot is, beside the one at the keyboard.

    ``pose`` is the pose of this recording; where it is None, the first one named is. Of a tour of
    poses it is the one that is waited for.
    ``in_order`` takes every line in its turn, as recorded and simulated gauges have it.
    """

    def __init__(
        self,
        port: DevicePort | SocketLine,
        operator: Operator,
        *,
        journal: Journal,
        tell: Callable[[Said], None],
        pose: str | None,
        in_order: bool,
    ) -> None:
        self._port = port
        self._operator = operator
        self._journal = journal
        self._tell = tell
        self._pose = pose
        self._in_order = in_order
        self._begun = b""
        self._waiting: deque[str] = deque()
        self._taking = False
        self._lost: InstrumentError | None = None

    def poll(self) -> Command | None:
        """Return the operator's command, or a `Take` for a line that says the pose awaited."""
        came = self._receive()
        if self._taking and not self._in_order:
            for line in came:
                self._refuse(line, "came while a reading was being taken")
            came = []
        self._taking = False
        self._waiting += came
        command = self._operator.poll()
        if command is not None and not isinstance(command, Take):
            return command
        while self._waiting:
            if self._is_awaited(self._waiting.popleft()):
                self._taking = True
                return Take()
        if self._lost is not None:
            raise self._lost
        return None

    def told(self, said: Said) -> None:
        """Tell the robot that a cycle is on the disk, and the listener everything."""
        self._tell(said)
        if isinstance(said, Waiting) and said.pose is not None:
            self._pose = said.pose
        if isinstance(said, CycleDone):
            self._answer(f"OK {said.cycle}")

    def _answer(self, text: str) -> None:
        with suppress(InstrumentError):  # a robot that left needs none; reading will say so
            self._port.write(f"{text}\r\n".encode("ascii", "replace"))

    def _receive(self) -> list[str]:
        try:
            data = b"" if self._lost else self._port.read()
        except InstrumentError as error:  # what was said before still counts
            self._lost = error
            return []
        if not data:
            return []
        self._journal.append("robot", port=self._port.address, hex=data.hex())
        text = self._begun + data
        lines = [found[1] for found in _LINE.finditer(text)]
        ended = max((found.end() for found in _LINE.finditer(text)), default=0)
        self._begun = text[ended:][-_LONGEST:]
        return [line.decode("ascii", "backslashreplace").strip() for line in lines if line.strip()]

    def _is_awaited(self, line: str) -> bool:
        found = _AT.fullmatch(line)
        if found is None:
            self._refuse(line, "no line such as AT P3")
            return False
        named = found[1].upper()
        self._pose = self._pose or named
        if named != self._pose.upper():
            self._refuse(line, f"{self._pose} is awaited")
            return False
        return True

    def _refuse(self, line: str, reason: str) -> None:
        shown = line[:60]
        self._journal.append("notice", axis="", message=f"robot: {shown!r} not taken: {reason}")
        self._journal.sync()
        self._tell(Noticed("", f"the robot says {shown!r}, not taken: {reason}"))
        self._answer(f"NO {reason}")
