"""`selftest`: whether this program gives references that were made elsewhere, on this machine.

``python -m scara_iso.commands.selftest TABLE`` records a simulated dial and says each reading
that is safely stored; `recorder_checks` kills it and reads what it left.
"""

from __future__ import annotations

import json
import math
import platform
import random
import re
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from hashlib import sha256
from importlib.metadata import requires, version
from operator import attrgetter
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TypeAlias

import numpy as np

from scara_iso import __version__, iso9283, recorder, reporting
from scara_iso.base.errors import DataError
from scara_iso.base.process import of_a_child
from scara_iso.base.quantities import parse_unit, rounding_uncertainty
from scara_iso.commands.record import record
from scara_iso.commands.shared import output as out
from scara_iso.commands.shared.options import Asked, option, takes_options_of
from scara_iso.commands.shared.output import Answer
from scara_iso.comparison import exchangeability
from scara_iso.diagnosis import SEED, CyclesWanted, close_the_loop
from scara_iso.rawfile import raw_path, read_history
from scara_iso.reporting import Installation, ReferenceCheck, Validation, validation_document
from scara_iso.robot import first_joint, table_1
from scara_iso.signals import read_loop
from scara_iso.tables import read_table

_HERE = Path(__file__).parent


def references(*names: str) -> Path:
    """Return a file or folder of ``data``, where it is kept among the tests in a checkout."""
    inside = _HERE.joinpath("data", *names)
    return inside if inside.exists() else _HERE.parents[1].joinpath("tests", "fixtures", *names)


def _figures(group: str, found: Callable[[Mapping[str, Any]], float]) -> Iterator[ReferenceCheck]:
    stated = json.loads(references("figures.json").read_text(encoding="utf-8"))
    for one in stated[group]:
        expected, obtained = one["expected"], float(found(one))
        yield ReferenceCheck(
            group, one["name"], one["source"], expected, obtained, one["tolerance"]
        )


def paper_checks() -> Iterator[ReferenceCheck]:
    """Yield the figures of Table I and those of the first joint."""
    figures, gear = iso9283.analyze(table_1()).poses[0].figures, first_joint()

    def found(one: Mapping[str, Any]) -> float:
        result = attrgetter(one["is"])(figures[one["of"]] if "of" in one else gear)
        return float(result)

    return _figures("paper", found)


_CERTIFIED = re.compile(r"Sample (?:Mean|Standard Deviation).*?:\s*(\S+)\n")
_RULE = re.compile(r"-{5,}\n")
_DIGITS = 1e-13
"""Share of a value that doubles may lose; of a deviation, the readings' digits lost with it."""


def nist_checks() -> Iterator[ReferenceCheck]:
    """Yield mean and standard deviation (n - 1) of each set, as the figures of a pose use them."""
    for file in sorted(references("nist_strd").glob("*.dat")):
        text = file.read_text(encoding="ascii")
        readings = np.array([float(row) for row in _RULE.split(text)[-1].split()])
        source = f"NIST StRD, univariate, {file.name}"
        certified = [float(value) for value in _CERTIFIED.findall(text)]
        mean = float(iso9283.repeatability(readings[np.newaxis]).mean[0])
        S = float(iso9283.standard_deviation(readings))
        apart = _DIGITS * float(np.abs(readings).max())
        name = file.stem
        yield ReferenceCheck("NIST StRD", f"{name} mean", source, certified[0], mean, apart)
        yield ReferenceCheck("NIST StRD", f"{name} deviation", source, certified[1], S, 10 * apart)


def unit_checks() -> Iterator[ReferenceCheck]:
    """Yield one check for each unit and each reading of a display."""

    def found(one: Mapping[str, Any]) -> float:
        unit = parse_unit(one["unit"])
        return unit.read(one["text"]) if "text" in one else unit.to_base(1.0)

    yield from _figures("units", found)
    exact, rounded = 1 / math.sqrt(12), rounding_uncertainty(1.0)
    yield ReferenceCheck("units", "u of rounding", "GUM F.2.2.1", exact, rounded, 1e-15)


_ARM = 0.25
"""From the joint to the dial of the push test [m]."""


def vector_checks() -> Iterator[ReferenceCheck]:
    """Yield value, u and ends of the interval of each figure, and what has no reference."""
    codes = set()
    for vector in json.loads(references("vectors", "vectors.json").read_text(encoding="utf-8")):
        found = {(one.code, one.pose, one.of): one for one in _characteristics(vector)}
        for figure in vector["figures"]:
            codes.add(figure["code"])
            yield from _compared(vector["name"], figure, found)
    for one in iso9283.find_characteristics():
        if one.__name__.startswith("scara_iso.") and one.CODE not in codes:
            yield ReferenceCheck("characteristics", one.CODE, "", "a reference", "none")


