"""``scara-iso record`` without a table: four questions, and the command line that they make."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from scara_iso.base.errors import (
    CannotCreateError,
    InstrumentError,
    ScaraIsoError,
    UsageError,
    WriteError,
)
from scara_iso.commands.output import as_answers
from scara_iso.commands.recording import RecordOptions, instruments_of, record_as_asked, usual_bench
from scara_iso.rawfile import raw_path
from scara_iso.recorder import (
    AUTO,
    BENCH_FILE,
    Detected,
    Device,
    RememberedBench,
    check_files,
    detect,
    find_dialect,
    list_devices,
    parse_gauges,
    parse_trigger,
    write_bench,
)
from scara_iso.reporting import printable

_T = TypeVar("_T")
_NAMES = "XYZ"
_OTHERS = (("sim:", "a simulated indicator, to try it"), ("keyboard:", "readings typed by hand"))
_DRIVERS = {"sim:": "opto-rs232", "keyboard:": "keyboard"}
_ANOTHER = "another port"
_TRIGGERS = "enter (key or foot switch), data (DATA key), timer:SECONDS, settled (dial at rest)"


def record_guided(options: RecordOptions) -> None:
    """Ask, record, and end with the command line that would have done the same."""
    options = guide(options)
    try:
        record_as_asked(options)
    except KeyboardInterrupt:
        _write("")  # below ^C
        raise
    finally:
        _write(f"The same without questions: {without_questions(options)}")


def guide(options: RecordOptions) -> RecordOptions:
    """Return the options with the answers of who sits at the terminal; `bench.toml` keeps them.

    Ports are listed first, and one is spoken to only once it was named for an axis.
    """
    bench = None if options.gauges else usual_bench(options)
    of_bench = {} if bench is None else instruments_of(options, bench)
    if bench and not _ask("   Record with these", "yes", _agreed):
        bench, of_bench = None, {}
    gauges = options.gauges or (bench.gauges if bench else _ask_gauges())
    gauges = _with_units(_with_drivers(gauges), options.unit)
    trigger = options.trigger or _ask_trigger(gauges, bench.trigger if bench else None)
    table = _ask_table()
    if bench is None:
        _remember(options.bench or table.parent / BENCH_FILE, RememberedBench(gauges, trigger))
    return replace(options, table=table, gauges=gauges, trigger=trigger, of_bench=of_bench)


def without_questions(options: RecordOptions) -> str:
    """Return the command line that does the same without a question."""
    words = ["scara-iso", "record", str(options.table)]
    for gauge in options.gauges:
        words += ["--gauge", gauge]
    words += ["--trigger", str(options.trigger)]
    for key, text in options.of_bench.items():
        words += ["--meta", f"{key}={text}"]
    return shlex.join(words)


def _ask_gauges() -> tuple[str, ...]:
    """List the ports and ask which indicator is on which axis."""
    usb, others = _parted(list_devices())
    listed = [*((device.name, str(device)) for device in usb), *_OTHERS]
    listed += [(device.name, "built in; often nothing is plugged in there") for device in others]
    ports = [port for port, _ in listed]
    _write("Ports:")
    width = max(map(len, ports))
    for k, (port, said) in enumerate(listed, start=1):
        _write(f"  {k:>2}  {port:<{width}}  {said}")
    _write("A port may also be typed as it is: X=/dev/ttyUSB0 or X=socket://HOST:PORT")
    usual = " ".join(f"{axis}={k + 1}" for k, axis in enumerate(_NAMES[: len(usb)]))
    return _ask(
        "Axis and port of each indicator",
        usual or "X=1",
        lambda answer: _gauges_of(answer, ports),
    )


def _parted(devices: Sequence[Device]) -> tuple[list[Device], list[Device]]:
    """Return the devices on USB, where an indicator's cable ends, and those that are not."""
    return [d for d in devices if d.usb], [d for d in devices if not d.usb]


def _gauges_of(answer: str, ports: Sequence[str]) -> tuple[str, ...]:
    texts = []
    for part in answer.replace(",", " ").split():
        axis, named, port = part.partition("=")
        if not named:
            raise UsageError(f"{part} names no axis", remedy=f"write X={part}, if it is on X")
        if port.isascii() and port.isdigit() and 0 < int(port[:4]) <= len(ports):
            port = ports[int(port) - 1]
        texts.append(f"{axis}={_DRIVERS.get(port.partition('?')[0], AUTO)}@{port}")
    specs = parse_gauges([text.replace(f"={AUTO}", "=opto-rs232", 1) for text in texts])
    drivers = [text.partition("=")[2] for text in texts]
    return tuple(f"{spec.axis}={rest}" for spec, rest in zip(specs, drivers, strict=True))


