"""A technician's file to a `Run` and back.

`read_table` takes what is really sent (interface: "Table of readings") and gives the same numbers
or a `DataError` with every fault: never a number in silence that could be another. `write_table`
gives the canonical form.
"""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
