"""A gauge as the user writes it: ``AXIS=DRIVER[?OPTIONS]@PORT``, and the metadata of a table."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from urllib.parse import quote

from scara_iso.acquisition.indicators import KEYBOARD, Dialect, Parity, find_dialect
from scara_iso.acquisition.indicators.generic import make_generic
from scara_iso.acquisition.ports import is_device, is_keyboard, split_options
from scara_iso.acquisition.recorder.sizes import wrong_sizes
from scara_iso.errors import DataError, UsageError
from scara_iso.files import read_toml
from scara_iso.quantities import parse_unit
from scara_iso.run import AXES

OPTIONS = {
    "unit": "unit of the display, such as mm or inch",
    "channel": "channel of a multiplexer",
    "baud": "9600",
    "bits": "7 or 8 data bits",
    "parity": "N, E or O",
    "stop": "1 or 2 stop bits",
    "request": r"bytes that ask for a reading, such as ?\r",
    "pattern": "regular expression with the groups value and unit (driver generic only)",
}
"""Options behind a driver, written as in a URL: ``X=mitutoyo-mux?unit=mm&channel=1@COM3``."""

_SIMPLE = "X=opto-rs232@/dev/ttyUSB0"
_EXAMPLE = f"{_SIMPLE} or X=mitutoyo-mux?unit=mm&channel=1@COM3"
_AXES = {name.lower(): name for name in AXES}
_LONGEST = 50_000
_TABLE_KEY = re.compile(
    r"(unit|resolution)(_.*)?|first_cycle_discarded|axes_recorded"
    r"|simulated|cycles_planned|record_.*|indicator"
)
_KEY = re.compile(r"[A-Za-z][A-Za-z0-9_ -]{0,60}")


@dataclass(frozen=True, slots=True)
class GaugeSpec:
    """One indicator: its axis, how it speaks, its port, and the unit that the user states."""

    text: str
    """As the user wrote it, its unit included wherever that was stated."""
    axis: str
    dialect: Dialect
    address: str
    unit: str | None


def parse_gauge(text: str, *, unit: str | None = None) -> GaugeSpec:
    """Return the gauge that ``text`` spells; ``unit`` holds where its options name none.

    Raises `UsageError` for an unknown axis, driver, option or unit.
    """
    name, equals, rest = text.partition("=")
    driver, at, address = rest.partition("@")
    axis = _AXES.get(name.strip().lower())
    if not (equals and at and address.strip()) or axis is None:
        raise UsageError(
            f"`gauge={text}`: not AXIS=DRIVER@PORT" if axis else f"no axis {name.strip()!r}",
            remedy=f"write {axis or 'X'}=auto@{rest if axis and rest and not at else 'PORT'} to "
            f"have the driver found, or {_EXAMPLE}; axes: {', '.join(AXES)}",
        )
    key, options = split_options(driver, OPTIONS)
    _check_keyboard(key.strip(), address.strip())
    stated = options.get("unit", unit)
    if "unit" not in options and stated is not None:
        driver += f"{'&' if options else '?'}unit={quote(stated)}"
    return GaugeSpec(
        text=f"{axis}={driver}@{address}",
        axis=axis,
        dialect=_dialect(key.strip(), options),
        address=address.strip(),
        unit=None if stated is None else parse_unit(stated).name,
    )


def parse_gauges(texts: Iterable[str], *, unit: str | None = None) -> tuple[GaugeSpec, ...]:
    """Return the gauges, one an axis; `UsageError` otherwise, or where there is none."""
    gauges = tuple(parse_gauge(text, unit=unit) for text in texts)
    axes = [gauge.axis for gauge in gauges]
    twice = sorted({axis for axis in axes if axes.count(axis) > 1})
    if sum(is_keyboard(gauge.address) for gauge in gauges) > 1:
        raise UsageError("two gauges on one keyboard", remedy="type the readings of one axis")
    if not gauges or twice:
        raise UsageError(
            f"two gauges for {', '.join(twice)}" if twice else "no indicator is named",
            remedy=f"give `gauge={_SIMPLE}`, once for each axis",
        )
    return gauges


def _check_keyboard(key: str, address: str) -> None:
    """Raise `UsageError` where one of port and driver is the keyboard, and the other a cable's."""
    if is_device(address) and is_keyboard(address) != (key == KEYBOARD.key):
        raise UsageError(
            f"{key}@{address}: the keyboard has its own driver", remedy="write X=keyboard@keyboard:"
        )


