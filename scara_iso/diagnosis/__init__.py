"""Close the loop: what a model leaves unexplained in a run, and which effect it is."""

from scara_iso.diagnosis.bank import UNKNOWN
from scara_iso.diagnosis.design import Alike, Change, Design, Plan, Smallest, design
from scara_iso.diagnosis.gear import GearDiagnosis, GearFound, diagnose_sweep
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
from scara_iso.diagnosis.reversals import Reversal, RunReversals, diagnose_run_reversals

__all__ = [
    "SEED", "UNKNOWN", "Alike", "Change", "Design", "Diagnosis", "Error", "Flag", "Found",
    "GearDiagnosis", "GearFound", "Plan", "Repeatabilities", "Reversal", "Rival", "RunReversals",
    "Series", "Shares", "Smallest", "Verdict", "design", "diagnose", "diagnose_poses",
    "diagnose_run_reversals", "diagnose_sweep", "holm",
]  # fmt: skip
