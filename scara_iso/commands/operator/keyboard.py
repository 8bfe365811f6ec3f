"""Whoever says when: keys of a terminal (a foot switch types Enter), or lines of standard input."""

from __future__ import annotations

import contextlib
import queue
import re
import sys
import threading
from collections.abc import Callable, Iterator
from typing import TextIO

from scara_iso import recorder
from scara_iso.commands.operator.recording import is_typed

KEYS = "v void  n note  p pause  q quit"
_QUESTIONS = {"v": "Void {}, because: ", "n": "Note: "}
_LONGEST = 1000
_AHEAD = 1000
_ENTER = "\r\n "
_NUMBER = "0123456789+-.,"
_LONGEST_TYPED = 200
_ESCAPE = "\x1b"
_FUNCTION_KEY = re.compile(r"\x1b[\[O]+[0-9;]*.")
"""What a terminal sends at once for F1 or an arrow: no command."""
_RUB_OUT = "\x08\x7f"


class Typist:
    """Commands from lines: an empty one takes a reading; ``v REASON``, ``n TEXT``, ``p``, ``q``.

    Where it ``takes_readings``, lines that are no command are readings, taken in their order.
    """

    def __init__(self, *, takes_readings: bool = False) -> None:
        self.takes_readings = takes_readings
        self._next: str | None = None

    def poll(self) -> recorder.Command | None:
        """Return the command of the next line, if one has come and no reading waits before it."""
        line = self._look()
        command = None if line is None else parse_line(line)
        if command is not None or not self.takes_readings:
            self._next = None
        return None if self.takes_readings and isinstance(command, recorder.Take) else command

    def typed(self) -> bytes:
        """Return the next line, if it is a reading."""
        line = self._look()
        if line is None or parse_line(line) is not None:
            return b""
        self._next = None
        return line.strip("\r\n").encode("ascii", "replace") + b"\r"

    def _look(self) -> str | None:
        if self._next is None:
            self._next = self._line()
        return self._next

    def _line(self) -> str | None:
        """Return the line that comes next, None as long as none has ended."""
        raise NotImplementedError


class Keys(Typist):
    """Turns keys into lines; a reason or a note is typed at the `prompt` until Enter.

    Where it ``takes_readings``, the keys of a number make a line, with Enter or Tab at its end.
    """

    def __init__(self, read: Callable[[], str], *, takes_readings: bool = False) -> None:
        super().__init__(takes_readings=takes_readings)
        self._read = read
        self._letter = self._text = ""
        self._pending: list[str] = []

    def prompt(self, last: str = "the last reading") -> str:
        """Return the question being answered or the reading, with what was typed so far, or none.

        ``last`` is what would be struck: ``cycle 7, X 0.808``.
        """
        if self._letter:
            return _QUESTIONS[self._letter].format(last) + (self._text or "(Esc leaves it)")
        return f"Reading: {self._text}" if self._text else ""

    def _line(self) -> str | None:
        self._pending += _FUNCTION_KEY.sub("", self._read())
        while self._pending:
            key = self._pending.pop(0)
            begins = self.takes_readings and key in _NUMBER
            writes = self._letter or self._text or begins
            line = self._write(key) if writes else self._press(key.lower())
            if line is not None:
                return line
        return None

    def _press(self, key: str) -> str | None:
        if key in _QUESTIONS:
            self._letter = key
            return None
        return "" if key in _ENTER else key if key in "pq" else None

    def _write(self, key: str) -> str | None:
        """Take a key of an answer or a reading; return its line where that ends."""
        ends = key in ("\r\n" if self._letter else "\r\n\t")
        if ends and (self._letter != "v" or self._text.strip()):  # a reason is waited for
            letter, text = self._letter, self._text.strip()
            self._letter = self._text = ""
            return f"{letter} {text}".strip() if text else None
        if key == _ESCAPE:
            self._letter = self._text = ""
        elif key in _RUB_OUT:
            self._text = self._text[:-1]
        elif key.isprintable() and len(self._text) < _LONGEST_TYPED:
            self._text += key
        return None


class Lines(Typist):
    """The lines of a stream, whose end ends the session."""

    def __init__(self, stream: TextIO, *, takes_readings: bool = False) -> None:
        super().__init__(takes_readings=takes_readings)
        self._lines: queue.Queue[str] = queue.Queue(_AHEAD)
        self._follower = threading.Thread(target=self._follow, args=(stream,), daemon=True)
        self._follower.start()

    def _line(self) -> str | None:
        with contextlib.suppress(queue.Empty):
            return self._lines.get_nowait()
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


def parse_line(line: str) -> recorder.Command | None:
    """Return the command that a line spells; None where it spells none."""
    word, _, rest = line.strip()[:_LONGEST].partition(" ")
    match word.lower(), rest.strip():
        case "", _:
            return recorder.Take()
        case "v", reason if reason:
            return recorder.Void(reason)
        case "n", text if text:
            return recorder.Note(text)
        case "p", "":
            return recorder.Pause()
        case "q", "":
            return recorder.Quit()
    return None


def choose_operator(
    job: recorder.Job, stack: contextlib.ExitStack, *, shown: bool
) -> recorder.Operator:
    """Return who says when: keys of a terminal, lines of standard input, or nobody."""
    typed = is_typed(job.gauges)
    by_hand = typed or job.plan.trigger == "enter"
    if sys.stdin.isatty() and (shown or by_hand):
        return Keys(stack.enter_context(open_keyboard()), takes_readings=typed)
    return Lines(sys.stdin, takes_readings=typed) if by_hand else recorder.Unattended()


@contextlib.contextmanager
def open_keyboard() -> Iterator[Callable[[], str]]:
    """Yield a function that returns the keys pressed since it was last called, at once."""
    if sys.platform == "win32":
        import msvcrt

        def typed() -> str:
            key = msvcrt.getwch() if msvcrt.kbhit() else ""
            is_first = key in ("\x00", "\xe0") and msvcrt.kbhit()  # of a function key's two
            return "" if is_first and msvcrt.getwch() else key

        yield typed
        return
    import os
    import select
    import termios
    import tty

    file = sys.stdin.fileno()
    before = termios.tcgetattr(file)

    def read() -> str:
        ready, _, _ = select.select([file], [], [], 0)
        try:
            return os.read(file, 64).decode("utf-8", "ignore") if ready else ""
        except OSError:  # the terminal was closed
            raise KeyboardInterrupt from None

    try:
        tty.setcbreak(file)
        yield read
    finally:
        with contextlib.suppress(termios.error):
            termios.tcsetattr(file, termios.TCSADRAIN, before)