def _dialect(key: str, options: Mapping[str, str]) -> Dialect:
    pattern = options.get("pattern")
    if pattern is not None and key != "generic":
        raise UsageError(f"{key} has its own grammar", remedy="pattern= goes with generic")
    dialect = make_generic(pattern) if pattern is not None else find_dialect(key)
    dialect = dialect.configure(
        baud=_whole(options, "baud"),
        data_bits=_whole(options, "bits"),
        parity=_parity(options.get("parity")),
        stop_bits=_whole(options, "stop"),
        channel=options.get("channel"),
    )
    if "request" in options:
        dialect = replace(dialect, request_template=_bytes(options["request"]), request_line=None)
    return dialect


def _whole(options: Mapping[str, str], key: str) -> int | None:
    text = options.get(key)
    if text is None:
        return None
    if not (text.isascii() and text.isdigit() and len(text) < 9):
        raise UsageError(
            f"{key}={text} is not a whole number", remedy=f"write {key} as digits only"
        )
    return int(text)


def _parity(text: str | None) -> Parity | None:
    match (text or "").upper():
        case "":
            return None
        case "N" | "E" | "O" as parity:
            return parity
    raise UsageError(f"parity={text}: use N, E or O", remedy="write parity=N, parity=E or parity=O")


def _bytes(text: str) -> bytes:
    try:
        return text.encode("ascii").decode("unicode_escape").encode("latin-1")
    except UnicodeError as error:
        raise UsageError(f"request={text}: {error}", remedy=r"write \r, \n, \x02") from error


def read_metadata(path: Path) -> dict[str, str]:
    """Return the ``key = value`` lines of a TOML file as text.

    Raises `NoInputError` where it cannot be read and `DataError` where it is not such a file.
    """
    found = read_toml(path, "docs/recording.md")
    nested = sorted(key for key, value in found.items() if isinstance(value, dict | list))
    if nested:
        raise DataError(
            f"{', '.join(nested)}: not a single value",
            where=str(path),
            remedy='write lines such as robot = "FUM SCARA"',
        )
    return check_metadata({key: _toml_text(value) for key, value in found.items()})


def parse_metadata(texts: Iterable[str]) -> dict[str, str]:
    """Return ``KEY=VALUE`` options; `UsageError` where one is not, or the table says it itself."""
    pairs = [text.partition("=") for text in texts]
    wrong = [key for key, equals, _ in pairs if not equals]
    if wrong:
        raise UsageError(f"`meta={wrong[0]}`: not KEY=VALUE", remedy="`meta=robot=FUM SCARA`")
    return check_metadata({key.strip(): value.strip() for key, _, value in pairs})


def check_metadata(found: Mapping[str, str]) -> dict[str, str]:
    """Return ``found``; `UsageError` for too much, or a key that is no word or the recorder's."""
    wrong = [key for key in found if not _KEY.fullmatch(key)]
    taken = [key for key in found if _TABLE_KEY.fullmatch(key.lower().replace(" ", "_"))]
    if wrong or taken:
        raise UsageError(
            f"metadata {(wrong + taken)[0]!r}: "
            + ("not a key" if wrong else "the recorder states this itself"),
            remedy="use keys such as robot, payload, velocity, temperature, operator",
        )
    if sizes := wrong_sizes(found):
        raise UsageError(
            f"metadata {sizes[0]!r}: {found[sizes[0]]!r} is not a plain number above 0",
            remedy="in mm, of an angle in degrees: indicator_uncertainty=0.0005",
        )
    if sum(len(key) + len(value) for key, value in found.items()) > _LONGEST:
        raise UsageError(f"metadata of more than {_LONGEST} characters", remedy="shorten it")
    return dict(found)


def _toml_text(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
