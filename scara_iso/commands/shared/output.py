"""How every command writes: one JSON line, a report on the terminal, or a file.

A file that is there is overwritten only where the program could make it again.
"""

from __future__ import annotations

import re
import shlex
import sys
import textwrap
import zipfile
import zlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from shutil import get_terminal_size
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import typer

from scara_iso import iso9283, rawfile, render, reporting
from scara_iso.base.errors import CannotCreateError, ScaraIsoError, UsageError
from scara_iso.base.files import (
    check_output,
    check_table_name,
    is_file,
    is_folder,
    read_file,
    write_file,
)

if TYPE_CHECKING:
    from scara_iso.base.displayed import Plotted
    from scara_iso.commands.shared.series import MeasurementSeries

Item = TypeVar("Item")
NOT_WITHIN_LIMITS = 1
_OF_A_STUDY = (".json", ".dfq")
"""Endings of the file of a test or a gauge study, and of no page."""


def _check_page(path: Path) -> None:
    endings = [one for one in render.endings() if one not in _OF_A_STUDY]
    if path.suffix.lower() not in endings:
        raise UsageError(
            f"{path.name}: a page is written as {', '.join(endings)}",
            remedy="let the name end in one of them, or say `json=True`",
        )


def write_page(document: reporting.Document, path: Path) -> None:
    """Write a document by the name's ending; raises as `write_file`."""
    write_file(path, render.find_format(path.name, path.suffix)(document))


@dataclass(slots=True)
class Settings:
    """The general options of one call of the program."""

    debug: bool = False
    no_color: bool = False
    arguments: tuple[str, ...] = ()


settings = Settings()
_PARAMETER = re.compile(r"`([A-Za-z]\w*)=([^`]*)`")
_QUOTES = "'\""
_SET = ("", "True")
"""Values of an option that is given alone."""
_OPTION_OF = {"limits": "limit", "metadata": "meta"}
"""Options that may be given several times, by the keyword that takes them all."""


def as_options(text: str) -> str:
    """Return ``text`` with the parameters that it names (`` `unit=mm` ``) as options."""
    return _PARAMETER.sub(_option, text)


def as_answers(text: str) -> str:
    """Return ``text`` with the parameters that it names as what is typed where a question asks.

    What is no answer there stays an option.
    """
    return _PARAMETER.sub(lambda one: _option(one) if one[2] in _SET else one[2], text)


def _option(named: re.Match[str]) -> str:
    name, value = _OPTION_OF.get(named[1], named[1]), named[2]
    option = f"--{name.replace('_', '-')}"
    if value in _SET:
        return option
    return f"{option} {value if value[0] in _QUOTES else shlex.quote(value)}"


def write_result(published: object) -> None:
    """Write what is published of a result as one JSON object on a line of standard output."""
    from scara_iso.base.published import to_json, to_text

    sys.stdout.write(f"{to_text(to_json(published))}\n")


def write_report(report: reporting.Report, *, full: bool = False) -> None:
    """Write the answer of a report on standard output, or the report in full."""
    shown = reporting.in_form(report, "full" if full else "brief")
    console = render.open_console(sys.stdout, no_color=settings.no_color)
    typed = tuple(replace(one, blocks=tuple(map(_block_in_options, one.blocks))) for one in shown)
    render.show(typed, console, full=full)


def _block_in_options(block: reporting.Block) -> reporting.Block:
    match block:
        case reporting.Text() | reporting.Notice():
            return replace(block, text=as_options(block.text))
        case reporting.NextStep():
            words = as_options(block.command).split(" ")
            if "-" not in words:
                return replace(block, command=" ".join(words))
            command = " ".join("run.csv" if word == "-" else word for word in words)
            return replace(block, command=command, once="once the table is saved as run.csv")
        case reporting.Table():
            return replace(block, note=as_options(block.note))
    return block


class Answer(NamedTuple):
    """What a command says of a result: as one JSON object or on the terminal, and by its code."""

    published: object
    report: Callable[[], reporting.Report]
    written: Path | None = None
    """A file that is there now."""
    verdicts: Iterable[iso9283.Conformity | None] = ()
    """On limits."""
    code: int = 0
    """Exit code, where the verdicts do not say another."""

    def give(self, *, json: bool, full: bool = False) -> None:
        """Write it, and exit with its code."""
        if json:
            write_result(self.published)
        else:
            write_report(self.report(), full=full)
        say_written(self.written, aside=json)
        exit_by(self.verdicts)
        if self.code:
            raise typer.Exit(self.code)


