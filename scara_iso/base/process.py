"""The process that this program is: what code it trusts, and how it ends.

Trusted is what was installed, and nothing of the folder that the process stands in.

Ctrl-C and requests to end are raised as `KeyboardInterrupt`, never lost, never in a bad moment:
what a signal raises within an import leaves half a module behind, within a finaliser it is
swallowed, and while a file is written it leaves a part of one. There it is put off until it is
behind that; where it was swallowed all the same, it is raised again. The signal is remembered: a
process that heard one ends with 130, whatever became of the exception.

It imports only what Python has imported itself or has built in, since the program begins with it:
until then ``python -m scara_iso`` would take any other module from that folder.
"""

import _thread
import os
import sys
import time

TYPE_CHECKING = False
if TYPE_CHECKING:
    import signal
    from types import FrameType
else:
    import _signal as signal  # the other takes 10 ms first, deaf

_HOME = os.path.dirname(os.path.dirname(os.path.dirname(os.path.realpath(__file__))))
program = False
"""Whether this process is the program's own, and not a user's that imported the library."""


def begin_program() -> None:
    """Make this process the program's own: it and its children trust what is installed only."""
    global program  # noqa: PLW0603 - said once, at the start
    program = True
    sys.path[:] = code_folders()
    os.environ["PYTHONSAFEPATH"] = "1"
    os.environ.pop("MPLBACKEND", None)  # matplotlib would refuse to start with a wrong one
    os.environ.pop("EAGER_IMPORT", None)  # lazy_loader would import all that no command needs


def code_folders() -> list[str]:
    """Return where to look for code: ``sys.path`` without the folder that this process stands in.

    With it where it is the package's own, or where PYTHONPATH names it in full.
    """
    try:
        here = os.path.realpath(os.getcwd())
    except OSError:  # it is gone, and nothing is in it
        return list(sys.path)
    named = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    if here in (_HOME, *(os.path.realpath(one) for one in named if os.path.isabs(one))):
        return list(sys.path)
    return [folder for folder in sys.path if os.path.realpath(folder) != here]


def of_a_child() -> dict[str, str]:
    """Return the environment of a process that looks for code where this one does."""
    return {**os.environ, "PYTHONSAFEPATH": "1", "PYTHONPATH": os.pathsep.join(code_folders())}


INTERRUPTED = 130
_ENDING = ("SIGINT", "SIGTERM", "SIGHUP")
_AGAIN_S = 0.01
_IMPORTING, _FINALISER = "<frozen importlib", "__del__"
_heard: list[int] = []
_held: list[object] = []
_put_off: list[int] = []


class Later:
    """Within it no interrupt is raised; it comes behind it."""

    def __enter__(self) -> None:
        _held.append(self)

    def __exit__(self, *_: object) -> None:
        _held.remove(self)


def were_heard() -> bool:
    """Say whether a signal has asked this process to end."""
    return bool(_heard)


def leave_at_once() -> None:
    """Let Ctrl-C end this process without an exception, as long as nothing is begun."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # else: nohup, a script
        signal.signal(signal.SIGINT, lambda *_: os._exit(INTERRUPTED))


def listen() -> None:
    """From here on let each signal that would end this process raise `KeyboardInterrupt`.

    One that is ignored stays so, as under nohup or behind the & of a script.
    """
    before = sys.unraisablehook

    def swallowed(found: "sys.UnraisableHookArgs") -> None:
        if issubclass(found.exc_type, KeyboardInterrupt):
            _raise_later(_heard[0] if _heard else int(signal.SIGINT))
        else:
            before(found)

    sys.unraisablehook = swallowed
    for number in _numbers():
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, _hear)


def stop_listening() -> None:
    """Take no interrupt any more: nothing is left that it could end."""
    for number in _numbers():
        if signal.getsignal(number) is _hear:
            signal.signal(number, signal.SIG_IGN)


def _numbers() -> list[int]:
    return [int(getattr(signal, name)) for name in _ENDING if hasattr(signal, name)]


def _hear(number: int, frame: "FrameType | None") -> None:
    _heard.append(number)
    if _held or _is_bad_moment(frame):
        _raise_later(number)
    else:
        raise KeyboardInterrupt


def _is_bad_moment(frame: "FrameType | None") -> bool:
    while frame is not None:
        code = frame.f_code
        if code.co_filename.startswith(_IMPORTING) or code.co_name == _FINALISER:
            return True
        frame = frame.f_back
    return False


def _raise_later(number: int) -> None:
    """Send the signal again in a moment; a `threading.Thread` would take locks that may be held.

    One that is put off stands for all that come until then: a second would come while the first is
    answered.
    """
    if not _put_off:
        _put_off.append(number)
        _thread.start_new_thread(_send, (number, _thread.get_ident()))


def _send(number: int, to: int) -> None:
    time.sleep(_AGAIN_S)
    _put_off.clear()
    if hasattr(signal, "pthread_kill"):
        signal.pthread_kill(to, number)  # which also ends what the thread waits for
    else:
        _thread.interrupt_main(number)  # type: ignore[arg-type]
