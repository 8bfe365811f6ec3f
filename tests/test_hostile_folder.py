"""Nothing of the folder in which a command is run is run itself, or sets how a picture looks."""

import os
import re
import shutil
import subprocess
import sys
from functools import cache
from zipfile import ZipFile

import matplotlib as mpl
import numpy as np
import pytest
from hostile_folder import (
    COMMANDS,
    DRAWN,
    EXAMPLES,
    MODULE,
    SCRIPT,
    SETTINGS,
    environment,
    importable,
    loaded_before,
    plant,
    run,
)
from matplotlib import dates

from scara_iso.iso9283.poses import make_plan
from scara_iso.render.pictures import picture
from scara_iso.render.plots import plot_plan, save_figure
from scara_iso.reporting import Curve, Figure, Panel
from scara_iso.robot.arm import Arm

CODES = {"fleet --engine": (2, 69), "record, Bluetooth": (2, 69)}
"""Without their packages, or without what they are to speak with."""
PLAN = make_plan(Arm(400, 300, (-130, 130), (-145, 145), (0, 200)))


@pytest.fixture(scope="module")
def hostile(tmp_path_factory):
    """Return by door the folder, and the file of those of its names that ran."""
    place = tmp_path_factory.mktemp("hostile")
    names = {"scara-iso": importable()}
    names["-m"] = importable() - loaded_before(place)
    return {door: (place / door, plant(place / door, names[door])) for door in names}


@pytest.mark.slow
@pytest.mark.parametrize("name", COMMANDS)
@pytest.mark.parametrize("door", ["scara-iso", "-m"])
def test_nothing_of_the_folder_runs(hostile, door, name):
    folder, ran = hostile[door]
    ran.write_text("")
    done = run({"scara-iso": SCRIPT, "-m": MODULE}[door], name, folder)
    assert ran.read_text() == ""
    assert done.returncode in CODES.get(name, (0,)), done.stderr


def test_where_the_path_names_the_folder_nothing_runs_but_before_the_program(hostile):
    folder, ran = hostile["-m"]
    named = f"{os.pathsep}{os.environ.get('PYTHONPATH', '')}"  # of which an empty entry is left
    before = [sys.executable, "-P", "-c", "import re, sys"]  # as the console script begins
    names = {}
    for door in (before, SCRIPT):
        ran.write_text("")
        run(door, "--version", folder, PYTHONPATH=named)
        names[door[0]] = {line.split()[0] for line in ran.read_text().splitlines()}
    assert names[SCRIPT[0]] == names[sys.executable]


def test_a_hostile_module_says_that_it_ran(hostile):
    folder, ran = hostile["scara-iso"]
    ran.write_text("")
    told = subprocess.check_output([sys.executable, "-c", "import wave; print(wave.__file__)"],
                                   cwd=folder, text=True, env=environment())  # fmt: skip
    assert "wave" in ran.read_text().split()
    assert str(folder) not in told  # and hands over to the one that was meant


IN_A_NOTEBOOK = """
import os, sys
import scara_iso.fleets.engines, scara_iso.diagnosis.closed_loop, pandas, matplotlib.figure
sys.path.insert(0, "")
before = list(sys.path)
if {call!r} == "selftest":
    from scara_iso.commands.selftest import recorder_checks
    assert all(check.obtained == check.expected for check in recorder_checks())
else:
    scara_iso.diagnose_many(["before_repair.csv", "after_repair.csv"])
assert sys.path == before
assert "PYTHONSAFEPATH" not in os.environ
print(os.getpid())
"""


@pytest.mark.slow
@pytest.mark.parametrize("call", ["diagnose_many", "selftest"])
def test_processes_of_a_notebook_run_nothing_of_its_folder(hostile, call):
    folder, ran = hostile["scara-iso"]
    ran.write_text("")
    script = [sys.executable, "-P", "-c", IN_A_NOTEBOOK.format(call=call)]
    done = subprocess.run(script, cwd=folder, capture_output=True, check=False, text=True,
                          env=environment())  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert {line.split()[1] for line in ran.read_text().splitlines()} <= {done.stdout.strip()}


