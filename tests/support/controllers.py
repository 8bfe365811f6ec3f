"""Controllers that run a robot's program against the recorder, and a dial that the arm moves.

Each interpreter knows the verbs that the programs use and no other. Time on the controller does
not pass; the line is a real socket.
"""

from __future__ import annotations

import re
import select
import socket
import threading
import time
from contextlib import suppress
from types import SimpleNamespace

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

    def waiting(self):
        """Return what has come and is not read; None where nobody is connected any more."""
        if self.socket is None:
            return None
        if not select.select([self.socket], (), (), 0)[0]:
            return b""
        with suppress(OSError):
            return self.socket.recv(200, socket.MSG_PEEK) or None
        return None

    def line(self, wait):
        """Return a line without its end; raises as `byte`."""
        found = ""
        while not found.endswith("\n"):
            found += self.byte(wait)
        return found.strip()

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
        try:
            return self.line(wait)
        except OSError:
            return ""


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


class _EndError(Exception):
    """A function of SPEL+ is over."""


class Spel(Controller):
    """Runs the functions of a project line by line: SPEL+ has labels to go to."""

    def run(self, text, points):
        self._points, self._timer, self._functions = points, 0.0, {}
        lines = [line.strip() for line in text.splitlines()]
        lines = [line for line in lines if line and not line.startswith("'")]
        while lines:
            end = lines.index("Fend")
            head = re.fullmatch(r"Function (\w+)(?:\((.*)\))?(?: As \w+)?", lines[0])
            given = [one.split()[0] for one in (head[2] or "").split(",") if one]
            self._functions[head[1]] = ([_spelt(one) for one in given], lines[1:end])
            lines = lines[end + 1 :]
        self._call("main")
        raise StoppedError(self.shown[-1])

    def _call(self, name, *given):
        names, body = self._functions[name]
        scope = dict(zip(names, given, strict=True)) | {name: 0}
        at, self._handler = 0, None
        with suppress(_EndError):
            while at < len(body):
                try:
                    at = self._step(body, at, body[at], scope)
                except OSError:
                    if self._handler is None:
                        raise StoppedError("an error that nothing handles") from None
                    at = body.index(f"{self._handler}:")
        return scope[name]

    def _step(self, body, at, line, scope):  # noqa: C901, PLR0911 - a statement a case
        """Do a statement; return which one is next."""
        match line.split(maxsplit=2):
            case ["Integer" | "String" as kind, *names]:
                unset = 0 if kind == "Integer" else ""
                scope |= {_spelt(one.strip()): unset for one in " ".join(names).split(",")}
            case ["OnErr", "GoTo", label]:
                self._handler = None if label == "0" else label
            case ["GoTo" | "EResume", label]:
                return body.index(f"{label}:")
            case ["Exit", "Function"]:
                raise _EndError
            case ["Exit", "Do"]:
                return _behind(body, at, 1, "Do", "Loop")
            case ["Do", "While", condition] if not self._value(condition, scope):
                return _behind(body, at + 1, 1, "Do", "Loop")
            case ["Loop"]:
                return _before(body, at)
            case ["If", *_]:
                condition, then = re.fullmatch(r"If (.*?) Then(?: (.*))?", line).groups()
                holds = self._value(condition, scope)
                if then is None:
                    return at + 1 if holds else _behind(body, at + 1, 1, "If", "EndIf", "Else")
                return self._step(body, at, then, scope) if holds else at + 1
            case ["Else"]:
                return _behind(body, at + 1, 1, "If", "EndIf")
            case _ if not re.fullmatch(r"\w+:|Do|EndIf|Do While .*", line):
                self._do(line, scope)
        return at + 1

    def _do(self, line, scope):  # noqa: C901 - likewise
        verb, _, rest = line.partition(" ")
        if found := re.fullmatch(r"([\w$]+) = (.*)", line):
            scope[_spelt(found[1])] = self._value(found[2], scope)
        elif verb == "Call":
            name, _, given = rest.partition("(")
            self._value(f"{name}({given or ')'}", scope)
        elif verb == "Print" and rest.startswith("#"):
            self.send(self._value(rest.partition(", ")[2], scope) + "\r\n")
        elif verb == "Print":
            self.shown.append(self._value(f"Shown({rest})", scope))
        elif verb == "Line":
            scope[_spelt(rest.rpartition(" ")[2])] = self.line(1)
        elif verb == "Go":
            assert rest in self._points
            self.move(rest)
        elif verb == "SetNet":
            host, port = re.fullmatch(r'#201, "(.*)", (\d+), CRLF, NONE, 0', rest).groups()
            self._where = (host, int(port))
        elif verb == "OpenNet":
            with suppress(OSError):
                self.open(*self._where, 2)
        elif verb == "Quit":
            raise StoppedError(self.shown[-1].removeprefix("scara-iso: stopped. "))
        else:
            self._other(verb, rest)

    def _other(self, verb, rest):
        match verb, rest:
            case "CloseNet", "#201":
                self.shut()
            case "TmReset", "0":
                self._timer = time.monotonic()
            case "Wait", "0.05":
                time.sleep(0.005)
            case "Speed", percent:
                assert 0 < int(percent) <= 100
            case _:
                assert verb in ("Motor", "Power", "Wait", "WaitNet", "Pause"), (verb, rest)

    def _value(self, text, scope):
        parts = re.split(r'("[^"]*")', text)
        for k in range(0, len(parts), 2):
            for found, python in (("<>", "!="), (r"(?<![<>!])=", "=="), (r"\bMod\b", "%")):
                parts[k] = re.sub(found, python, parts[k])
            parts[k] = parts[k].replace("$", "_text")
        names = {
            name: lambda *given, name=name: self._call(name, *given)
            for name in self._functions
            if name not in scope or f"{name}(" in text
        }
        names |= {"__builtins__": {}}
        return eval("".join(parts), scope | self._verbs() | names)  # noqa: S307 - of a test

    def _verbs(self):
        return {
            "ChkNet": lambda _port: -1 if self.waiting() is None else len(self.waiting() or b""),
            "Tmr": lambda _number: time.monotonic() - self._timer,
            "TW": self.socket is None,
            "Shown": lambda *texts: "".join(texts),
            "Left_text": lambda text, n: text[:n],
            "Mid_text": lambda text, at: text[at - 1 :],
            "LTrim_text": str.lstrip,
            "Str_text": lambda number: f" {number}",
            "Val": int,
        }