def _compared(
    name: str,
    figure: Mapping[str, Any],
    found: Mapping[tuple[str, str | None, str], iso9283.Characteristic],
) -> Iterator[ReferenceCheck]:
    one = found.get((figure["code"], figure["pose"], figure["of"]))
    what = " ".join(filter(None, (figure["code"], figure["pose"], figure["of"])))
    ends = None if one is None else one.estimate.interval
    wanted = [("", figure["value"], None if one is None else one.estimate.value)]
    if figure["interval"] is not None:
        low, high = (None, None) if ends is None else ends
        wanted += [(", low", figure["interval"][0], low), (", high", figure["interval"][1], high)]
    if figure["u"] is not None:
        wanted.append((", u", figure["u"], None if one is None else one.estimate.u))
        parts = None if one is None else math.hypot(*one.estimate.parts.values())
        wanted.append((", its parts", figure["u"], parts))
    for part, expected, obtained in wanted:
        yield ReferenceCheck(
            "characteristics",
            f"{name}: {what}{part} [{figure['unit']}]",
            figure["source"],
            expected,
            "not there" if obtained is None else float(obtained),
            figure["tolerance"],
        )


def _characteristics(vector: Mapping[str, Any]) -> Sequence[iso9283.Characteristic]:
    tables = [references("vectors", name).read_bytes() for name in vector["tables"]]
    if vector["name"].startswith("push"):
        return iso9283.push_test(read_loop(tables[0]), arm_m=_ARM).characteristics
    analyses = [
        iso9283.analyze(read_table(table), iso9283.Counting(cycles=vector["cycles"]))
        for table in tables
    ]
    return exchangeability(analyses, {}) if len(analyses) > 1 else analyses[0].characteristics


_SOURCE = "ISO 9283 7.2: 30 cycles; the paper's 31st, run first and discarded"
_FEW = "fewer than five cycles have no interval"


def rule_checks() -> Iterator[ReferenceCheck]:
    """Yield what becomes of tables of 31 cycles and others, and of a figure at three limits."""
    for case in json.loads(references("procedure.json").read_text(encoding="utf-8")):
        ends = (part.partition("-") for part in case["cycles"].split(","))
        numbers = [n for first, _, last in ends for n in range(int(first), int(last or first) + 1)]
        expected, obtained = case["becomes"], _counted(numbers, case["options"])
        if expected.startswith("refused") and expected in obtained:
            obtained = expected
        yield ReferenceCheck("procedure", case["name"], _SOURCE, expected, obtained)
    for n, expected in ((4, "none"), (5, "an interval")):
        (pose,) = iso9283.analyze(
            read_table(_table(range(1, n + 2))), iso9283.Counting(cycles=n + 1)
        ).poses
        interval = pose.axes["X"].RP_interval
        obtained = "none" if interval is None else "an interval"
        yield ReferenceCheck("procedure", f"interval of {n} cycles", _FEW, expected, obtained)
    for limit, verdict in ((0.05, "pass"), (0.01, "not-provable"), (0.002, "fail")):
        (check,) = iso9283.analyze(read_table(_table(range(1, 32))), limits={"X": limit}).limits
        name = f"RP X against {limit:g} mm"
        source = "the 95 % interval inside, about or beyond the limit (ISO/IEC 17025 7.1.3)"
        yield ReferenceCheck("procedure", name, source, verdict, check.verdict.value)


def _counted(numbers: Sequence[int], options: Mapping[str, Any]) -> str:
    try:
        found = iso9283.analyze(read_table(_table(numbers)), iso9283.Counting(**options))
    except DataError as error:
        text = error.faults[0].message if error.faults else error.what
        return f"refused: {text}"
    gone = ", ".join(map(str, found.cycles.discarded)) or "none"
    gaps = "".join(f", {first} to {last} missing" for first, last in found.poses[0].missing)
    return f"{gone} discarded, {found.cycles.used} used{gaps}"


def _table(numbers: Sequence[int], seed: int = 9283) -> bytes:
    rng = random.Random(seed)  # noqa: S311 - readings
    rows = [f"{number},{rng.gauss(0, _SIGMA):.4f}" for number in numbers]
    return "\n".join(["# unit: mm", "# resolution: 0.0001", "cycle,X", *rows, ""]).encode()


