"""Close the loop: what a model leaves unexplained in a run, and which effect it is."""

from scara_iso.diagnosis.bank import UNKNOWN
from scara_iso.diagnosis.loop import SEED, diagnose
from scara_iso.diagnosis.poses import diagnose_poses, holm
from scara_iso.diagnosis.result import (
    Diagnosis,
    Error,
    Flag,
    Found,
    Repeatabilities,
    Rival,
    Series,
    Shares,
    Verdict,
)

__all__ = [
    "SEED", "UNKNOWN", "Diagnosis", "Error", "Flag", "Found", "Repeatabilities", "Rival",
    "Series", "Shares", "Verdict", "diagnose", "diagnose_poses", "holm",
]  # fmt: skip
