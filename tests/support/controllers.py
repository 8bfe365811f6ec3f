"""Controllers that run a robot's program against the recorder, and a dial that the arm moves.

Each interpreter knows the verbs that the programs use and no other. Time on the controller does
not pass; the line is a real socket.
"""

from __future__ import annotations

import re
import socket
import threading
from contextlib import suppress

from robots import OPEN


class StoppedError(Exception):
    """The program has stopped the robot, or the controller has stopped the program."""


class Dial:
    """An indicator on a socket that shows where the arm is: 1.000 at P1, 2.000 at P2, ..

    A thousandth more at each arrival, so that every reading says which one it is of.
    """

    def __init__(self):
        self._server = socket.create_server(("127.0.0.1", 0))
        self.gauge = f"X=opto-rs232@socket://127.0.0.1:{self._server.getsockname()[1]}"
        self.at = ""
        self.arrivals = {}
        OPEN.append(self)
        threading.Thread(target=self._serve, daemon=True).start()

    def move(self, point):
        self.at = point
        if not point.startswith("appro"):
            self.arrivals[point] = self.arrivals.get(point, 0) + 1

    def shown(self):
        if not re.fullmatch(r"P[0-9]", self.at):
            return 999.0
        return int(self.at[1]) + self.arrivals[self.at] / 1000

    def _serve(self):
        with suppress(OSError):
            while True:
                peer, _ = self._server.accept()
                with peer, suppress(OSError):
                    while request := peer.recv(64):
                        peer.sendall(self.answer(request.strip().upper()))

    def answer(self, request):
        return b"MM\r" if request.startswith(b"UNI") else b"%+08.3f\r" % self.shown()

    def close(self):
        self._server.close()


class Controller:
    """What both languages have: the arm, the line, and mishaps on the way.

    ``mishaps`` maps the number of a line that is sent to one of ``drop`` (the connection ends
    before the answer) and ``lose`` (it ends when the answer has come, and is not read).
    """

    def __init__(self, dial, mishaps=()):
        self.dial = dial
        self.mishaps = dict(mishaps)
        self.said = []
        self.shown = []
        self.socket = None

    def move(self, point):
        if not isinstance(point, str):
            raise StoppedError(f"no taught point: {point}")
        self.dial.move(point)

    def open(self, host, port, wait):
        self.shut()
        self.socket = socket.create_connection((host, int(port)), timeout=wait)

    def shut(self):
        if self.socket is not None:
            self.socket.close()
            self.socket = None

    def send(self, text):
        if self.socket is None:
            raise ConnectionError
        self.socket.sendall(text.encode("ascii"))
        if not text.strip():
            return
        self.said.append(text.strip())
        match self.mishaps.get(len(self.said)):
            case "drop":
                self.shut()
            case "lose":
                self.socket.settimeout(20)
                while b"\n" not in self.socket.recv(64):
                    continue
                self.shut()

    def byte(self, wait):
        """Return one byte; `TimeoutError`, or `ConnectionError` where nobody is there any more."""
        if self.socket is None:
            raise ConnectionError
        self.socket.settimeout(wait)
        found = self.socket.recv(1)
        if not found:
            raise ConnectionError
        return found.decode("ascii")


