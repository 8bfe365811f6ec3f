"""The names of the whole, apart: before the program begins it imports nothing."""

from lazy_loader import attach_stub

import scara_iso

__getattr__, __dir__, __all__ = attach_stub("scara_iso", scara_iso.__file__)
