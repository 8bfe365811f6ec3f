"""What a recording left: its raw file, the readings in it, and whether any of it was changed.

`read_history` reads a raw file, `check_manifest` compares table and raw file with their manifest.
"""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
