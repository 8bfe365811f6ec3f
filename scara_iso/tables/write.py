"""A `Run` to the canonical table."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Callable, Iterator
from decimal import Decimal

import numpy as np

from scara_iso.errors import DataError
from scara_iso.quantities import Dimension
from scara_iso.run import AXES, Axis, FloatArray, Run
from scara_iso.tables.layout import normal_key
from scara_iso.tables.names import Column, Kind, read_name
from scara_iso.tables.numbers import parse_number
from scara_iso.tables.statements import COMMAND, is_of_axes

_CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f]+")
_CUT = re.compile(r"[,;]\s*[\"']?[=+@-]|[,;\"]\s*$|^[^:]*\"|^[^:]*(:\s*)?,")


def write_table(run: Run) -> str:
    """Return ``run`` as the canonical table, which `read_table` reads back to the same run.

    Metadata lines first; lengths in mm, angles in degrees; readings with the digits of their
    resolution unless that would change a value; LF line ends. No text in it becomes a formula in
    a spreadsheet. Raises `DataError` for columns whose name says something else in a table.
    """
    _check_names(run)
    file = io.StringIO()
    for line in _preamble(run):
        file.write(f"{line}\n")
    columns: dict[str, list[str]] = {"cycle": [str(n) for n in run.cycle.tolist()]}
    if run.pose is not None:
        columns["pose"] = [_text_cell(label) for label in run.pose.tolist()]
    columns |= {name: _digits(axis.readings, axis.resolution) for name, axis in run.axes.items()}
    columns |= {_text_cell(n): _plain(n, values) for n, values in run.covariates.items()}
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*columns.values(), strict=True))
    return file.getvalue()


def _check_names(run: Run) -> None:
    axes = [name for name in run.axes if name not in AXES]
    wrong = [n for n in run.covariates if read_name(_text_cell(n)) != Column(Kind.COVARIATE, n)]
    if axes or wrong:
        raise DataError(
            f"a table cannot hold columns named {', '.join(map(repr, axes + wrong))}",
            remedy="rename them",
        )


def _preamble(run: Run) -> Iterator[str]:
    lengths = {n: a for n, a in run.axes.items() if a.dimension is Dimension.LENGTH}
    angles = {n: a for n, a in run.axes.items() if a.dimension is Dimension.ANGLE}
    if lengths:
        yield "# unit: mm"
    for name in angles:
        yield f"# unit_{name}: deg"
    yield from _sizes("resolution", lengths, angles, lambda axis: axis.resolution)
    yield from _sizes("indicator_uncertainty", lengths, angles, lambda axis: axis.uncertainty)
    for name, axis in run.axes.items():
        if axis.command is not None:
            yield f"# {COMMAND}_{name}: {axis.command!r}"
    for key, value in run.metadata.items():
        name = _CONTROL.sub(" ", normal_key(key).replace(":", "_").replace("=", "_"))
        if not is_of_axes(name):
            yield _metadata_line(name, value)


def _sizes(
    key: str,
    lengths: dict[str, Axis],
    angles: dict[str, Axis],
    size_of: Callable[[Axis], float | None],
) -> Iterator[str]:
    sizes = {name: size_of(axis) for name, axis in {**lengths, **angles}.items()}
    shared = sizes[next(iter(lengths))] if lengths else None
    if shared is not None and all(sizes[name] is not None for name in lengths):
        yield f"# {key}: {shared!r}"
        sizes = {n: size for n, size in sizes.items() if n in angles or size != shared}
    yield from (f"# {key}_{n}: {size!r}" for n, size in sizes.items() if size is not None)


def _metadata_line(key: str, value: str) -> str:
    """Return a metadata line; in quotes where a formula or another key could be cut out."""
    line = f"# {key}: {_CONTROL.sub(' ', value).strip()}"
    if not _CUT.search(line):
        return line
    return '"' + line.replace('"', '""') + '"'


def _text_cell(text: str) -> str:
    """Return a label or name that no spreadsheet takes for a formula; numbers are left alone."""
    text = _CONTROL.sub(" ", text)
    if text[:1] == "'" or (text[:1] in ("=", "+", "-", "@") and parse_number(text) is None):
        return "'" + text
    return text


def _digits(values: FloatArray, resolution: float | None) -> list[str]:
    if resolution is None:
        return [repr(v) for v in values.tolist()]
    places = max(0, -int(Decimal(repr(resolution)).normalize().as_tuple().exponent))
    rounded = [(f"{v:.{places}f}", v) for v in values.tolist()]
    return [text if float(text) == v else repr(v) for text, v in rounded]


def _plain(name: str, values: FloatArray) -> list[str]:
    if name == "approach" and np.all(np.abs(values) == 1):
        return [f"{v:+.0f}" for v in values.tolist()]
    return [repr(v) for v in values.tolist()]
