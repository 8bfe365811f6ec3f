"""A joint pushed to and fro at its arm: what its play, its spring and its friction are.

`read_loop` takes the table of a push test, `fit_loop` estimates compliance, play and friction.
"""

from typing import TYPE_CHECKING

from scara_iso.base.faces import face

if TYPE_CHECKING:
    from scara_iso.force_loop.fit import LoopFit as LoopFit, fit_loop as fit_loop
    from scara_iso.force_loop.loop import (
        ForceLoop as ForceLoop,
        is_loop as is_loop,
        loop_of as loop_of,
        read_loop as read_loop,
    )
else:
    __getattr__ = face(__name__)
