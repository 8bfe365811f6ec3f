"""The names of the whole, apart: before the program begins it imports nothing."""

from pathlib import Path

from lazy_loader import attach_stub

_STUB = Path(__file__).with_name("__init__.pyi")
__getattr__, __dir__, __all__ = attach_stub("scara_iso", str(_STUB))
