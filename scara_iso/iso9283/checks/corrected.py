"""The readings are corrected.

The table or test.toml states the curve of the indicator's certificate, or the angle of its plunger.
Every reading was corrected before anything was computed; the table keeps what the dial showed. The
uncertainty of the correction is in the budget. Above ten degrees, mount the indicator anew.
"""

from scara_iso.iso9283.core.results import Finding, Findings, Measured

CODE = "corrected"
_PREFIX = "corrected_"


def check(measured: Measured) -> Findings:
    """Yield what was corrected of each axis, and by how much."""
    for key, text in measured.run.metadata.items():
        name, _, pose = key.removeprefix(_PREFIX).removesuffix("]").partition("[")
        axis = measured.run.axes.get(name)
        if key.startswith(_PREFIX) and axis is not None and axis.displayed is not None:
            said = f"every reading is corrected: {text}"
            yield Finding(CODE, "info", said, name, pose or None)
