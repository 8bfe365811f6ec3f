"""``bench.toml``: the gauges of a bench and its trigger, remembered for the next recording."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote

from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.files import read_toml, write_file
from scara_iso.recorder.detection import AUTO
from scara_iso.recorder.plan import RobotLine, parse_gauges, parse_trigger
from scara_iso.recorder.ports.listening import LISTEN
from scara_iso.recorder.ports.port import check_address, port_kind

BENCH_FILE = "bench.toml"
_HEAD = (
    "# The indicators of this bench, for scara-iso record. Edit it freely.",
    '# AXIS = "DRIVER?OPTIONS@PORT", as on the command line.',
)
_REMEDY = 'write a section [gauges] with lines such as X = "opto-rs232@/dev/ttyUSB0"'
_PLAIN = frozenset({"unit", "channel", "baud", "bits", "parity", "stop"})
"""Options that change nothing of what is sent to a port."""


@dataclass(frozen=True, slots=True)
class RememberedBench:
    """The gauges as ``AXIS=DRIVER@PORT``, and the trigger where one is remembered."""

    gauges: tuple[str, ...]
    trigger: str | None = None

    def reaches_out(self) -> tuple[str, ...]:
        """Return what does more than ask a device of this machine in its dialect's own words.

        Those are servers, and requests that the file spells: whoever wrote it chose them.
        """
        trigger = () if self.trigger is None else (self.trigger,)
        return tuple(gauge for gauge in self.gauges if _reaches_out(gauge)) + tuple(
            text for text in trigger if isinstance(parse_trigger(text), RobotLine)
        )


def read_bench(path: Path) -> RememberedBench:
    """Return what the file remembers; nothing in it is opened.

    Its sections ``[instrument.X]`` are those of a test.toml, and are not looked at here.
    Raises `NoInputError`, and `DataError` for an unknown key, a gauge that is not valid, or one
    that names a file.
    """
    try:
        bench = _remembered(read_toml(path))
        _check(bench)
    except UsageError as error:
        raise DataError(error.what, where=str(path), remedy=error.remedy) from error
    return bench


def _remembered(found: Mapping[str, object]) -> RememberedBench:
    gauges, trigger = found.get("gauges"), found.get("trigger")
    if unknown := sorted(set(found) - {"gauges", "trigger", "instrument"}):
        remedy = "leave it out, or say it as an option of record"
        raise UsageError(f"unknown: {', '.join(unknown)}", remedy=remedy)
    if not isinstance(gauges, dict) or not isinstance(trigger, str | None):
        raise UsageError("holds something other than gauges and a trigger", remedy=_REMEDY)
    wrong = [axis for axis, text in gauges.items() if not isinstance(text, str)]
    if wrong or not gauges:
        raise UsageError(f"{wrong[0]} is not text" if wrong else "no gauges", remedy=_REMEDY)
    return RememberedBench(tuple(f"{axis}={text}" for axis, text in gauges.items()), trigger)


def write_bench(path: Path, bench: RememberedBench) -> None:
    """Write the file anew, its instruments as they are there; raises as `write_file`."""
    _check(bench)
    kept = _instruments(path)
    lines = [*_HEAD]
    if bench.trigger is not None:
        lines.append(f"trigger = {json.dumps(bench.trigger, ensure_ascii=False)}")
    lines += ["", "[gauges]"]
    for gauge in bench.gauges:
        axis, _, rest = gauge.partition("=")
        lines.append(f"{axis.strip()} = {json.dumps(rest, ensure_ascii=False)}")
    write_file(path, "\n".join([*lines, *kept, ""]).encode())


def _instruments(path: Path) -> list[str]:
    """Return the lines of the sections that say which instruments these are, as they are."""
    if not path.is_file():
        return []
    kept: list[str] = []
    inside = False
    for line in path.read_text("utf-8-sig").splitlines():
        inside = line.lstrip().startswith("[instrument") or (
            inside and not line.lstrip().startswith("[")
        )
        kept += [line] if inside else []
    return ["", *kept] if kept else []


def _check(bench: RememberedBench) -> None:
    """Raise `UsageError` for what is not a gauge or trigger, or names a file."""
    if not all(text.isprintable() for text in (*bench.gauges, bench.trigger or "")):
        raise UsageError("characters that no port's name has", remedy=_REMEDY)
    named = [gauge.replace(f"={AUTO}", "=opto-rs232", 1) for gauge in bench.gauges]
    for spec in parse_gauges(named):
        check_address(spec.address)
        kind = port_kind(spec.address)
        if kind == "replay" or (kind == "sim" and "model" in unquote(spec.address)):
            raise UsageError(
                f"{spec.address}: {BENCH_FILE} names no files",
                remedy=f"give it as `gauge={spec.text}`",
            )
    if bench.trigger is not None:
        trigger = parse_trigger(bench.trigger)
        if isinstance(trigger, RobotLine) and not trigger.address.startswith(LISTEN):
            check_address(trigger.address)
            if port_kind(trigger.address) == "replay":
                raise UsageError(f"{trigger}: {BENCH_FILE} names no files", remedy=_REMEDY)


def _reaches_out(gauge: str) -> bool:
    driver, _, address = gauge.partition("=")[2].partition("@")
    head, mark, tail = driver.partition("?")
    names = {pair.partition("=")[0] for pair in tail.split("&")} if mark else set()
    return "://" in address or head.strip() == AUTO or not names <= _PLAIN
