r"""KRL of KUKA (KR C4, KR C5; KR SCARA) with EthernetKRL: a module, and the XML of its connection.

Verbs: KST EthernetKRL 2.2 and KSS programming manuals (`EKI_Init`, `EKI_Open`, `EKI_Send`,
`EKI_CheckBuffer`, `EKI_GetString`; `SWRITE`, `StrComp`, `StrToInt`). The XML belongs to
C:\KRC\ROBOTER\Config\User\Common\EthernetKRL; flag 11 is set while the recorder is connected.
"""

from __future__ import annotations

from collections.abc import Iterator

from scara_iso.recorder.programs import (
    CONNECT_S,
    SILENCE_S,
    Language,
    ProgramPart,
    ProgramPlan,
    Served,
    commented,
    visits,
)

_POINTS = "by inline forms in this module (P1 is XP1 there), with their tool and base"


def _write(plan: ProgramPlan) -> tuple[str, ...]:
    if plan.line is None:
        raise ValueError("no serial line")
    parts = "\n".join(line for part in plan.parts for line in _part(part, plan))
    program = f"""\
DEF {plan.name}( )
{commented(plan.head(_POINTS), ";", "  ")}
  DECL INT CYCLE
  DECL INT AXIS
  GLOBAL INTERRUPT DECL 3 WHEN $STOPMESS==TRUE DO IR_STOPM( )
  INTERRUPT ON 3
  BAS(#INITMOV, 0)
  CONNECT( )
{parts}
  CYCLE=SAY("END")
  MsgNotify("The test is over.")
END
{_SPEAKING.replace("<NAME>", plan.name).replace("<DWELL>", f"{plan.dwell_s:g}")}"""
    return program, _connection(plan.line)


def _connection(line: Served) -> str:
    return f"""\
<ETHERNETKRL>
  <CONFIGURATION>
    <EXTERNAL>
      <IP>{line.host}</IP>
      <PORT>{line.port}</PORT>
      <TYPE>Server</TYPE>
    </EXTERNAL>
    <INTERNAL>
      <ENVIRONMENT>Program</ENVIRONMENT>
      <BUFFERING Mode="FIFO" Limit="10"/>
      <ALIVE Set_Flag="11"/>
    </INTERNAL>
  </CONFIGURATION>
  <RECEIVE>
    <RAW>
      <ELEMENT Tag="Answer" Type="STREAM" EOS="13,10"/>
    </RAW>
  </RECEIVE>
  <SEND/>
</ETHERNETKRL>
"""


_SPEAKING = f"""
DEF STOP_ROBOT(REASON[]:OUT)
  DECL CHAR REASON[]
  MsgQuit(REASON[])
  LOOP
    HALT
  ENDLOOP
END

DEF CONNECT( )
  DECL EKI_STATUS RET
  DECL INT TRIES
  FOR TRIES=1 TO {CONNECT_S // 2}
    RET=EKI_Init("<NAME>")
    RET=EKI_Open("<NAME>")
    WAIT SEC 2.0
    IF $FLAG[11]==TRUE THEN
      RETURN
    ENDIF
    RET=EKI_Clear("<NAME>")
  ENDFOR
  STOP_ROBOT("no connection to the recorder")
END

; Says a line until it is answered, again after a lost connection; returns the number behind OK.
DEFFCT INT SAY(WORDS[]:OUT)
  DECL CHAR WORDS[], ANSWER[200], BEGIN[3], EOL[2]
  DECL EKI_STATUS RET
  DECL INT NUMBER, I
  DECL BOOL DONE
  EOL[1]=13
  EOL[2]=10
  RET=EKI_Send("<NAME>", WORDS[])
  RET=EKI_Send("<NAME>", EOL[])
  $TIMER[1]=0
  $TIMER_STOP[1]=FALSE
  LOOP
    RET=EKI_CheckBuffer("<NAME>", "Answer")
    IF RET.Buff>0 THEN
      EXIT
    ENDIF
    IF $FLAG[11]==FALSE THEN
      RET=EKI_Clear("<NAME>")
      CONNECT( )
      RET=EKI_Send("<NAME>", WORDS[])
      RET=EKI_Send("<NAME>", EOL[])
      $TIMER[1]=0
    ENDIF
    IF $TIMER[1]>{SILENCE_S * 1000} THEN
      STOP_ROBOT("no answer of the recorder")
    ENDIF
    WAIT SEC 0.05
  ENDLOOP
  FOR I=1 TO 200
    ANSWER[I]=0
  ENDFOR
  RET=EKI_GetString("<NAME>", "Answer", ANSWER[])
  FOR I=1 TO 3
    BEGIN[I]=ANSWER[I]
  ENDFOR
  IF NOT StrComp(BEGIN[], "OK ", #NOT_CASE_SENS) THEN
    STOP_ROBOT(ANSWER[])
  ENDIF
  FOR I=1 TO 197
    ANSWER[I]=ANSWER[I+3]
  ENDFOR
  DONE=StrToInt(ANSWER[], NUMBER)
  IF NOT DONE THEN
    STOP_ROBOT("the recorder's answer has no number")
  ENDIF
  RETURN NUMBER
ENDFCT

DEF VISITED(AT[]:OUT, CYCLE:IN, ADDED[]:OUT)
  DECL CHAR AT[], ADDED[], WORDS[200]
  DECL INT CYCLE, OFFSET, I
  DECL STATE_T STATE
  WAIT SEC <DWELL>
  FOR I=1 TO 200
    WORDS[I]=0
  ENDFOR
  OFFSET=0
  SWRITE(WORDS[], STATE, OFFSET, "%s cycle=%d%s", AT[], CYCLE, ADDED[])
  IF SAY(WORDS[])<>CYCLE THEN
    STOP_ROBOT("another cycle was answered")
  ENDIF
END
"""


def _part(part: ProgramPart, plan: ProgramPlan) -> Iterator[str]:
    yield f"  ; {part.title}"
    if plan.waits_before(part):
        yield f'  MsgNotify("Set the dials up at {part.poses[0]}, then go on.")'
        yield "  HALT"
    yield "  FOR AXIS=1 TO 6"
    yield f"    $VEL_AXIS[AXIS]={max(1, round(part.speed))}"
    yield "  ENDFOR"
    yield f'  CYCLE=1+SAY("{part.hello}")'
    yield f"  WHILE CYCLE<={part.cycles}"
    words = ("IF (CYCLE-2*(CYCLE/2))==1 THEN", "ELSE", "ENDIF")
    yield from (f"    {line}" for line in visits(part, plan, _visit, words))
    yield "    CYCLE=CYCLE+1"
    yield "  ENDWHILE"


def _visit(pose: str, approach: str, added: str) -> Iterator[str]:
    """Yield the way to a pose, with tool and base of its inline form (FP1 beside XP1)."""
    for point in (approach, pose):
        yield f"FDAT_ACT=F{point}"
        yield "BAS(#FRAMES)"
        yield f"PTP X{point}"
    yield f'VISITED("AT {pose}", CYCLE, "{added}")'


LANGUAGE = Language(
    "krl", (".src", ".xml"), "KUKA (KR SCARA)", "EthernetKRL, with its XML file", _write
)
