"""Conditions of the test that the table does not state.

ISO 9283 wants load, velocity and ambient conditions stated and held constant; a figure without its
instrument and calibration cannot be traced. Add them as ``# key: value`` lines in the head of the
table, or in test.toml. They are then compared with rated values and limits.
"""

from collections.abc import Collection

from scara_iso.iso9283.checks import _stated
from scara_iso.iso9283.results import Finding, Findings, Measured
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
    stated = {key for key, text in lines.items() if _stated.is_said(text)}
    known = stated | {name.lower() for name in run.covariates}
    missing = [condition for condition, keys in _CONDITIONS.items() if not keys & known]
    for condition, keys in _CONDITIONS.items():
        if at := _poses_without(run, keys):
            missing.append(f"{condition} at {', '.join(at)}")
    missing += [k.replace("_", " ") for k, text in lines.items() if text.strip() and k not in known]
    if missing:
        what, rule = f"not stated: {', '.join(missing)}", "ISO 9283 6.2, 6.3 require them"
        advice = "add '# key: value' lines to the table's head"
        yield Finding(CODE, "info", what, rule=rule, advice=advice)


def _poses_without(run: Run, keys: Collection[str]) -> list[str]:
    """Return the poses of which a condition is not stated that is stated of others."""
    lines = [line.key.casefold() for line in _stated.stated(run.metadata, keys)]
    of = {key.partition("[")[2].removesuffix("]") for key in lines}
    poses = [str(label) for label, _ in run.rows_by_pose()]
    missing = [pose for pose in poses if pose.casefold() not in of]
    whole = "" in of or any(name.lower() in keys for name in run.covariates)
    return [] if whole or len(missing) == len(poses) else missing
