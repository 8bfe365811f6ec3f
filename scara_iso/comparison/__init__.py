"""Two runs of one robot, and more: what differs by more than chance and the dial explain."""

from scara_iso.comparison.compare import SEED, compare
from scara_iso.comparison.result import Comparison, Contrast, Pair, Verdict

__all__ = ["SEED", "Comparison", "Contrast", "Pair", "Verdict", "compare"]
