"""From bytes to a table: what instruments say, the lines they say it on, the recorder.

`indicators` turns bytes into events without a port, `ports` opens lines, `recorder` joins both with
a disk so that no announced reading is lost.
"""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
