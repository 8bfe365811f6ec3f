"""SPEL+ of Epson (RC+; LS, T and G SCARAs): the function `main` of a project that has the points.

Verbs: SPEL+ Language Reference (`SetNet`, `OpenNet`, `WaitNet`, `ChkNet`, `Print #`,
`Line Input #`, `Tmr`; `OpenCom`, `ChkCom` for a serial line). `ChkNet` and `ChkCom` give the bytes
that wait, and less than 0 where nobody is connected.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from scara_iso.recorder.programs import (
    CONNECT_S,
    SILENCE_S,
    Language,
    ProgramPart,
    ProgramPlan,
    commented,
    visits,
)

_TRY_S = 2
_POINTS = "as labels of the project's point file, P1 as the point of that number"


def _write(plan: ProgramPlan) -> tuple[str, ...]:
    parts = "\n".join(line for part in plan.parts for line in _part(part, plan))
    port = "1" if plan.line is None else "201"
    speaking = _SPEAKING.replace("<PORT>", port)
    if plan.line is None:
        speaking = speaking.replace("ChkNet", "ChkCom")
    text = f"""\
{commented(plan.head(_POINTS), "'")}

Function main
  Integer cycle
  Motor On
  Power High
  Call ConnectLine
{parts}
  cycle = Say("END")
  Print "The test is over."
Fend

{_serial() if plan.line is None else _network(plan.line.host, plan.line.port)}
{speaking}"""
    return (text,)


def _network(host: str, port: int) -> str:
    return f"""\
Function ConnectLine
  Integer tries
  SetNet #201, "{host}", {port}, CRLF, NONE, 0
  tries = 0
  Do
    CloseNet #201
    OpenNet #201 As Client
    WaitNet #201, {_TRY_S}
    If TW = 0 Then Exit Function
    tries = tries + 1
    If tries >= {CONNECT_S // _TRY_S} Then Call StopRobot("no connection to the recorder")
  Loop
Fend
"""


def _serial() -> str:
    return """\
Function ConnectLine
  SetCom #1, 9600, 8, 1, N, CRLF, NONE
  CloseCom #1
  OpenCom #1
Fend
"""


_SPEAKING = f"""\
Function StopRobot(reason$ As String)
  Print "scara-iso: stopped. ", reason$
  Quit All
Fend

' Says a line until it is answered, again after a lost connection; returns the number behind OK.
Function Say(words$ As String) As Integer
  String answer$
  Integer waiting, tries
  tries = 0
again:
  OnErr GoTo lost
  Print #<PORT>, words$
  TmReset 0
  Do
    waiting = ChkNet(<PORT>)
    If waiting > 0 Then Exit Do
    If waiting < 0 Then GoTo reconnect
    If Tmr(0) > {SILENCE_S} Then Call StopRobot("no answer to " + words$)
    Wait 0.05
  Loop
  Line Input #<PORT>, answer$
  OnErr GoTo 0
  If Left$(answer$, 3) <> "OK " Then Call StopRobot(answer$)
  Say = Val(Mid$(answer$, 4))
  Exit Function
lost:
  EResume reconnect
reconnect:
  tries = tries + 1
  If tries > 5 Then Call StopRobot("the connection is lost again and again")
  Call ConnectLine
  GoTo again
Fend

Function Visited(place$ As String, cycle As Integer, added$ As String)
  If Say(place$ + " cycle=" + LTrim$(Str$(cycle)) + added$) <> cycle Then
    Call StopRobot("another cycle was answered to " + place$)
  EndIf
Fend
"""


def _part(part: ProgramPart, plan: ProgramPlan) -> Iterator[str]:
    yield f"  ' {part.title}"
    if plan.waits_before(part):
        yield f'  Print "Set the dials up at {part.poses[0]}, then go on."'
        yield "  Pause"
    yield f"  Speed {max(1, round(part.speed))}"
    yield f'  cycle = 1 + Say("{part.hello}")'
    yield f"  Do While cycle <= {part.cycles}"
    words = ("If cycle Mod 2 = 1 Then", "Else", "EndIf")
    visit = partial(_visit, plan.dwell_s)
    yield from (f"    {line}" for line in visits(part, plan, visit, words))
    yield "    cycle = cycle + 1"
    yield "  Loop"


def _visit(dwell_s: float, pose: str, approach: str, added: str) -> Iterator[str]:
    yield f"Go {approach}"
    yield f"Go {pose}"
    yield f"Wait {dwell_s:g}"
    yield f'Call Visited("AT {pose}", cycle, "{added}")'


LANGUAGE = Language(
    "spel", (".prg",), "Epson SCARA (SPEL+)", "OpenNet, Print #, Line Input #", _write, serial=True
)
