"""The program's door: what a process does once, before the first import and after the last word.

From here on Ctrl-C ends it with 130 and no traceback, in an import too.
"""

import atexit
import gc
import os
import sys

from scara_iso.base import process

_COLLECTED_AFTER = 100_000
"""New objects before the first look for garbage: imports make most of them, and none of it."""


def run() -> None:
    """Run the command with the process' arguments and exit: the console script."""
    process.begin_program()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy; the matrices are small
    process.leave_at_once()
    gc.set_threshold(_COLLECTED_AFTER)
    from scara_iso.commands import main  # noqa: PLC0415 - not before Ctrl-C is understood

    code = 0
    try:
        process.listen()
        code = main()
        process.stop_listening()
    except KeyboardInterrupt:  # behind the last word of the command
        process.stop_listening()
    _end(process.INTERRUPTED if process.were_heard() else code)


def _end(code: int) -> None:
    """End with a code: at once, since to take every module apart is a tenth of a short command.

    In the ordinary way where a thread is waited for, or a stream does not take its last words.
    """
    import threading  # noqa: PLC0415 - the parser has imported it

    if threading.active_count() == 1:
        try:
            atexit._run_exitfuncs()
            sys.stdout.flush()
            sys.stderr.flush()
        except (OSError, ValueError, AttributeError):
            sys.exit(code)
        os._exit(code)
    sys.exit(code)


if __name__ == "__main__":
    run()
