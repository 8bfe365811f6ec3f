"""A robot, its gears, pose, indicators and declared effects: what the readings should be.

`read_model` reads a MODEL.toml, `predict` makes the `Run` that the model expects, `simulate` the
`Run` that a dial would have shown, and `declare` writes a found effect into the file.
"""

from scara_iso.robot.model.file import declare, read_model
from scara_iso.robot.model.own import read_effects
from scara_iso.robot.model.parts import DeclaredEffect, Gearbox, Indicator, Model, Rated
from scara_iso.robot.model.predict import predict
from scara_iso.robot.model.simulate import simulate

__all__ = [
    "DeclaredEffect",
    "Gearbox",
    "Indicator",
    "Model",
    "Rated",
    "declare",
    "predict",
    "read_effects",
    "read_model",
    "simulate",
]
