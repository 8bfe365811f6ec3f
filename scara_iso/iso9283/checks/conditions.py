"""Conditions of the test that the table does not state.

ISO 9283 wants load, velocity and ambient conditions stated and held constant; a figure without its
instrument and calibration cannot be traced. Add them as ``# key: value`` lines in the head of the
table, or in test.toml. They are then compared with rated values and limits.
"""

from scara_iso.iso9283.checks import _stated
from scara_iso.iso9283.core.results import Finding, Findings, Measured
from scara_iso.run import Run

CODE = "not-stated"
_CONDITIONS = {
    "load": _stated.LOAD,
    "velocity": _stated.VELOCITY,
    "ambient temperature": {"temperature", "temperature_c", "ambient_temperature"},
    "instrument": {"indicator", "instrument", "dial"},
}


def check(measured: Measured) -> Findings:
    """Yield one note that lists what is not stated."""
    run = measured.run
    lines = {key.lower().partition("[")[0]: text for key, text in run.metadata.items()}
    columns = {name.lower() for name in run.covariates}
    missing = [_missing(run, name, keys, columns) for name, keys in _CONDITIONS.items()]
    unsaid = (key for key, text in lines.items() if text.strip() and not _stated.is_said(text))
    missing += [key.replace("_", " ") for key in unsaid if key not in columns]
    if any(missing):
        what = f"not stated: {', '.join(filter(None, missing))}"
        rule = "ISO 9283 6.2, 6.3 require them"
        advice = "add '# key: value' lines to the table's head"
        yield Finding(CODE, "info", what, rule=rule, advice=advice)


def _missing(run: Run, name: str, keys: set[str], columns: set[str]) -> str:
    """Return a condition that is not stated; where it is of some poses alone, with the others."""
    lines = _stated.stated(run.metadata, keys)
    of = {line.key.lower().partition("[")[2].rstrip("]") for line in lines}
    poses = [str(label) for label, _ in run.rows_by_pose()]
    left = [pose for pose in poses if pose.lower() not in of]
    if keys & columns or "" in of or (of and len(left) in (0, len(poses))):
        return ""
    return f"{name} at {', '.join(left)}" if of else name
