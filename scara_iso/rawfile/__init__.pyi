from .history import (
    THEN as THEN,
    VOIDABLE as VOIDABLE,
    History as History,
    ShownReading as ShownReading,
    read_history as read_history,
)
from .integrity import (
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
from .records import (
    LATE as LATE,
    SECOND as SECOND,
    TWICE as TWICE,
    UNASKED as UNASKED,
    UNIT_ASKED as UNIT_ASKED,
    Timeline as Timeline,
    Tour as Tour,
    wrong_sizes as wrong_sizes,
)
