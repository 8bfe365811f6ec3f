"""Whoever says when: keys of a terminal (a foot switch types Enter), or lines of standard input."""

from __future__ import annotations

import contextlib
import queue
import sys
import threading
from collections.abc import Callable, Iterator
from typing import TextIO

from scara_iso.recorder import (
    Command,
    Enter,
    Job,
    Note,
    Operator,
    Pause,
    Quit,
    Take,
    Unattended,
    Void,
    port_kind,
)

KEYS = "v void  n note  p pause  q quit"
_ASKING: dict[str, tuple[str, Callable[[str], Command]]] = {
    "v": ("Void the last reading, because: ", Void),
    "n": ("Note: ", Note),
}
_LONGEST = 1000
_AHEAD = 1000
_ENTER = "\r\n "
_NUMBER = "0123456789+-.,"
_LINE_ENDS = "\r\n\t"
_LONGEST_TYPED = 64
_ESCAPE = "\x1b"
_RUB_OUT = "\x08\x7f"


class Keys:
    """Turns keys into commands; a reason or a note is typed in `prompt` until Enter."""

    def __init__(self, read: Callable[[], str]) -> None:
        self._read = read
        self._question: tuple[str, Callable[[str], Command]] | None = None
        self._typed = ""
        self._pending: list[str] = []

    @property
    def prompt(self) -> str:
        """The question being answered with what was typed so far, or nothing."""
        return self._question[0] + self._typed if self._question else ""

    def poll(self) -> Command | None:
        """Return the command that the keys pressed so far make."""
        self._pending += self._read()
        while self._pending and not self._holds():
            key = self._pending.pop(0)
            command = self._answer(key) if self._question else self._press(key)
            if command is not None:
                return command
        return None

    def _holds(self) -> bool:
        """Say whether the keys that follow wait for the session to take what was typed."""
        return False

    def _press(self, key: str) -> Command | None:
        match key.lower():
            case "q":
                return Quit()
            case "p":
                return Pause()
            case "v" | "n" as letter:
                self._question, self._typed = _ASKING[letter], ""
            case _ if key in _ENTER:
                return Take()
        return None

    def _answer(self, key: str) -> Command | None:
        question = self._question
        if key in "\r\n" and question is not None:
            self._question = None
            return question[1](self._typed.strip()) if self._typed.strip() else None
        if key == _ESCAPE:
            self._question = None
        elif key in _RUB_OUT:
            self._typed = self._typed[:-1]
        elif key.isprintable() and len(self._typed) < 200:
            self._typed += key
        return None


class TypedKeys(Keys):
    """Keys of which those of a number make a line: a reading, with Enter or Tab at its end."""

    def __init__(self, read: Callable[[], str]) -> None:
        super().__init__(read)
        self._line = ""
        self._whole = b""

    @property
    def prompt(self) -> str:
        """As of `Keys`, or the line being typed."""
        return super().prompt or (f"Reading: {self._line}" if self._line else "")

    def typed(self) -> bytes:
        """Return the line that was ended since the last call, if any."""
        line, self._whole = self._whole, b""
        return line

    def _holds(self) -> bool:
        return bool(self._whole)

    def _press(self, key: str) -> Command | None:
        if not self._line and key not in _NUMBER:
            return None if key in _LINE_ENDS + " " else super()._press(key)
        if key in _LINE_ENDS:
            self._whole, self._line = _as_bytes(self._line), ""
        elif key == _ESCAPE:
            self._line = ""
        elif key in _RUB_OUT:
            self._line = self._line[:-1]
        elif len(self._line) < _LONGEST_TYPED:
            self._line += key
        return None


class Lines:
    """Commands from lines: an empty one takes a reading; ``v REASON``, ``n TEXT``, ``p``, ``q``.

    The end of the input ends the session.
    """

    def __init__(self, stream: TextIO) -> None:
        self._lines: queue.Queue[str] = queue.Queue(_AHEAD)
        self._follower = threading.Thread(target=self._follow, args=(stream,), daemon=True)
        self._follower.start()

    def poll(self) -> Command | None:
        """Return the command of the next line, if one has come."""
        try:
            return parse_line(self._lines.get_nowait())
        except queue.Empty:
            return None

    def _follow(self, stream: TextIO) -> None:
        """Hand on the lines, the beginnings of long ones; the queue's bound holds the sender."""
        begins = True
        with contextlib.suppress(ValueError):  # closed by whoever opened it: the end, too
            while piece := stream.readline(_LONGEST):
                if begins:
                    self._lines.put(piece)
                begins = piece.endswith("\n")
        self._lines.put("q")


class TypedLines(Lines):
    """Lines of which those that are no command are readings; they are taken in their order."""

    def __init__(self, stream: TextIO) -> None:
        super().__init__(stream)
        self._next: str | None = None

    def poll(self) -> Command | None:
        """Return the command of the next line, if it is one and no reading waits before it."""
        line = self._look()
        command = None if line is None else parse_line(line)
        if command is not None:
            self._next = None
        return None if isinstance(command, Take) else command

    def typed(self) -> bytes:
        """Return the next line, if it is no command."""
        line = self._look()
        if line is None or parse_line(line) is not None:
            return b""
        self._next = None
        return _as_bytes(line)

    def _look(self) -> str | None:
        if self._next is None:
            with contextlib.suppress(queue.Empty):
                self._next = self._lines.get_nowait()
        return self._next


def _as_bytes(line: str) -> bytes:
    return line.strip("\r\n").encode("ascii", "replace") + b"\r"


def parse_line(line: str) -> Command | None:
    """Return the command that a line spells; None where it spells none."""
    word, _, rest = line.strip()[:_LONGEST].partition(" ")
    match word.lower(), rest.strip():
        case "", _:
            return Take()
        case "v", reason if reason:
            return Void(reason)
        case "n", text if text:
            return Note(text)
        case "p", "":
            return Pause()
        case "q", "":
            return Quit()
    return None


def choose_operator(job: Job, stack: contextlib.ExitStack, *, shown: bool) -> Operator:
    """Return who says when: keys of a terminal, lines of standard input, or nobody."""
    typed = any(port_kind(spec.address) == "keyboard" for spec in job.gauges)
    by_hand = typed or job.plan.trigger == Enter()
    if sys.stdin.isatty() and (shown or by_hand):
        return (TypedKeys if typed else Keys)(stack.enter_context(open_keyboard()))
    if not by_hand:
        return Unattended()
    return (TypedLines if typed else Lines)(sys.stdin)


@contextlib.contextmanager
def open_keyboard() -> Iterator[Callable[[], str]]:
    """Yield a function that returns the keys pressed since it was last called, at once."""
    if sys.platform == "win32":
        import msvcrt

        yield lambda: msvcrt.getwch() if msvcrt.kbhit() else ""
        return
    import os
    import select
    import termios
    import tty

    file = sys.stdin.fileno()
    before = termios.tcgetattr(file)

    def read() -> str:
        ready, _, _ = select.select([file], [], [], 0)
        return os.read(file, 64).decode("utf-8", "ignore") if ready else ""

    try:
        tty.setcbreak(file)
        yield read
    finally:
        termios.tcsetattr(file, termios.TCSADRAIN, before)
