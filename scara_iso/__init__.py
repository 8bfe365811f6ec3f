"""ISO 9283 repeatability of SCARA robots from digital dial indicators.

    >>> import scara_iso
    >>> run = scara_iso.read_table("examples/fum_scara_table1.csv")
    >>> round(scara_iso.analyze(run).poses[0].axes["X"].RP, 5)
    0.01404

There is one function for each command, with its options as keywords: `analyze`, `analyze_many`,
`diagnose`, `diagnose_many`, `fleet`, `gauge_study`, `compare`, `report`, `simulate`, `plan`,
`plan_separating`, `backlash`, `program`, `record`, `visits`, `push`, `history`, `selftest`.
Where a table is wanted they take a path, a `Run` or a pandas table with its unit. Errors
are `ScaraIsoError`s with what, where and what to do.
"""

from importlib import import_module

from scara_iso.base import faces

TYPE_CHECKING = False  # nothing is imported before the program begins: scara_iso.base.process
if TYPE_CHECKING:
    from scara_iso.base.errors import (
        DataError as DataError,
        ScaraIsoError as ScaraIsoError,
        UsageError as UsageError,
    )
    from scara_iso.commands.analyze import analyze as analyze, analyze_many as analyze_many
    from scara_iso.commands.compare import compare as compare
    from scara_iso.commands.diagnose import diagnose as diagnose
    from scara_iso.commands.diagnose_many import (
        Diagnoses as Diagnoses,
        diagnose_many as diagnose_many,
    )
    from scara_iso.commands.fleet import fleet as fleet, fleet_figures as fleet_figures
    from scara_iso.commands.gauge_study import gauge_study as gauge_study
    from scara_iso.commands.history import history as history
    from scara_iso.commands.plan import plan as plan, plan_separating as plan_separating
    from scara_iso.commands.program import program as program
    from scara_iso.commands.push import push as push
    from scara_iso.commands.record import record as record
    from scara_iso.commands.report import TestReport as TestReport, report as report
    from scara_iso.commands.selftest import selftest as selftest
    from scara_iso.commands.simulate import simulate as simulate
    from scara_iso.commands.visits import visits as visits
    from scara_iso.comparison import Comparison as Comparison
    from scara_iso.diagnosis import Diagnosis as Diagnosis
    from scara_iso.fleets import FleetFigures as FleetFigures, FleetSummary as FleetSummary
    from scara_iso.gauge import GaugeStudy as GaugeStudy
    from scara_iso.iso9283 import (
        Analysis as Analysis,
        AxisResult as AxisResult,
        Finding as Finding,
        PosePlan as PosePlan,
        PoseResult as PoseResult,
        RadialResult as RadialResult,
    )
    from scara_iso.robot import Backlash as Backlash, Crossing as Crossing, backlash as backlash
    from scara_iso.run import Axis as Axis, Run as Run
    from scara_iso.tables import read_table as read_table, write_table as write_table
else:
    __getattr__ = faces.face(__name__)

faces.notebook = lambda: import_module("scara_iso.commands.notebook")

__version__ = "1.0.0"


def __dir__() -> list[str]:
    return [*faces.face(__name__)("__all__"), "__version__"]
