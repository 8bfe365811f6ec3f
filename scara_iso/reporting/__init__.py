"""The report on a result, decided once; `render` decides how it looks.

A report is sections of blocks: text, tables, strips and notices. A number keeps all
its digits and carries how many of them are worth showing; who shows it rounds.
"""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
