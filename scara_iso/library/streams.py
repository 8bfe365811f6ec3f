"""`visits`: a fast sensor's stream to a table of visits."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Unpack

from scara_iso.iso9283 import StreamVisits, with_arrivals
from scara_iso.library.inputs import ReadingOptions, Table, TableOptions
from scara_iso.run import Run
from scara_iso.signals import Wanted, find_visits
from scara_iso.tables import read_bytes

_RECORDING = ".raw.jsonl"


def visits(
    stream: Table,
    *,
    dwell: float = 1.0,
    still: float | None = None,
    band: float | None = None,
    poses: str | Sequence[str] = (),
    **reading: Unpack[ReadingOptions],
) -> StreamVisits:
    """Return the visits of a stream: a row for each sample, time_s and the axes as columns.

    ``stream`` is a table, or the raw file of a recording (NAME.raw.jsonl). ``dwell`` is the
    shortest rest that is a visit [s]; ``still`` the largest range of the readings within a window
    at rest and ``band`` the half width of the limit band (7.4), both in mm (degrees where there are
    angles only); without them both are found from the stream. ``poses`` names the rests in turn,
    ``-`` one that is no pose: ``"P1,-"``, or a sequence. ``reading`` is as in `read_table`.
    Raises `DataError` for what cannot be read or told apart.
    """
    order = poses.split(",") if poses and isinstance(poses, str) else list(poses)
    wanted = Wanted(dwell, still, band, tuple(name.strip() for name in order))
    run, digest = _read(stream, TableOptions(**reading))
    found = with_arrivals(find_visits(run, wanted))
    source = {} if digest is None else {"stream_sha256": digest}
    named = {"stream": Path(run.origin.source).name} if run.origin.source else {}
    return replace(
        found, run=replace(found.run, metadata={**named, **source, **found.run.metadata})
    )


def _read(stream: Table, options: TableOptions) -> tuple[Run, str | None]:
    """Return the run of the samples and the SHA-256 of the bytes that it was read from."""
    if isinstance(stream, str | Path) and str(stream).endswith(_RECORDING):
        from scara_iso.rawfile import read_history

        run = read_history(Path(stream)).run()
        return run, hashlib.sha256(read_bytes(stream)[0]).hexdigest()
    if isinstance(stream, str | Path) and str(stream) != "-":
        digest = hashlib.sha256(read_bytes(stream)[0]).hexdigest()
        return options.read(stream), digest
    if isinstance(stream, bytes) or (isinstance(stream, str) and stream == "-"):
        data, _ = read_bytes(stream)
        return options.read(data), hashlib.sha256(data).hexdigest()
    return options.read(stream), None
