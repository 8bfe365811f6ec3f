from .all_conditions import (
    joined_analysis as joined_analysis,
    pose_under as pose_under,
)
from .folder import (
    Folder as Folder,
    PartState as PartState,
    completed as completed,
    lacking as lacking,
    push_of as push_of,
    read_folder as read_folder,
    refuse_faulty as refuse_faulty,
    run_under as run_under,
)
from .place import FILE as FILE, is_test_folder as is_test_folder
from .progress import (
    Assignment as Assignment,
    about as about,
    assign as assign,
    next_of_load as next_of_load,
    published_status as published_status,
    seconds_left as seconds_left,
)
from .statements import (
    lines_of as lines_of,
    parse_test as parse_test,
    read_instruments as read_instruments,
    read_test as read_test,
)
from .whole_test import (
    Condition as Condition,
    Part as Part,
    WholeTest as WholeTest,
)
from .writing import (
    plan_test as plan_test,
    strike as strike,
    taught_test as taught_test,
    toml_of as toml_of,
)
