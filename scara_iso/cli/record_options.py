"""The options of ``record``: as given, and completed by what is remembered or found on a port."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path

from scara_iso.base.errors import UsageError
from scara_iso.recorder import BENCH_FILE, RememberedBench, name_dialects, read_bench
from scara_iso.reporting import printable


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordOptions:
    """The options of the command, as given."""

    table: Path | None
    gauges: tuple[str, ...]
    trigger: str | None
    cycles: int | None
    pose: str | None
    stable: int
    rearm: float | None
    unit: str | None
    meta: tuple[str, ...]
    meta_file: Path | None
    resume: bool
    part: str | None
    repeat: str | None
    excel_locale: str | None
    json: bool
    bench: Path | None = None
    watch: bool | None = None
    quiet: bool = False
    usual_trigger: str | None = None
    of_bench: Mapping[str, str] = field(default_factory=dict)
    """What bench.toml states of its instruments, as lines of the table's head."""

    @property
    def shown(self) -> bool:
        """Whether the recording shows on a terminal."""
        return not self.json and sys.stdout.isatty()

    @property
    def watched(self) -> bool:
        """Whether the readings are watched: on a terminal unless it is not wanted."""
        return self.shown if self.watch is None else self.watch

    @property
    def guided(self) -> bool:
        """Whether somebody is there to be asked, and to see the questions."""
        return self.shown and sys.stdin.isatty()


def complete(options: RecordOptions) -> RecordOptions:
    """Return the options with what was left out: asked for, remembered, or found on the port."""
    if options.gauges:
        return replace(options, gauges=name_dialects(options.gauges, say))
    bench = usual_bench(options)
    if bench is None:
        return options
    return replace(
        options,
        gauges=name_dialects(bench.gauges, say),
        usual_trigger=bench.trigger,
        of_bench=instruments_of(options, bench),
    )


def instruments_of(options: RecordOptions, bench: RememberedBench) -> dict[str, str]:
    """Return what the bench's file states of its instruments, as lines of a table; say whose."""
    from scara_iso.testfolder import lines_of, read_instruments

    path = _bench_file(options)
    found = read_instruments(path)
    if found:
        say(f"certificates of {path}: {', '.join(found)}")
    return lines_of(found, [gauge.partition("=")[0].strip() for gauge in bench.gauges])


def usual_bench(options: RecordOptions) -> RememberedBench | None:
    """Return the bench that the options name, or that lies beside the table; say which it is.

    What was found and not named may be another's: a server in it, or a request of its own, is
    confirmed before it is used.
    """
    path = _bench_file(options)
    if options.bench is None and not path.is_file():
        return None
    bench = read_bench(path)
    say(f"gauges of {path}: {'  '.join(bench.gauges)}")
    if options.bench is None and (reached := bench.reaches_out()):
        confirm(
            reached,
            f"{path} reaches beyond this machine's ports, or sends words of its own, with",
            remedy=f"if this is your bench: --bench {shlex.quote(str(path))}",
            on_terminal=options.shown,
        )
    return bench


def _bench_file(options: RecordOptions) -> Path:
    table = options.table or Path()
    folder = table if table.is_dir() else table.parent
    return options.bench or folder / BENCH_FILE


def say(text: str) -> None:
    """Say on standard error what was decided for the user."""
    sys.stderr.write(f"scara-iso: {printable(text)}\n")


def confirm(named: Sequence[str], said: str, *, remedy: str, on_terminal: bool) -> None:
    """Have the ports confirmed that a file names: whoever wrote it chose what they reach."""
    if on_terminal and sys.stdin.isatty():
        sys.stdout.write(f"{printable(said)}\n")
        sys.stdout.writelines(f"  {printable(gauge)}\n" for gauge in named)
        with suppress(EOFError):
            if input("Go on with these? [y/N] ").strip().lower() in ("y", "yes"):
                return
            raise UsageError("stopped; nothing was changed")
    raise UsageError("a file names the ports, and they are to be confirmed", remedy=remedy)
