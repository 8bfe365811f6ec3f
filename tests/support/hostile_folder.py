"""A folder of readings in which every file would like to run, and every setting to be read.

For the tests and `benchmarks/hostile_folder.py`.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from pkgutil import iter_modules

EXAMPLES = Path(__file__).parents[2] / "examples"
SIM = ["--gauge", "X=opto-rs232@sim:?pace=0", "--trigger", "timer:0.1"]
TABLES = ["before_repair.csv", "after_repair.csv", "scatter.csv"]
MODEL = "fum_scara.toml"

COMMANDS = {
    "no command": [],
    "--help": ["--help"],
    "--version": ["--version"],
    "completion": [],
    "analyze": ["analyze", TABLES[0], "--definitions"],
    "analyze --json": ["analyze", "five_poses.csv", "--json"],
    "tables": ["tables", "tutorial/two_days.xlsx", "--sheet", "Monday"],
    "diagnose": ["diagnose", "warm_up.csv", "--plot", "d.svg", "--save-model", "d.toml",
                 "--model", MODEL],
    "diagnose three": ["diagnose", *TABLES, "--json"],
    "diagnose --design": ["diagnose", "--design", "--columns", "approach,temperature_C"],
    "diagnose --effects": ["diagnose", TABLES[0], "--effects", "my_effects.toml"],
    "compare": ["compare", *TABLES[:2], "--plot", "c.png"],
    "fleet": ["fleet", "fleet", "-o", "fleet_results", "--workers", "2"],
    "fleet --figures": ["fleet", "fleet", "-o", "fleet_figures", "--figures"],
    "fleet --engine": ["fleet", "fleet", "-o", "d", "--engine", "dask://127.0.0.1:9"],
    "push": ["push", "push.csv"],
    "backlash": ["backlash", "--Im", "2.65e-4", "--IL", "4.749", "--arcmin", "12", "--json"],
    "report .html": ["report", "warm_up.csv", "-o", "r.html"],
    "report .xlsx": ["report", TABLES[0], "-o", "r.xlsx", "--archive", "r.zip"],
    "report .pdf": ["report", TABLES[1], "-o", "r.pdf"],
    "demo": ["demo"],
    "explain": ["explain", "warm_up"],
    "simulate": ["simulate", MODEL, "-o", "s.csv", "--drivetrain"],
    "plan": ["plan", MODEL, "--picture", "p.png"],
    "history": ["history", "months", "-o", "h.html"],
    "selftest": ["selftest", "--report", "st.md"],
    "record": ["record", "run.csv", *SIM, "--watch", "--json"],
    "record, Bluetooth": ["record", "b.csv", "--gauge", "X=opto-rs232@00:11:22:33:44:55",
                          "--trigger", "timer:0.1"],
    "ports": ["ports", "--json"],
    "visits": ["visits", "stream.csv", "--poses", "P1,-"],
    "gauge-study": ["gauge-study", "dial_crossed.csv", "--plot", "g.png"],
    "test new": ["test", "new", "whole", "--model", MODEL],
}  # fmt: skip
"""What is run, by name: every command, and what of it starts processes or draws."""

DRAWN = {
    "plan": "p.png", "report .html": "r.html", "report .xlsx": "r.xlsx", "history": "h.html",
    "compare": "c.png", "diagnose": "d.svg", "gauge-study": "g.png",
}  # fmt: skip
"""The pictures among them, by command."""

PLUGIN = "evil_plugin"
GROUPS = ("checks", "characteristics", "indicators", "effects")
SETTINGS = """\
text.usetex: True
backend: module://evil_backend
axes.facecolor: red
axes.formatter.use_locale: True
date.epoch: 0000-12-31T00:00:00
timezone: Asia/Tokyo
font.family: serif
lines.linewidth: 9
path.sketch: 3, 20, 2
svg.fonttype: path
savefig.bbox: tight
savefig.dpi: 20
no such key: 1
: malformed
"""
"""A ``matplotlibrc`` that would start LaTeX, and change every picture."""

_RUNS = """\
import sys
with open({ran!r}, "a") as ran:
    ran.write(f"{{__name__}} {{sys.modules['os'].getpid()}}\\n")
folders = [p for p in sys.path if p not in ("", {folder!r})]
meant = sys.modules["_frozen_importlib_external"].PathFinder.find_spec(__name__, folders)
if meant is None:
    raise ModuleNotFoundError(__name__)
sys.modules["_frozen_importlib"]._load(meant)
"""
_LOADED = "import sys; print(*(name for name in sys.modules if '.' not in name))"


def importable():
    """Return every name that an import may ask for first: this Python's and of all packages."""
    absent = {"bleak", "distributed", "dask", "sitecustomize", "usercustomize", PLUGIN}
    return sys.stdlib_module_names | {one.name for one in iter_modules()} | absent | {"scara_iso"}


def loaded_before(folder):
    """Return the names that ``python -m`` imports before the first line of what it is to run."""
    package = folder / "of_nobody"
    package.mkdir(parents=True)
    (package / "__init__.py").touch()
    (package / "__main__.py").write_text(_LOADED, encoding="utf-8")
    command = [sys.executable, "-m", package.name]
    told = subprocess.run(command, cwd=folder, capture_output=True, check=True, encoding="utf-8")
    return {"scara_iso", *told.stdout.split()}


def plant(folder, names):
    """Put the examples there, beside a module of each name that says that it ran; return where.

    It then hands over to the one that was meant, so that nothing else would tell. A distribution
    that declares plugins lies there, too.
    """
    ran = folder.with_name(f"{folder.name}.ran")
    ran.touch()
    shutil.copytree(EXAMPLES, folder)
    for name in names:
        code = _RUNS.format(ran=str(ran), folder=os.path.realpath(folder))
        (folder / f"{name}.py").write_text(code, encoding="utf-8")
    declared = folder / "evil-1.0.dist-info"
    declared.mkdir()
    (declared / "METADATA").write_text("Metadata-Version: 2.1\nName: evil\nVersion: 1.0\n")
    groups = (f"[scara_iso.{group}]\nevil = {PLUGIN}\n" for group in GROUPS)
    (declared / "entry_points.txt").write_text("\n".join(groups))
    return ran


def environment(**more):
    """Return this process' environment as a user's: without what makes a path safe."""
    ours = {k: v for k, v in os.environ.items() if k != "PYTHONSAFEPATH"}
    return {**ours, "OPENBLAS_NUM_THREADS": "1", **more}


def run(door, name, folder, **more):
    """Run a command in a folder through a door; return what is left of it."""
    if name == "completion":
        more |= {"_SCARA_ISO_COMPLETE": "complete_bash", "COMP_WORDS": "scara-iso ana",
                 "COMP_CWORD": "1"}  # fmt: skip
    return subprocess.run(
        [*door, *COMMANDS[name]], cwd=folder, env=environment(**more), capture_output=True,
        check=False, stdin=subprocess.DEVNULL, timeout=300,
    )  # fmt: skip


SCRIPT = [str(Path(sys.executable).with_name("scara-iso"))]
MODULE = [sys.executable, "-m", "scara_iso"]
