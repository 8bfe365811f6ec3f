"""URScript of Universal Robots: a Script node (file) of a PolyScope program that has the waypoints.

Verbs: URScript Programming Language manual, chapters on motion, interfaces and strings
(`socket_open`, `socket_send_line`, `socket_read_line`, `str_cat`, `to_num`; PolyScope 5.9 on).
PolyScope declares the waypoint P1 as `P1_p` and `P1_q`. A line that is empty asks whether the
connection still stands: sending then fails.
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

_LOOK_S = 2
_POINTS = "as waypoints of the PolyScope program that this script is a node of"


def _write(plan: ProgramPlan) -> tuple[str, ...]:
    if plan.line is None:
        raise ValueError("no serial line")
    parts = "\n\n".join("\n".join(_part(part, plan)) for part in plan.parts)
    text = f"""\
{commented(plan.head(_POINTS), "#")}

global HOST = "{plan.line.host}"
global PORT = {plan.line.port}
global DWELL = {plan.dwell_s:g}
global FULL_SPEED = 0.0  # rad/s of the joints that are 100 % of this robot's speed: fill in
global ACCELERATION = 1.4  # rad/s2
global SEND_TEMPERATURES = True
{_SPEAKING}
if FULL_SPEED <= 0.0:
  stop_robot("fill in FULL_SPEED at the top of this program")
end
connect()

{parts}

say("END")
socket_close("iso")
popup("The test is over.", title="scara-iso", blocking=True)
"""
    return (text,)


_SPEAKING = f"""
def stop_robot(reason):
  stopj(2.0)
  socket_close("iso")
  popup(reason, title="scara-iso", error=True, blocking=True)
  halt
end

def connect():
  local tries = 0
  socket_close("iso")
  while not socket_open(HOST, PORT, "iso"):
    tries = tries + 1
    if tries >= {CONNECT_S // _LOOK_S}:
      stop_robot("no connection to the recorder")
    end
    sleep({_LOOK_S}.0)
  end
end

# Says a line until it is answered, again after a lost connection; returns the number behind OK.
def say(words):
  local waited = 0
  local answer = ""
  if not socket_send_line(words, "iso"):
    connect()
    socket_send_line(words, "iso")
  end
  while answer == "":
    answer = socket_read_line("iso", {_LOOK_S}.0)
    if answer == "":
      waited = waited + {_LOOK_S}
      if waited >= {SILENCE_S}:
        stop_robot(str_cat("no answer to ", words))
      end
      if not socket_send_line("", "iso"):
        connect()
        socket_send_line(words, "iso")
      end
    end
  end
  if str_sub(answer, 0, 3) != "OK ":
    stop_robot(answer)
  end
  return to_num(str_sub(answer, 3))
end

def temperatures():
  local words = ""
  local joint = 0
  while SEND_TEMPERATURES and joint < 6:
    words = str_cat(words, str_cat(" T", str_cat(to_str(joint + 1), "_C=")))
    words = str_cat(words, to_str(get_joint_temp(joint)))
    joint = joint + 1
  end
  return words
end

def visit(at, cycle, added, approach, point, percent):
  movej(approach, a=ACCELERATION, v=FULL_SPEED * percent / 100)
  movej(point, a=ACCELERATION, v=FULL_SPEED * percent / 100)
  sleep(DWELL)
  local words = str_cat(at, str_cat(" cycle=", to_str(cycle)))
  local stored = say(str_cat(words, str_cat(added, temperatures())))
  if stored != cycle:
    stop_robot(str_cat("another cycle was answered to ", words))
  end
end
"""


def _part(part: ProgramPart, plan: ProgramPlan) -> Iterator[str]:
    yield f"# {part.title}"
    if plan.waits_before(part):
        yield f'popup("Set the dials up at {part.poses[0]}.", title="scara-iso", blocking=True)'
    yield f'stored = say("{part.hello}")'
    yield "cycle = 1"
    yield "while cycle <= stored:"
    yield "  cycle = cycle + 1"
    yield "end"
    yield f"while cycle <= {part.cycles}:"
    words = ("if cycle % 2 == 1:", "else:", "end")
    yield from (f"  {line}" for line in visits(part, plan, partial(_visit, part.speed), words))
    yield "  cycle = cycle + 1"
    yield "end"


def _visit(speed: float, pose: str, point: str, added: str) -> tuple[str, ...]:
    return (f'visit("AT {pose}", cycle, "{added}", {point}_q, {pose}_q, {speed:g})',)


LANGUAGE = Language(
    "urscript",
    (".script",),
    "Universal Robots",
    "socket_open, socket_send_line, socket_read_line",
    _write,
)
