"""Which of several tables were read in another unit than the first."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from scara_iso.run import Run


def converted(runs: Mapping[str, Run]) -> Iterator[tuple[str, str]]:
    """Yield the name of each run in another unit, and what is said of it.

    All are in mm or degrees by now.
    """
    first, run = next(iter(runs.items()))
    for axis, unit in run.origin.units.items():
        for name, one in runs.items():
            other = one.origin.units.get(axis, unit)
            if other != unit:
                base = run.axes[axis].unit
                both = f"{axis} in {other}, and in {unit} in {first}"
                yield name, f"{name}: {both}; all is converted to {base}"