def write_text(text: str, path: Path | None) -> None:
    """Write ``text`` to a file and say so, or to standard output where there is none.

    A terminal is shown what it should not obey.
    """
    if path is None and sys.stdout.isatty():
        sys.stdout.write("\n".join(map(reporting.printable, text.split("\n"))))
    elif path is None:
        sys.stdout.write(text)
    else:
        write_file(path, text.encode("utf-8", "backslashreplace"))
        tell_written(path)


def write_picture(result: Plotted, path: Path | None) -> None:
    """Write the picture of a result to a file, if one is named, and say so."""
    if path is not None:
        render.save_figure(result.plot(), path)
        tell_written(path)


def with_progress(each: Iterable[Item], count: int) -> Iterator[Item]:
    """Yield the items, and show on standard error how many have come."""
    console = render.open_console(sys.stderr, no_color=settings.no_color)
    return iter(render.track(each, count, console))


def say_written(path: Path | None, *, aside: bool = False) -> None:
    """Say that a file is there now: on standard output, or ``aside`` of an answer there."""
    if path is not None:
        say(f"{path} is written", aside=aside)


def say_condition(one: MeasurementSeries, found: Sequence[MeasurementSeries]) -> None:
    """Write which of several conditions follows."""
    if len(found) > 1:
        sys.stdout.write(f"{one.condition}:\n")


def recorded_among(found: Sequence[MeasurementSeries]) -> list[MeasurementSeries]:
    """Return those that have readings; say what is missing of the others."""
    for one in found:
        if one.run is None:
            missing = f"nothing is recorded; missing: {', '.join(one.missing)}"
            say(f"{one.folder.path}, {one.condition}: {missing}")
    return [one for one in found if one.run is not None]


def say(text: str, *, aside: bool = True) -> None:
    """Write a line to standard error, ``aside`` of an answer; else to standard output."""
    (sys.stderr if aside else sys.stdout).write(f"{reporting.printable(text)}\n")


def say_in_words(text: str) -> None:
    """Write a line aside, for a person broken between words: a path or an option stays whole."""
    line = reporting.printable(text)
    if sys.stderr.isatty():
        line = textwrap.fill(
            line,
            max(get_terminal_size().columns - 1, 20),
            subsequent_indent=" " * (len(line) - len(line.lstrip()) + 2),
            break_long_words=False,
            break_on_hyphens=False,
        )
    sys.stderr.write(f"{line}\n")


def path_under(path: Path | None, name: str, found: Sequence[object]) -> Path | None:
    """Return the file of the condition ``name``: each of several has its own."""
    if path is None or len(found) < 2:
        return path
    return path.with_name(f"{path.stem}-{name}{path.suffix}")


def write_results(
    found: Sequence[MeasurementSeries],
    results: Sequence[reporting.OfTable],
    *,
    of: int,
    other_tests: iso9283.OtherTests | None = None,
) -> None:
    """Write what is published of a table or a condition, of several in one JSON object."""
    if of == 1:
        for result in results:
            write_result(result)
    elif results:
        write_result(reporting.published_conditions(found, results, other_tests))


def exit_by(verdicts: Iterable[iso9283.Conformity | None]) -> None:
    """Exit with 1 where a limit is not kept."""
    if {*verdicts} - {None, iso9283.Conformity.PASS}:
        raise typer.Exit(NOT_WITHIN_LIMITS)


def tell_written(path: Path | None) -> None:
    """Say so to a person at a terminal."""
    if path is not None:
        tell(f"{path} is written")


def tell(text: str) -> None:
    """Say something to a person at a terminal; a script reads nothing but the answer."""
    if sys.stderr is not None and sys.stderr.isatty():
        say(text)


