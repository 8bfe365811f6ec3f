"""The indicator's own hysteresis: its reading depends on where the plunger came from."""

import numpy as np

from scara_iso.effects import Parameter, proportional

EFFECT = proportional(
    name="indicator_hysteresis",
    of="approach",
    by=np.sign,
    size=Parameter("size", "h", "reading", "half of the distance between approaches"),
    cause="friction and play in the indicator: its plunger goes in and comes out another way",
    confirm_by="bring a gauge block or a micrometer against the indicator from both sides, without "
    "the robot: the difference must be there too",
    weight=0.12,  # a course that it shares with lost motion, which is far more common
)
