"""`new_test`: the folder of a test, from the plan of a model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from scara_iso.acceptance import FILE, plan_test, toml_of
from scara_iso.disk import write_file
from scara_iso.errors import CannotCreateError, UsageError
from scara_iso.library.models import plan
from scara_iso.robot import read_model


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
    if file.exists():
        raise CannotCreateError(
            "is there already", where=str(file), remedy="edit it, or name another folder"
        )
    _check_percents({"velocities": velocities, "loads": loads})
    described = read_model(model)
    test = plan_test(
        plan(described, **planned), described, model_path=model, folder=folder,
        velocities=velocities, loads=loads,
    )  # fmt: skip
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CannotCreateError(
            f"cannot be created ({error.strerror})", where=str(folder), remedy="name another folder"
        ) from error
    write_file(file, toml_of(test).encode())
    return file


def _check_percents(given: Mapping[str, Sequence[float]]) -> None:
    for name, values in given.items():
        wrong = [value for value in values if not 0 <= value <= 100]
        if wrong or not values or len(set(values)) < len(values):
            raise UsageError(
                f"{name} {', '.join(f'{value:g}' for value in values)}: no such test",
                remedy=f"give per cent of the rated ones, each once: `{name}=100,50,10`",
            )
