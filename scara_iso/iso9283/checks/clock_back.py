"""The times of the readings fall while their cycles rise.

The rows were sorted anew, a clock was set, or a time was typed wrongly. RP does not use the times;
a drift, a warm-up or a period in seconds does: correct them, or remove the column.
"""

import numpy as np

from scara_iso.iso9283.core.results import Finding, Findings, Measured

CODE = "clock-back"
BRIEF = "times run backwards"


def check(measured: Measured) -> Findings:
    """Yield a warning where ``time_s`` falls from one reading of a pose to the next."""
    time = measured.run.covariates.get("time_s")
    if time is None:
        return
    for label, rows in measured.run.rows_by_pose():
        falls = rows[1:][np.diff(time[rows]) < 0]
        if len(falls):
            times = "once" if len(falls) == 1 else f"{len(falls)} times"
            what = f"time_s runs backwards {times}, first at cycle {measured.run.cycle[falls[0]]}"
            yield Finding(CODE, "warning", what, pose=label)
