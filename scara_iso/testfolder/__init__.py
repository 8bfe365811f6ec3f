"""The whole test as a folder: test.toml says what is measured, its recordings are the parts.

`read_folder` says how far each part is, `assign` which comes next, `run_under` makes one `Run` of
the parts of a condition.
"""

from pathlib import Path
from typing import TYPE_CHECKING

from scara_iso.base.faces import face
from scara_iso.base.files import is_file

if TYPE_CHECKING:
    from scara_iso.testfolder.all_conditions import (
        joined_analysis as joined_analysis,
        pose_under as pose_under,
    )
    from scara_iso.testfolder.folder import (
        Folder as Folder,
        PartState as PartState,
        completed as completed,
        lacking as lacking,
        push_of as push_of,
        read_folder as read_folder,
        refuse_faulty as refuse_faulty,
        run_under as run_under,
    )
    from scara_iso.testfolder.progress import (
        Assignment as Assignment,
        about as about,
        assign as assign,
        next_of_load as next_of_load,
        published_status as published_status,
        seconds_left as seconds_left,
    )
    from scara_iso.testfolder.statements import (
        lines_of as lines_of,
        parse_test as parse_test,
        read_instruments as read_instruments,
        read_test as read_test,
    )
    from scara_iso.testfolder.whole_test import (
        Condition as Condition,
        Part as Part,
        WholeTest as WholeTest,
    )
    from scara_iso.testfolder.writing import (
        plan_test as plan_test,
        strike as strike,
        taught_test as taught_test,
        toml_of as toml_of,
    )
else:
    __getattr__ = face(__name__)

FILE = "test.toml"


def is_test_folder(path: object) -> bool:
    """Say whether a path names the folder of a test; every command asks, so it stands here."""
    return isinstance(path, str | Path) and is_file(Path(path) / FILE)
