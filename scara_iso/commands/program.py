"""`program`: the program by which a robot paces a test over its line."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from scara_iso import __version__, recorder
from scara_iso.base.errors import CannotCreateError, UsageError
from scara_iso.base.files import Disk, write_atomically
from scara_iso.commands.operator.recording import part_program
from scara_iso.commands.shared import output as out
from scara_iso.commands.shared.options import Asked, argument, option, output_file, takes_options_of
from scara_iso.iso9283 import CYCLES_RUN
from scara_iso.testfolder import WholeTest, read_test

DWELL_S = 5.0
_NAME = "iso_test"


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotProgram:
    """A program in the language of a controller, on which it was never run."""

    schema: Literal["scara-iso/program/1"] = "scara-iso/program/1"
    """Name and number of this schema."""
    language: str
    """Its key."""
    controllers: str
    """That understand it."""
    run_on_a_controller: bool
    """Whether it ever was."""
    stages: tuple[recorder.ProgramPart, ...]
    """In their order."""
    points: tuple[str, ...]
    """To be taught, by name."""
    dwell_s: Annotated[float, ("unit", "s")]
    """At rest at the pose before its reading."""
    line: str
    """Where the recorder listens, or `serial`."""
    files: Mapping[str, str]
    """Their texts by name, the program first."""


@dataclass(frozen=True, slots=True, kw_only=True)
class KnownLanguages:
    """``program`` alone."""

    schema: Literal["scara-iso/program-languages/1"] = "scara-iso/program-languages/1"
    """Name and number of this schema."""
    languages: tuple[recorder.Language, ...]
    """By their keys."""


def program(
    language: str,
    folder: str | Path | None = None,
    *,
    line: str,
    poses: str | Sequence[str] | None = None,
    cycles: int | None = None,
    dwell: float | None = None,
    load: float | None = None,
    unattended: bool = False,
    name: str = _NAME,
) -> RobotProgram:
    """Return the program by which a robot visits the poses of a test and asks for each reading.

    ``language`` is a key of `find_languages`. ``folder`` is that of a test: its test.toml gives
    poses, velocities, cycles and dwell; of several loads ``load`` [% of rated] names the one
    mounted. Otherwise every cycle visits ``poses``. ``line`` is ``HOST:PORT`` where the recorder
    listens (``trigger=listen://HOST:PORT``), or ``serial``. ``dwell`` is in seconds, 5 unless
    stated. Between two poses of a folder the robot waits for a person who moves the dials, unless
    ``unattended``. Raises `UsageError` for options that do not fit and for names that cannot stand
    in a program, and as `read_test`.
    """
    known = recorder.find_language(language)
    test = None if folder is None else read_test(Path(folder))
    if test is None:
        stages = _tour(poses, cycles, load)
    else:
        _refuse_stated(test, poses=poses, cycles=cycles, dwell=dwell)
        stages = tuple(stages_of(test, load))
    rests = (dwell, None if test is None else test.schedule.dwell_s, DWELL_S)
    rest = next(one for one in rests if one is not None)
    if not 0 <= rest <= 3600:
        raise UsageError(f"a dwell of {rest:g} s", remedy="give 0 to 3600 s, as `dwell=5`")
    plan = recorder.ProgramPlan(
        name,
        stages,
        rest,
        recorder.parse_served(line, known),
        __version__,
        both_sides=test is not None and test.approaches_by_turns,
        attended=not unattended,
    )
    return RobotProgram(
        language=known.key,
        controllers=known.controllers,
        run_on_a_controller=False,
        stages=stages,
        points=plan.points,
        dwell_s=plan.dwell_s,
        line="serial" if plan.line is None else str(plan.line),
        files=recorder.write_program(known, plan),
    )


def _tour(
    poses: str | Sequence[str] | None, cycles: int | None, load: float | None
) -> tuple[recorder.ProgramPart, ...]:
    if poses is None or load is not None:
        raise UsageError(
            "no poses are named" if poses is None else "a load is chosen from a test folder",
            remedy="name the folder of a test, or give `poses=P1,P2,P3,P4,P5`",
        )
    names, run = recorder.parse_poses(poses), cycles or CYCLES_RUN
    return (recorder.ProgramPart(recorder.program_id(names, run), names, run, 100.0),)


def _refuse_stated(test: WholeTest, **given: object) -> None:
    if test.schedule.dwell_s is None:
        given.pop("dwell")
    if stated := [name for name, value in given.items() if value is not None]:
        raise UsageError(
            f"test.toml says the {stated[0]}", remedy=f"leave `{stated[0]}=` out, or edit test.toml"
        )


def stages_of(test: WholeTest, load: float | None) -> Iterator[recorder.ProgramPart]:
    """Yield the parts of a test at a load, in its order; a drift test has a program of its own.

    Raises `UsageError` where the test has several loads and none of them is named.
    """
    loads = test.schedule.loads
    if len(loads) > 1 if load is None else load not in loads:
        raise UsageError(
            "the test has several loads" if load is None else f"the test has no load of {load:g} %",
            remedy=f"name the one that is mounted: `load={loads[0]:g}`; "
            f"loads: {', '.join(f'{one:g}' for one in loads)}",
        )
    for part in test.parts():
        if not part.other_tests and part.condition.load == (loads[0] if load is None else load):
            announced, cycles = part_program(part, test), test.visits_of(part)
            yield recorder.ProgramPart(announced, (part.pose,), cycles, part.condition.velocity)


@takes_options_of(
    program,
    language=argument(
        "Language of the controller.",
        "LANGUAGE",
        str | None,
        show_default=False,
        autocompletion=lambda: list(recorder.find_languages()),
    ),
    folder=argument("Folder of the test.", "DIR", Path | None, show_default=False),
    poses=option("Poses of every cycle, without DIR.", metavar="P1,P2,..."),
    cycles=option("Number of cycles, the first included [31].", metavar="N", min=2, max=9999),
    dwell=option("Rest before each reading [5 s].", metavar="SECONDS"),
    line=option("Address where record listens, or serial.", kind=str | None, metavar="HOST:PORT"),
    load=option("Load mounted, in per cent of the rated one.", metavar="PERCENT"),
    unattended=option("Run through without waiting for a person between poses."),
    output=output_file("File to write [standard output]."),
    replace=option("Overwrite files that exist."),
)
def program_command(
    asked: Asked[RobotProgram],
    *,
    output: Path | None = None,
    replace: bool = False,
    json: bool = False,
) -> None:
    """Write the program by which a robot paces the test; alone, list the languages.

    No program was ever run on a controller.

    Example: scara-iso program rapid acceptance --line 192.168.1.10:5000 -o iso_test.mod
    """
    if asked["language"] is None:
        _list(json=json)
        return
    known = recorder.find_language(asked["language"])
    if asked["line"] is None:
        raise UsageError("no address of the recorder", remedy="give `line=192.168.1.10:5000`")
    paths = [] if output is None else _paths(known, output, replace=replace)
    if output is None and not json and len(known.endings) > 1:
        raise UsageError(
            f"{known.key} has {len(known.endings)} files", remedy="name them: `output=iso_test`"
        )
    found = asked.result(name=_NAME if output is None else output.stem)
    texts = [text.encode() for text in found.files.values()]
    if paths:
        write_atomically(Disk(), dict(zip(paths, texts, strict=True)))
    elif not json:
        out.write_text(next(iter(found.files.values())), None)
    for path in paths:
        out.tell_written(path)
    if json:
        out.write_result(found)


def _paths(language: recorder.Language, output: Path, *, replace: bool) -> list[Path]:
    """Return the files to write; `CannotCreateError` where one is there, as `check_outputs`."""
    if output.suffix not in ("", language.endings[0]):
        raise UsageError(
            f"{output.name}: a {language.key} program ends in {language.endings[0]}",
            remedy="name it so",
        )
    paths = [output.with_name(f"{output.stem}{ending}") for ending in language.endings]
    there = [path for path in paths if os.path.lexists(path)]
    if there and not replace:
        raise CannotCreateError(
            "exists already", where=str(there[0]), remedy="give `replace=`, or another name"
        )
    out.check_outputs([], [], decided=paths)
    return paths


def _list(*, json: bool) -> None:
    known = tuple(recorder.find_languages().values())
    if json:
        out.write_result(KnownLanguages(languages=known))
        return
    width = max(len(one.key) for one in known)
    lines = [f"{one.key:<{width}}  {one.controllers}: {one.talks_by}" for one in known]
    lines += ["None of them was run on a controller. --help has an example.", ""]
    out.write_text("\n".join(lines), None)
