"""What a report holds for who checks it: every figure, every step to it, every reading."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from scara_iso.diagnosis import Diagnosis
from scara_iso.iso9283 import Analysis, PoseResult, poses_in_cycles
from scara_iso.reporting.analysis import pose_figures
from scara_iso.reporting.backlash import backlash_report
from scara_iso.reporting.blocks import Section, Strip, Text
from scara_iso.reporting.characteristics import characteristics
from scara_iso.reporting.diagnosis import Failure, diagnosis_report
from scara_iso.reporting.intermediates import by_cycle, intermediates
from scara_iso.reporting.limits import limits
from scara_iso.reporting.raw_data import raw_data
from scara_iso.robot import Gearbox


def appendix(
    analysis: Analysis,
    diagnoses: Mapping[str | None, Diagnosis | Failure],
    gearboxes: Mapping[int, tuple[Gearbox, float | None]],
) -> Iterator[Section]:
    """Yield figures, limits, diagnosis, backlash, intermediate values and readings of a test."""
    poses = poses_in_cycles(analysis)
    for pose in poses:
        yield Section(_of(pose, "Repeatability"), tuple(pose_figures(pose)))
    for section in (*characteristics(analysis, advice=False), *limits(analysis)):
        yield replace(section, heading=section.heading.capitalize())
    for pose in poses:
        yield from _diagnosis(pose, diagnoses.get(pose.label))
    for joint, (gearbox, arm) in gearboxes.items():
        yield from _gear(joint, gearbox, arm, poses)
    for pose in poses:
        yield Section(_of(pose, "Intermediate values"), tuple(intermediates(pose)))
        yield Section(_of(pose, "Deviations of each cycle"), tuple(by_cycle(pose)))
    for pose in analysis.poses:
        yield Section(_of(pose, "Raw data"), tuple(raw_data(analysis, pose)))


def _of(pose: PoseResult, heading: str) -> str:
    return heading if pose.label is None else f"{heading} at pose {pose.label}"


def _diagnosis(pose: PoseResult, found: Diagnosis | Failure | None) -> Iterator[Section]:
    """Yield the figures of a diagnosis; its words stand before."""
    if isinstance(found, Diagnosis):
        for section in diagnosis_report(found, "")[1:]:
            if not all(isinstance(block, Strip) for block in section.blocks):
                yield Section(_of(pose, f"Diagnosis: {section.heading}"), section.blocks)


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
