"""A recorder that is killed in the middle, and what of its readings is there afterwards.

``python -m scara_iso.library.killed TABLE`` records a simulated dial and says each reading that is
safely stored; `recorder_checks` kills it and reads what it left.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

from scara_iso.base.trust import of_a_child
from scara_iso.library.recordings import record
from scara_iso.rawfile import raw_path, read_history
from scara_iso.recorder import Said, Stored
from scara_iso.validation import ReferenceCheck

_GAUGE = "X=opto-rs232@sim:?pace=1"
_TRIGGER = "timer:0.1"
_CYCLES = 31
_KILLED_AFTER = 7
_SOURCE = "docs/appendix/durability.md: no announced reading is lost"


def recorder_checks() -> Iterator[ReferenceCheck]:
    """Yield whether a killed recording holds what it announced, and can be gone on with."""
    with TemporaryDirectory(prefix="scara-iso-", ignore_cleanup_errors=True) as folder:
        table = Path(folder) / "run.csv"
        announced = _killed(table)
        history = read_history(raw_path(table))
        run = record(table, [_GAUGE.replace("pace=1", "pace=0")], trigger=_TRIGGER, resume=True)
    in_table = dict(zip(run.cycle.tolist(), run.axes["X"].readings.tolist(), strict=True))
    in_raw_file = history.readings().get("X", {})
    for name, expected, obtained in (
        ("announced readings in the raw file", _said(announced), _said(announced, in_raw_file)),
        ("announced readings in the table", _said(announced), _said(announced, in_table)),
        ("faults of the raw file", "none", "; ".join(map(str, history.faults)) or "none"),
        ("cycles after going on", _cycles(range(1, _CYCLES + 1)), _cycles(in_table)),
    ):
        yield ReferenceCheck("recorder", name, _SOURCE, expected, obtained)


def _said(announced: Mapping[int, float], found: Mapping[int, float] | None = None) -> str:
    """Return the announced readings as they are found; None: as they were announced."""
    where = announced if found is None else found
    each = (f"{c}: {f'{where[c]:.6f}' if c in where else 'lost'}" for c in announced)
    return "; ".join(f"cycle {one}" for one in each)


def _cycles(numbers: Iterable[int]) -> str:
    return ", ".join(map(str, numbers))


def _killed(table: Path) -> dict[int, float]:
    """Return the readings, by cycle, that a recorder announced before it was killed."""
    words = [sys.executable, "-P", "-m", __name__, str(table)]
    with subprocess.Popen(  # noqa: S603 - ourselves
        words, stdout=subprocess.PIPE, text=True, env=of_a_child()
    ) as child:
        assert child.stdout is not None  # noqa: S101 - a pipe was asked for
        lines = [child.stdout.readline() for _ in range(_KILLED_AFTER)]
        child.kill()
        lines += child.stdout.readlines()
    told = [line.split() for line in lines if line.endswith("\n")]
    return {int(cycle): float(value) for cycle, value in told}


def _announce(said: Said) -> None:
    if isinstance(said, Stored):
        sys.stdout.write(f"{said.cycle} {said.value:.6f}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    record(sys.argv[1], [_GAUGE], trigger=_TRIGGER, cycles=_CYCLES, tell=_announce)
