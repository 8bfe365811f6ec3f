"""The whole test as a folder: test.toml says what is measured, its recordings are the parts.

`read_folder` says how far each part is, `assign` which comes next, `run_under` makes one `Run` of
the parts of a condition.
"""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
