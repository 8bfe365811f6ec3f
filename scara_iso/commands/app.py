"""The program `scara-iso`: its commands by what they are for, its help, one error boundary."""

from __future__ import annotations

import errno
import os
import re
import shlex
import sys
import traceback
import warnings
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from pkgutil import get_data
from shutil import get_terminal_size
from typing import Any

import typer
from typer._completion_classes import completion_init
from typer.core import TyperCommand, TyperGroup

from scara_iso import __version__, render
from scara_iso.base import process
from scara_iso.base.errors import NoInputError, ScaraIsoError, UsageError
from scara_iso.commands.shared.output import as_options, say_in_words, settings

GROUPS = {
    "Measure": ("test", "plan", "ports", "program", "record", "visits", "gauge-study"),
    "Understand": ("tables", "analyze", "diagnose", "compare", "fleet", "push", "backlash"),
    "Report": ("report",),
    "Learn": ("demo", "explain", "simulate"),
    "Watch and validate": ("history", "selftest"),
}
COMMANDS = {
    name: f"{__package__}.{name.replace('-', '_')}" for names in GROUPS.values() for name in names
}
_SUMMARY = re.compile(r'(?:def \w+_command\(.*?"""|Typer\(help=")(.+?)["\n]', re.DOTALL)
_OPTIONS = {
    "How a table is read": ("unit", "resolution", "decimal", "sheet", "columns"),
    "Which cycles count": ("first_cycle_discarded", "cycles", "all_count", "allow_gaps"),
    "What is shown and written": (
        "output",
        "to",
        "plot",
        "picture",
        "map_",
        "excel_locale",
        "language",
        "page",
        "full",
        "json",
        "help",
    ),
}
_FEWEST = 8
"""Options of which fewer are one list."""
_COMPLAINTS = {
    "is not a valid float.": "is not a number: digits and a decimal point, such as 0.5",
    "is not a valid int range.": "is not a whole number",
    "is not a valid int.": "is not a whole number",
}


class Command(TyperCommand):
    """A command whose help has the options by what they are for."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the arguments and the groups of options that this command has."""
        params = self.get_params(ctx)
        options = {param.name for param in params if param.param_type_name == "option"}
        titles = {
            name: title
            for title, names in _OPTIONS.items()
            if len(options) >= _FEWEST and len(options.intersection(names)) > 1
            for name in names
        }
        shown: dict[str, list[Any]] = {name: [] for name in ("Arguments", "Options", *_OPTIONS)}
        for param in params:
            place = titles.get(str(param.name), "Options") if param.name in options else "Arguments"
            if (record := param.get_help_record(ctx)) is not None:
                shown[place].append(record)
        for title in filter(shown.get, shown):
            with formatter.section(title):
                formatter.write_dl(shown[title])


BUG = 70
CANNOT_WRITE = 74
_INTERRUPTED = "scara-iso: interrupted"
_ANYWHERE = ("--debug", "--no-color")
_HELP = ("-h", "--help")
_LONG = 6
_NARROWEST, _WIDEST = 20, 100
_READ_TOO = (".csv", ".json", ".xlsx")
_NO_COMMAND = re.compile(r"No such command '(.+?)'")
_EXTRA = re.compile(r"unexpected extra argument\S* \((\S+)\)")
_NO_INPUT = (errno.EACCES, errno.EPERM, errno.ENAMETOOLONG)  # what is written is checked first
WELCOME = """\
scara-iso - how repeatable is a SCARA, and why (ISO 9283, dial indicators)

  scara-iso demo              the paper's robot in one minute
  scara-iso record            read your indicators (asks what it needs)
  scara-iso analyze TABLE     repeatability of a table
  scara-iso diagnose TABLE    what is in it besides scatter
  scara-iso report TABLE      the report to sign

scara-iso --help lists the rest; scara-iso COMMAND --help has an example.
"""


class _Program(TyperGroup):
    def format_commands(self, ctx: object, formatter: Any) -> None:  # noqa: ARG002 - click's
        for group, commands in GROUPS.items():
            with formatter.section(group):
                formatter.write_dl([(name, _summary(name)) for name in commands])


def _summary(name: str) -> str:
    """Return what a command is for: the first line of its docstring, without its import."""
    text = (get_data(__package__, f"{name.replace('-', '_')}.py") or b"").decode()
    found = _SUMMARY.search(text)
    return found[1] if found else ""


