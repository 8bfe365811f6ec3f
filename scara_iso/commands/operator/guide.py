"""What ``scara-iso record`` asks and remembers: gauges of a bench, trigger, the table's head."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from itertools import count
from pathlib import Path
from typing import TypeVar

from scara_iso import rawfile, recorder, reporting, testfolder
from scara_iso.base.errors import InstrumentError, ScaraIsoError, UsageError
from scara_iso.base.quantities import parse_unit
from scara_iso.commands.operator.recording import EXAMPLE, RecordOptions, refuse_unconfirmed, remark
from scara_iso.commands.operator.screen import write_line
from scara_iso.commands.operator.watching import Announced
from scara_iso.commands.shared.options import command_line
from scara_iso.commands.shared.output import as_answers, say

_T = TypeVar("_T")
_write = partial(say, aside=False)
ASKED = ("robot", "payload", "velocity", "temperature", "operator", "calibration_date")
"""Metadata asked for at the start, where someone is there to answer and gave none."""
_NAMES = "XYZ"
_OTHERS = (("sim:", "a simulated indicator, to try it"), ("keyboard:", "readings typed by hand"))
_DRIVERS = {"sim:": "opto-rs232", "keyboard:": "keyboard"}
_ANOTHER = "another port"
_TRIGGERS = "enter (key or foot switch), data (DATA key), timer:SECONDS, settled (dial at rest)"


@dataclass(frozen=True, slots=True)
class Terminal:
    """Where a recording shows, and whether somebody is there to be asked."""

    json: bool = False
    quiet: bool = False

    @property
    def shown(self) -> bool:
        """Whether the recording shows on a terminal; else JSON lines are written."""
        return not self.json and sys.stdout.isatty()

    @property
    def guided(self) -> bool:
        """Whether somebody is there to be asked, and to see the questions."""
        return self.shown and sys.stdin.isatty()

    def tell(self, event: Announced, in_words: str) -> None:
        """Say one thing, as a JSON line or in words."""
        if self.shown:
            _write(in_words)
        else:
            write_line(event)

    def confirm(self, named: Sequence[str], said: str, *, remedy: str) -> None:
        """Have the ports confirmed that a file names: whoever wrote it chose what they reach."""
        if self.guided:
            for line in (said, *(f"  {one}" for one in named)):
                _write(line)
            with suppress(EOFError):
                if input("Continue with these? [y/N] ").strip().lower() in ("y", "yes"):
                    return
                raise UsageError("stopped; nothing was changed")
        refuse_unconfirmed(named, said, remedy=remedy)


def with_bench(options: RecordOptions, named: Path | None) -> RecordOptions:
    """Return the options with the gauges of a bench, where they name none; say which it is.

    That is the one ``named``, or the one beside the table. The latter may be another's: a server
    in it, or a request of its own, is confirmed before it is used.
    """
    table = options.table or Path()
    path = named or (table if table.is_dir() else table.parent) / recorder.BENCH_FILE
    if options.gauges or (named is None and not path.is_file()):
        return options
    bench = recorder.read_bench(path)
    remark(f"gauges of {path}: {'  '.join(bench.gauges)}")
    if named is None and (reached := bench.reaches_out()):
        options.confirm(
            reached,
            f"{path} reaches beyond this machine's ports, or sends words of its own, with",
            remedy=f"if this is your bench: --bench {shlex.quote(str(path))}",
        )
    if instruments := testfolder.read_instruments(path):
        remark(f"certificates of {path}: {', '.join(instruments)}")
    axes = [gauge.partition("=")[0].strip() for gauge in bench.gauges]
    return replace(
        options,
        gauges=bench.gauges,
        usual_trigger=bench.trigger or options.usual_trigger,
        certificates=testfolder.lines_of(instruments, axes),
        remembered=True,
    )


def ask_metadata(specs: Sequence[recorder.GaugeSpec]) -> dict[str, str]:
    """Ask once for what the report will want to state; an empty answer leaves it out.

    Raises `InstrumentError` before anybody types, where a port is not there.
    """
    for spec in specs:
        recorder.refuse_absent(spec.address, spec.dialect.line)
    _write("For the head of the table (Enter leaves a line out):")
    width = max(map(len, ASKED))
    answers: dict[str, str] = {}
    with suppress(EOFError):
        for key in ASKED:
            answers[key] = input(f"  {key.replace('_', ' '):<{width}} ").strip()
    return recorder.check_metadata({key: answer for key, answer in answers.items() if answer})


def guide(options: RecordOptions, bench: Path | None = None) -> RecordOptions:
    """Return the options with the answers of who sits at the terminal; `bench.toml` keeps them.

    Beside a bench only the table is asked for. Else ports are listed first, and one is spoken to
    only once it was named for an axis; each gauge has shown a reading before the last question.
    Raises `UsageError` before the first where nothing can be gone on with.
    """
    if options.resume or options.part or options.repeat:
        raise UsageError(
            "`resume=True`, `part=` and `repeat=` need the table or the folder that is meant",
            remedy="name it: scara-iso record OUT.csv `resume=True`, or DIR `part=P3-v50-l100`",
        )
    options = with_bench(replace(options, usual_trigger=None), bench)
    known = options.remembered
    gauges, answer = _proven(options.gauges or _ask_gauges(), options.unit, known=known)
    trigger = options.trigger or options.usual_trigger or _ask_trigger(gauges, answer=answer)
    table = _ask("File to write", str(_free("run")), _table)
    path = bench or (Path() if known else table.parent) / recorder.BENCH_FILE
    if not known and path.exists():
        _write(f"{path} is there and stays as it is: it does not remember this.")
    elif gauges != options.gauges or not known:
        _remember(path, recorder.RememberedBench(gauges, trigger))
    return replace(options, table=table, gauges=gauges, trigger=trigger)


def without_questions(options: RecordOptions, stated: Mapping[str, object]) -> str:
    """Return the command line that does the same without a question."""
    pairs = {**options.certificates, **options.metadata}
    asked: dict[str, object] = {"gauge": options.gauges, "trigger": options.trigger}
    given = {**asked, **stated, **asked, "meta": [f"{key}={text}" for key, text in pairs.items()]}
    return f"scara-iso record {command_line([str(options.table)], given)}"


def _ask_gauges() -> tuple[str, ...]:
    """List the ports and ask which indicator is on which axis; a simulated one is never usual."""
    devices = recorder.list_devices()
    usb, others = [d for d in devices if d.usb], [d for d in devices if not d.usb]
    listed = [*((device.name, str(device)) for device in usb), *_OTHERS]
    listed += [(device.name, "built in; often nothing is plugged in there") for device in others]
    ports = [port for port, _ in listed]
    _write("Ports:")
    width = max(map(len, ports))
    for k, (port, said) in enumerate(listed, start=1):
        _write(f"  {k:>2}  {port:<{width}}  {said}")
    _write("A port may also be typed as it is: X=/dev/ttyUSB0 or X=socket://HOST:PORT")
    _write("Name all indicators in one line: X=1 Y=2")
    usual = " ".join(f"{axis}={k + 1}" for k, axis in enumerate(_NAMES[: len(usb)]))
    question = "Axis and port of each indicator"
    return _ask(question, usual, lambda answer: _gauges_of(answer, ports))


def _gauges_of(answer: str, ports: Sequence[str]) -> tuple[str, ...]:
    texts = []
    for part in answer.replace(",", " ").split() or [""]:
        axis, named, port = part.partition("=")
        if not named:
            is_axis = part.upper() in (*_NAMES, "THETA", "")
            what = f"{part} names no {'port' if is_axis else 'axis'}"
            how = "1, with the number of its port" if is_axis else f"{part}, if it is on X"
            remedy = f"write {(is_axis and part) or 'X'}={how}"
            raise UsageError(what if part else "no indicator is named", remedy=remedy)
        if port.isascii() and port.isdigit() and 0 < int(port[:4]) <= len(ports):
            port = ports[int(port) - 1]
        texts.append(f"{axis}={_DRIVERS.get(port.partition('?')[0], recorder.AUTO)}@{port}")
    pairs = zip(_parsed(texts), texts, strict=True)
    return tuple(f"{spec.axis}={text.partition('=')[2]}" for spec, text in pairs)


def _parsed(gauges: Sequence[str]) -> tuple[recorder.GaugeSpec, ...]:
    """Return the gauges, those of which the driver is not known yet with any; raises likewise."""
    return recorder.parse_gauges(
        [gauge.replace(f"={recorder.AUTO}", "=opto-rs232", 1) for gauge in gauges]
    )


def _proven(
    gauges: Sequence[str], unit: str | None, *, known: bool
) -> tuple[tuple[str, ...], bool]:
    """Return the gauges, with driver and unit, each proven by a reading, and whether all answer.

    Where a port speaks nothing, the ports may be named anew. Those of a bench (``known``) that send
    by their DATA key are not waited for.
    """
    while True:
        _parsed(gauges)
        named = filter(None, map(_with_driver, gauges))
        found = [_prove(gauge, unit, wait=not known) for gauge in named]
        if len(found) == len(gauges) and all(gauge for gauge, _ in found):
            return tuple(gauge for gauge, _ in found), all(answers for _, answers in found)
        gauges, known = _ask_gauges(), False


def _prove(gauge: str, unit: str | None, *, wait: bool) -> tuple[str, bool]:
    """Return the gauge with its unit, and whether it answers; empty where it shows no reading."""
    spec = recorder.parse_gauges([gauge])[0]
    shown, answers = spec.unit, False
    answering = wait or spec.dialect.request is not None
    if answering and recorder.port_kind(spec.address) != "keyboard":
        press = partial(_write, f"  Press DATA on the indicator of {spec.axis} once")
        try:
            first = recorder.read_once(spec, press if wait else None)
        except InstrumentError as error:
            return _refused(error), False
        shown, answers = first.unit or spec.unit, first.answered
        seen = " ".join(filter(None, (first.text, shown)))
        simulated = recorder.port_kind(spec.address) == "sim"
        check = "SIMULATED, no dial is read" if simulated else "compare with its display"
        _write(f"  {spec.axis} reads {seen}: {check}")
    if shown is None and not spec.dialect.sends_unit:
        shown = unit or _ask(f"Unit on the display of {spec.axis}, mm or inch", "mm", _unit)
        spec = recorder.parse_gauges([gauge], unit=shown)[0]
    return spec.text, answers


def _refused(error: InstrumentError) -> str:
    """Say why a port is no use, and return no gauge."""
    _write(f"  {error.where}: {error.what}; {error.remedy}")
    return ""


def _unit(answer: str) -> str:
    parse_unit(answer)
    return answer


def _with_driver(gauge: str) -> str:
    """Return the gauge with its driver; empty where another port is wanted."""
    axis, _, rest = gauge.partition("=")
    driver, _, address = rest.partition("@")
    if not driver.startswith(recorder.AUTO):
        return gauge
    _write(f"Trying what {address} speaks (up to half a minute) ...")
    try:
        found = recorder.detect(address)
    except InstrumentError as error:
        return _refused(error)
    _write(f"  {found}")
    keys = tuple(found.fits)
    if len(keys) != 1:
        keys = (_ask_driver(axis, found),)
    return keys[0] and f"{axis}={keys[0]}{driver.removeprefix(recorder.AUTO)}@{address}"


def _ask_driver(axis: str, found: recorder.Detected) -> str:
    """Ask which dialect it is, where the port does not tell it by itself; empty: another port."""
    if not found.fits:
        _write("  Is the indicator on, and its data output too? Is its cable in this port?")
    _write("  scara-iso ports --dialects MAKER says which driver an instrument has")

    def known(answer: str) -> str:
        return "" if answer == _ANOTHER else recorder.find_dialect(answer).key

    return _ask(f"   Driver of {axis}, or {_ANOTHER}", next(iter(found.fits), _ANOTHER), known)


def _ask_trigger(gauges: Sequence[str], *, answer: bool) -> str:
    if any(gauge.endswith("@keyboard:") for gauge in gauges):
        return "data"
    _write(f"   {_TRIGGERS}")
    usual = "enter" if answer else "data"
    return _ask("When is a reading taken", usual, lambda text: str(recorder.parse_trigger(text)))


def _free(stem: str) -> Path:
    """Return the first name of which neither table nor raw file is there."""
    paths = (Path(f"{stem}{'' if k == 1 else k}.csv") for k in count(1))
    return next(path for path in paths if not path.exists() and not rawfile.raw_path(path).exists())


def _table(answer: str) -> Path:
    path = Path(answer if "." in Path(answer).name else f"{answer}.csv")
    recorder.check_files(path, resume=False)
    return path


def _remember(path: Path, bench: recorder.RememberedBench) -> None:
    """Write `bench.toml`; a bench that is no use again, or a disk that fails, stops nothing."""
    try:
        recorder.write_bench(path, bench)
    except ScaraIsoError as error:
        _write(f"{path} is not written: {error.what}")
        return
    _write(f"{path} remembers this: next time, scara-iso record NAME.csv is enough.")


def _ask(question: str, usual: str, read: Callable[[str], _T]) -> _T:
    """Ask until the answer can be read; Enter takes the usual one."""
    while True:
        sys.stdout.write(reporting.printable(f"{question}{usual and f' [{usual}]'}: "))
        sys.stdout.flush()
        try:
            return read(input().strip() or usual)
        except EOFError as error:
            raise UsageError("no answer", remedy=EXAMPLE) from error
        except ScaraIsoError as error:
            said = f"{error.what}; {error.remedy}" if error.remedy else error.what
            _write(f"   {as_answers(said)}")
