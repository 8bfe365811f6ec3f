"""Check what a source archive and a wheel hold: python .ci/contents.py SDIST WHEEL.

Everything that git knows of the package is in both, and what the tests need is in the archive.
"""

import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
IN_THE_ARCHIVE = (
    "pyproject.toml", "README.md", "LICENSE", "CHANGELOG.md", "CONTRIBUTING.md", ".importlinter",
    "tests/conftest.py", "docs/README.md", "examples/fum_scara_table1.csv", "benchmarks/page.py",
    ".ci/run",
)  # fmt: skip


def main(archive: str, wheel: str) -> int:
    """Print what is missing or does not belong there; return 1 where there is any."""
    known = ["git", "-C", str(ROOT), "ls-files", "scara_iso"]
    listed = subprocess.run(known, capture_output=True, check=True, encoding="utf-8")  # noqa: S603
    package = {path for path in listed.stdout.splitlines() if (ROOT / path).is_file()}
    with tarfile.open(archive) as file:
        inside = {name.partition("/")[2] for name in file.getnames()}
    with zipfile.ZipFile(wheel) as file:
        built = set(file.namelist())
    wrong = [f"not in {archive}: {path}" for path in sorted({*package, *IN_THE_ARCHIVE} - inside)]
    wrong += [f"not in {wheel}: {path}" for path in sorted(package - built)]
    fixtures = tuple(f"scara_iso/commands/data/{name}/" for name in ("streams", "nist_strd"))
    wrong += [
        f"not in {wheel}: {one}" for one in fixtures if not any(p.startswith(one) for p in built)
    ]
    strange = {
        path
        for path in built - package
        if ".dist-info/" not in path and not path.startswith(fixtures)
    }
    wrong += [f"in {wheel}, and not known to git: {path}" for path in sorted(strange)]
    print("\n".join(wrong) or f"{len(inside)} files in the archive, {len(built)} in the wheel")  # noqa: T201
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
