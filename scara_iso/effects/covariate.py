"""Whatever else was recorded beside the readings: in proportion to that column.

Columns through which another effect acts are left to it.
"""

from scara_iso.effects import Parameter, proportional

EFFECT = proportional(
    name="covariate",
    of="*",
    recorded="z: the recorded quantity",
    size=Parameter("size", "c", "reading/unit", "change per unit of the recorded quantity"),
    cause="whatever this column records acts on the pose, or shares a cause with it",
    confirm_by="hold the quantity constant, then change it on purpose, in random order",
)
