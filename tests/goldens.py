"""Golden files: what every command says and writes, on the examples and fixture tables.

``python tests/goldens.py`` writes them all to tests/golden/ anew, ``python tests/goldens.py NAME``
one of them; the difference that version control shows is the change of behaviour. The program is
called by its command line only, so that no move of modules is seen. Numbers have ten significant
digits and JSON one key a line, sorted: the same on any machine.
"""

import contextlib
import io
import json
import math
import os
import re
import shlex
import shutil
import sys
import tempfile
from pathlib import Path
from unittest import mock

import scara_iso
from scara_iso.commands import main

TESTS = Path(__file__).parent
GOLDEN = TESTS / "golden"
TERMINAL = {"COLUMNS": "100", "NO_COLOR": "1"}
EXAMPLES = (
    "after_repair", "before_repair", "fum_scara_table1", "scatter", "unexplained", "warm_up",
)  # fmt: skip
TABLES = sorted(path.name for path in (TESTS / "fixtures" / "tables").iterdir())
EFFECTS = {
    "warm_up": "warm_up@X:size=0.05,tau=8",
    "linear_drift": "linear_drift@X:size=0.03",
    "step": "step@Y:size=0.03,at_cycle=15",
    "periodic": "periodic@X:size=0.02,period=6,phase=1",
    "contact_side": "contact_side@X,Y:size=0.03,switching=0.3",
    "lost_motion": "lost_motion@X,Y:size=0.03",
    "temperature": "temperature@Z:size=0.02",
    "compliance": "compliance@Z:size=0.02",
    "random_walk": "random_walk@X:size=0.01",
    "outlier": "outlier@Y:size=0.2,at_cycle=9",
    "scatter_change": "scatter_change@X:ratio=4,at_cycle=16,scatter=0.004",
    "overcorrection": "overcorrection@X:size=0.01,share=1",
}
DIALECTS = (
    "opto-rs232", "mitutoyo-mux", "mitutoyo-idh", "mitutoyo-uwave", "digimatic-hex",
    "cdi-starrett-iq", "starrett-spc", "heidenhain-nd", "keyence-dlrs1a", "magnescale", "maxum",
    "metro-mux", "millimar", "mux24", "stream-4800",
)  # fmt: skip
MODEL = "examples/fum_scara.toml"
NUMBER = re.compile(r"(?<![\w.])-?\d+(\.\d+(e[-+]\d+)?|e[-+]\d+)(?![\w.])")


def cases() -> dict[str, tuple[str, ...]]:
    """Return the command lines of each golden file, played in order in one folder."""
    return {
        **{f"analyze_{name}": _analyze(f"examples/{name}.csv") for name in EXAMPLES},
        **{f"table_{Path(name).stem}": _spelling(f"tables/{name}") for name in TABLES},
        **{f"diagnose_{name}": _diagnose(f"examples/{name}.csv") for name in EXAMPLES},
        **{f"effect_{name}": _effect(spelt) for name, spelt in EFFECTS.items()},
        **{f"record_{key}": _dialect(key) for key in DIALECTS},
        **{f"report_{name}": _report(f"examples/{name}.csv") for name in EXAMPLES},
        **_others(),
    }


def _analyze(table: str) -> tuple[str, ...]:
    return (
        f"analyze {table} --json --definitions --limit 0.05 --limit XY=0.02",
        f"analyze {table} --limit 0.02",
    )


def _spelling(table: str) -> tuple[str, ...]:
    short = f"analyze {table} --json --cycles 5"
    return (
        f"analyze {table}",
        f"{short} --unit mm" if "scientific" in table else short,
        f"diagnose {table} --json",
    )


def _diagnose(table: str) -> tuple[str, ...]:
    return f"diagnose {table} --json", f"diagnose {table} --json --model {MODEL}"


def _effect(spelt: str) -> tuple[str, ...]:
    conditions = "--approach random --temperature 20:24 --payload 0,2,4"
    return (
        f"simulate {MODEL} {conditions} --effect {spelt} -o run.csv --json",
        f"diagnose run.csv --json --model {MODEL} --save-model new.toml",
    )


def _dialect(key: str) -> tuple[str, ...]:
    gauge = f"--gauge X={key}@sim:?pace=0"
    return (
        f"record run.csv {gauge} --unit mm --trigger timer:0.1 --cycles 3 --json",
        f"record data.csv {gauge} --unit mm --trigger data --cycles 3 --json",
        f"ports --probe sim:?pace=0 --ask {key} --json",
    )


def _report(table: str) -> tuple[str, ...]:
    return (
        f"report {table} --model {MODEL} --limit 0.05 -o full.md",
        f"report {table} -o page.csv --json",
    )


def _others() -> dict[str, tuple[str, ...]]:
    """Return the commands of goldens.txt: a name, and its command lines indented below it."""
    text = (TESTS / "goldens.txt").read_text(encoding="utf-8")
    parts = re.split(r"^(\w+):\n", text, flags=re.MULTILINE)[1:]
    return {
        name: tuple(line.strip() for line in lines.splitlines())
        for name, lines in zip(parts[::2], parts[1::2], strict=True)
    }


def played(lines: tuple[str, ...]) -> str:
    """Return what the command lines say and write, in a folder with the inputs beside them."""
    with (
        tempfile.TemporaryDirectory() as folder,
        mock.patch.dict(os.environ, TERMINAL),
        contextlib.chdir(folder),
    ):
        _lay_out(Path())
        known = _files()
        return "".join(_call(line, known) for line in lines)


