"""Many robots: parts of tables, worked on by any `concurrent.futures.Executor`, and summed up.

A part is a file with whole tables of some robots. `run_fleet` has each part examined once, whoever
dies on the way; `summarise` says which robots stand out when all are looked at together.
"""

from typing import TYPE_CHECKING

from scara_iso.base.faces import face

if TYPE_CHECKING:
    from scara_iso.fleets.drift import FleetDrift as FleetDrift, RobotGrowth as RobotGrowth
    from scara_iso.fleets.engines import (
        LOCAL as LOCAL,
        Engine as Engine,
        cores as cores,
        engine_of as engine_of,
        open_processes as open_processes,
    )
    from scara_iso.fleets.figures import run_figures as run_figures
    from scara_iso.fleets.parts import ReadAs as ReadAs
    from scara_iso.fleets.runs import (
        Figure as Figure,
        FleetRun as FleetRun,
        Task as Task,
        Track as Track,
    )
    from scara_iso.fleets.screening import run_fleet as run_fleet
    from scara_iso.fleets.summary import (
        FleetFigures as FleetFigures,
        FleetSummary as FleetSummary,
        NameAlone as NameAlone,
        NamesAndNumbers as NamesAndNumbers,
        RobotFigures as RobotFigures,
        RobotResult as RobotResult,
        summarise as summarise,
        summarise_figures as summarise_figures,
    )
else:
    __getattr__ = face(__name__)
