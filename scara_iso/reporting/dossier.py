"""What is said of a test on paper: everything, in the order in which a laboratory reports it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from scara_iso.diagnosis import Diagnosis
from scara_iso.iso9283 import Analysis, PoseResult, poses_in_cycles
from scara_iso.reporting.analysis import findings, pose_figures, verdict
from scara_iso.reporting.backlash import backlash_report
from scara_iso.reporting.blocks import Block, Report, Section, Strip, Table, Text
from scara_iso.reporting.characteristics import characteristics
from scara_iso.reporting.diagnosis import Failure, diagnosis_report, diagnosis_verdict
from scara_iso.reporting.drift import drift_pictures
from scara_iso.reporting.figures import courses, plane, predictions
from scara_iso.reporting.intermediates import by_cycle, intermediates
from scara_iso.reporting.limits import limits
from scara_iso.reporting.raw_data import raw_data
from scara_iso.reporting.stated import head
from scara_iso.reporting.uncertainty import budget_blocks
from scara_iso.robot import Gearbox


@dataclass(frozen=True, slots=True)
class InputFile:
    """A file that the report was made of, and the SHA-256 of its bytes in hex."""

    role: str
    """What it is to the report: ``table`` or ``model``."""
    name: str
    """As the user named it."""
    sha256: str
    """64 hexadecimal digits."""


@dataclass(frozen=True, slots=True)
class Provenance:
    """How a report came to be, so that it can be made again."""

    files: tuple[InputFile, ...]
    """What it was made of."""
    version: str
    """Of this program."""
    command: str
    """The call that made it."""


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
    gearboxes: Mapping[int, tuple[Gearbox, float | None]] = field(default_factory=dict)


SCOPE = "The results relate only to the item tested (ISO/IEC 17025:2017, 7.8.2.1 l)."


@dataclass(frozen=True, slots=True)
class Document:
    """A report as a file holds it: title and sections, and what they are about, as data."""

    title: str
    sections: Report
    source: Dossier | None = None
    """None where it is not about a whole test."""


def document(dossier: Dossier) -> Document:
    """Return the whole report of a test."""
    robot = dossier.analysis.run.metadata.get("robot", "").strip()
    title = f"ISO 9283 repeatability of {robot or dossier.provenance.files[0].name}"
    return Document(title, _sections(dossier), dossier)


def _sections(dossier: Dossier) -> Report:
    analysis = dossier.analysis
    sections = [
        Section("Result", (*verdict(analysis), *_diagnosed(dossier))),
        Section(
            "Test", (head(analysis.run, analysis.cycles), Text(SCOPE), *_reading_notes(analysis))
        ),
    ]
    separate = any(found.code == "separate-axes" for found in analysis.findings)
    poses = poses_in_cycles(analysis)
    sections += drift_pictures(analysis)
    for pose in poses:
        sections.append(Section(_of(pose, "Repeatability"), tuple(pose_figures(pose))))
        pictures = (*courses(pose), *plane(pose, separate=separate))
        sections.append(Section(_of(pose, "Readings"), pictures))
    sections += [_capital(section) for section in (*characteristics(analysis), *limits(analysis))]
    sections.append(Section("Uncertainty budget", tuple(budget_blocks(analysis))))
    sections += [_capital(section) for section in findings(analysis)]
    for pose in analysis.poses:
        sections += _diagnosis(pose, dossier.diagnoses.get(pose.label))
    for joint, (gearbox, arm) in dossier.gearboxes.items():
        sections += _gear(joint, gearbox, arm, analysis.poses)
    for pose in poses:
        sections.append(Section(_of(pose, "Intermediate values"), tuple(intermediates(pose))))
        sections.append(Section(_of(pose, "Deviations of each cycle"), tuple(by_cycle(pose))))
    sections += [Section(_of(p, "Raw data"), tuple(raw_data(analysis, p))) for p in analysis.poses]
    return (*sections, Section("Provenance", tuple(_provenance(dossier.provenance))))


def _of(pose: PoseResult, heading: str) -> str:
    return heading if pose.label is None else f"{heading} at pose {pose.label}"


def _capital(section: Section) -> Section:
    return replace(section, heading=section.heading[:1].upper() + section.heading[1:])


def _reading_notes(analysis: Analysis) -> Iterator[Block]:
    origin = analysis.run.origin
    if origin.understood:
        yield Text(f"The table was read as {origin.understood}.", "quiet")
    yield from (Text(note, "quiet") for note in origin.notes)


def _diagnosed(dossier: Dossier) -> Iterator[Block]:
    for pose, found in dossier.diagnoses.items():
        where = "Diagnosis" if pose is None else f"Diagnosis at pose {pose}"
        if isinstance(found, Failure):
            yield Text(f"{where}: none, {found.message}", "warn")
        else:
            yield Text(f"{where}: {diagnosis_verdict(found)}")
    if len(dossier.diagnoses) > 1:
        yield Text(
            "Each pose is diagnosed against a constant: a model file describes one pose.", "quiet"
        )


def _diagnosis(pose: PoseResult, found: Diagnosis | Failure | None) -> Iterator[Section]:
    match found:
        case None:
            return
        case Failure():
            yield Section(_of(pose, "Diagnosis"), (Text(found.message, "warn"),))
        case Diagnosis():
            opening, *others = diagnosis_report(found, "")
            blocks = (*opening.blocks[1:], *predictions(found, pose))
            yield Section(_of(pose, "Diagnosis"), blocks)
            for section in others:
                if not all(isinstance(block, Strip) for block in section.blocks):
                    name = f"Diagnosis: {section.heading}"
                    yield Section(_of(pose, name), section.blocks)


def _gear(
    joint: int, gearbox: Gearbox, arm: float | None, poses: Sequence[PoseResult]
) -> Iterator[Section]:
    actual = poses[0] if len(poses) == 1 else None
    opening, *others = backlash_report(gearbox.backlash(arm), actual)
    blocks = list(opening.blocks[1:])
    if arm is not None:
        blocks.append(
            Text(f"Joint to tool: {arm:g} m, the arm stretched, as in the paper.", "quiet")
        )
    yield Section(f"Backlash of joint {joint}", tuple(blocks))
    for section in others:
        name = section.heading and f"Backlash of joint {joint}: {section.heading}"
        yield Section(name, section.blocks)


def _provenance(made: Provenance) -> Iterator[Block]:
    rows = [
        row
        for file in made.files
        for row in ((file.role, file.name), (f"SHA-256 of the {file.role}", file.sha256))
    ]
    rows += [("program", f"scara-iso {made.version}"), ("command", made.command)]
    yield Table(("made from", "by"), tuple(rows), verbatim=True)