def _spelt(name):
    return name.replace("$", "_text")


def _behind(body, at, depth, begin, end, also=None):
    """Return the line behind the end of the block around ``at``, or behind its ``also``."""
    while depth:
        line = body[at]
        opens = line.split()[0] == begin and not re.search(r" Then .", line)
        depth += opens - (line == end or (line == also and depth == 1))
        at += 1
    return at


def _before(body, at):
    """Return the ``Do`` of the ``Loop`` at ``at``."""
    depth = 1
    while depth:
        at -= 1
        depth += (body[at] == "Loop") - (body[at].split()[0] == "Do")
    return at


class Chars(list):
    """A text of KRL: characters counted from 1, zeros behind its end."""

    def __init__(self, text):
        super().__init__([0] * text if isinstance(text, int) else map(ord, text))

    def __getitem__(self, at):
        return list.__getitem__(self, at - 1) if 0 < at <= len(self) else 0

    def __setitem__(self, at, code):
        assert 0 < at <= len(self)
        list.__setitem__(self, at - 1, code)

    def __str__(self):
        return "".join(map(chr, self)).partition("\0")[0]

    def fill(self, text):
        for at, char in enumerate(text, start=1):
            self[at] = ord(char)


_KRL = (
    (r"<>", "!="), (r"\bNOT\b", "not"), (r"\bTRUE\b", "True"), (r"\bFALSE\b", "False"),
    (r"(\w+)\[\]", r"\1"), (r"#(\w+)", r"0"), (r"\$FLAG\[11\]", "connected()"),
    (r"\$TIMER\[1\]", "timer()"), (r"/", "//"),
)  # fmt: skip


