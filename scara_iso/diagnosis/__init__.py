"""Close the loop: what a model leaves unexplained in a run, and which effect it is.

`close_the_loop` gives table and model to `diagnose`; `gears` is the same loop on eq. 16.

Every level, prior and threshold stands where it is used, with what chose it. One table of
``benchmarks/diagnosis.py`` is meant where only a table is named; its figures stand in
benchmarks/results/diagnosis.md, section 8, those of ``benchmarks/gear.py`` in section 5. The
weights of single effects, chosen on the tables *naming* (prior) and *power* (test), stand in their
files.
"""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