def test_a_folder_that_pythonpath_names_in_full_is_the_users_word(tmp_path):
    (tmp_path / "asked_for.py").touch()
    ask = "from scara_iso.__main__ import process; process.begin_program(); import asked_for"
    for named, code in ((str(tmp_path), 0), ("", 1), (os.curdir, 1)):
        done = subprocess.run([sys.executable, "-c", ask], cwd=tmp_path, capture_output=True,
                              check=False, env=environment(PYTHONPATH=named))  # fmt: skip
        assert done.returncode == code, done.stderr


# What a picture looks like


def settings_in(folder, text):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "matplotlibrc").write_bytes(text)
    return folder


UNREADABLE = b"lines.linewidth: \xff\n"  # matplotlib ends with an error when it reads this
SOURCES = {
    "the folder": lambda place, text: settings_in(place / "data", text) and {},
    "MATPLOTLIBRC": lambda place, text: {"MATPLOTLIBRC": str(settings_in(place / "rc", text))},
    "the user": lambda place, text: {
        "XDG_CONFIG_HOME": str(settings_in(place / "home" / "matplotlib", text).parent)
    },
    "MPLBACKEND": lambda place, text: {"MPLBACKEND": "nonsense"},
}


def drawn(place, name, **more):
    """Return what a command draws in a folder of examples."""
    folder = place / "data"
    shutil.copytree(EXAMPLES, folder, dirs_exist_ok=True)
    done = run(SCRIPT, name, folder, **more)
    assert (done.returncode, done.stderr) == (0, b"")
    file = folder / DRAWN[name]
    if file.suffix != ".xlsx":
        return file.read_bytes()
    with ZipFile(file) as book:
        return [book.read(one) for one in sorted(book.namelist()) if "media" in one]


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """Return what the commands draw where no settings are, each when it is asked for."""
    place = tmp_path_factory.mktemp("plain")
    return cache(lambda name: drawn(place, name))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("source", "name"),
    [*(("the folder", name) for name in list(DRAWN)[1:4]), *((one, "plan") for one in SOURCES)],
)
def test_no_settings_change_a_picture(plain, tmp_path, source, name):
    more = SOURCES[source](tmp_path, SETTINGS.encode())
    assert drawn(tmp_path, name, **more) == plain(name)


@pytest.mark.slow
@pytest.mark.parametrize("source", ["the folder", "MATPLOTLIBRC", "the user"])
def test_settings_are_not_even_read(plain, tmp_path, source):
    more = SOURCES[source](tmp_path, UNREADABLE)
    assert drawn(tmp_path, "plan", **more) == plain("plan")


def the_users(text):
    """Return a user's settings of matplotlib, as a session has them."""
    lines = (line.partition(":") for line in text.splitlines())
    return {key.strip(): value.strip() for key, _, value in lines if "." in key}


def test_a_session_keeps_its_settings_and_the_picture_ours(tmp_path):
    users = the_users(SETTINGS)
    del users["date.epoch"]
    save_figure(plot_plan(PLAN), tmp_path / "before.png")
    with mpl.rc_context(users):
        theirs = mpl.rcParams.copy()
        save_figure(plot_plan(PLAN), tmp_path / "with.png")
        assert mpl.rcParams.copy() == theirs
    assert (tmp_path / "with.png").read_bytes() == (tmp_path / "before.png").read_bytes()


def test_dates_are_right_in_a_session_that_counts_days_from_year_1(monkeypatch):
    days = 20000 + 30 * np.arange(6.0)
    ends = np.tile([[0.01], [0.03]], 6)
    tests = Curve("", days, np.full(6, 0.02), "points", "ink", ends)
    panel = Panel("", (tests,), upright=(20050.0,))
    figure = Figure("RP", "by date", "", "[mm]", (panel,), dates=True)
    expected = months_named(picture(figure, 1))
    assert "Nov" in expected
    monkeypatch.setattr(dates, "_epoch", "0000-12-31T00:00:00")
    assert months_named(picture(figure, 1)) == expected


def months_named(svg):
    return re.findall(r">(\d{4}|[A-Z][a-z]{2})</text>", svg)
