"""RAPID of ABB (IRC5, OmniCore; IRB 910SC and others): a module with `main`.

Verbs: Technical reference manual, RAPID instructions, functions and data types (`SocketCreate`,
`SocketConnect`, `SocketSend`, `SocketReceive`, `StrToVal`, `VelSet`; option PC Interface).
`TRYNEXT` goes on behind the statement that failed; how often `RETRY` may, a parameter limits.
An answer is read byte by byte: a string holds 80 characters, and a line may come in pieces.
"""

from __future__ import annotations

from collections.abc import Iterator

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
_POINTS = "as robtargets of a module of yours, with the tool `PERS tooldata test_tool`"


def _write(plan: ProgramPlan) -> tuple[str, ...]:
    if plan.line is None:
        raise ValueError("no serial line")
    parts = "\n".join(line for part in plan.parts for line in _part(part, plan))
    text = f"""\
MODULE {plan.name}
{commented(plan.head(_POINTS), "!", "  ")}

  CONST string HOST := "{plan.line.host}";
  CONST num PORT := {plan.line.port};
  CONST num DWELL := {plan.dwell_s:g};
  CONST num SILENCE := {SILENCE_S};
  VAR socketdev line_socket;

  PROC main()
    VAR num cycle;
    VAR num stored;
    ConnectLine;
{parts}
    stored := Say("END");
    SocketClose line_socket;
    TPWrite "The test is over.";
    EXIT;
  ENDPROC
{_SPEAKING}
ENDMODULE
"""
    return (text,)


_SPEAKING = f"""
  PROC StopRobot(string reason)
    SocketClose line_socket;
    TPWrite "scara-iso: stopped.";
    TPWrite reason;
    EXIT;
  ENDPROC

  PROC ConnectLine()
    VAR bool connected := FALSE;
    VAR num tries := 0;
    WHILE NOT connected DO
      IF tries >= {CONNECT_S // _TRY_S} THEN
        StopRobot "no connection to the recorder";
      ENDIF
      tries := tries + 1;
      SocketClose line_socket;
      SocketCreate line_socket;
      connected := TRUE;
      SocketConnect line_socket, HOST, PORT \\Time:={_TRY_S};
    ENDWHILE
  ERROR
    connected := FALSE;
    WaitTime {_TRY_S};
    TRYNEXT;
  ENDPROC

  ! Says a line until it is answered, again after a lost connection; returns the number behind OK.
  FUNC num Say(string words)
    VAR string answer;
    VAR string piece;
    VAR num number := 0;
    VAR bool lost := TRUE;
    WHILE lost DO
      lost := FALSE;
      answer := "";
      piece := "";
      SocketSend line_socket \\Str:=words + "\\0A";
      WHILE NOT lost AND piece <> "\\0A" DO
        SocketReceive line_socket \\Str:=piece \\ReadNoOfBytes:=1 \\Time:=SILENCE;
        IF piece <> "\\0D" AND piece <> "\\0A" AND StrLen(answer) < 70 THEN
          answer := answer + piece;
        ENDIF
      ENDWHILE
    ENDWHILE
    IF StrLen(answer) < 4 THEN
      StopRobot "no answer of the recorder: " + answer;
    ENDIF
    IF StrPart(answer, 1, 3) <> "OK " THEN
      StopRobot answer;
    ENDIF
    IF NOT StrToVal(StrPart(answer, 4, StrLen(answer) - 3), number) THEN
      StopRobot answer;
    ENDIF
    RETURN number;
  ERROR
    IF ERRNO = ERR_SOCK_TIMEOUT THEN
      StopRobot "no answer to " + words;
    ENDIF
    lost := TRUE;
    ConnectLine;
    TRYNEXT;
  ENDFUNC

  PROC Visit(string pose, num cycle, string added, robtarget approach, robtarget point)
    VAR num stored;
    MoveJ approach, vmax, fine, test_tool;
    MoveJ point, vmax, fine, test_tool;
    WaitTime \\InPos, DWELL;
    stored := Say("AT " + pose + " cycle=" + NumToStr(cycle, 0) + added);
    IF stored <> cycle THEN
      StopRobot "another cycle was answered to AT " + pose;
    ENDIF
  ENDPROC"""


def _part(part: ProgramPart, plan: ProgramPlan) -> Iterator[str]:
    yield f"    ! {part.title}"
    if plan.waits_before(part):
        yield f'    TPWrite "Set the dials up at {part.poses[0]}, then go on.";'
        yield "    Stop;"
    yield f"    VelSet {part.speed:g}, MaxRobSpeed();"
    yield f'    cycle := 1 + Say("{part.hello}");'
    yield f"    WHILE cycle <= {part.cycles} DO"
    words = ("IF cycle MOD 2 = 1 THEN", "ELSE", "ENDIF")
    yield from (f"      {line}" for line in visits(part, plan, _visit, words))
    yield "      cycle := cycle + 1;"
    yield "    ENDWHILE"


def _visit(pose: str, point: str, added: str) -> tuple[str, ...]:
    return (f'Visit "{pose}", cycle, "{added}", {point}, {pose};',)


LANGUAGE = Language(
    "rapid",
    (".mod",),
    "ABB (IRB 910SC and others)",
    "SocketCreate, SocketConnect, SocketSend, SocketReceive",
    _write,
)
