"""A whole test as one JSON object: schema ``scara-iso/report/1`` of docs/json.md."""

from __future__ import annotations

from dataclasses import asdict

from scara_iso.diagnosis import published_backlash, published_diagnosis
from scara_iso.errors import UsageError
from scara_iso.measurement_system import GaugeStudy, published_gauge_study
from scara_iso.published import Json, to_json
from scara_iso.render.json import analysis_json, to_text
from scara_iso.reporting import Document, Dossier, Failure, head, uncertainty_budget


def render(document: Document) -> bytes:
    """Return the object as one line; `UsageError` for what is neither a whole test nor a study."""
    match document.source:
        case Dossier():
            found = report_json(document.source)
        case GaugeStudy():
            found = to_json(published_gauge_study(document.source))
        case _:
            raise UsageError(
                f"{document.title}: only a whole test or a study is written as JSON",
                remedy="let the name end in .html, .md or .csv",
            )
    return f"{to_text(found)}\n".encode()


def report_json(dossier: Dossier) -> Json:
    """Return the JSON object of ``report``; its parts are those of the other commands."""
    analysis, made = dossier.analysis, dossier.provenance
    run = analysis.run
    return {
        "schema": "scara-iso/report/1",
        "head": [
            {"field": field, "stated": text} for field, text in head(run, analysis.cycles).rows
        ],
        "analysis": analysis_json(analysis),
        "uncertainty": [asdict(line) for line in uncertainty_budget(analysis)],
        "diagnoses": [
            {"pose": pose, "error": found.message}
            if isinstance(found, Failure)
            else {"pose": pose, **to_json(published_diagnosis(found))}
            for pose, found in dossier.diagnoses.items()
        ],
        "backlash": [
            {"joint": joint, **to_json(published_backlash(gearbox.backlash(arm)))}
            for joint, (gearbox, arm) in dossier.gearboxes.items()
        ],
        "readings": {
            "line": None if run.lines is None else run.lines.tolist(),
            "cycle": run.cycle.tolist(),
            "pose": None if run.pose is None else run.pose.tolist(),
            **({} if run.direction is None else {"approach": run.direction.tolist()}),
            "axes": {name: axis.readings.tolist() for name, axis in run.axes.items()},
            "covariates": {name: values.tolist() for name, values in run.covariates.items()},
        },
        "files": [asdict(file) for file in made.files],
        "restated": [asdict(one) for one in made.restated],
        "amendment": None if dossier.amendment is None else asdict(dossier.amendment),
        "version": made.version,
        "command": made.command,
    }
