from .base.errors import (
    DataError as DataError,
    ScaraIsoError as ScaraIsoError,
    UsageError as UsageError,
)
from .commands.analyze import analyze as analyze, analyze_many as analyze_many
from .commands.compare import compare as compare
from .commands.diagnose import diagnose as diagnose
from .commands.diagnose_many import (
    Diagnoses as Diagnoses,
    diagnose_many as diagnose_many,
)
from .commands.fleet import fleet as fleet, fleet_figures as fleet_figures
from .commands.gauge_study import gauge_study as gauge_study
from .commands.history import history as history
from .commands.plan import plan as plan, plan_separating as plan_separating
from .commands.program import program as program
from .commands.push import push as push
from .commands.record import record as record
from .commands.report import TestReport as TestReport, report as report
from .commands.selftest import selftest as selftest
from .commands.simulate import simulate as simulate
from .commands.visits import visits as visits
from .comparison import Comparison as Comparison
from .diagnosis import Diagnosis as Diagnosis
from .fleets import FleetFigures as FleetFigures, FleetSummary as FleetSummary
from .gauge import GaugeStudy as GaugeStudy
from .iso9283 import (
    Analysis as Analysis,
    AxisResult as AxisResult,
    Finding as Finding,
    PosePlan as PosePlan,
    PoseResult as PoseResult,
    RadialResult as RadialResult,
)
from .robot import Backlash as Backlash, Crossing as Crossing, backlash as backlash
from .run import Axis as Axis, Run as Run
from .tables import read_table as read_table, write_table as write_table

__version__: str
