"""The page and the picture of every result of the public functions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from html import escape
from typing import TYPE_CHECKING, Any

from scara_iso.commands.diagnose_many import Diagnoses
from scara_iso.commands.report import TestReport
from scara_iso.comparison import Comparison, RobotHistory
from scara_iso.diagnosis import Diagnosis, DiagnosisOfPoses, SeparatingPlan
from scara_iso.fleets import FleetFigures, FleetSummary
from scara_iso.gauge import GaugeStudy
from scara_iso.iso9283 import Analysis, PosePlan, PushResult, StreamVisits
from scara_iso.render import (
    find_format,
    plot_comparison,
    plot_diagnosis,
    plot_gauge_study,
    plot_plan,
    plot_poses,
    plot_separating,
)
from scara_iso.reporting import (
    Document,
    Report,
    Validation,
    analysis_report,
    backlash_report,
    comparison_report,
    diagnosis_report,
    document,
    fleet_figures_report,
    fleet_report,
    gauge_study_report,
    history_report,
    plan_report,
    poses_report,
    push_report,
    readings_report,
    separating_report,
    summary_report,
    validation_report,
    visits_report,
)
from scara_iso.robot import Backlash
from scara_iso.run import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_PAGES: Mapping[type, tuple[str, Callable[[Any], Report]]] = {
    Analysis: ("Repeatability by ISO 9283", analysis_report),
    Backlash: ("Backlash", backlash_report),
    Comparison: ("Comparison", comparison_report),
    Diagnoses: ("Diagnoses", lambda found: summary_report(found.names, found.found)),
    Diagnosis: ("Diagnosis", diagnosis_report),
    DiagnosisOfPoses: ("Diagnosis of several poses", poses_report),
    FleetFigures: ("Figures of a fleet", fleet_figures_report),
    FleetSummary: ("Fleet", fleet_report),
    GaugeStudy: ("Gauge study", gauge_study_report),
    PosePlan: ("Plan of the test", plan_report),
    PushResult: ("Push test", push_report),
    RobotHistory: ("Months of a robot", history_report),
    Run: ("Readings", readings_report),
    SeparatingPlan: ("Poses that tell the joints apart", separating_report),
    StreamVisits: ("Visits of a stream", visits_report),
    Validation: ("Validation", validation_report),
}
_PICTURES: Mapping[type, Callable[[Any], Figure]] = {
    Comparison: plot_comparison,
    Diagnosis: plot_diagnosis,
    DiagnosisOfPoses: plot_poses,
    GaugeStudy: plot_gauge_study,
    PosePlan: plot_plan,
    SeparatingPlan: plot_separating,
}


def page(result: object) -> str:
    """Return a result as a page, in a frame: its style and its policy stay its own."""
    if isinstance(result, TestReport):
        shown = document(result.dossier)
    else:
        title, report = _PAGES[type(result)]
        shown = Document(title, report(result))
    text = escape(find_format("page", ".html")(shown).decode())
    return f'<iframe sandbox srcdoc="{text}" style="width:100%;height:45em;border:0"></iframe>'


def figure(result: object) -> Figure:
    """Return the figure of a result that has one."""
    return _PICTURES[type(result)](result)
