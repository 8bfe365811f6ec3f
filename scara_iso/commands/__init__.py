"""One module a command: the public function, and the options and screen of the same command.

The functions are the face of `scara_iso` itself, which finds them in these modules: a package that
showed `analyze` beside its module `analyze` would lose one to the other. Here stand the program
and what else of the commands is of use outside.
"""

from typing import TYPE_CHECKING

from scara_iso.base.faces import face

if TYPE_CHECKING:
    from scara_iso.commands.app import (
        COMMANDS as COMMANDS,
        WELCOME as WELCOME,
        build_app as build_app,
        main as main,
    )
    from scara_iso.commands.operator.watching import Watcher as Watcher
    from scara_iso.commands.plan import new_test as new_test
    from scara_iso.commands.shared.series import read_conditions as read_conditions
    from scara_iso.commands.simulate import (
        PublishedRun as PublishedRun,
        published_run as published_run,
    )
else:
    __getattr__ = face(__name__)
