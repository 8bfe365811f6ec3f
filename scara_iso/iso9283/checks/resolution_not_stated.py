"""The indicator's resolution is not stated.

Without it the dial's share of the figure is unknown. Where all readings lie on equal steps, the
step is taken for the interval of RP. State it in the head of the table: ``# resolution: 0.001``, in
the table's unit.
"""

from scara_iso.base.quantities import MILLIMETRE, parse_unit
from scara_iso.iso9283.core.results import Finding, Findings, Measured
from scara_iso.run import Run, common_step

CODE = "resolution-not-stated"
BRIEF = "resolution not stated"
_USUAL = {"mm": "0.001", "um": "1", "inch": "0.0001", "deg": "0.01"}
"""What dials step by, in the unit of their readings."""


def check(measured: Measured) -> Findings:
    """Yield a warning for each axis without a resolution, with the step its readings show."""
    how = _example(measured.run)
    for axis in measured.run.axes.values():
        if axis.resolution is None:
            step = common_step(axis.readings)
            taken = f"; its readings lie on steps of {step:.4g} {axis.unit}, taken as the dial's"
            what = f"the resolution is not stated{taken if step else ''}"
            advice = "state it: interval and verdict rest on it"
            yield Finding(CODE, "warning", what, axis.name, advice=advice, in_short=how)


def _example(run: Run) -> str:
    """Return how it is stated of this table: the option is one size, in the unit of the lengths."""
    every = {name: run.origin.units.get(name, axis.unit) for name, axis in run.axes.items()}
    lengths = [name for name, axis in run.axes.items() if axis.unit == MILLIMETRE.name]
    units = {every[name] for name in lengths or every}
    steps = [step for name in lengths or every if (step := common_step(run.axes[name].readings))]
    if len(units) > 1 or not units <= _USUAL.keys():
        base = run.axes[(lengths or [*every])[0]].unit
        return f"state it in its head, as '# resolution: {min(steps, default=0.001):.4g} {base}'"
    (unit,) = units
    size = f"{min(steps) / parse_unit(unit).to_base(1.0):.4g}" if steps else _USUAL[unit]
    return f"state it, as `resolution={size}`"
