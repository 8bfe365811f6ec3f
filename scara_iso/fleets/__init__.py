"""Many robots: parts of tables, worked on by any `concurrent.futures.Executor`, and summed up.

A part is a file with whole tables of some robots. `run_fleet` has each part examined once, whoever
dies on the way; `summarise` says which robots stand out when all are looked at together.
"""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
