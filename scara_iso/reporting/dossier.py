"""The test report on paper: page 1 decides, figures and diagnosis follow, then all else.

The tests beside the poses in a report: what of them is on page 1, and what follows it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from scara_iso.diagnosis import Diagnosis
from scara_iso.gauge import GaugeStudy
from scara_iso.iso9283 import Analysis, Beside, Characteristic, PushResult, not_measured
from scara_iso.reporting.analysis import findings
from scara_iso.reporting.appendix import appendix, raw_data
from scara_iso.reporting.blocks import (
    Block,
    Chart,
    Curve,
    Figure,
    Number,
    Report,
    Section,
    Table,
    Text,
    page_sections,
)
from scara_iso.reporting.drift import drift_pictures, largest_of
from scara_iso.reporting.figures import courses, planes, predictions
from scara_iso.reporting.front import Amendment, front_page
from scara_iso.reporting.named_effects import Failure, interpretation
from scara_iso.reporting.push import BOUGHT_BY, push_report
from scara_iso.reporting.result_table import ResultPart
from scara_iso.reporting.stated import (
    InputFile,
    Provenance,
    conditions,
    not_stated,
    provenance,
    remarks,
    stated_field,
)
from scara_iso.reporting.uncertainty import budget_blocks
from scara_iso.robot import Gearbox


def in_short(beside: Beside) -> tuple[Characteristic, ...]:
    """Return what belongs on page 1: what is held against a limit, and the figures of the whole."""
    drift = [] if beside.drift is None else list(beside.drift.characteristics)
    shown = [largest_of(drift, code) for code in dict.fromkeys(one.code for one in drift)]
    pushed = [one for one in beside.characteristics if one not in drift]
    of_joints = any(not one.of.endswith("reading") for one in pushed)
    shown += [
        one
        for one in pushed
        if one.code in BOUGHT_BY and not (of_joints and one.of.endswith("reading"))
    ]
    return tuple(one for one in beside.characteristics if one in shown or one.limit is not None)


def beside_sections(beside: Beside) -> Iterator[Section]:
    """Yield the course of the drift test, and what each push test came to."""
    if beside.drift is not None:
        yield from drift_pictures(beside.drift)
    for name, found in beside.pushes.items():
        blocks = tuple(block for section in push_report(found) for block in section.blocks)
        yield Section(_titled("Push test", name), (*blocks, _picture(found)))


def _picture(found: PushResult) -> Figure:
    """Return the picture of the loops: what the dial showed over the force."""
    loop = found.loop
    curve = Curve("readings, in their order", loop.force, loop.reading)
    chart = Chart("force [N]", "mm", (curve,), {})
    return Figure(chart, "Loops of the push test", "the width at no force is the hysteresis")


def beside_readings(beside: Beside) -> Iterator[Section]:
    """Yield the conditions and every reading of these tests."""
    if (drift := beside.drift) is not None:
        held = tuple(facts for facts in conditions(drift.run, drift.cycles) if facts.rows)
        yield Section("Conditions of the drift test", held)
        for pose in drift.poses:
            yield Section("Raw data of the drift test", tuple(raw_data(drift, pose)))
    for name, found in beside.pushes.items():
        yield Section(_titled("Raw data of the push test", name), (_steps(found),))


def _titled(title: str, name: str) -> str:
    joint = name.partition("-")[2]
    return f"{title} of {joint}" if joint else title


def _steps(found: PushResult) -> Table:
    loop = found.loop
    pairs = zip(loop.force.tolist(), loop.reading.tolist(), strict=True)
    rows = tuple(
        (Number(k), Number(force, ".12g"), Number(reading, ".12g"))
        for k, (force, reading) in enumerate(pairs, 1)
    )
    return Table(("step", "force [N]", "reading [mm]"), rows)


@dataclass(frozen=True, slots=True)
class Dossier:
    """Everything that is known of a test, to be reported.

    ``diagnoses`` by pose; ``gearboxes`` by the number of the joint, with the distance from the
    joint to the tool [m] where the model gives it.
    """

    analysis: Analysis
    """Figures and findings."""
    provenance: Provenance
    """What the report was made of, and by which command."""
    diagnoses: Mapping[str | None, Diagnosis | Failure] = field(default_factory=dict)
    """By pose."""
    gearboxes: Mapping[int, tuple[Gearbox, float | None]] = field(default_factory=dict)
    """By the number of the joint, with the reach from it to the tool [m] where it is known."""
    amendment: Amendment | None = None
    """Which report it replaces."""
    parts: tuple[ResultPart, ...] = ()
    """The results by condition, where there are several; a pose is then called by its part."""
    beside: Beside = field(default_factory=Beside)
    """The tests beside the poses; their figures and findings are in `analysis` too."""

    def with_beside(self, beside: Beside, files: Sequence[InputFile] = ()) -> Dossier:
        """Return it with the tests beside the poses, read from ``files`` more."""
        if not beside:
            return self
        labels = [pose.label for pose in self.analysis.poses]
        parts = self.parts or (ResultPart(self.analysis.characteristics, labels),)
        read = replace(self.provenance, files=(*self.provenance.files, *files))
        return replace(
            self,
            analysis=beside.added_to(self.analysis),
            provenance=read,
            parts=(*parts, ResultPart(in_short(beside), ())),
            beside=beside,
        )


@dataclass(frozen=True, slots=True)
class Document:
    """A report as a file holds it: title and sections, and what they are about, as data.

    ``title`` identifies the report on every page; ``simulated`` is to be seen across each of them.
    """

    title: str
    sections: Report
    source: Dossier | GaugeStudy | None = None
    """None where it is about neither a whole test nor a gauge study."""
    simulated: bool = False
    """Whether the readings are of no dial."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "sections", page_sections(self.sections))


