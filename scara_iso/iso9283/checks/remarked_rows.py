"""Rows have a remark, or a line speaks of some cycles, and all of them count.

A remark such as "dial touched" may say that a reading is not the robot's: remove its row.
Unexplained numbers are quoted.
"""

from scara_iso.iso9283.core.results import Finding, Findings, Measured

CODE = "remarked-rows"
BRIEF = "remarks to read: all rows count"
_SHOWN = 3


def check(measured: Measured) -> Findings:
    """Yield a warning that quotes the remarks."""
    remarks = measured.run.origin.remarks
    if remarks:
        more = f" and {len(remarks) - _SHOWN} more" if len(remarks) > _SHOWN else ""
        what = f"remarked, and counted: {', '.join(remarks[:_SHOWN])}{more}"
        advice = "remove a row whose reading is not the robot's (`allow_gaps=`)"
        yield Finding(CODE, "warning", what, advice=advice)