def _lay_out(folder: Path) -> None:
    left_out = shutil.ignore_patterns("reports")
    shutil.copytree(TESTS.parent / "examples", folder / "examples", ignore=left_out)
    for name in ("tables", "streams", "recordings"):
        shutil.copytree(TESTS / "fixtures" / name, folder / name)
    (folder / "poses.csv").write_text("".join(_poses()), encoding="utf-8")
    (folder / "angle.csv").write_text("".join(_angle()), encoding="utf-8")
    (folder / "sweep.csv").write_text("".join(_sweep()), encoding="utf-8")


def _poses():
    """Yield three poses of four axes with everything that a table can state."""
    yield "# unit: mm\n# resolution: 0.001\n# theta_radius_mm: 50\n# robot: =1+1 <b>\n"
    yield "# command_X: 0\n# command_Y: 0\n# command_Z: 0\npose,cycle,X,Y,Z,theta,approach\n"
    for pose in range(1, 4):
        for cycle in range(1, 32):
            values = (_scatter(cycle, 4 * pose + k) * 0.001 for k in range(4))
            row = ",".join(f"{value:.3f}" for value in values)
            yield f"P{pose},{cycle},{row},{(-1) ** cycle}\n"


def _angle():
    yield "# unit: mm\n# unit_theta: deg\n# resolution_theta: 0.001\ncycle,X,theta\n"
    for cycle in range(1, 32):
        yield f"{cycle},{0.5 + _scatter(cycle, 1) * 0.01:.2f},{12 + _scatter(cycle, 2) / 1e3:.3f}\n"


def _sweep():
    """Yield reversals of a gap smaller than stated."""
    yield "Im,IL,arcmin,deviation_rad\n"
    for k, load in enumerate((0.5, 1.0, 2.0, 3.0, 4.749, 8.0)):
        noise = 1 + 0.002 * _scatter(k, 3)
        yield f"2.65e-4,{load},12,{-0.6 * math.radians(0.2) / (1 + load / 2.65e-4) * noise:.8e}\n"


def _scatter(cycle: int, series: int) -> int:
    """Return a whole number from -21 to 21 that looks random, from the middle more often."""
    return sum((7919 * cycle * cycle + 104729 * series * k + 31 * cycle * k) % 15 - 7
               for k in (3, 5, 11))  # fmt: skip


def _call(line: str, known: dict[Path, bytes]) -> str:
    out, err = io.StringIO(), io.StringIO()
    with (
        mock.patch("sys.stdin", io.TextIOWrapper(io.BytesIO())),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        code = main(shlex.split(line))
    said = [f"$ scara-iso {line}\n", f"exit {code}\n", out.getvalue(), _part("errors", err)]
    now = _files()
    for path in sorted(path for path in now if now[path] != known.get(path)):
        text = now[path].decode("utf-8-sig").replace("\r\n", "\n")
        said.append(f"--- {path.as_posix()}\n{text}")
    known.clear()
    known.update(now)
    return _normal("".join(said)) + "\n"


def _part(name: str, text: io.StringIO) -> str:
    return f"--- {name}\n{text.getvalue()}" if text.getvalue() else ""


def _files() -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in Path().glob("*.*") if path.is_file()}


def _normal(text: str) -> str:
    """Return the text without what may differ from day to day: version, checksums, blank ends."""
    text = text.replace(f"scara-iso {scara_iso.__version__}", "scara-iso VERSION")
    text = text.replace(f'"{scara_iso.__version__}"', '"VERSION"')
    text = re.sub(r"\b[0-9a-f]{64}\b", "SHA256", text)
    text = re.sub(r'^\{".*\}$', lambda line: _keys(json.loads(line[0])), text, flags=re.MULTILINE)
    text = NUMBER.sub(ten_digits, text)
    return re.sub(r"[ \t]+$", "", text, flags=re.MULTILINE)


def _keys(value: object, indent: str = "") -> str:
    """Return JSON with one sorted key a line; a list of plain values is one line."""
    deeper = indent + "  "
    match value:
        case dict() if value:
            items = (f"{deeper}{json.dumps(key)}: {_keys(value[key], deeper)}"
                     for key in sorted(value))  # fmt: skip
            return "{\n" + ",\n".join(items) + f"\n{indent}}}"
        case list() if any(isinstance(item, dict | list) for item in value):
            rows = (f"{deeper}{_keys(item, deeper)}" for item in value)
            return "[\n" + ",\n".join(rows) + f"\n{indent}]"
    return json.dumps(value)


def ten_digits(number: re.Match[str]) -> str:
    """Return the number as it was said, or to ten significant digits where it has more.

    What is 0 but for the rounding of sums is ``0.0``: its sign is the processor's.
    """
    said, value = number[0], round(float(number[0]), 15)
    if value == 0:
        return "0.0" if "e" in said or said == "-0.0" else said
    digits = said.partition("e")[0].replace(".", "").lstrip("-0")
    return said if len(digits) <= 10 else f"{value:.10g}"


def write(names: list[str]) -> None:
    """Write golden files, all of them where none is named."""
    GOLDEN.mkdir(exist_ok=True)
    every = cases()
    if not names:
        for path in GOLDEN.glob("*.txt"):
            path.unlink()
    for name in names or every:
        (GOLDEN / f"{name}.txt").write_text(played(every[name]), encoding="utf-8", newline="")


if __name__ == "__main__":
    write(sys.argv[1:])
