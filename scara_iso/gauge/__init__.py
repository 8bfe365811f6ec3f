"""Is the dial good enough: studies of a measuring system by AIAG's MSA manual and by VDA 5.

`read_gauge_tables` takes the tables of a study, `study_gauge` says which kind of study they are
and gives its figures, each with an interval, and what a tolerance makes of them.
"""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
