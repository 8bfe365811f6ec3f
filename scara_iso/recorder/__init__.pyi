from .detection import (
    ECHO as ECHO,
    Detected as Detected,
    FirstReading as FirstReading,
    detect as detect,
    is_echo as is_echo,
    name_dialects as name_dialects,
    read_once as read_once,
)
from .events import (
    Command as Command,
    CycleDone as CycleDone,
    Done as Done,
    Gross as Gross,
    Note as Note,
    Noted as Noted,
    Noticed as Noticed,
    Operator as Operator,
    Pause as Pause,
    Paused as Paused,
    Problem as Problem,
    Quit as Quit,
    Refused as Refused,
    Said as Said,
    Started as Started,
    Stored as Stored,
    Take as Take,
    Unattended as Unattended,
    Void as Void,
    Voided as Voided,
    Waiting as Waiting,
    when_started as when_started,
)
from .indicators import (
    Decoder as Decoder,
    DeviceNotice as DeviceNotice,
    Dialect as Dialect,
    Event as Event,
    Garbage as Garbage,
    InstrumentFault as InstrumentFault,
    Reading as Reading,
    find_dialect as find_dialect,
    find_dialects as find_dialects,
)
from .plan import (
    AUTO as AUTO,
    BENCH_FILE as BENCH_FILE,
    METADATA_KEY as METADATA_KEY,
    GaugeSpec as GaugeSpec,
    Job as Job,
    RecordingPlan as RecordingPlan,
    RememberedBench as RememberedBench,
    RobotLine as RobotLine,
    Settled as Settled,
    Timer as Timer,
    Trigger as Trigger,
    check_metadata as check_metadata,
    parse_gauges as parse_gauges,
    parse_poses as parse_poses,
    parse_trigger as parse_trigger,
    read_bench as read_bench,
    write_bench as write_bench,
)
from .ports import choose_clock as choose_clock, open_port as open_port
from .ports.device import (
    Device as Device,
    list_devices as list_devices,
    refuse_absent as refuse_absent,
)
from .ports.listening import LISTEN as LISTEN, ListeningLine as ListeningLine
from .ports.port import port_kind as port_kind
from .programs import (
    Language as Language,
    ProgramPart as ProgramPart,
    ProgramPlan as ProgramPlan,
    find_language as find_language,
    find_languages as find_languages,
    parse_served as parse_served,
    program_id as program_id,
    write_program as write_program,
)
from .recording import (
    check_files as check_files,
    earlier_of as earlier_of,
    rebuild as rebuild,
    record as record,
)
