"""The load is not the rated one.

ISO 9283 measures at 100 % of the rated load: a lighter arm repeats better. State ``# payload`` and
``# rated_payload`` in kg, or the payload in per cent of the rated one. A payload that changes from
cycle to cycle (column `payload_kg`) is an experiment on the gear, not a test at one load.
"""

from scara_iso.iso9283.checks._stated import LOAD, MASS, ShareOfRated
from scara_iso.iso9283.core.results import Findings, Measured

CODE = "other-load"
_LOAD = ShareOfRated(
    CODE,
    "load",
    keys=LOAD,
    rated={"rated_payload", "rated_load", "rated_payload_kg", "rated_load_kg"},
    columns=("payload_kg", "load_kg"),
    units=MASS,
    shares=(100,),
    rule="ISO 9283 7.2: 100 % of the rated load",
    is_no="mass",
    example="2 kg, or 100 %",
)


def check(measured: Measured) -> Findings:
    """Yield a warning for a load other than the rated one, and for one that changes."""
    yield from _LOAD.findings(measured.run)
