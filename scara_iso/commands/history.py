"""`history`: every test of one robot, in time order."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import datetime
from functools import partial
from itertools import pairwise, product
from pathlib import Path
from typing import Any, Unpack

from scara_iso import comparison, iso9283, reporting
from scara_iso.base.errors import DataError, Fault, NoInputError, ScaraIsoError, UsageError
from scara_iso.base.files import is_file, is_folder
from scara_iso.commands.shared import inputs, options as opt, output as out
from scara_iso.reporting import printable
from scara_iso.testfolder import is_test_folder

_HEAD = 4096
_DATE = re.compile(r"(?im)^\W{0,3}dat(?:e|um|a)[\s:=;,]{1,4}([0-9][0-9.:/T -]{7,24})")
_SHOWN = 3
"""Remarks of a table that are quoted."""


def history(
    tables: inputs.Tables,
    *,
    events: str | Path | None = None,
    robot: str | None = None,
    limits: inputs.Sizes | None = None,
    **options: Unpack[inputs.TablesOptions],
) -> comparison.RobotHistory:
    """Return every test of one robot in time order: figures, control charts, trend, limit, service.

    ``tables`` are paths, runs or pandas tables, one a test, or the path of a folder, of tables or
    of folders: those of a folder in it are one test where one names a pose. Each states
    its date (``# date: 2026-05-12``, or a column `timestamp`), or else its file's name does.
    ``events`` is a table with the columns date and what, else each ``events.csv`` beside the tests
    of a folder is one. ``robot`` takes only the tests of that name or serial number, and of the
    one that stands with it alone.
    ``limits`` and the other options are those of `analyze`, for each table. A table that cannot be
    used is listed in ``unreadable``. Raises `DataError` where none can be used, one states no date,
    or the tests are of several robots or in no order; `NoInputError` for what is not there;
    `UsageError` for a limit of no figure.
    """
    limits = inputs.sizes_of("limits", limits)
    reading, counting = inputs.reading_and_counting(history, options)
    found, folders = _tests(tables, events, reading)
    analyses, failed = _analyses(found, reading, {"counting": counting, "limits": limits})
    if not analyses:
        remedies = {error.remedy for _, error in failed}
        raise DataError(
            f"none of {len(failed)} tables can be used",
            remedy=remedies.pop() if len(remedies) == 1 else "mend each as its line says",
            faults=[Fault(f"{name}: {_why(error)}") for name, error in failed],
        )
    if robot is not None:
        analyses = _of_robot(analyses, robot)
        if not analyses:
            raise DataError(
                f"no table is of the robot {printable(robot)!r}",
                remedy="write it as the tables state it: '# robot' or '# serial_number'",
            )
    _ask_which(analyses)
    services = _services(events, folders, analyses)
    dated = _dated(analyses)
    followed = comparison.follow(dated, services, robot=robot)
    named = sum(iso9283.moment_in_name(one.run) is not None for one in analyses)
    by_name = f"{named} of {len(analyses)} tables state no date: that in the file's name holds"
    return replace(
        followed,
        notes=(*followed.notes, *([by_name] if named else []), *_remarked(analyses)),
        unreadable=tuple(
            comparison.UnreadableTable(
                name, _why(error), (day := _day_of(name)) is not None and day >= dated[-1].when
            )
            for name, error in failed
        ),
    )


def _day_of(unreadable: str) -> datetime | None:
    """Return the day that the name or the head of a table states that cannot be read."""
    if day := iso9283.day_in_name(unreadable):
        return day
    text = Path(unreadable).read_bytes()[:_HEAD] if is_file(unreadable) else b""
    stated = _DATE.search(text.decode("utf-8", "replace"))
    return iso9283.parse_moment(stated[1]) if stated else None


def _remarked(analyses: Sequence[iso9283.Analysis]) -> Iterator[str]:
    for one in analyses:
        remarks = one.run.origin.remarks
        more = f" and {len(remarks) - _SHOWN} more" if len(remarks) > _SHOWN else ""
        if remarks:
            quoted = printable(", ".join(remarks[:_SHOWN]))
            yield f"{one.source}: remarked, and counted: {quoted}{more}"


def _tests(
    tables: inputs.Tables, events: str | Path | None, reading: inputs.Reading
) -> tuple[list[inputs.Table], list[Path]]:
    """Return the tables, one a test, and the folders among them.

    Of a folder and of those in it each table is a test; a folder is one where it names poses.
    """
    many: Any = tables if isinstance(tables, list | tuple) else [tables]
    paths = {k: Path(one) for k, one in enumerate(many) if isinstance(one, str | Path)}
    folders = {k: path for k, path in paths.items() if is_folder(path)}
    for folder in filter(is_test_folder, folders.values()):
        raise UsageError(
            "is the folder of one test",
            where=str(folder),
            remedy="name a folder of tables, one a test",
        )
    single = [one for k, one in enumerate(many) if k not in folders]
    found = inputs.tables_of(single) if single else []
    for folder in folders.values():
        found += inputs.table_files(folder)
        for below in inputs.folders_below(folder):
            inner = inputs.table_files(below)
            whole = is_test_folder(below) or any(inputs.names_a_pose(one, reading) for one in inner)
            found += [below] if whole else inner
    if events is not None:
        known = Path(events).resolve()
        found = [t for t in found if not isinstance(t, str | Path) or Path(t).resolve() != known]
    if not found:
        where = str(next(iter(folders.values()), ""))
        raise NoInputError("no table is there", where=where, remedy="put tables there, one a test")
    return found, [*folders.values()]


def _services(
    events: str | Path | None, folders: Sequence[Path], analyses: Sequence[iso9283.Analysis]
) -> list[comparison.ServiceEvent]:
    """Return what was done in time order: by the file given, else by all beside tests of folders.

    A file beside tests of another robot alone says nothing of this one.
    """
    if events is not None:
        return list(comparison.read_events(events))
    sources = [Path(one.run.origin.source) for one in analyses]
    above = [place for source in sources for place in (source, *source.parents)]
    below = [place for place in above if any(map(place.is_relative_to, folders))]
    files = [place / inputs.EVENTS for place in dict.fromkeys([*folders, *below])]
    found = [event for file in files if file.is_file() for event in comparison.read_events(file)]
    return sorted(found, key=lambda event: event.when)


def _analyses(
    tables: Sequence[inputs.Table], reading: inputs.Reading, options: Mapping[str, Any]
) -> tuple[list[iso9283.Analysis], list[tuple[str, ScaraIsoError]]]:
    def analysis(table: inputs.Table) -> iso9283.Analysis:
        return iso9283.analyze(inputs.read_run(table, reading), **options)

    found: list[iso9283.Analysis] = []
    failed: list[tuple[str, ScaraIsoError]] = []
    for k, table in enumerate(tables, 1):
        one = inputs.attempt(analysis, table)
        if isinstance(one, iso9283.Analysis):
            found.append(one)
            continue
        name = str(table) if isinstance(table, str | Path) else f"table {k}"
        if isinstance(one, NoInputError) and not is_file(name):
            raise one
        failed.append((name, one))
    return found, failed


def _why(error: ScaraIsoError) -> str:
    faults = error.fault_lines() if isinstance(error, DataError) else []
    return ": ".join([error.what, *(line.strip() for line in faults[:1])])


def _of_robot(analyses: Sequence[iso9283.Analysis], robot: str) -> list[iso9283.Analysis]:
    """Return the tests that state a robot by name or serial number, or only the other of the two.

    The other one is its own where it stands with no other robot.
    """
    asked = robot.strip().casefold()
    stated = [_stated(one) for one in analyses]
    known_as: dict[str, set[str]] = {}
    for names, serials in stated:
        for name, serial in product(names, serials):
            known_as.setdefault(name, set()).add(serial)
            known_as.setdefault(serial, set()).add(name)
    own = {asked, *(other for other in known_as.get(asked, ()) if known_as[other] == {asked})}
    words = [names.keys() | serials.keys() for names, serials in stated]
    return [
        one
        for one, known in zip(analyses, words, strict=True)
        if asked in known or (known and known <= own)
    ]


def _stated(analysis: iso9283.Analysis) -> tuple[dict[str, str], dict[str, str]]:
    """Return names and serial numbers that a table states, by how they are compared."""
    head = {key.partition("[")[0]: text for key, text in analysis.run.metadata.items()}
    texts = [
        [head.get(key, "").strip() for key in keys]
        for keys in (("robot", "item"), ("serial_number", "robot_serial_number"))
    ]
    names, serials = ({text.casefold(): text for text in own if text} for own in texts)
    return names, serials


def _ask_which(analyses: Sequence[iso9283.Analysis]) -> None:
    """Raise `DataError` where a name and a serial number may be one robot, and nothing says so."""
    stated = [_stated(one) for one in analyses]
    names = {key: text for own, serials in stated if not serials for key, text in own.items()}
    numbers = {key: text for own, serials in stated if not own for key, text in serials.items()}
    together = {pair for own, serials in stated for pair in product(own, serials)}
    if names and numbers and together.isdisjoint(product(names, numbers)):
        name, number = next(iter(names.values())), next(iter(numbers.values()))
        raise DataError(
            f"some tables state the robot {printable(name)}, others the serial number "
            f"{printable(number)}: is it one robot?",
            remedy=f"if it is, state both in one of them; else take one: `robot={name}`",
        )


def _dated(analyses: Sequence[iso9283.Analysis]) -> list[comparison.DatedAnalysis]:
    found = []
    missing = []
    for one in analyses:
        when = iso9283.moment_of_test(one.run) or iso9283.moment_in_name(one.run)
        if when and comparison.is_plausible(when):
            found.append(comparison.DatedAnalysis(when, one))
        else:
            text, source = one.run.metadata.get("date", ""), one.run.origin.source
            why = f": {printable(text)!r} is not year-month-day" if text else ""
            missing.append(Fault(source + why))
    if missing:
        raise DataError(
            f"{len(missing)} of {len(analyses)} tables state no date that can be read",
            remedy="write '# date: 2026-05-12' above each, or none and name it 2026-05-12.csv",
            faults=missing,
        )
    ordered = sorted(found, key=lambda test: test.when)
    zoned = [(iso9283.zoned_moment_of_test(one.analysis.run), one.source) for one in ordered]
    known = [(when, source) for when, source in zoned if when is not None]
    turned = [(a, b) for a, b in pairwise(known) if b[0] < a[0]]
    if turned:
        raise DataError(
            "time zones differ, and local times are in another order than the tests",
            remedy="state the dates of all tests in one zone, '# date: 2026-05-12T14:30'",
            faults=[Fault(f"{b} ({y}) was before {a} ({x})") for (x, a), (y, b) in turned],
        )
    return found


@opt.takes_options_of(
    history,
    "full",
    "json",
    tables=opt.argument("Tables, one for each test, or their folder.", "DIR|TABLE...", list[str]),
    events=opt.option("Services, columns date,what [events.csv of the folder].", metavar="FILE"),
    robot=opt.option("Only the tests of this robot or serial number.", metavar="NAME"),
    output=opt.output_file("Page of the robot, by its ending: .html .md .csv .xlsx .pdf."),
)
def history_command(
    asked: opt.Asked[comparison.RobotHistory], *, output: Path | None = None
) -> out.Answer:
    """Follow one robot over months: control charts, trend, when it may exceed a limit.

    Exit code 1 where a limit is exceeded since the last service, or where the last test does not
    prove it kept, or cannot be read.

    Example: scara-iso history examples/months --limit XY=0.03 -o robot.html
    """
    out.check_outputs([], [*asked["tables"], asked["events"]], pages=[output])
    found = asked.result()
    for one in found.unreadable:
        out.say(f"scara-iso: {one}")
    if output is not None:
        out.write_page(reporting.history_document(found), output)
    broken = [one.broken[-1] for one in found.spreads if one.broken]
    test = max(broken, key=lambda one: one.when, default=found.tests[-1])
    is_last = test.when == found.tests[-1].when
    which = "the last test" if is_last else f"the test of {test.when:%Y-%m-%d}"
    line = opt.command_line([test.source], asked.stated(*opt.READING, *opt.COUNTING))
    following = reporting.NextStep(f"scara-iso diagnose {line}", f"what is in {which}")
    report = partial(reporting.history_report, found, following)
    lacks = any(one.may_be_last for one in found.unreadable)
    limited = any(one.limit is not None for one in found.spreads)
    kept = not found.crossed and all(one.is_proven for one in found.spreads)
    kept &= not (lacks and limited)
    return out.Answer(found, report, output, code=0 if kept else out.NOT_WITHIN_LIMITS)