class URScript(Controller):
    """Runs a script: blocks end with ``end``, and each statement is read as that of Python."""

    taught = "{}_q"

    def run(self, text, points):
        code = "\n".join(self._line(line) for line in text.splitlines())
        names = {self.taught.format(point): point for point in points}
        exec(compile(code, "script", "exec"), self._verbs() | names)  # noqa: S102 - of a test

    def _line(self, line):
        words = line.partition("#")[0] if '"' not in line else line
        if words.strip() == "end":
            return ""
        words = re.sub(r"^(\s*)(local|global) ", r"\1", words)
        return re.sub(r"^(\s*)halt$", r"\1halt()", words)

    def _verbs(self):
        return {
            "__builtins__": {},
            "socket_open": self._open,
            "socket_close": lambda _name: self.shut(),
            "socket_send_line": self._send,
            "socket_read_line": self._read,
            "movej": lambda point, *, a, v: self._move(point, a, v),
            "stopj": lambda _a: None,
            "sleep": lambda _s: None,
            "popup": lambda text, **_how: self.shown.append(text),
            "halt": self._halt,
            "str_cat": lambda one, other: one + other,
            "str_sub": lambda text, at, n=-1: text[at:] if n < 0 else text[at : at + n],
            "to_str": str,
            "to_num": float,
            "get_joint_temp": lambda joint: 30.5 + joint,
        }

    def _move(self, point, acceleration, speed):
        assert acceleration > 0
        assert speed > 0
        self.move(point)

    def _halt(self):
        raise StoppedError(self.shown[-1])

    def _open(self, host, port, _name):
        try:
            self.open(host, port, 2)
        except OSError:
            return False
        return True

    def _send(self, text, _name):
        try:
            self.send(f"{text}\n")
        except OSError:
            return False
        return True

    def _read(self, _name, wait):
        found = ""
        try:
            while not found.endswith("\n"):
                found += self.byte(wait)
        except OSError:
            return ""
        return found.strip()


_TIMEOUT, _CLOSED = 1, 2
_MEANT = (
    (r"<>", "!="),
    (r"(?<![<>!:=\w])=(?!=)", "=="),
    (r"\bAND\b", "and"),
    (r"\bOR\b", "or"),
    (r"\bNOT\b", "not"),
    (r"\bMOD\b", "%"),
)


class RapidError(Exception):
    """An error that a routine's ERROR clause may handle; others stop the program."""