def document(dossier: Dossier) -> Document:
    """Return the whole report of a test."""
    run = dossier.analysis.run
    title = _title(dossier)
    sections = (*_sections(dossier), Section("", (Text(f"End of {title}", "quiet"),)))
    simulated = bool(run.metadata.get("simulated")) or dossier.beside.simulated
    return Document(title, sections, dossier, simulated=simulated)


def _title(dossier: Dossier) -> str:
    """Return the number of the report, or what identifies it in its place."""
    number = stated_field(dossier.analysis.run, "report number")
    readings = dossier.provenance.files[0].sha256[:8]
    return f"Test report {number}" if number else f"Test report of the readings {readings}"


def _sections(dossier: Dossier) -> Iterator[Section]:
    analysis, found = dossier.analysis, dossier.diagnoses
    yield Section("", tuple(front_page(analysis, found, dossier.amendment, dossier.parts)))
    if analysis.block is None:
        yield Section("Figures", (*planes(analysis), *courses(analysis)), new_page=True)
    yield from drift_pictures(analysis)
    yield from beside_sections(dossier.beside)
    if found:
        diagnosed = {pose: d for pose, d in found.items() if isinstance(d, Diagnosis)}
        pictures = predictions(diagnosed, analysis.poses)
        said = (*interpretation(found), *pictures)
        yield Section("Diagnosis: opinions and interpretations", said)
    held = tuple(facts for facts in conditions(analysis.run, analysis.cycles) if facts.rows)
    lacking = [
        Text(f"Not stated: {', '.join(names)}", "quiet")
        for names in (not_stated(analysis.run),)
        if names
    ]
    yield Section("Conditions and instruments", (*held, *lacking, *_struck(analysis)))
    yield Section("Uncertainty budget", tuple(budget_blocks(analysis)))
    every = [
        *(_capital(section) for section in findings(analysis, advice=False)),
        *appendix(analysis, found, dossier.gearboxes),
        *beside_readings(dossier.beside),
        Section("Not measured, by clause of ISO 9283:1998", (Text(_not_measured(analysis)),)),
        Section("Provenance", tuple(provenance(dossier.provenance, analysis.run.origin))),
    ]
    first = replace(every[0], heading=f"Appendix: {every[0].heading}", new_page=True)
    yield from (first, *every[1:])


def _not_measured(analysis: Analysis) -> str:
    of_the_standard = [one for one in not_measured(analysis) if one.clause[0].isdigit()]
    found = sorted(of_the_standard, key=lambda one: [*map(int, re.findall(r"\d+", one.clause))])
    return "; ".join(f"{one.clause} {one.name}" for one in found) + "."


def _capital(section: Section) -> Section:
    return replace(section, heading=section.heading[:1].upper() + section.heading[1:])


def _struck(analysis: Analysis) -> Iterator[Block]:
    """Yield what the recording says was struck, with its reasons, and its other remarks."""
    said = remarks(analysis.run)
    struck = [text for kind, text in said if kind == "struck"]
    if struck:
        yield Text("Readings that were struck and taken again:", "strong")
        yield from map(Text, struck)
    others = [f"{kind}: {text}" for kind, text in said if kind != "struck"]
    if others:
        yield Text("Remarks of the recording:", "strong")
        yield from map(Text, others)
