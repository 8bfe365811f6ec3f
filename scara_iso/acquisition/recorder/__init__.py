"""From ports to durable files: port, clock, disk, operator and listener are arguments."""

from scara_iso.acquisition.manifest import check_manifest, manifest_path, raw_path
from scara_iso.acquisition.recorder.earlier import refuse_existing
from scara_iso.acquisition.recorder.events import (
    Command,
    CycleDone,
    Done,
    Gross,
    Note,
    Noted,
    Noticed,
    Operator,
    Pause,
    Paused,
    Problem,
    Quit,
    Refused,
    Said,
    Started,
    Stored,
    Take,
    Void,
    Voided,
    Waiting,
    as_json,
)
from scara_iso.acquisition.recorder.history import History, read_history
from scara_iso.acquisition.recorder.plan import (
    Enter,
    Job,
    Listen,
    Plan,
    Timer,
    Trigger,
    parse_trigger,
)
from scara_iso.acquisition.recorder.recording import record
from scara_iso.acquisition.recorder.spec import (
    GaugeSpec,
    check_metadata,
    parse_gauges,
    parse_metadata,
    read_metadata,
)
from scara_iso.acquisition.recorder.table import rebuild
from scara_iso.disk import Disk, SystemDisk

__all__ = [
    "Command", "CycleDone", "Disk", "Done", "Enter", "GaugeSpec", "Gross", "History", "Job",
    "Listen", "Note", "Noted", "Noticed", "Operator", "Pause", "Paused", "Plan", "Problem", "Quit",
    "Refused", "Said", "Started", "Stored", "SystemDisk", "Take", "Timer", "Trigger", "Void",
    "Voided", "Waiting", "as_json", "check_manifest", "check_metadata", "manifest_path",
    "parse_gauges", "parse_metadata", "parse_trigger", "raw_path", "read_history",
    "read_metadata", "rebuild", "record", "refuse_existing",
]  # fmt: skip
