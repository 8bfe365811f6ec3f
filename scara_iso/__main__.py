"""The program's door: from here on Ctrl-C ends it with 130 and no traceback, in an import too."""

from __future__ import annotations

import os
import signal
import sys

INTERRUPTED = 130


def run() -> None:
    """Run the command with the process' arguments and exit: the console script."""
    heard = signal.getsignal(signal.SIGINT) is signal.default_int_handler  # else: nohup, a script
    if heard:
        signal.signal(signal.SIGINT, _leave)
    from scara_iso.cli import main  # noqa: PLC0415 - not before Ctrl-C is understood

    if heard:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    code = main()
    if heard:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # nothing is left to interrupt
    sys.exit(code)


def _leave(*_: object) -> None:
    """Leave at once: nothing was begun, and an exception may be lost within an import."""
    os._exit(INTERRUPTED)


if __name__ == "__main__":
    run()
