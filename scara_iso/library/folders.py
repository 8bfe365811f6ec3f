"""`new_test`: the folder of a test, from the plan of a model, or its test.toml alone."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from scara_iso.base.disk import check_folder, check_output, write_file
from scara_iso.base.errors import CannotCreateError, UsageError
from scara_iso.iso9283 import PosePlan
from scara_iso.library.models import plan
from scara_iso.robot import Model, read_model
from scara_iso.testfolder import FILE, plan_test, toml_of


def new_test(
    folder: str | Path,
    model: str | Path,
    *,
    velocities: Sequence[float] = (100.0,),
    loads: Sequence[float] = (100.0,),
    **planned: Any,
) -> Path:
    """Make the folder of a test with the test.toml that `plan` gives for a model; return that file.

    ``velocities`` and ``loads`` are in per cent of the rated ones; ``planned`` are options of
    `plan`. Raises as `plan`, and `CannotCreateError` where a test is there already.
    """
    folder, model = Path(folder), Path(model)
    file = folder / FILE
    refuse_existing_test(file)
    check_folder(folder)
    _check_percents({"velocities": velocities, "loads": loads})
    described = read_model(model)
    found = plan(described, **planned)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CannotCreateError(
            f"cannot be created ({error.strerror})", where=str(folder), remedy="name another folder"
        ) from error
    return _write(file, found, described, model, velocities, loads)


def write_planned_test(file: str | Path, planned: PosePlan, model: str | Path) -> Path:
    """Write the test of a plan, as `new_test` does, for its one velocity and load; return ``file``.

    ``model`` is the file that the plan was made of. Raises `CannotCreateError` where ``file`` is
    there already: a test.toml is edited by hand.
    """
    file, model = Path(file), Path(model)
    refuse_existing_test(file)
    check_output(file)
    how = planned.conditions
    velocities, loads = (how.velocity_percent,), (how.load_percent,)
    _check_percents({"velocities": velocities, "loads": loads})
    return _write(file, planned, read_model(model), model, velocities, loads)


def refuse_existing_test(file: Path) -> None:
    """Raise `CannotCreateError` where a test is there already: it is edited by hand."""
    if os.path.lexists(file):
        raise CannotCreateError(
            "is there already", where=str(file), remedy="edit it, or name another folder"
        )


def _write(
    file: Path,
    planned: PosePlan,
    described: Model,
    model: Path,
    velocities: Sequence[float],
    loads: Sequence[float],
) -> Path:
    test = plan_test(
        planned,
        described,
        model_path=model,
        folder=file.parent,
        velocities=velocities,
        loads=loads,
    )
    write_file(file, toml_of(test).encode())
    return file


def _check_percents(given: Mapping[str, Sequence[float]]) -> None:
    for name, values in given.items():
        wrong = [v for v in values if not 0 <= v <= 100 or (v == 0 and name == "velocities")]
        if wrong or not values or len(set(values)) < len(values):
            raise UsageError(
                f"{name} {', '.join(f'{value:g}' for value in values)}: no such test",
                remedy=f"give per cent of the rated ones, each once: `{name}=100,50,10`",
            )
