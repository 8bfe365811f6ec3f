"""The robot: its arm, workspace, gears, and what a model of them says that a dial will read.

`read_model` reads a MODEL.toml, `predict` makes the `Run` that the model expects and `simulate` the
one that a dial would have shown. `Arm` and `Workspace` are the geometry, `backlash` the paper's
two inertias in closed form.
"""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
