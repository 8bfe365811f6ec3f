"""The same loop on the gears: reversals, measured or read from a run, against eq. 16."""

from scara_iso.diagnosis.reversals.from_run import (
    Reversal,
    RunReversals,
    diagnose_run_reversals,
)
from scara_iso.diagnosis.reversals.search import GearDiagnosis, GearFound, diagnose_sweep
from scara_iso.diagnosis.reversals.sweeps import MeasuredSweep, read_sweep

__all__ = [
    "GearDiagnosis",
    "GearFound",
    "MeasuredSweep",
    "Reversal",
    "RunReversals",
    "diagnose_run_reversals",
    "diagnose_sweep",
    "read_sweep",
]
