"""What a drive train is."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from scara_iso.errors import UsageError


@dataclass(frozen=True, slots=True)
class DriveTrain:
    """A motor, a gap and a load on one shaft; every term beyond the first three can be left out.

    Raises `UsageError`, naming every fault, for a number outside its range.
    """

    motor_inertia: float
    """I_m, at the motor shaft [kg m²]."""
    load_inertia: float
    """I_L, at the output [kg m²]."""
    gap: float
    """2Δ, the full gap at the output [rad]."""
    ratio: float = 1.0
    """N: the rotor counts N² times at the output. 1 is the paper's single shaft."""
    coulomb: float = 0.0
    """Coulomb friction on the load, at rest and in motion [N m]."""
    viscous: float = 0.0
    """Viscous friction on the load [N m s/rad]."""
    load_torque: float = 0.0
    """Constant torque on the load [N m]."""
    stiffness: float = math.inf
    """Torsional stiffness of gear and shaft in contact [N m/rad]; infinite: plastic impacts."""
    damping: float = 0.0
    """Torsional damping in contact [N m s/rad]; of use only with a finite stiffness."""

    def __post_init__(self) -> None:
        positive = {"motor_inertia", "load_inertia", "gap", "ratio"}
        faults = []
        for name, value in ((f.name, getattr(self, f.name)) for f in fields(self)):
            match name:
                case "load_torque":
                    good, rule = math.isfinite(value), "finite"
                case "stiffness":
                    good, rule = value > 0, "positive"
                case _ if name in positive:
                    good, rule = 0 < value < math.inf, "positive and finite"
                case _:
                    good, rule = 0 <= value < math.inf, "not negative, and finite"
            faults += [] if good else [f"{name} is {value:g}, must be {rule}"]
        if faults:
            raise UsageError(f"not a possible drive train: {'; '.join(faults)}")

    @property
    def reflected_inertia(self) -> float:
        """N² I_m: inertia of the rotor seen at the output [kg m²]."""
        return self.ratio**2 * self.motor_inertia

    @property
    def rigid(self) -> bool:
        """Whether contacts are rigid, so that impacts are plastic."""
        return math.isinf(self.stiffness)
