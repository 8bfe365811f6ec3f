"""The dial's own division: readings are rounded to it.

Its share of the variance is known and not searched: resolution^2 / 12 (GUM F.2.2.1). What is added
are rounding errors as they are beside scatter wider than a third of a division.
"""

from numpy.random import Generator

from scara_iso.effects import Parameter, RandomCourse
from scara_iso.run import FloatArray


def _uniform(rng: Generator, n: int) -> FloatArray:
    return rng.uniform(-0.5, 0.5, size=n)


EFFECT = RandomCourse(
    name="resolution",
    parameters=(
        Parameter("division", "d", "reading", "smallest difference that is shown", above=0),
    ),
    cause="the indicator's division is too coarse for this robot's scatter",
    confirm_by="measure with a finer indicator",
    common=False,
    innovations=_uniform,
)
