"""It was too warm or too cold for the test.

An arm of aluminium grows by 9 um per kelvin and 400 mm. Tests are usual at (20 ± 2) °C; where the
test has its own limits, state them as ``# temperature_limits: 18 .. 26 C``. The temperature is that
of the lines ``# temperature`` and of the column `temperature_C`.
"""

from scara_iso.iso9283.checks._stated import CELSIUS, first, stated
from scara_iso.iso9283.core.results import Finding, Findings, Measured

CODE = "temperature-limits"
_TEMPERATURE = {"temperature", "temperature_c", "ambient_temperature", "ambient_temperature_c"}
_LIMITS = {"temperature_limits", "temperature_limits_c"}
_USUAL = (18.0, 22.0)
_PRACTICE = "good practice (no clause verified): (20 ± 2) °C"


def check(measured: Measured) -> Findings:
    """Yield a warning where a temperature is outside the test's limits, else outside 20 ± 2 C."""
    run = measured.run
    own = first(run, _LIMITS)
    limits = None if own is None else own.ends(CELSIUS)
    unclear = [] if own is None or limits else [own]
    low, high = limits or _USUAL
    rule = f"the test's own limits: {low:g} .. {high:g} °C" if limits else _PRACTICE
    for line in stated(run.metadata, _TEMPERATURE):
        found = line.ends(CELSIUS)
        if found is None:
            unclear.append(line)
        elif not low <= found[0] <= found[1] <= high:
            yield Finding(CODE, "warning", f"{line} is outside", rule=rule)
    for name, values in run.covariates.items():
        if name.lower() in _TEMPERATURE and not low <= values.min() <= values.max() <= high:
            said = f"{name} goes from {values.min():g} to {values.max():g}"
            yield Finding(CODE, "warning", said, rule=rule)
    for line in unclear:
        yield line.unclear(CODE, "temperature", "20 C, or 18 .. 22 C")
