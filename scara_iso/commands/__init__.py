"""One module a command: the public function, and the options and screen of the same command.

The functions are the face of `scara_iso` itself, which finds them in these modules: a package that
showed `analyze` beside its module `analyze` would lose one to the other. Here stand the program
and what else of the commands is of use outside.
"""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
