"""How a result looks: terminal, HTML, JSON, plots. What is said of it is decided elsewhere."""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
