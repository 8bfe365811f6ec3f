"""ISO 9283 repeatability of SCARA robots from digital dial indicators.

    >>> import scara_iso
    >>> run = scara_iso.read_table("examples/fum_scara_table1.csv")
    >>> round(scara_iso.analyze(run).poses[0].axes["X"].RP, 5)
    0.01404

`read_table` and `Run.from_frame` give a `Run`; `analyze` turns it into an `Analysis`, `compare`
several of these into a `Comparison`, and `diagnose` says which effect moves its readings;
`backlash` runs the paper's two-inertia model. Errors are `ScaraIsoError`s with what, where and what
to do.
"""

from __future__ import annotations

from importlib import import_module

TYPE_CHECKING = False  # the import of typing takes as long as all before it: Ctrl-C waits for it
if TYPE_CHECKING:
    from scara_iso.analysis import analyze as analyze
    from scara_iso.closing import diagnose as diagnose
    from scara_iso.comparison import Comparison as Comparison
    from scara_iso.comparison import compare as compare
    from scara_iso.diagnosis import Diagnosis as Diagnosis
    from scara_iso.errors import DataError as DataError
    from scara_iso.errors import ScaraIsoError as ScaraIsoError
    from scara_iso.errors import UsageError as UsageError
    from scara_iso.results import Analysis as Analysis
    from scara_iso.results import AxisResult as AxisResult
    from scara_iso.results import Finding as Finding
    from scara_iso.results import PoseResult as PoseResult
    from scara_iso.results import RadialResult as RadialResult
    from scara_iso.run import Axis as Axis
    from scara_iso.run import Run as Run
    from scara_iso.tables import read_table as read_table
    from scara_iso.tables import write_table as write_table
    from scara_iso.two_inertia import Backlash as Backlash
    from scara_iso.two_inertia import Crossing as Crossing
    from scara_iso.two_inertia import backlash as backlash

__version__ = "0.1.0"

_HOMES = {
    "analyze": "analysis",
    "diagnose": "closing",
    **dict.fromkeys(("Comparison", "compare"), "comparison"),
    "Diagnosis": "diagnosis",
    **dict.fromkeys(("DataError", "ScaraIsoError", "UsageError"), "errors"),
    **dict.fromkeys(("Analysis", "AxisResult", "Finding", "PoseResult", "RadialResult"), "results"),
    **dict.fromkeys(("Axis", "Run"), "run"),
    **dict.fromkeys(("read_table", "write_table"), "tables"),
    **dict.fromkeys(("Backlash", "Crossing", "backlash"), "two_inertia"),
}
__all__ = [
    "Analysis",
    "Axis",
    "AxisResult",
    "Backlash",
    "Comparison",
    "Crossing",
    "DataError",
    "Diagnosis",
    "Finding",
    "PoseResult",
    "RadialResult",
    "Run",
    "ScaraIsoError",
    "UsageError",
    "analyze",
    "backlash",
    "compare",
    "diagnose",
    "read_table",
    "write_table",
]


def __getattr__(name: str) -> object:
    """Import a public name on first use, so that ``--help`` does not pay for numpy."""
    if name not in _HOMES:
        raise AttributeError(f"module 'scara_iso' has no attribute {name!r}")
    return getattr(import_module(f"scara_iso.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return [*_HOMES, "__version__"]
