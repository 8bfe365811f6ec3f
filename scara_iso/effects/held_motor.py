"""The motor is held: I_m to infinity in eq. 16, the load crosses the whole gap."""

from scara_iso.effects._effect import GearEffect, Sizes, Sweep
from scara_iso.run import FloatArray


def _deviation(sweep: Sweep, _: Sizes) -> FloatArray:
    return -sweep.gap


def _candidates(_: Sweep) -> tuple[Sizes, ...]:
    return ({},)


EFFECT = GearEffect(
    name="held_motor",
    parameters=(),
    cause="servo or brake holds the motor while the load is pushed across the whole gap",
    confirm_by="measure with the servo on and off",
    deviation=_deviation,
    candidates=_candidates,
)
