"""A part's table with what test.toml states beside it; what the table says itself holds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from scara_iso.acceptance.stated import NOT_STATED, command_of, metadata_of, other_instruments
from scara_iso.acceptance.whole_test import Part, WholeTest
from scara_iso.errors import DataError, Fault
from scara_iso.iso9283 import DRIFT_CODES
from scara_iso.run import Axis, Run
from scara_iso.tables import corrected, is_of_corrections


def completed(run: Run, part: Part, test: WholeTest) -> Run:
    """Return the run of a part, with the lines and sizes of the test that its table lacks."""
    of_test = metadata_of(part, test, run.axes)
    own = {key: text for key, text in run.metadata.items() if text.strip() != NOT_STATED}
    done = {f"_{name}" for name, axis in run.axes.items() if axis.displayed is not None}
    lines = {
        key: text
        for key, text in of_test.items()
        if not key.startswith(("command_", "indicator_unc"))
        and not (is_of_corrections(key) and key.endswith(tuple(done)))
    }
    axes = {name: _axis(axis, part, test) for name, axis in run.axes.items()}
    other = other_instruments(own, of_test)
    said = {"characteristics": ", ".join(_planned(part, test)), "instrument_of_the_test": other}
    of_whole = {key: text for key, text in said.items() if text}
    pose = np.full(len(run), part.pose) if part.beside else run.pose
    known = replace(run, metadata={**lines, **own, **of_whole}, axes=axes, pose=pose)
    found, wrong = corrected(known)
    if wrong:
        raise DataError(
            f"cannot be corrected: {wrong[0]}",
            where=run.origin.source,
            faults=[Fault(one) for one in wrong],
            remedy="state the curve and its zero in test.toml: docs/test-folder.md",
        )
    return found


def _planned(part: Part, test: WholeTest) -> list[str]:
    """Return the characteristics that a part has to give; a drift test gives its own alone."""
    planned = test.schedule.characteristics
    if test.drift is None:
        return list(planned)
    return [code for code in planned if (code in DRIFT_CODES) == bool(part.beside)]


def _axis(axis: Axis, part: Part, test: WholeTest) -> Axis:
    instrument = test.instruments.get(axis.name)
    command, uncertainty = axis.command, axis.uncertainty
    if command is None:
        command = command_of(part, test, axis.name)
    if uncertainty is None and instrument is not None:
        uncertainty = instrument.uncertainty
    return replace(axis, command=command, uncertainty=uncertainty)
