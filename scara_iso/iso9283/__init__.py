"""The test of ISO 9283: which cycles count, where the poses are, what the readings amount to.

`analyze` turns a `Run` into an `Analysis`; `characteristics` has one file for each clause,
`checks` one for each finding.
"""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
