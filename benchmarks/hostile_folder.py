"""What of a folder runs when a command is run in it: modules named as those that a start imports.

Prints the table of benchmarks/results/durability.md. ``python benchmarks/hostile_folder.py``;
``--only fleet`` for the commands with that word.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests" / "support")]

from hostile_folder import (  # noqa: E402
    COMMANDS,
    DRAWN,
    EXAMPLES,
    MODULE,
    SCRIPT,
    SETTINGS,
    importable,
    loaded_before,
    plant,
    run,
)


def main() -> None:
    """Run every command through both doors, and print what ran of the folder."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="commands with this word")
    wanted = [name for name in COMMANDS if parser.parse_args().only in name]
    with tempfile.TemporaryDirectory() as place:
        before = loaded_before(Path(place, "before"))
        doors = {"scara-iso": (SCRIPT, importable()),
                 "python -m scara_iso": (MODULE, importable() - before)}  # fmt: skip
        print("| started as | hostile names | commands | in which one ran | names that ran |")
        print("|---|---|---|---|---|")
        for said, (door, names) in doors.items():
            folder = Path(place, said.replace(" ", "_"))
            ran = plant(folder, names)
            found = {name: _ran(door, name, folder, ran) for name in wanted}
            hit = {name: each for name, each in found.items() if each}
            print(f"| `{said}` | {len(names)} | {len(wanted)} | {len(hit)} "
                  f"| {len(set().union(*hit.values()))} |", flush=True)  # fmt: skip
            for name, each in hit.items():
                print(f"  {name}: {len(each)}: {', '.join(sorted(each)[:6])}", file=sys.stderr)
        _pictures(Path(place), [name for name in DRAWN if name in wanted])
        print("\nImported before the program:", ", ".join(sorted(before)))


def _pictures(place: Path, wanted: list[str]) -> None:
    """Print how many pictures are other bytes, or none at all, with each source of settings."""
    plain = {name: _drawn(place / "plain", name) for name in wanted}
    rc = place / "settings" / "matplotlib"
    rc.mkdir(parents=True)
    (rc / "matplotlibrc").write_text(SETTINGS)
    sources = {"matplotlibrc of the folder": {}, "`MATPLOTLIBRC`": {"MATPLOTLIBRC": str(rc)},
               "the user's": {"XDG_CONFIG_HOME": str(rc.parent)},
               "`MPLBACKEND`": {"MPLBACKEND": "nonsense"}}  # fmt: skip
    print("\n| settings | pictures | changed or not drawn |\n|---|---|---|")
    for source, more in sources.items():
        folder = place / source.replace("`", "")
        shutil.copytree(EXAMPLES, folder)
        if not more:
            shutil.copy(rc / "matplotlibrc", folder)
        changed = sum(_drawn(folder, name, **more) != plain[name] for name in wanted)
        print(f"| {source} | {len(wanted)} | {changed} |", flush=True)


def _drawn(folder: Path, name: str, **more: str) -> bytes:
    """Return the file that a command draws, empty where it does not."""
    shutil.copytree(EXAMPLES, folder, dirs_exist_ok=True)
    run(SCRIPT, name, folder, **more)
    drawn = folder / DRAWN[name]
    return drawn.read_bytes() if drawn.exists() else b""


def _ran(door: list[str], name: str, folder: Path, ran: Path) -> Counter[str]:
    ran.write_text("")
    done = run(door, name, folder)
    print(f"  {name}: exit {done.returncode}", file=sys.stderr)
    return Counter(line.split()[0] for line in ran.read_text().splitlines())


if __name__ == "__main__":
    main()