def stream_checks() -> Iterator[ReferenceCheck]:
    """Yield one check for each recorded stream, and one for a dialect without any."""
    dialects = recorder.find_dialects()
    for file in sorted(references("streams").glob("*/*.bin")):
        dialect = file.parent.name
        stated = json.loads(file.with_suffix(".json").read_text(encoding="utf-8"))
        events = recorder.Decoder(dialects[dialect]).feed(file.read_bytes())
        yield ReferenceCheck(
            "streams",
            f"{dialect}/{file.name}",
            stated["source"],
            _events_as_text(stated["events"]),
            _events_as_text([_as_stated(event) for event in events]),
        )


def _events_as_text(events: list[dict[str, Any]]) -> str:
    return "; ".join(
        "garbage"
        if event.get("garbage")
        else " ".join(f"{key} {value}" for key, value in event.items() if value is not None)
        for event in events
    )


def _as_stated(event: recorder.Event) -> dict[str, Any]:
    match event:
        case recorder.Reading(text, unit, channel, mode):
            return {"reading": text, "unit": unit, "channel": channel, "mode": mode}
        case recorder.InstrumentFault(code=code, channel=channel):
            return {"fault": code, "channel": channel}
        case recorder.DeviceNotice(unit=unit):
            return {"notice": unit}
        case recorder.Garbage():
            return {"garbage": True}


_CYCLES = 31
_NULLS = 20
_MOST_ALARMS = 3
"""More than three of twenty have a chance of 1.6 % at the level of 5 %."""
_SIGMA = 0.004  # [mm]


def diagnosis_checks() -> Iterator[ReferenceCheck]:
    """Yield how many tables of mere scatter are taken for more, and each effect that is named."""
    alarms = sum(
        _verdict(_table(range(1, _CYCLES + 1), seed)) != "nothing-to-explain"
        for seed in range(_NULLS)
    )
    name = f"alarms in {_NULLS} tables of scatter"
    text = "few enough" if alarms <= _MOST_ALARMS else f"{alarms}: more than {_MOST_ALARMS}"
    yield ReferenceCheck("diagnosis", name, "level 5 %", "few enough", text)
    for file in sorted(references("effects").glob("*.csv")):
        effect = file.stem
        source = f"readings made with {effect} and scatter of {_SIGMA:g} mm"
        found = _verdict(file.read_bytes())
        yield ReferenceCheck("diagnosis", effect, source, f"explained by {effect}", found)


def _verdict(table: bytes) -> str:
    found = close_the_loop(read_table(table), None, CyclesWanted(), seed=SEED)
    named = [one.effect for one in found.effects]
    return " ".join([found.verdict.value, *(["by", ", ".join(named)] if named else [])])


_GAUGE = "X=opto-rs232@sim:?pace=1"
_TRIGGER = "timer:0.1"
_ENDED_AFTER = 7
_DURABILITY = "no announced reading is lost"


def recorder_checks() -> Iterator[ReferenceCheck]:
    """Yield whether a killed recording holds what it announced, and can be gone on with."""
    with TemporaryDirectory(prefix="scara-iso-", ignore_cleanup_errors=True) as folder:
        table = Path(folder) / "run.csv"
        announced = _recorded_until_the_end(table)
        history = read_history(raw_path(table))
        run = record(table, [_GAUGE.replace("pace=1", "pace=0")], trigger=_TRIGGER, resume=True)
    in_table = dict(zip(run.cycle.tolist(), run.axes["X"].readings.tolist(), strict=True))
    in_raw_file = history.readings().get("X", {})
    expected_text = _as_text(announced, announced)
    every = ", ".join(map(str, range(1, _CYCLES + 1)))
    for name, expected, obtained in (
        ("announced readings in the raw file", expected_text, _as_text(announced, in_raw_file)),
        ("announced readings in the table", expected_text, _as_text(announced, in_table)),
        ("faults of the raw file", "none", "; ".join(map(str, history.faults)) or "none"),
        ("cycles after going on", every, ", ".join(map(str, in_table))),
    ):
        yield ReferenceCheck("recorder", name, _DURABILITY, expected, obtained)


def _as_text(announced: Mapping[int, float], found: Mapping[int, float]) -> str:
    each = (f"{c}: {f'{found[c]:.6f}' if c in found else 'lost'}" for c in announced)
    return "; ".join(f"cycle {one}" for one in each)


