"""What is trusted: code that was installed, and nothing of the folder that a process stands in.

It imports only what Python has imported itself, since the program begins with it: until then
``python -m scara_iso`` would take any other module from that folder.
"""

import os
import sys

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
