"""The one type that all rooms share: readings by cycle and axis, what else a row tells, their dial.

A recording, a table and a model give the same `Run`.
"""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
