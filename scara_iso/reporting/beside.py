"""The tests beside the poses in a report: what of them is on page 1, and what follows it."""

from __future__ import annotations

from collections.abc import Iterator

from scara_iso.iso9283 import Beside, Characteristic, PushResult
from scara_iso.reporting.blocks import Figure, Number, Section, Table
from scara_iso.reporting.drift import drift_pictures, largest_of
from scara_iso.reporting.plotted import Chart, Curve
from scara_iso.reporting.push import BOUGHT_BY, push_report
from scara_iso.reporting.raw_data import raw_data
from scara_iso.reporting.stated import conditions


def in_short(beside: Beside) -> tuple[Characteristic, ...]:
    """Return what belongs on page 1: what is held against a limit, and the figures of the whole."""
    drift = [] if beside.drift is None else list(beside.drift.characteristics)
    shown = [largest_of(drift, code) for code in dict.fromkeys(one.code for one in drift)]
    pushed = [one for one in beside.characteristics if one not in drift]
    of_joints = any(not one.of.endswith("reading") for one in pushed)
    shown += [
        one
        for one in pushed
        if one.code in BOUGHT_BY and not (of_joints and one.of.endswith("reading"))
    ]
    return tuple(one for one in beside.characteristics if one in shown or one.limit is not None)


def beside_sections(beside: Beside) -> Iterator[Section]:
    """Yield the course of the drift test, and what each push test came to."""
    if beside.drift is not None:
        yield from drift_pictures(beside.drift)
    for name, found in beside.pushes.items():
        blocks = tuple(block for section in push_report(found) for block in section.blocks)
        yield Section(_titled("Push test", name), (*blocks, _picture(found)))


def _picture(found: PushResult) -> Figure:
    """Return the picture of the loops: what the dial showed over the force."""
    loop = found.loop
    curve = Curve("readings, in their order", loop.force, loop.reading)
    chart = Chart("force [N]", "mm", (curve,), {})
    return Figure(chart, "Loops of the push test", "the width at no force is the hysteresis")


def beside_readings(beside: Beside) -> Iterator[Section]:
    """Yield the conditions and every reading of these tests."""
    if (drift := beside.drift) is not None:
        held = tuple(facts for facts in conditions(drift.run, drift.cycles) if facts.rows)
        yield Section("Conditions of the drift test", held)
        for pose in drift.poses:
            yield Section("Raw data of the drift test", tuple(raw_data(drift, pose)))
    for name, found in beside.pushes.items():
        yield Section(_titled("Raw data of the push test", name), (_steps(found),))


def _titled(title: str, name: str) -> str:
    joint = name.partition("-")[2]
    return f"{title} of {joint}" if joint else title


def _steps(found: PushResult) -> Table:
    loop = found.loop
    pairs = zip(loop.force.tolist(), loop.reading.tolist(), strict=True)
    rows = tuple(
        (Number(k), Number(force, ".12g"), Number(reading, ".12g"))
        for k, (force, reading) in enumerate(pairs, 1)
    )
    return Table(("step", "force [N]", "reading [mm]"), rows)