def build_app(arguments: Sequence[str] = ()) -> typer.Typer:
    """Return the program with the command that the arguments name, without any for its own help.

    Otherwise with all of them, which takes three times as long to import and parse.
    """
    app = typer.Typer(
        name="scara-iso",
        add_completion=False,  # --install-completion writes a shell's start-up files in place
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
        cls=_Program,
        subcommand_metavar="COMMAND",
        context_settings={
            "help_option_names": [*_HELP],
            "terminal_width": max(min(get_terminal_size().columns, _WIDEST) - 2, _NARROWEST),
        },
        help="How repeatable a SCARA is, by ISO 9283 and digital dial indicators, and why.",
    )
    app.callback()(_general)
    if _completing():
        completion_init()
    for name in _wanted(arguments):
        module = import_module(COMMANDS[name])
        if hasattr(module, f"{name}_app"):
            app.add_typer(getattr(module, f"{name}_app"), name=name)
        else:
            app.command(name, cls=Command)(getattr(module, f"{name.replace('-', '_')}_command"))
    return app


def _wanted(arguments: Sequence[str]) -> Sequence[str]:
    called = _command(arguments)
    if called:
        return (called,)
    asked = set(arguments) & set(_HELP) and set(arguments) <= {*_HELP, *_ANYWHERE}
    return () if asked and not _completing() else tuple(COMMANDS)


def _completing() -> bool:
    """Say whether a shell asks how a line may go on."""
    return "_SCARA_ISO_COMPLETE" in os.environ


def _show_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"scara-iso {__version__}")
        raise typer.Exit


