from .arm import (
    SMALLEST_MM as SMALLEST_MM,
    Arm as Arm,
    Elbow as Elbow,
    Rectangle as Rectangle,
    Workspace as Workspace,
    largest_rectangle as largest_rectangle,
)
from .model import (
    DeclaredCourse as DeclaredCourse,
    DeclaredEffect as DeclaredEffect,
    Gearbox as Gearbox,
    Model as Model,
    Rated as Rated,
)
from .model_file import (
    declare as declare,
    parse_effect as parse_effect,
    read_effects as read_effects,
    read_model as read_model,
)
from .prediction import (
    Approach as Approach,
    is_random as is_random,
    lever_mm as lever_mm,
    predict as predict,
    rest_positions as rest_positions,
    sides as sides,
    simulate as simulate,
    sweep_of as sweep_of,
)
from .two_inertia import (
    PRINTED_MM as PRINTED_MM,
    PRINTED_RP_MM as PRINTED_RP_MM,
    Backlash as Backlash,
    Crossing as Crossing,
    backlash as backlash,
    first_joint as first_joint,
    table_1 as table_1,
)
