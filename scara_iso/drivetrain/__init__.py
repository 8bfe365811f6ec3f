"""Two inertias and a gap through time: what the gearbox of one joint does, event by event.

The mechanics of the paper's eq. 7-9 (Mousavi et al., "Repeatability Analysis of a SCARA Robot with
Planetary Gearbox"): motor and load turn freely inside a gap, meet in plastic impacts, and push each
other on one flank. `solve` is exact, in closed form from event to event, for the paper's model and
for what keeps accelerations constant: rotor inertia seen through the gearbox, Coulomb friction, a
constant load torque, a motor held to its commanded motion. `integrate` also takes viscous friction,
a compliant gear and a servo of finite gain, by numerical integration between located events.
`arrivals` repeats the end of a move many times and tells where the load comes to rest in the gap.

Units are SI: kg m², N m, rad, s, all at the gearbox output unless said otherwise.
"""

from scara_iso.drivetrain.arrivals import Approach, Arrivals, Move, arrivals, sides
from scara_iso.drivetrain.integration import integrate
from scara_iso.drivetrain.solution import solve
from scara_iso.drivetrain.train import (
    LEFT,
    NO_CONTACT,
    RIGHT,
    Drive,
    DriveTrain,
    Held,
    Servo,
    State,
    Torque,
    Trajectory,
)

__all__ = [
    "LEFT",
    "NO_CONTACT",
    "RIGHT",
    "Approach",
    "Arrivals",
    "Drive",
    "DriveTrain",
    "Held",
    "Move",
    "Servo",
    "State",
    "Torque",
    "Trajectory",
    "arrivals",
    "integrate",
    "sides",
    "solve",
]
