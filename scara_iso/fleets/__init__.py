"""Many robots: parts of tables, worked on by any `concurrent.futures.Executor`, and summed up.

A part is a file with whole tables of some robots. `run_fleet` has each part examined once, whoever
dies on the way; `summarise` says which robots stand out when all are looked at together.
"""

from typing import TYPE_CHECKING

from scara_iso.faces import face

if TYPE_CHECKING:
    from scara_iso.fleets.dispatch import Engine as Engine
    from scara_iso.fleets.drift import (
        DriftPeriod as DriftPeriod,
        FleetDrift as FleetDrift,
        RobotGrowth as RobotGrowth,
    )
    from scara_iso.fleets.figure_summary import (
        FleetFigures as FleetFigures,
        RobotFigures as RobotFigures,
        summarise_figures as summarise_figures,
    )
    from scara_iso.fleets.figures import (
        FiguresTask as FiguresTask,
        run_figures as run_figures,
    )
    from scara_iso.fleets.names import NameAlone as NameAlone, SeveralNames as SeveralNames
    from scara_iso.fleets.parts import ReadAs as ReadAs
    from scara_iso.fleets.published import (
        PublishedFleet as PublishedFleet,
        PublishedFleetFigures as PublishedFleetFigures,
        published_fleet as published_fleet,
        published_fleet_figures as published_fleet_figures,
    )
    from scara_iso.fleets.runs import FleetRun as FleetRun, run_fleet as run_fleet
    from scara_iso.fleets.summary import (
        FailedTable as FailedTable,
        FleetSummary as FleetSummary,
        RobotResult as RobotResult,
        summarise as summarise,
    )
    from scara_iso.fleets.work import (
        PartResult as PartResult,
        TableRow as TableRow,
        Task as Task,
    )
else:
    __getattr__ = face(__name__)
