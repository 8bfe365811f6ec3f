"""Several unrelated tables, each diagnosed by itself."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np

from scara_iso import diagnose_many
from scara_iso.diagnosis import Diagnosis
from scara_iso.reporting import Failure


def test_which_cycles_count_is_stated_for_every_table(tmp_path):
    tables = []
    for k in range(2):
        readings = np.random.default_rng(k).normal(0.5, 0.004, 30)
        rows = "".join(f"{j},{x:.4f}\n" for j, x in enumerate(readings, 1))
        tables.append(tmp_path / f"{k}.csv")
        tables[-1].write_text(f"# unit: mm\n# resolution: 0.0001\ncycle,X\n{rows}")
    with ThreadPoolExecutor(1) as pool:
        asked = diagnose_many(tables, executor=pool)
        told = diagnose_many(tables, executor=pool, all_count=True)
    assert all(isinstance(one, Failure) for one in asked)
    assert all(isinstance(one, Diagnosis) for one in told)
