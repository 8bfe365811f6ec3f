"""The page and the picture of every result of the public functions."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from scara_iso import render, reporting
from scara_iso.commands.diagnose_many import Diagnoses
from scara_iso.commands.report import TestReport
from scara_iso.comparison import Comparison, RobotHistory
from scara_iso.diagnosis import Diagnosis, DiagnosisOfPoses, SeparatingPlan
from scara_iso.fleets import FleetFigures, FleetSummary
from scara_iso.gauge import GaugeStudy
from scara_iso.iso9283 import Analysis, PosePlan, PushResult, StreamVisits
from scara_iso.robot import Backlash
from scara_iso.run import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_PAGES: Mapping[type, tuple[str, Callable[[Any], reporting.Report]]] = {
    Analysis: ("Repeatability by ISO 9283", reporting.analysis_report),
    Backlash: ("Backlash", reporting.backlash_report),
    Comparison: ("Comparison", reporting.comparison_report),
    Diagnoses: ("Diagnoses", lambda found: reporting.summary_report(found.names, found.found)),
    Diagnosis: ("Diagnosis", reporting.diagnosis_report),
    DiagnosisOfPoses: ("Diagnosis of several poses", reporting.poses_report),
    FleetFigures: ("Figures of a fleet", reporting.fleet_figures_report),
    FleetSummary: ("Fleet", reporting.fleet_report),
    GaugeStudy: ("Gauge study", reporting.gauge_study_report),
    PosePlan: ("Plan of the test", reporting.plan_report),
    PushResult: ("Push test", reporting.push_report),
    RobotHistory: ("Months of a robot", reporting.history_report),
    Run: ("Readings", reporting.readings_report),
    SeparatingPlan: ("Poses that tell the joints apart", reporting.separating_report),
    StreamVisits: ("Visits of a stream", reporting.visits_report),
    reporting.Validation: ("Validation", reporting.validation_report),
}
_PICTURES: Mapping[type, Callable[[Any], Figure]] = {
    Comparison: lambda found: render.plot(reporting.comparison_pictures(found)),
    Diagnosis: lambda found: render.plot(reporting.diagnosis_pictures(found)),
    DiagnosisOfPoses: lambda found: render.plot(reporting.diagnosis_pictures(found)),
    GaugeStudy: lambda found: render.plot(map(reporting.study_picture, found.axes.values())),
    PosePlan: render.plot_plan,
    SeparatingPlan: render.plot_separating,
}


def page(result: object) -> str:
    """Return a result as a part of the page that shows it, in whose style its tables are.

    Nothing of a file in it is markup. The headings stand below those of a notebook.
    """
    if isinstance(result, TestReport):
        shown = reporting.document(result.dossier)
    else:
        title, report = _PAGES[type(result)]
        shown = reporting.Document(title, report(result))
    text = render.find_format("page", ".html")(shown).decode()
    body = text[text.index("<main>") : text.rindex("</main>")] + "</main>"
    return re.sub(r"<(/?)h([1-3])>", lambda tag: f"<{tag[1]}h{int(tag[2]) + 2}>", body)


def figure(result: object) -> Figure:
    """Return the figure of a result that has one."""
    return _PICTURES[type(result)](result)
