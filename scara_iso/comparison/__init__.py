"""Two runs of one robot, and more: what differs by more than chance and the dial explain."""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
