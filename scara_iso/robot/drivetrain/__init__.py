"""Two inertias and a gap through time: what the gearbox of one joint does, event by event.

The mechanics of the paper's eq. 7-9 (Mousavi et al., "Repeatability Analysis of a SCARA Robot with
Planetary Gearbox"): motor and load turn freely inside a gap, meet in plastic impacts, and push each
other on one flank. `arrivals` repeats the end of a move many times, in closed form from event to
event, and tells where the load comes to rest in the gap: under Coulomb friction and a constant load
torque, with a motor that follows its command.

Units are SI: kg m², N m, rad, s, all at the gearbox output unless said otherwise.
"""

from scara_iso.robot.drivetrain.arrivals import Approach, Arrivals, Move, arrivals, sides
from scara_iso.robot.drivetrain.train import DriveTrain

__all__ = ["Approach", "Arrivals", "DriveTrain", "Move", "arrivals", "sides"]
