"""What a recording left: its raw file, the readings in it, and whether any of it was changed.

`read_history` reads a raw file, `check_manifest` compares table and raw file with their manifest.
"""

from typing import TYPE_CHECKING

from scara_iso.base.faces import face

if TYPE_CHECKING:
    from scara_iso.rawfile.history import (
        THEN as THEN,
        VOIDABLE as VOIDABLE,
        History as History,
        ShownReading as ShownReading,
        read_history as read_history,
    )
    from scara_iso.rawfile.integrity import (
        FIRST as FIRST,
        LEFT_OUT as LEFT_OUT,
        SCHEMA as SCHEMA,
        check_manifest as check_manifest,
        check_recording as check_recording,
        checksum as checksum,
        encode as encode,
        find_doubts as find_doubts,
        is_raw_file as is_raw_file,
        manifest_of as manifest_of,
        manifest_path as manifest_path,
        raw_path as raw_path,
        read_records as read_records,
    )
    from scara_iso.rawfile.records import (
        LATE as LATE,
        SECOND as SECOND,
        TWICE as TWICE,
        UNASKED as UNASKED,
        UNIT_ASKED as UNIT_ASKED,
        Timeline as Timeline,
        Tour as Tour,
        wrong_sizes as wrong_sizes,
    )
else:
    __getattr__ = face(__name__)