def _with_drivers(gauges: Sequence[str]) -> tuple[str, ...]:
    """Return the gauges with the driver that each port speaks: found, or asked for.

    Where a port speaks nothing, the ports may be named anew.
    """
    while True:
        parse_gauges([gauge.replace(f"={AUTO}", "=opto-rs232", 1) for gauge in gauges])
        found = [_with_driver(g) if g.partition("=")[2].startswith(AUTO) else g for g in gauges]
        if all(found):
            return tuple(found)
        gauges = _ask_gauges()


def _with_driver(gauge: str) -> str:
    """Return the gauge with its driver; empty where another port is wanted."""
    axis, _, rest = gauge.partition("=")
    driver, _, address = rest.partition("@")
    _write(f"Trying what {address} speaks (up to half a minute) ...")
    found = detect(address)
    _write(f"  {found}")
    keys = tuple(found.fits)
    if len(keys) != 1:
        keys = (_ask_driver(axis, found),)
    return keys[0] and f"{axis}={keys[0]}{driver.removeprefix(AUTO)}@{address}"


def _ask_driver(axis: str, found: Detected) -> str:
    """Ask which dialect it is, where the port does not tell it by itself; empty: another port."""
    if not found.fits:
        _write("  Is the indicator on, and its data output too? Is its cable in this port?")
    _write("  scara-iso ports --dialects MAKER says which driver an instrument has")

    def known(answer: str) -> str:
        return "" if answer == _ANOTHER else find_dialect(answer).key

    return _ask(f"   Driver of {axis}, or {_ANOTHER}", next(iter(found.fits), _ANOTHER), known)


def _with_units(gauges: Sequence[str], unit: str | None) -> tuple[str, ...]:
    """State a unit where neither the frames nor the instrument would."""
    specs = parse_gauges(gauges)
    silent = [
        spec
        for spec in specs
        if spec.unit is None
        and not spec.dialect.sends_unit
        and spec.dialect.unit_request is None
        and not spec.address.startswith("sim:")
    ]
    if not silent:
        return tuple(spec.text for spec in specs)
    axes = " ".join(spec.axis for spec in silent)
    stated = unit or _ask(f"Unit on the display of {axes}", "mm", _unit)
    texts = [
        parse_gauges([spec.text], unit=stated if spec in silent else None)[0].text for spec in specs
    ]
    return tuple(texts)


def _agreed(answer: str) -> bool:
    if answer.lower() not in ("y", "yes", "n", "no"):
        raise UsageError("answer yes or no")
    return answer.lower() in ("y", "yes")


def _unit(answer: str) -> str:
    from scara_iso.base.quantities import parse_unit

    parse_unit(answer)
    return answer


def _ask_trigger(gauges: Sequence[str], usual: str | None) -> str:
    if any(gauge.endswith("@keyboard:") for gauge in gauges):
        return "data"
    specs = parse_gauges(gauges)
    asked = all(s.dialect.request is not None or s.dialect.request_line is not None for s in specs)
    _write(f"   {_TRIGGERS}")
    return _ask(
        "When is a reading taken",
        usual or ("enter" if asked else "data"),
        lambda answer: str(parse_trigger(answer)),
    )


def _ask_table() -> Path:
    return _ask("File to write", str(_free("run")), _table)


def _free(stem: str) -> Path:
    """Return the first name of which neither table nor raw file is there."""
    k = 1
    while True:
        path = Path(f"{stem}.csv" if k == 1 else f"{stem}{k}.csv")
        if not path.exists() and not raw_path(path).exists():
            return path
        k += 1


def _table(answer: str) -> Path:
    path = Path(answer if "." in Path(answer).name else f"{answer}.csv")
    check_files(path, resume=False)
    return path


def _remember(path: Path, bench: RememberedBench) -> None:
    """Write `bench.toml`; a bench that is no use again, or a disk that fails, stops nothing."""
    try:
        write_bench(path, bench)
    except ScaraIsoError as error:
        _write(f"{path} is not written: {error.what}")
        return
    _write(f"{path} remembers this: next time, scara-iso record NAME.csv is enough.")


def _ask(question: str, usual: str, read: Callable[[str], _T]) -> _T:
    """Ask until the answer can be read; Enter takes the usual one."""
    while True:
        sys.stdout.write(printable(f"{question} [{usual}]: "))
        sys.stdout.flush()
        try:
            return read(input().strip() or usual)
        except EOFError as error:
            raise UsageError("no answer", remedy="scara-iso record OUT.csv --gauge …") from error
        except (UsageError, InstrumentError, CannotCreateError, WriteError) as error:
            said = f"{error.what}; {error.remedy}" if error.remedy else error.what
            _write(f"   {as_answers(said)}")


def _write(text: str) -> None:
    sys.stdout.write(printable(text) + "\n")
