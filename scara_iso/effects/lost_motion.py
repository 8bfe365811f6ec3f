"""Lost motion: the reading follows the sign of the approach, half width to either side."""

import numpy as np

from scara_iso.effects import Parameter, proportional

EFFECT = proportional(
    name="lost_motion",
    of="approach",
    by=np.sign,
    size=Parameter("size", "h", "reading", "half of the distance between approaches"),
    cause="backlash and wind-up of a drive, taken up on the other side when the pose is "
    "approached the other way",
    confirm_by="run with one approach only: the difference must vanish",
    by_flank=True,
)