def _recorded_until_the_end(table: Path) -> dict[int, float]:
    """Return the readings, by cycle, that a recorder announced before it was killed."""
    words = [sys.executable, "-P", "-m", __name__, str(table)]
    with subprocess.Popen(  # noqa: S603 - ourselves
        words, stdout=subprocess.PIPE, text=True, env=of_a_child()
    ) as child:
        assert child.stdout is not None  # noqa: S101 - a pipe was asked for
        lines = [child.stdout.readline() for _ in range(_ENDED_AFTER)]
        child.kill()
        lines += child.stdout.readlines()
    rows = [line.split() for line in lines if line.endswith("\n")]
    return {int(cycle): float(value) for cycle, value in rows}


def _announce(event: object) -> None:
    if isinstance(event, recorder.Stored):
        sys.stdout.write(f"{event.cycle} {event.value:.6f}\n")
        sys.stdout.flush()


Group: TypeAlias = Callable[[], Iterable[ReferenceCheck]]
GROUPS: Mapping[str, Group] = {
    "paper": paper_checks,
    "NIST StRD": nist_checks,
    "units": unit_checks,
    "characteristics": vector_checks,
    "procedure": rule_checks,
    "streams": stream_checks,
    "diagnosis": diagnosis_checks,
    "recorder": recorder_checks,
}


def validate(groups: Mapping[str, Group] = GROUPS) -> Iterator[ReferenceCheck]:
    """Yield every check of every group; an error ends its group and is itself a failed check."""
    for group, checks in groups.items():
        try:
            yield from checks()
        except Exception as error:  # noqa: BLE001 - whatever it is, the reference is not met
            text = f"{type(error).__name__}: {error}"
            yield ReferenceCheck(group, "the rest of this group", "", "no error", text)


def selftest(
    to: str | Path | None = None, *, tell: Callable[[ReferenceCheck], None] | None = None
) -> Validation:
    """Return what this program makes of references, on this machine (ISO/IEC 17025 7.11.2).

    The paper's table, NIST's certified sets, units, a table with sums made elsewhere for every
    characteristic, the procedure's rules, recorded streams, a sample of scatter and of known
    effects, and a recorder that is killed. ``to`` also writes the record to sign (.html, .md,
    .csv, .xlsx, .pdf); ``tell`` hears each check as it is made. Raises `UsageError` for another
    ending, and as `write_file`.
    """
    if to is not None:
        out.check_outputs([], [], pages=[Path(to)])
    checks = []
    for check in validate():
        checks.append(check)
        if tell is not None:
            tell(check)
    found = Validation(checks=tuple(checks), installation=_installation())
    if to is not None:
        out.write_page(validation_document(found), Path(to))
    return found


def _installation() -> Installation:
    needed = (re.match(r"[\w-]+", one) for one in requires("scara-iso") or () if "extra" not in one)
    packages = sorted(found[0] for found in needed if found)
    return Installation(
        program=__version__,
        versions={"Python": platform.python_version()} | {n: version(n) for n in packages},
        platform=f"{platform.platform()} {platform.machine()}, {sys.implementation.name}",
        hashes={"program": _digest(".py"), "references": _digest("", "commands", "data")},
    )


def _digest(ending: str, *folder: str) -> str:
    """Return one SHA-256 of the names and bytes of the package's files with this ending."""
    root, total = Path(__file__).parents[1].joinpath(*folder), sha256()
    for path in sorted(path for path in root.rglob(f"*{ending}") if path.is_file()):
        data = path.read_bytes()
        total.update(f"{path.relative_to(root).as_posix()}\0{len(data)}\0".encode() + data)
    return total.hexdigest()


@takes_options_of(
    selftest,
    "full",
    "json",
    to=option(
        "Record to sign, by its ending: .html .md .csv .xlsx .pdf.", "--report", kind=Path | None
    ),
)
def selftest_command(asked: Asked[Validation]) -> Answer:
    """Compare this installation with references: exit 0, or 1 naming what differs.

    For the record that ISO/IEC 17025 7.11.2 asks for before software is used.

    Example: scara-iso selftest --report validation.html
    """
    found = asked.result()
    code = 0 if found.verdict == "pass" else out.NOT_WITHIN_LIMITS
    return Answer(found, partial(reporting.validation_report, found), asked["to"], code=code)


if __name__ == "__main__":
    record(sys.argv[1], [_GAUGE], trigger=_TRIGGER, cycles=_CYCLES, tell=_announce)
