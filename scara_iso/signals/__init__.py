"""What is read of a sensor: samples in time to visits, and forces to and fro to play and spring.

`find_visits` takes a `Run` with a row for each sample and gives one with a row for each visit: rest
is distinguished from motion by a stated rule, and doubts are listed. `read_loop` takes the table of
a push test, `fit_loop` estimates compliance, play and friction.
"""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
