"""The robot: its arm, workspace, gears, and what a model of them says that a dial will read.

`read_model` reads a MODEL.toml, `predict` makes the `Run` that the model expects and `simulate` the
one that a dial would have shown. `Arm` and `Workspace` are the geometry, `backlash` the paper's
two inertias in closed form, `drivetrain` the same through time.
"""

from typing import TYPE_CHECKING

from scara_iso.faces import face

if TYPE_CHECKING:
    from scara_iso.robot.arm import Arm as Arm, Elbow as Elbow
    from scara_iso.robot.drivetrain import (
        Approach as Approach,
        Arrivals as Arrivals,
        DriveTrain as DriveTrain,
        Move as Move,
        arrivals as arrivals,
        sides as sides,
    )
    from scara_iso.robot.largest_cube import (
        SMALLEST_MM as SMALLEST_MM,
        Rectangle as Rectangle,
        largest_rectangle as largest_rectangle,
    )
    from scara_iso.robot.model import (
        DeclaredEffect as DeclaredEffect,
        Gearbox as Gearbox,
        Indicator as Indicator,
        Model as Model,
        Rated as Rated,
        declare as declare,
        predict as predict,
        read_effects as read_effects,
        read_model as read_model,
        simulate as simulate,
    )
    from scara_iso.robot.model.arrive import rest_positions as rest_positions
    from scara_iso.robot.model.predict import (
        is_random as is_random,
        lever_mm as lever_mm,
        sweep_of as sweep_of,
    )
    from scara_iso.robot.model.spec import parse_effect as parse_effect
    from scara_iso.robot.paper import (
        PRINTED_DEVIATION_MM as PRINTED_DEVIATION_MM,
        PRINTED_FREE_PLAY_MM as PRINTED_FREE_PLAY_MM,
        PRINTED_L_BAR_MM as PRINTED_L_BAR_MM,
        PRINTED_RP_MM as PRINTED_RP_MM,
        PRINTED_S_MM as PRINTED_S_MM,
        PRINTED_XY_MM as PRINTED_XY_MM,
        first_joint as first_joint,
        table_1 as table_1,
    )
    from scara_iso.robot.two_inertia import (
        Backlash as Backlash,
        Crossing as Crossing,
        backlash as backlash,
    )
    from scara_iso.robot.workspace import Workspace as Workspace
else:
    __getattr__ = face(__name__)
