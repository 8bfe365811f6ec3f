"""Close the loop: what a model leaves unexplained in a run, and which effect it is."""

from scara_iso.diagnosis.design import Alike, Change, Design, Plan, Smallest, design
from scara_iso.diagnosis.loop import diagnose
from scara_iso.diagnosis.poses import diagnose_poses, holm
from scara_iso.diagnosis.result import (
    Diagnosis,
    Error,
    Flag,
    Found,
    Repeatabilities,
    Series,
    Shares,
)
from scara_iso.diagnosis.tuning import LEVEL, SEED, UNKNOWN
from scara_iso.verdict import Rival, Verdict

__all__ = [
    "LEVEL", "SEED", "UNKNOWN", "Alike", "Change", "Design", "Diagnosis", "Error", "Flag", "Found",
    "Plan", "Repeatabilities", "Rival", "Series", "Shares", "Smallest", "Verdict", "design",
    "diagnose", "diagnose_poses", "holm",
]  # fmt: skip