class Rapid(Controller):
    """Runs a module: each statement of a routine with an ERROR clause goes on behind TRYNEXT."""

    def run(self, text, points):
        lines = [line.strip() for line in text.splitlines()]
        lines = [line for line in lines if line and not line.startswith("!")]
        names = (
            self._verbs()
            | {point: point for point in points}
            | {"ERR_SOCK_TIMEOUT": _TIMEOUT, "ERR_SOCK_CLOSED": _CLOSED}
        )
        names |= {"vmax": "vmax", "fine": "fine", "test_tool": "test_tool", "line_socket": self}
        names |= {"TRUE": True, "FALSE": False}
        assert re.fullmatch(r"MODULE \w+", lines[0])
        assert lines[-1] == "ENDMODULE"
        exec(compile("\n".join(self._module(lines[1:-1])), "module", "exec"), names)  # noqa: S102
        names["main"]()

    def _module(self, lines):
        at = 0
        while at < len(lines):
            kind = lines[at].partition(" ")[0]
            if kind not in ("PROC", "FUNC"):
                yield self._statement(lines[at])
                at += 1
                continue
            end = lines.index(f"END{kind}", at)
            yield from self._routine(lines[at], lines[at + 1 : end])
            at = end + 1

    def _routine(self, head, body):
        name, given = re.fullmatch(r"(?:PROC|FUNC \w+) (\w+)\((.*)\)", head).groups()
        named = [one.split()[-1] for one in given.split(",") if one.strip()]
        yield f"def {name}({', '.join(named)}):"
        handler = body[body.index("ERROR") + 1 :] if "ERROR" in body else None
        body = body[: body.index("ERROR")] if handler else body
        yield from (f"  {line}" for line in self._block(body, handler))

    def _block(self, lines, handler):
        depth = 0
        for line in lines:
            word = line.partition(" ")[0]
            if word in ("ENDIF", "ENDWHILE"):
                depth -= 1
            elif line.startswith(("IF ", "WHILE ", "ELSE")):
                depth -= word == "ELSE"
                yield "  " * depth + self._condition(line)
                depth += 1
            else:
                yield from ("  " * depth + one for one in self._guarded(line, handler))

    def _guarded(self, line, handler):
        if handler is None or line.startswith(("VAR ", "RETURN")):
            yield self._statement(line)
            return
        yield "try:"
        yield f"  {self._statement(line)}"
        yield "except RapidError as error:"
        yield "  ERRNO = error.args[0]"
        yield from (f"  {one}" for one in self._block(handler, None))

    def _condition(self, line):
        found = re.fullmatch(r"(IF|WHILE) (.*) (THEN|DO)|ELSE", line)
        return "else:" if line == "ELSE" else f"{found[1].lower()} {self._value(found[2])}:"

    def _statement(self, line):
        assert line.endswith(";"), line
        line = line[:-1]
        if found := re.fullmatch(r"(?:CONST|VAR) \w+ (\w+)(?: := (.*))?", line):
            return f"{found[1]} = {self._value(found[2] or 'None')}" if found[2] else "pass"
        if found := re.fullmatch(r"SocketReceive line_socket \\Str:=(\w+)(.*)", line):
            return f"{found[1]} = SocketReceive({self._named(found[2])})"
        if found := re.fullmatch(r"(\w+) := (.*)", line):
            return f"{found[1]} = {self._value(found[2])}"
        if found := re.fullmatch(r"RETURN (.*)", line):
            return f"return {self._value(found[1])}"
        if line == "TRYNEXT":
            return "pass"
        word, _, given = line.partition(" ")
        return f"{word}({self._named(given)})"

    def _named(self, given):
        """Return arguments; ``\\Time:=2`` is named, ``\\InPos`` a switch."""
        given = re.sub(r" ?\\InPos,?", "", given)
        given = re.sub(r" \\(\w+):=", r", \1=", f" {given}".rstrip())
        return self._value(given.strip().lstrip(","))

    def _value(self, text):
        """Return an expression in Python; strings stay as they are but for RAPID's own escapes."""
        if found := re.fullmatch(r"StrToVal\((.*), (\w+)\)", text.removeprefix("NOT ")):
            read = f"StrToVal({self._value(found[1])})"
            return f"{'not ' * text.startswith('NOT ')}(({found[2]} := {read}) is not None)"
        parts = re.split(r'("[^"]*")', text)
        for k in range(0, len(parts), 2):
            for said, meant in _MEANT:
                parts[k] = re.sub(said, meant, parts[k])
        return "".join(parts).replace("\\0A", "\\n").replace("\\0D", "\\r")

    def _verbs(self):
        return {
            "__builtins__": {},
            "RapidError": RapidError,
            "SocketCreate": lambda _socket: None,
            "SocketClose": lambda _socket: self.shut(),
            "SocketConnect": self._connect,
            "SocketSend": self._send,
            "SocketReceive": self._receive,
            "MoveJ": self._move,
            "WaitTime": lambda _s: None,
            "VelSet": lambda share, _most: None if 0 < share <= 100 else self._stop("VelSet"),
            "MaxRobSpeed": lambda: 5000,
            "TPWrite": self._show,
            "Stop": lambda: None,
            "EXIT": lambda: self._stop(self.shown[-1]),
            "NumToStr": lambda number, decimals: f"{number:.{decimals}f}",
            "StrLen": len,
            "StrPart": lambda text, at, n: text[at - 1 : at - 1 + n],
            "StrToVal": lambda text: float(text) if re.fullmatch(r"[0-9.+-]+", text) else None,
        }

    def _show(self, text):
        assert len(text) <= 80, "a string of RAPID holds 80 characters"
        self.shown.append(text)

    def _stop(self, why):
        raise StoppedError(why)

    def _move(self, point, speed, zone, tool):
        assert (speed, zone, tool) == ("vmax", "fine", "test_tool")
        self.move(point)

    def _connect(self, _socket, host, port, Time):
        try:
            self.open(host, port, Time)
        except TimeoutError:
            raise RapidError(_TIMEOUT) from None
        except OSError:
            raise RapidError(_CLOSED) from None

    def _send(self, _socket, Str):
        assert len(Str) <= 80, "a string of RAPID holds 80 characters"
        try:
            self.send(Str)
        except OSError:
            raise RapidError(_CLOSED) from None

    def _receive(self, ReadNoOfBytes, Time):
        assert ReadNoOfBytes == 1
        try:
            return self.byte(Time)
        except TimeoutError:
            raise RapidError(_TIMEOUT) from None
        except OSError:
            raise RapidError(_CLOSED) from None