class Krl(Controller):
    """Runs a module: its blocks are those of Python."""

    def run(self, text, points):
        self._points, self._began, self._quit = points, 0.0, None
        lines = [line.strip() for line in text.splitlines()]
        code = "\n".join(self._module([one for one in lines if one and one[0] != ";"]))
        names = self._verbs()
        exec(compile(code, "module", "exec"), names)  # noqa: S102 - of a test
        names["iso_test"]()
        raise StoppedError(self.shown[-1])

    def _module(self, lines):
        depth, given = 0, ()
        for line in lines:
            word = line.partition(" ")[0]
            if head := re.fullmatch(r"(?:DEF|DEFFCT INT) (\w+)\((.*)\)", line):
                given = re.findall(r"(\w+)(?:\[\])?:", head[2])
                yield f"def {head[1]}({', '.join(given)}):"
                depth = 1
            elif word in ("ENDIF", "ENDFOR", "ENDWHILE", "ENDLOOP", "END", "ENDFCT"):
                yield "  " * depth + "pass"
                depth -= 1
            else:
                depth -= word == "ELSE"
                yield from ("  " * depth + one for one in self._line(line, given))
                depth += word in ("ELSE", "FOR", "WHILE", "LOOP", "IF")

    def _line(self, line, given):  # noqa: C901 - a statement a case
        if found := re.fullmatch(r"DECL (\w+) (.*)", line):
            for name, size in re.findall(r"(\w+)(?:\[(\d*)\])?", found[2]):
                if name not in given:
                    yield f"{name} = Chars({size})" if size else f"{name} = 0"
        elif found := re.fullmatch(r"FOR (\w+)=1 TO (\d+)", line):
            yield f"for {found[1]} in range(1, {found[2]} + 1):"
        elif found := re.fullmatch(r"(IF|WHILE) (.*?)(?: THEN)?", line):
            yield f"{found[1].lower()} {self._value(found[2])}:"
        elif line in ("LOOP", "ELSE", "EXIT", "HALT"):
            yield {"LOOP": "while True:", "ELSE": "else:", "EXIT": "break", "HALT": "HALT()"}[line]
        elif found := re.fullmatch(r"(\w+)=StrToInt\((\w+)\[\], (\w+)\)", line):
            yield f"{found[1]}, {found[3]} = StrToInt({found[2]})"
        elif found := re.fullmatch(r"([\w$]+(?:\[\w+\])?)=(.*)", line):
            yield self._set(found[1], self._value(found[2]))
        elif found := re.fullmatch(r"PTP X(\w+)", line):
            yield f"PTP({found[1]!r})"
        elif found := re.fullmatch(r"WAIT SEC (.*)", line):
            yield f"WAIT({found[1]})"
        elif found := re.fullmatch(r"RETURN ?(.*)", line):
            yield f"return {self._value(found[1])}"
        else:
            yield "pass" if "INTERRUPT" in line or line[:4] == "BAS(" else self._value(line)

    def _set(self, name, value):
        match name:
            case "FDAT_ACT":
                return f"FRAME({value!r})"
            case "$TIMER[1]":
                return "reset()"
            case "$TIMER_STOP[1]":
                return "pass"
            case "$VEL_AXIS[AXIS]":
                return f"assert 0 < {value} <= 100"
        return f"{name} = {value}"

    def _value(self, text):
        parts = re.split(r'("[^"]*")', text)
        for k, part in enumerate(parts):
            if k % 2:
                parts[k] = f"Chars({part})"
            for found, python in _KRL if not k % 2 else ():
                parts[k] = re.sub(found, python, parts[k])
        return "".join(parts)

    def _verbs(self):
        return {
            "__builtins__": {"range": range},
            "Chars": Chars,
            "connected": lambda: self.waiting() is not None,
            "timer": lambda: 1000 * (time.monotonic() - self._began),
            "reset": lambda: setattr(self, "_began", time.monotonic()),
            "WAIT": lambda seconds: time.sleep(0.005) if seconds == 0.05 else None,
            "FRAME": lambda name: setattr(self, "_frame", name),
            "PTP": self._move,
            "HALT": self._halt,
            "MsgQuit": lambda text: setattr(self, "_quit", str(text)),
            "MsgNotify": lambda text: self.shown.append(str(text)),
            "EKI_Init": lambda _name: None,
            "EKI_Open": self._open,
            "EKI_Clear": lambda _name: self.shut(),
            "EKI_Send": self._send,
            "EKI_CheckBuffer": lambda *_: SimpleNamespace(Buff=b"\n" in (self.waiting() or b"")),
            "EKI_GetString": lambda _name, _tag, chars: chars.fill(self.line(1)),
            "SWRITE": lambda chars, _state, _at, form, *given: chars.fill(
                str(form) % tuple(one if isinstance(one, int) else str(one) for one in given)
            ),
            "StrComp": lambda one, other, _how: str(one).lower() == str(other).lower(),
            "StrToInt": lambda chars: (str(chars).isdigit(), int(str(chars) or 0)),
        }

    def _move(self, point):
        assert self._frame == f"F{point}"
        assert point in self._points
        self.move(point)

    def _halt(self):
        if self._quit is not None:
            raise StoppedError(self._quit)

    def _open(self, name):
        with suppress(OSError):
            self.open(*self.server, 2)

    def _send(self, _name, chars):
        """Send a text; its line end is sent on its own, and ends a line that was said."""
        self._begun = getattr(self, "_begun", "") + str(chars)
        if self._begun.endswith("\n"):
            words, self._begun = self._begun, ""
            with suppress(OSError):
                self.send(words)