def files_read(tables: Sequence[str]) -> list[str]:
    """Return the files of tables that are named, and all that is read of a folder and its own."""
    from scara_iso.commands.shared.inputs import EVENTS, folders_seen, table_files

    folders = [Path(one) for one in tables if is_folder(one)]
    within = [inner for folder in folders for inner in (folder, *folders_seen(folder))]
    files = [path for folder in within for path in (*table_files(folder), folder / EVENTS)]
    return [*tables, *map(str, files)]


def check_outputs(
    outputs: Sequence[Path | None],
    inputs: Sequence[str | None],
    *,
    pictures: Sequence[Path | None] = (),
    tables: Sequence[Path | None] = (),
    pages: Sequence[Path | None] = (),
    decided: Sequence[Path | None] = (),
) -> None:
    """Raise before anything is read where an output cannot be written, or is not to be.

    As `check_output`; `CannotCreateError` where an output is what the command reads, of a
    recording, or another's file, but for those of which the command has ``decided``; `UsageError`
    where two outputs are one file, or one of the ``pictures``, ``tables`` or ``pages`` has an
    ending of none.
    Of folders among ``inputs`` all is read.
    """
    for path in filter(None, pictures):
        render.check_picture(path)
    written = [*filter(None, (*outputs, *tables, *pictures, *pages))]
    outs = [*filter(None, decided), *written]
    check_output(*outs)
    read = files_read([name for name in inputs if name not in (None, "-")]) if outs else []
    for path in outs:
        if any(_same_file(path, Path(name)) for name in read):
            raise CannotCreateError(
                "is an input of this command", where=str(path), remedy="name another file"
            )
        if _of_a_recording(path.resolve()):
            raise CannotCreateError(
                "holds a recording",
                where=str(path),
                remedy="name another file, or remove it yourself",
            )
    if len({path.resolve() for path in outs}) < len(outs):
        raise UsageError(f"{outs[0]} is named for two outputs", remedy="name two files")
    for path in filter(None, tables):
        check_table_name(path)
    refuse_foreign(*written)
    for path in filter(None, pages):
        _check_page(path)


def _same_file(path: Path, name: Path) -> bool:
    try:
        return path.samefile(name) and path.is_file()
    except OSError:  # one of them is not there
        return False


def _of_a_recording(path: Path) -> bool:
    """Say whether a recording's raw file or manifest is there, or the place of its table."""
    if path.is_file():
        with path.open("rb") as file:
            if rawfile.is_raw_file(file.read(16)) or path.name.endswith(
                (".raw.jsonl", ".manifest.json")
            ):
                return True
    return rawfile.raw_path(path).exists() or rawfile.manifest_path(path).exists()


_LARGEST, _UNREAD = 1 << 28, b"unread"
_BROKEN = (zipfile.BadZipFile, zlib.error)
_OWN = re.compile(
    rb"\A\s*\Z|^(?!#).*scara-iso|^# (written by scara-iso|simulated:|stream_sha256:)"
    rb"|\A\W*(x_mm.y_mm.RP_mm|visit.pose.x_mm)",
    re.MULTILINE,
)
"""What a file of this program says: its name (in a comment that may stand above readings, only as
of a saved model), that readings are simulated or of a stream that is named, a map's or plan's head.
"""


def refuse_foreign(*paths: Path) -> None:
    """Raise `CannotCreateError` where one is there that the program could not make again.

    Readings are measured once: it overwrites nothing but what it wrote itself, and empty files.
    """
    for path in paths:
        if is_file(path) and not _OWN.search(text_of(path)):
            raise CannotCreateError(
                "is there, and may hold what cannot be made again",
                where=str(path),
                remedy="name another file, or remove it yourself",
            )


def text_of(path: Path) -> bytes:
    """Return the bytes of a file, those of its parts where it is packed, as a workbook is.

    Where they cannot be read, or are more than this program writes, some that it never writes.
    """
    try:
        data = read_file(path, _LARGEST)
        if not zipfile.is_zipfile(path):
            return data
        with zipfile.ZipFile(path) as parts:
            if sum(one.file_size for one in parts.infolist()) > _LARGEST:
                return _UNREAD
            return b"".join(map(parts.read, parts.namelist()))
    except (ScaraIsoError, OSError, RuntimeError, ValueError, EOFError, *_BROKEN):
        return _UNREAD
