"""The size of every unit, and what a display's text becomes in mm or degrees."""

from __future__ import annotations

import math
from collections.abc import Iterator

from scara_iso.base.quantities import parse_unit, rounding_uncertainty
from scara_iso.validation.result import ReferenceCheck

_SI = "SI Brochure (9th edition); inch = 25.4 mm exactly (yard and pound agreement of 1959)"
_SIZES = {
    "mm": 1.0,
    "um": 1e-3,
    "nm": 1e-6,
    "cm": 10.0,
    "m": 1e3,
    "inch": 25.4,
    "thou": 0.0254,
    "deg": 1.0,
    "rad": 57.29577951308232,
    "mrad": 0.05729577951308232,
    "arcmin": 1 / 60,
    "arcsec": 1 / 3600,
    "0.01 mm": 0.01,
}
_READ = {("0.5660", "inch"): 14.3764, ("35", "0.01 mm"): 0.35, ("-12.5", "um"): -0.0125}


def unit_checks() -> Iterator[ReferenceCheck]:
    """Yield one check for each unit and each reading of a display."""
    for name, size in _SIZES.items():
        found = parse_unit(name).to_base(1.0)
        yield ReferenceCheck("units", f"1 {name}", _SI, size, found, 1e-15 * size)
    for (text, name), expected in _READ.items():
        found = parse_unit(name).read(text)
        yield ReferenceCheck("units", f"{text} {name}", "exact in decimals", expected, found)
    rounded = rounding_uncertainty(1.0)
    exact = 1 / math.sqrt(12)
    yield ReferenceCheck("units", "u of rounding", "GUM F.2.2.1", exact, rounded, 1e-15)