def _general(
    debug: bool = typer.Option(False, "--debug", help="Show the traceback of an error."),
    no_color: bool = typer.Option(False, "--no-color", help="No colour, as NO_COLOR does."),
    version: bool = typer.Option(  # noqa: ARG001 - typer calls _show_version
        False, "--version", callback=_show_version, is_eager=True, help="Show the version."
    ),
) -> None:
    settings.debug = debug
    settings.no_color = no_color


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command with ``argv`` and return its exit code; errors go to standard error."""
    arguments = _in_order(sys.argv[1:] if argv is None else argv)
    settings.arguments = tuple(arguments)
    _mend_streams(reopen=_command(arguments) == "record")
    with warnings.catch_warnings():
        warnings.showwarning = lambda message, *_, **__: _say([f"scara-iso: {message}"])
        return _call(arguments)


def _in_order(arguments: Sequence[str]) -> list[str]:
    """Return general options, which users write anywhere, in front; ``help COMMAND`` as --help."""
    end = list(arguments).index("--") if "--" in arguments else len(arguments)
    general = [word for word in arguments[:end] if word in _ANYWHERE]
    words = [*(word for word in arguments[:end] if word not in _ANYWHERE), *arguments[end:]]
    at = next((k for k, word in enumerate(words) if not word.startswith("-")), None)
    if at is not None and words[at] == "help":
        words = [*words[:at], *words[at + 1 :], "--help"]
    return [*general, *words]


def _command(arguments: Sequence[str]) -> str:
    """Return the command that the arguments call, empty where they call none."""
    first = next((word for word in arguments if not word.startswith("-")), "")
    return first if first in COMMANDS else ""


def _mend_streams(*, reopen: bool) -> None:
    """Let no character that a stream cannot hold end a command.

    With ``reopen`` streams that were closed lead nowhere: a recording goes on without them. Other
    commands say that they are closed.
    """
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        stream = getattr(sys, name)
        if stream is None and reopen:
            nowhere = Path(os.devnull).open(mode, encoding="utf-8")  # noqa: SIM115 - to the end
            setattr(sys, name, nowhere)
        elif hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")


def _call(arguments: Sequence[str]) -> int:
    try:
        _check_characters(arguments)
        if sys.stdout is None:
            raise OSError("standard output is closed")
        code = _run(arguments)
        sys.stdout.flush()
    except SystemExit as leaving:
        if isinstance(leaving.__context__, OSError):  # the parser's answer to a closed pipe
            return _discard_output()
        return leaving.code if isinstance(leaving.code, int) else 1
    except (KeyboardInterrupt, typer.Abort):
        _say([_INTERRUPTED])
        return process.INTERRUPTED
    except BrokenPipeError:
        return _discard_output()
    except Exception as error:  # noqa: BLE001 - the one error boundary
        lines, code = _explain(error)
        trace = "".join(traceback.format_exception(error)).rstrip("\n").split("\n")
        _say([*(trace if settings.debug else ()), *lines])
        return code
    return code if isinstance(code, int) else 0


def _run(arguments: Sequence[str]) -> object:
    if set(arguments) <= set(_ANYWHERE) and not _completing():
        sys.stdout.write(WELCOME)
        return 0
    code = build_app(arguments)(args=arguments, prog_name="scara-iso", standalone_mode=False)
    if code == process.INTERRUPTED:  # what the parser makes of Ctrl-C
        raise KeyboardInterrupt
    return code


def _check_characters(arguments: Sequence[str]) -> None:
    """Raise `UsageError` for characters that no file's name and no shell's word can hold."""
    try:
        names = os.fsencode("".join(arguments))
    except UnicodeEncodeError as error:
        raise UsageError(f"an argument is not text: {error.reason}") from error
    if b"\0" in names:
        raise UsageError("a NUL character in the arguments")


def _discard_output() -> int:
    """Return the code where the reader left: nothing to say, but no success either.

    What is still to be written must not fail again when the process ends.
    """
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
        except (ValueError, AttributeError):  # closed by the caller
            continue
    return CANNOT_WRITE


def _say(lines: Sequence[str]) -> None:
    """Write to standard error; where that is closed, the exit code still says it."""
    with suppress(OSError, ValueError, AttributeError):
        for line in lines:
            say_in_words(as_options(line))
        sys.stderr.flush()
        return
    _discard_output()


def _explain(error: Exception) -> tuple[list[str], int]:
    if isinstance(error, ScaraIsoError):
        said = f"scara-iso: {error}".split("\n")
        hint = _hint(error.where) if isinstance(error, NoInputError) else ""
        remedy = [f"  {todo}"] if (todo := hint or error.remedy) else []
        first = 1 if len(said) > _LONG else len(said)  # what to do is not below a long list
        return [*said[:first], *remedy, *said[first:]], error.exit_code
    if process.were_heard():  # within a library that made another error of it
        return [_INTERRUPTED], process.INTERRUPTED
    if hasattr(error, "format_message") and hasattr(error, "exit_code"):  # the parser's own
        return _explain_call(error), int(error.exit_code)
    if isinstance(error, OSError) and error.filename and error.errno in _NO_INPUT:
        todo = "  name another file or folder, or have it opened to you"
        return [f"scara-iso: {error.filename}: {error.strerror}", todo], NoInputError.exit_code
    if isinstance(error, OSError):
        todo = "  make room, or send it to another place"
        return [f"scara-iso: cannot write: {error}", todo], CANNOT_WRITE
    return [
        f"scara-iso: a defect of this program: {type(error).__name__}: {error}",
        "  run it again with --debug and report what it prints",
    ], BUG


def _explain_call(error: Any) -> list[str]:
    """Return what the parser complains of without its names of types, and what was meant."""
    complaint = error.format_message()
    for said, plain in _COMPLAINTS.items():
        complaint = complaint.replace(said, plain)
    extra, no_command = _EXTRA.search(complaint), _NO_COMMAND.match(complaint)
    hint = _hint(extra[1], is_argument=True) if extra else ""
    if no_command and os.path.exists(no_command[1]):  # noqa: PTH110 - it may be too long a name
        hint = f"to analyze it: scara-iso analyze {shlex.quote(no_command[1])}"
    path = getattr(getattr(error, "ctx", None), "command_path", "scara-iso")
    return [f"scara-iso: {complaint}", f"  {hint}" if hint else f"  see '{path} --help'"]


def _hint(name: str, *, is_argument: bool = False) -> str:
    """Return what to do where a word behind command and table is no file but ends as a report."""
    ending = Path(name).suffix.lower()
    words = [word for word in settings.arguments if not word.startswith("-")]
    read = os.path.exists(name) or ending in _READ_TOO  # noqa: PTH110 - it may be too long a name
    if (
        name not in words[2:]
        or (read and not is_argument)
        or ending not in (*render.endings(), ".dfq")
    ):
        return ""
    program = typer.main.get_command(build_app(settings.arguments))
    command = getattr(program, "commands", {}).get(_command(settings.arguments))
    writes = any("-o" in param.opts for param in getattr(command, "params", ()))
    return f"did you mean -o {name}?" if writes else ""
