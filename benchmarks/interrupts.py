"""Ctrl-C at random moments of whole processes: 130, or 0 where it was done, and not a word else.

Prints a table of benchmarks/results/durability.md. ``benchmarks/interrupts.py --tries 300``.
The moments begin at the program's door: before it Python itself starts, for some 30 ms. Needs
signals (Linux, macOS).
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TABLE = str(ROOT / "examples" / "fum_scara_table1.csv")
COMMANDS = {
    "analyze": ["analyze", TABLE],
    "diagnose": ["diagnose", str(ROOT / "examples" / "warm_up.csv")],
    "report": ["report", TABLE, "-o", "out.html"],
}
DOOR = """
import os, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
from scara_iso import __main__ as door
os.write({pipe}, b".")
sys.argv = ["scara-iso", *{arguments!r}]
door.run()
"""
SAID = ("", "scara-iso: interrupted\n")


def interrupted(arguments: list[str], place: str, life: float | None) -> tuple[int, str, float]:
    """Return code, words on standard error and the time taken, with Ctrl-C after ``life``."""
    reader, writer = os.pipe()
    script = DOOR.format(pipe=writer, arguments=arguments)
    with subprocess.Popen(
        [sys.executable, "-c", script], cwd=place, pass_fds=[writer], text=True,
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    ) as child:  # fmt: skip
        os.close(writer)
        os.read(reader, 1)
        os.close(reader)
        start = time.perf_counter()
        if life is not None:
            time.sleep(life)
            child.send_signal(signal.SIGINT)
        err = child.communicate()[1]
        return child.returncode, err, time.perf_counter() - start


def main() -> int:
    """Print the table; exit 1 where an interrupt was lost or said more than that."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tries", type=int, default=300, help="of each command")
    tries, failures = parser.parse_args().tries, 0
    rng = random.Random(20261123)  # noqa: S311
    print("| command | tries | ended with 130 | done before | failures |")
    print("|---|---|---|---|---|")
    for name, arguments in COMMANDS.items():
        with tempfile.TemporaryDirectory() as place:
            takes = min(interrupted(arguments, place, None)[2] for _ in range(3))
            found = [
                interrupted(arguments, place, rng.uniform(0.001, 1.1 * takes)) for _ in range(tries)
            ]
            parts = len([*Path(place).glob("*.part")])
        wrong = [one for one in found if one[0] not in (0, 130) or one[1] not in SAID]
        codes = [code for code, _, _ in found]
        failures += len(wrong) + parts
        print(
            f"| {name} | {tries} | {codes.count(130)} | {codes.count(0)} | {len(wrong) + parts} |",
            flush=True,
        )
        for code, said, _ in wrong:
            print(f"exit code {code}: {said}", file=sys.stderr)
    return int(failures > 0)


if __name__ == "__main__":
    sys.exit(main())
