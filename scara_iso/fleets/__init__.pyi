from .drift import FleetDrift as FleetDrift, RobotGrowth as RobotGrowth
from .engines import (
    LOCAL as LOCAL,
    Engine as Engine,
    cores as cores,
    engine_of as engine_of,
    open_processes as open_processes,
)
from .figures import run_figures as run_figures
from .parts import ReadAs as ReadAs
from .runs import (
    Figure as Figure,
    FleetRun as FleetRun,
    Task as Task,
    Track as Track,
)
from .screening import run_fleet as run_fleet
from .summary import (
    FleetFigures as FleetFigures,
    FleetSummary as FleetSummary,
    NameAlone as NameAlone,
    NamesAndNumbers as NamesAndNumbers,
    RobotFigures as RobotFigures,
    RobotResult as RobotResult,
    summarise as summarise,
    summarise_figures as summarise_figures,
)
