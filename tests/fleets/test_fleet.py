"""Many robots: found and ranked, each part done once, whoever dies on the way."""

import io
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from pathlib import Path

import duckdb
import numpy as np
import openpyxl
import pandas as pd
import pytest
from hypothesis import given, strategies as st
from rich.console import Console

import scara_iso
from scara_iso.base.errors import CannotCreateError, DataError, ServiceError, UsageError, WriteError
from scara_iso.commands import main
from scara_iso.diagnosis import CyclesWanted, finer, floor_of, screen
from scara_iso.fleets import Engine, ReadAs, engines
from scara_iso.fleets.database import as_parquet, results_in, workspace
from scara_iso.fleets.engines import done_by, open_processes
from scara_iso.fleets.parts import _taken, tables_in
from scara_iso.fleets.runs import Checkpoint, HasChangedError
from scara_iso.render import track
from scara_iso.reporting.shared.digits import many

ROOT = Path(scara_iso.__file__).parents[1]
HEAD = "# unit: mm\n# resolution: 0.001\nrobot,test,cycle,X,Y\n"


def rows_of(robot, rng, step=0.0, n=31):
    values = rng.normal(0, 0.003, (n, 2)) + np.where(np.arange(n) < 15, 0, step)[:, None]
    return [f"{robot},t1,{k},{x:.3f},{y:.3f}" for k, (x, y) in enumerate(values, 1)]


def fleet_of(folder, parts=3, robots=4, ill=("R1-2",)):
    folder.mkdir(exist_ok=True)
    rng = np.random.default_rng(5)
    for part in range(parts):
        names = [f"R{part}-{k}" for k in range(robots)]
        lines = [row for n in names for row in rows_of(n, rng, 0.03 if n in ill else 0.0)]
        (folder / f"part{part}.csv").write_text(HEAD + "\n".join(lines) + "\n", encoding="utf-8")
    return folder


def results(folder):
    found = duckdb.sql(f"FROM read_parquet('{folder}/parts/*.parquet')").fetchall()
    return sorted(map(repr, found))


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fleet")
    source = fleet_of(folder / "source")
    (source / "unreadable.parquet").write_bytes(b"PAR1 and no more")
    (source / "letters.csv").write_text(HEAD + "R8,t1,1,abc,0\nR9,t1,1,0.5,0.1\n", "utf-8")
    summary = scara_iso.fleet(source, folder / "out", workers=2)
    return source, folder / "out", summary


def test_the_ill_robot_is_first_and_alone(done):
    _, _, summary = done
    assert [one.robot for one in summary.found] == ["R1-2"]
    assert summary.found[0].effects == ("step",)
    assert summary.robots[0] is summary.found[0]
    assert len(summary.robots) == 12
    assert summary.effects == {"step": 1}


def test_what_cannot_be_read_is_listed_and_the_rest_goes_on(done):
    _, _, summary = done
    assert list(summary.run.failed) == ["unreadable.parquet"]
    said = {one.robot: one.error for one in summary.failed}
    assert "line 4, column 4: 'abc' is not a number" in said["R8"]
    assert "cycle" in said["R9"]


def test_each_table_is_as_diagnose_says(done):
    source, _, summary = done
    lines = (source / "part1.csv").read_text("utf-8").splitlines()
    alone = [line.split(",", 2)[2] for line in lines if line.startswith(("R1-2", "robot"))]
    table = "# unit: mm\n# resolution: 0.001\n" + "\n".join(alone) + "\n"
    found = scara_iso.diagnose(table.encode())
    assert summary.found[0].p_value == found.p_value
    assert summary.found[0].RP_XY == pytest.approx(found.repeatability.measured["XY"])


def test_the_q_values_are_those_of_benjamini_and_hochberg(done):
    _, _, summary = done
    p = sorted(one.p_value for one in summary.robots)
    m = len(p)
    q = [min(p[j] * m / (j + 1) for j in range(k, m)) for k in range(m)]
    assert sorted(one.q_value for one in summary.robots) == pytest.approx(q)


def test_more_orders_name_a_robot_that_the_first_thousand_cannot(tmp_path, done):
    source, out, summary = done
    shutil.copytree(out, tmp_path / "o")
    found = scara_iso.fleet(source, tmp_path / "o", level=0.005, workers=1)
    assert summary.found[0].q_value > 0.005  # as far as 999 orders go
    assert [one.robot for one in found.found] == ["R1-2"]
    assert found.found[0].p_value == 1 / (3429 + 1) / 0.7  # 12 robots / (0.005 x 0.7)
    others = {one.robot: one.p_value for one in summary.robots[1:]}
    assert {one.robot: one.p_value for one in found.robots[1:]} == others
    before = results(tmp_path / "o")
    again = scara_iso.fleet(source, tmp_path / "o", level=0.005, workers=1)
    assert again.robots == found.robots
    assert results(tmp_path / "o") == before


def has_changed(*_, **__):
    raise HasChangedError


def test_a_part_that_changes_during_a_closer_look_keeps_its_p_values(
    tmp_path, done, in_this_process, monkeypatch
):
    source, out, summary = done
    shutil.copytree(out, tmp_path / "o")
    monkeypatch.setattr("scara_iso.fleets.screening._looked", has_changed)
    found = scara_iso.fleet(source, tmp_path / "o", level=0.005, workers=1)
    assert found.run.failed["part1.csv"].endswith("has changed since it was read: run it again")
    assert found.robots[0].p_value == summary.robots[0].p_value


def test_of_several_poses_the_largest_figure_is_kept():
    rows = [f"P{pose},{k},{(k * 7 % 11) / 1000 / pose}" for pose in (1, 2) for k in range(1, 32)]
    table = "\n".join(["# unit: mm", "pose,cycle,X", *rows, ""]).encode()
    run, figures = scara_iso.read_table(table), scara_iso.analyze(table).poses
    assert figures["P1"].axes["X"].RP > figures["P2"].axes["X"].RP
    found = screen(run, CyclesWanted(), seed=1)
    assert found.RP["X"] == pytest.approx(figures["P1"].axes["X"].RP)


def test_a_table_at_the_floor_by_chance_drops_out_and_keeps_a_valid_p_value():
    values = np.random.default_rng(4).normal(0, 0.003, (31, 2)).round(3)
    rows = "\n".join(f"{k},{x:.3f},{y:.3f}" for k, (x, y) in enumerate(values, 1))
    run = scara_iso.read_table(f"# unit: mm\n# resolution: 0.001\ncycle,X,Y\n{rows}\n".encode())
    p_value, at_floor = finer(run, CyclesWanted(), 2000, seed=9283)
    assert (p_value, at_floor) == (floor_of(999), False)  # never above what it had


def test_what_is_done_is_not_done_again(done, capsys):
    source, out, _ = done
    before, whole = results(out), (out / "manifest.jsonl").read_bytes()
    assert main(["fleet", str(source), "-o", str(out), "--json"]) == 65  # some cannot be read
    found = json.loads(capsys.readouterr().out)
    assert found["parts"]["done_before"] == found["parts"]["count"] == 5
    assert (out / "manifest.jsonl").read_bytes() == whole
    torn = whole[: whole.rfind(b"\n", 0, -1) + 20]  # as a kill may leave it
    (out / "manifest.jsonl").write_bytes(torn)
    assert scara_iso.fleet(source, out, workers=1).run.before == 4
    assert results(out) == before


def test_a_head_that_a_kill_left_unfinished_is_begun_anew(tmp_path):
    manifest = tmp_path / "manifest.jsonl"
    manifest.write_text('{"schema": "scara-iso/fleet-man')
    for _ in range(2):
        Checkpoint(tmp_path, "1", {}).close()
    assert manifest.read_bytes().count(b"\n") == 1
    manifest.write_text("mine")
    with pytest.raises(DataError, match="not a manifest"):
        Checkpoint(tmp_path, "1", {})
    assert manifest.read_text() == "mine"


def test_a_manifest_of_another_version_or_other_options_is_refused(tmp_path, done, capsys):
    source, out, _ = done
    now = scara_iso.__version__
    for change, said, words in (
        (f'"version": "{now}'.encode(), b'"version": "9.9', f"version was 9.9 and is {now}"),
        (b'"unit": null', b'"unit": "um"', "unit was um and is None"),
    ):
        other = tmp_path / f"other{len(said)}"
        other.mkdir()
        head = (out / "manifest.jsonl").read_bytes().replace(change, said, 1)
        (other / "manifest.jsonl").write_bytes(head)
        assert main(["fleet", str(source), "-o", str(other), "--json"]) == 65
        captured = capsys.readouterr()
        assert captured.out == ""
        assert f"was begun otherwise: {words}\n" in captured.err
        assert captured.err.endswith(f"or remove {other}\n")


def test_outputs_that_would_be_lost_are_refused(tmp_path, done):
    source, _, _ = done
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(CannotCreateError, match="not empty"):
        scara_iso.fleet(source, tmp_path)
    assert (tmp_path / "mine.txt").read_text() == "mine"
    assert main(["fleet", str(tmp_path / "none"), "-o", str(tmp_path / "o")]) == 66
    assert main(["fleet", str(source), "-o", str(tmp_path / "o"), "--engine", "slurm"]) == 2
    assert main(["fleet", str(source), "-o", str(tmp_path / "o"), "--level", "5"]) == 2


def test_a_cluster_that_is_not_there(tmp_path, done, monkeypatch):
    pytest.importorskip("distributed")
    source, _, _ = done
    monkeypatch.setattr("scara_iso.fleets.engines._PATIENCE", 1)
    with pytest.raises(ServiceError, match="no Dask scheduler"):
        scara_iso.fleet(source, tmp_path / "o", engine="dask://127.0.0.1:9")
    with pytest.raises(UsageError):
        scara_iso.fleet(source, tmp_path / "o", engine="dask://nowhere")
    assert not (tmp_path / "o").exists()


@pytest.fixture
def in_this_process(monkeypatch):
    monkeypatch.setattr(engines, "open_processes", lambda _: ThreadPoolExecutor(1))


def test_a_part_that_is_a_link_is_known_by_its_own_name(tmp_path, in_this_process):
    short = tmp_path / "short.csv"
    short.write_text(HEAD + "R1,t,1,0.1,0.2\nR1,t,2,0.1,0.2\n", encoding="utf-8")
    (tmp_path / "parts").mkdir()
    for name in ("a.csv", "b.csv"):
        (tmp_path / "parts" / name).symlink_to(short)
    for before in (0, 2):
        found = scara_iso.fleet(tmp_path / "parts", tmp_path / "o")
        assert found.run.before == before
        assert [one.part for one in found.failed] == ["a.csv", "b.csv"]
        assert found.tables == 0  # none of them was diagnosed


def test_the_tables_of_one_part_are_shared_and_are_those_of_the_whole(
    tmp_path, done, in_this_process, monkeypatch
):
    source, out, _ = done
    (tmp_path / "parts").mkdir()
    shutil.copy(source / "part1.csv", tmp_path / "parts")
    monkeypatch.setattr("scara_iso.fleets.screening._SHARE", 500)
    for before in (0, 1):
        found = scara_iso.fleet(tmp_path / "parts", tmp_path / "o", workers=2)
        assert (found.run.before, found.tables) == (before, 4)
    assert lines_of(tmp_path / "o" / "manifest.jsonl") > 4
    of_part = [row for row in results(out) if "part1.csv" in row]
    assert results(tmp_path / "o") == of_part


def test_a_part_that_changes_before_its_turn_is_left_to_the_next_run(
    tmp_path, done, in_this_process, monkeypatch
):
    (tmp_path / "s").mkdir()
    part = Path(shutil.copy(done[0] / "part1.csv", tmp_path / "s"))
    examine = scara_iso.fleets.screening.examine

    def changed(*given, **options):
        with part.open("a", encoding="utf-8") as file:
            file.write("\n")
        return examine(*given, **options)

    monkeypatch.setattr("scara_iso.fleets.screening.examine", changed)
    found = scara_iso.fleet(tmp_path / "s", tmp_path / "o")
    assert found.run.failed == {"part1.csv": "has changed since it was read: run it again"}
    monkeypatch.setattr("scara_iso.fleets.screening.examine", examine)
    found = scara_iso.fleet(tmp_path / "s", tmp_path / "o")
    assert (found.run.before, found.tables, found.run.failed) == (0, 4, {})


@given(count=st.integers(0, 50), pieces=st.integers(1, 30))
def test_shares_hold_everything_once_in_its_order(count, pieces):
    own = [_taken(range(count), (number, pieces)) for number in range(pieces)]
    assert [one for several in own for one in several] == list(range(count))
    assert max(map(len, own)) - min(map(len, own)) <= 1


@pytest.mark.parametrize("header", ["robot,cycle,X,X", "robot;cycle;x;X"])
def test_columns_of_one_name_are_refused(tmp_path, header):
    part = tmp_path / "a.csv"
    row = "R,1,0.1,0.2".replace(",", header[5])
    part.write_text(f"# unit: mm\n{header}\n{row}\n{row}\n", encoding="utf-8")
    with pytest.raises(DataError, match="several columns x"):
        list(tables_in(part, ReadAs()))


def test_a_part_apart_by_semicolons_is_several_robots(tmp_path):
    part = tmp_path / "a.csv"
    text = HEAD.replace(",", ";") + "R1;t;1;0.1;0.2\nR2;t;1;0.3;0.4\n"
    part.write_text(text, encoding="utf-8")
    found = {one.robot: one.run.axes["X"].readings[0] for one in tables_in(part, ReadAs())}
    assert found == {"R1": 0.1, "R2": 0.3}


def test_a_german_part_is_several_robots(tmp_path):
    rows = "R1;A;03.02.2026;1;0,1\nR1;A;03.02.2026;2;0,2\nR2;A;04.02.2026;1;0,3\n"
    text = f"# Einheit: mm\nRoboter;Prüfung;Datum;Zyklus;X\n{rows}"
    (tmp_path / "a.csv").write_bytes(text.encode("cp1252"))
    found = list(tables_in(tmp_path / "a.csv", ReadAs()))
    assert [(one.robot, one.test, one.run.metadata["date"]) for one in found] == [
        ("R1", "A", "03.02.2026"), ("R2", "A", "04.02.2026")
    ]  # fmt: skip
    assert found[0].run.axes["X"].readings.tolist() == [0.1, 0.2]


def test_a_statement_about_the_robot_is_no_header_of_several(tmp_path):
    """As `analyze` reads the table of one robot."""
    rows = "".join(f"{k};0,80{k % 7};1,10{k % 5}\n" for k in range(1, 32))
    (tmp_path / "a.csv").write_text(f"Roboter;R1\nAuflösung;0,001 mm\nNr.;X [mm];Y [mm]\n{rows}")
    (found,) = tables_in(tmp_path / "a.csv", ReadAs())
    assert (found.robot, len(found.run), list(found.run.axes)) == ("R1", 31, ["X", "Y"])


def test_a_table_that_passes_midnight_has_the_date_of_its_first_row(tmp_path):
    rows = "R1,A,2026-02-03,1,0.1\nR1,A,2026-02-04,2,0.2\n"
    (tmp_path / "a.csv").write_text(f"# unit: mm\nrobot,test,date,cycle,X\n{rows}", "utf-8")
    assert only_run(tmp_path / "a.csv").metadata["date"] == "2026-02-03"


def only_run(part, **options):
    (found,) = tables_in(part, ReadAs(**options))
    if isinstance(found.run, DataError):
        raise found.run
    return found.run


COMMAS = ("0,1", "0,25", "0,003")


@pytest.mark.parametrize(
    ("cells", "options", "expected"),
    [
        (COMMAS, {}, [0.1, 0.25, 0.003]),
        (("1,512", "2,048", "3,001"), {}, "could have a decimal comma or group thousands"),
        (("1,512", "2,048", "3,001"), {"decimal": ","}, [1.512, 2.048, 3.001]),
        (("1,512", "2,048", "3,001"), {"decimal": "."}, [1512, 2048, 3001]),
        (("0,1", "0.25", "0,3"), {}, "commas and points both occur"),
        (("0,1", "dent", "0,3"), {}, "line 4, column 3: 'dent' is not a number"),
    ],
)
def test_decimal_commas_of_a_part_are_those_of_analyze(tmp_path, cells, options, expected):
    part, table = tmp_path / "a.csv", tmp_path / "t.csv"
    rows = [f"{k};{cell}" for k, cell in enumerate(cells, 1)]
    own = "\n".join(f"R1;{row}" for row in rows)
    part.write_text(f"# unit: mm\nrobot;cycle;X\n{own}\n", "utf-8")
    table.write_text("# unit: mm\ncycle;X\n" + "\n".join(rows) + "\n", "utf-8")
    if isinstance(expected, str):
        with pytest.raises(DataError):
            scara_iso.read_table(table, **options)
        with pytest.raises(DataError, match=expected):
            only_run(part, **options)
        return
    found = only_run(part, **options)
    read = scara_iso.read_table(table, **options)
    assert found.axes["X"].readings.tolist() == expected == read.axes["X"].readings.tolist()


def test_micrometres_that_may_be_grouped_are_refused(tmp_path):
    part = tmp_path / "a.csv"
    text = "# unit: um\nrobot;cycle;X\nR1;1;1.512\nR1;2;2.048\n"
    part.write_text(text, encoding="utf-8")
    with pytest.raises(DataError, match="group thousands"):
        only_run(part)
    (found,) = tables_in(part, ReadAs(decimal="."))
    assert found.run.axes["X"].readings.tolist() == pytest.approx([0.001512, 0.002048])


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ("R1,t1,1,0.1\n", "line 4: 4 cells, and the header has 5"),
        ("R1,t1,1,0.1,0.2,0.3\n", "line 4: 6 cells, and the header has 5"),
        ('"R1,t1,1,0.1,0.2\n', "line 4: a quotation mark opens or closes in the wrong place"),
        ("", "holds no rows"),
    ],
)
def test_one_row_that_cannot_be_read_is_said_by_its_line(tmp_path, rows, said):
    part = tmp_path / "a.csv"
    part.write_text(HEAD + rows, encoding="utf-8")
    with pytest.raises(DataError, match=said):
        list(tables_in(part, ReadAs()))


NAMES = ("R1", "#2", "3\u00e9")
ROWS = [f"{name},t1,{k},{k % 7 / 1000:.3f},0.1" for name in NAMES for k in range(40)]


@pytest.mark.parametrize(
    "content",
    [
        (HEAD + "\n".join(ROWS)).encode("utf-8-sig"),
        (HEAD + "\n".join(ROWS)).encode("utf-16"),
        (HEAD + "\n".join(ROWS)).encode("cp1252"),
        (HEAD + "\r\n".join(ROWS)).encode(),
        (HEAD + "\n".join(ROWS[:50]) + "\r\n" + "\r".join(ROWS[50:])).encode(),
        (HEAD + "\n".join(ROWS[:50]) + "\n# a note\n\n" + "\n".join(ROWS[50:])).encode(),
        (HEAD + "\n".join(ROWS).replace("#2,", '" #2 ",')).encode(),
    ],
    ids=["BOM", "UTF-16", "cp1252", "header of other ends", "mixed ends", "comment", "quotes"],
)
def test_text_of_several_robots_is_read_in_every_form_of_a_table(tmp_path, content):
    """A robot whose name begins as a comment does is not lost."""
    (tmp_path / "a.csv").write_bytes(content)
    found = {one.robot: one.run for one in tables_in(tmp_path / "a.csv", ReadAs())}
    assert tuple(found) == NAMES
    assert all(len(run) == 40 and run.axes["X"].unit == "mm" for run in found.values())


def test_two_tests_of_one_name_are_said_to_be_that(tmp_path, in_this_process):
    (tmp_path / "s").mkdir()
    rows = [f"R1,2026-01-05,{k},{k * 7 % 11 / 1000}" for k in range(1, 32)]
    part = tmp_path / "s" / "a.csv"
    part.write_text("# unit: mm\nrobot,test,cycle,X\n" + "\n".join(rows * 2), encoding="utf-8")
    for found in (scara_iso.fleet(tmp_path / "s", tmp_path / "o"),
                  scara_iso.fleet_figures(tmp_path / "s", tmp_path / "f")):  # fmt: skip
        (failed,) = found.failed
        assert failed.error.endswith("tell them apart by the column test")


@pytest.mark.parametrize(
    ("text", "encoding", "said"),
    [
        (
            "# unit: mm\n# resolution: fine\nrobot,X\nR1,1\n",
            "utf-8",
            "line 2: resolution: 'fine' is not a number",
        ),
    ],
)
def test_a_part_whose_head_cannot_be_used_is_refused(tmp_path, text, encoding, said):
    (tmp_path / "a.csv").write_text(text, encoding=encoding)
    with pytest.raises(DataError, match=said):
        only_run(tmp_path / "a.csv")


def test_a_workbook_is_a_robot_and_a_note_beside_it_is_listed(tmp_path, in_this_process):
    book = openpyxl.Workbook()
    for row in [["# unit: mm"], ["cycle", "X"], *([k, k % 7 / 1000] for k in range(1, 32))]:
        book.active.append(row)
    (tmp_path / "parts").mkdir()
    book.save(tmp_path / "parts" / "R7.xlsx")
    (tmp_path / "parts" / "notes.txt").write_text("R7 is new", encoding="utf-8")
    found = scara_iso.fleet(tmp_path / "parts", tmp_path / "o")
    assert [one.robot for one in found.robots] == ["R7"]
    assert [one.part for one in found.failed] == ["notes.txt"]


@pytest.mark.parametrize("figures", [False, True])
def test_a_robot_stated_by_name_and_by_serial_number_is_one(tmp_path, in_this_process, figures):
    stated = [("R7", "4711"), ("R7", None), (None, "4711"), ("R8", "1"), ("R8", "2"), ("R8", None)]
    X = np.random.default_rng(1).normal(0, 0.003, 12)
    rows = "cycle,X\n" + "".join(f"{k},{x:.3f}\n" for k, x in enumerate(X, 1))
    (tmp_path / "parts").mkdir()
    for k, (name, serial) in enumerate(stated):
        head = f"# robot: {name}\n" if name else ""
        head += f"# serial_number: {serial}\n" if serial else ""
        (tmp_path / "parts" / f"{k}.csv").write_text(f"# unit: mm\n{head}{rows}", encoding="utf-8")
    summed = "SELECT 'R7' AS robot, 'b' AS test, k AS cycle, sin(k * k) / 99 AS X "
    duckdb.sql(f"{summed} FROM range(1, 13) a(k)").write_parquet(f"{tmp_path}/parts/6.parquet")
    run = scara_iso.fleet_figures if figures else scara_iso.fleet
    found = run(tmp_path / "parts", tmp_path / "o", unit="mm", cycles=12)
    robots = found.worst if figures else found.robots
    assert {one.robot: one.tables for one in robots} == {"4711": 4, "1": 1, "2": 1, "R8": 1}
    assert [(one.name, one.serial_numbers, one.tables) for one in found.names_alone] == [
        ("R7", ("4711",), 2),
        ("R8", ("1", "2"), 1),
    ]
    shown = found._repr_html_()
    assert "R7 and serial number 4711 are taken for one robot" in shown
    assert "R8 is the name of serial numbers 1, 2" in shown


def named(tmp_path, stated):
    """Return the summary of tables that state a name, a serial number or both."""
    X = np.random.default_rng(1).normal(0, 0.003, 12)
    rows = "cycle,X\n" + "".join(f"{k},{x:.3f}\n" for k, x in enumerate(X, 1))
    (tmp_path / "parts").mkdir()
    for k, (name, serial) in enumerate(stated):
        head = f"# robot: {name}\n" if name else ""
        head += f"# serial_number: {serial}\n" if serial else ""
        (tmp_path / "parts" / f"{k}.csv").write_text(f"# unit: mm\n{head}{rows}", encoding="utf-8")
    found = scara_iso.fleet_figures(tmp_path / "parts", tmp_path / "o", unit="mm", cycles=12)
    assert not found.failed
    return found


@pytest.mark.parametrize(
    ("stated", "robots", "said"),
    [
        ([("G", "n/a"), ("H", "N/A"), ("I", "-"), ("J", "-")], {"G", "H", "I", "J"}, None),
        ([("G", "0815"), ("H", "0815")], {"0815"}, "0815 stands with the names G, H"),
        ([("B", "C"), ("C", None)], {"C"}, "C stands with the names B, C: they are taken for one"),
        ([("A", "1"), ("A", "2")], {"1", "2"}, None),
        ([("E", "007"), ("F", "7")], {"007", "7"}, "007, 7 are alike but for"),
        ([("D", "77"), ("d ", None)], {"77", "d"}, "D, d are alike but for"),
        ([("K 1", None), ("K01", None)], {"K 1", "K01"}, "K 1, K01 are alike but for"),
        ([("K10", None), ("K1", None)], {"K10", "K1"}, None),
        ([("SCARA", "1"), ("Scara", "2")], {"1", "2"}, None),
        ([("R7", "1"), ("R7", None), (None, "1")], {"1"}, None),
        ([("R7", None), (None, "4711")], {"R7", "4711"}, "name alone (1, as R7), others by serial"),
        ([(None, None), (None, "4711"), (None, "4712")], {"0", "4711", "4712"}, "(2, as 4711)"),
        ([(None, "4711"), (None, "4712")], {"4711", "4712"}, None),
    ],
)
def test_names_that_leave_open_which_robot_it_is_are_said(
    tmp_path, in_this_process, stated, robots, said
):
    found = named(tmp_path, stated)
    assert {one.robot for one in found.worst} == robots
    doubts = [*found.several_names, *found.alike, found.names_and_numbers]
    assert len(list(filter(None, doubts))) == (said is not None)
    assert (said or f"of {many(len(robots), 'robot')}<") in found._repr_html_()


def test_only_the_first_doubts_are_shown_unless_all_are_asked_for(tmp_path, capsys):
    named(tmp_path, [(letter, None) for letter in "ABCDEFGHIJKLabcdefghijkl"])
    command = ["fleet", str(tmp_path / "parts"), "-o", str(tmp_path / "o"), "--figures",
               "--unit", "mm", "--cycles", "12"]  # fmt: skip
    for more, shown in ([], 10), (["--full"], 12):
        assert main([*command, *more]) == 0
        said = capsys.readouterr().out
        assert said.count("are alike but") == shown
        assert ("and 2 more like that: --full" in said) == (not more)


def test_one_row_below_a_header_in_quotes_is_read(tmp_path):
    part = tmp_path / "a.csv"
    part.write_text('# unit: mm\n"robot","X",\n"R1","0.1",\n', encoding="utf-8")
    (found,) = tables_in(part, ReadAs())
    assert (found.robot, found.run.axes["X"].readings[0]) == ("R1", 0.1)


def test_a_full_disk_and_damaged_results_are_said(tmp_path, monkeypatch):
    (tmp_path / "a.parquet").write_bytes(b"PAR1 and no more")
    with pytest.raises(DataError, match="results cannot be read"), results_in(tmp_path):
        pass
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "none"))
    with pytest.raises(WriteError, match="temporary"):
        as_parquet([pd.DataFrame({"a": [1]})], {"a": "INTEGER"})


SORTED = "CREATE TABLE a AS SELECT random()::VARCHAR AS r FROM range(400000) ORDER BY r"


def test_duckdb_draws_nothing_where_results_are_printed():
    code = (
        "from scara_iso.fleets.database import connect; "
        "print(connect().execute(\"SELECT current_setting('enable_progress_bar')\").fetchone()[0])"
    )  # by -c DuckDB takes the process for a person's
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, text=True)
    assert done.stdout == "False\n"


def test_no_bar_is_drawn_where_nothing_is_to_be_done():
    shown = io.StringIO()
    assert list(track([], 0, Console(file=shown, force_terminal=True))) == []
    assert shown.getvalue() == ""


def raised(words):
    raise duckdb.IOException(words)


@pytest.mark.parametrize(
    ("done", "kind", "words"),
    [
        (lambda query: (query("SET memory_limit = '3MB'"), query(SORTED)),
         DataError, ("part: takes more memory", "split the part")),
        (lambda query: (query("SET max_temp_directory_size = '1MiB'"),
                        query("SET memory_limit = '16MB'"), query(SORTED)),
         WriteError, ("no room for temporary files", "TMPDIR")),
        (lambda _: raised("No space left on device"), WriteError, ("no room", "TMPDIR")),
        (lambda _: raised("No such file"), DataError, ("cannot be read", "mend the file")),
    ],
    ids=["memory", "disk", "disk, when written", "neither"],
)  # fmt: skip
def test_memory_and_disk_that_are_full_are_told_apart(tmp_path, done, kind, words):
    with pytest.raises(kind, match=words[0]) as found, workspace(tmp_path / "part") as query:
        done(query)
    assert words[1] in found.value.remedy


def test_parquet_needs_its_unit_and_a_test_that_is_there_twice_is_said(tmp_path):
    source = fleet_of(tmp_path / "source", parts=1, robots=2, ill=())
    for name in ("a,1", "b"):
        duckdb.sql(
            f"COPY (FROM read_csv('{source}/part0.csv', comment='#')) TO '{source}/{name}.parquet'"
        )
    (source / "part0.csv").unlink()
    none = scara_iso.fleet(source, tmp_path / "none", workers=1)
    assert len(none.failed) == 4
    assert none.twice == ()  # nothing of them counts
    assert "unit" in none.failed[0].error
    found = scara_iso.fleet(source, tmp_path / "out", unit="mm", resolution=0.001, workers=1)
    assert [(one.robot, one.parts) for one in found.twice] == [
        ("R0-0", ("a,1.parquet", "b.parquet")), ("R0-1", ("a,1.parquet", "b.parquet"))
    ]  # fmt: skip


def test_a_test_without_its_number_is_one_of_its_own(tmp_path):
    (source := tmp_path / "source").mkdir()
    rows = "".join(f"R,{t},{c},{0.4 + c * c % 7 / 1000}\n" for t in (1, "") for c in range(1, 32))
    (tmp_path / "a.csv").write_text(f"robot,test,cycle,X\n{rows}")
    duckdb.sql(f"COPY (FROM read_csv('{tmp_path}/a.csv')) TO '{source}/a.parquet'")
    found = scara_iso.fleet(source, tmp_path / "out", unit="mm", resolution=0.001, workers=1)
    assert (found.tables, dict(found.run.failed), found.failed) == (2, {}, ())


def dying(part, marks):
    """Die the first time on 'once', each time on 'always'."""
    mark = Path(marks, part)
    if part == "always" or (part == "once" and not mark.exists()):
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return part.upper()


@pytest.mark.slow
def test_killed_processes_lose_and_double_nothing(tmp_path):
    engine = Engine(partial(open_processes, 2), lambda: 4)
    parts = ["a", "b", "once", "c", "always", "d", "e"]
    found = list(done_by(engine, partial(dying, marks=tmp_path), parts))
    assert sorted(part for part, _ in found) == sorted(parts)
    given_up = {part for part, one in found if isinstance(one, Exception)}
    assert given_up == {"always"}
    assert all(one == part.upper() for part, one in found if part not in given_up)


def test_many_by_any_executor(tmp_path):
    source = fleet_of(tmp_path / "s", parts=1, robots=1, ill=())
    table = tmp_path / "t.csv"
    rows = (source / "part0.csv").read_text("utf-8").replace("robot,test,", "")
    table.write_text(rows.replace("R0-0,t1,", ""), encoding="utf-8")
    with ThreadPoolExecutor(1) as pool:
        found = scara_iso.diagnose_many([table, tmp_path / "no.csv"], executor=pool)
        figures = scara_iso.analyze_many([table, tmp_path / "no.csv"], executor=pool)
    assert found[0].verdict.value == "nothing-to-explain"
    assert found[1].exit_code == 66
    assert figures[0].poses[0].axes["X"].RP == scara_iso.analyze(table).poses[0].axes["X"].RP
    assert isinstance(figures[1], scara_iso.ScaraIsoError)
    assert set(figures.to_frame()["source"]) == {str(table)}


def started(*words):
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.Popen(
        [sys.executable, *words], env=environment, stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )  # fmt: skip


def until(condition, seconds=180):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it did not come"
        time.sleep(0.05)


def lines_of(manifest):
    return manifest.read_bytes().count(b"\n") if manifest.exists() else 0


@pytest.mark.slow
def test_a_script_without_a_guard_runs_once(tmp_path):
    """Processes that start from nothing run the script again, unless nobody names it to them."""
    script = tmp_path / "script.py"
    table = ROOT / "examples" / "scatter.csv"
    script.write_text(
        "import scara_iso\nprint('once')\n"
        f"print(len(scara_iso.analyze_many([{str(table)!r}] * 2)))\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    call = [sys.executable, str(script)]
    done = subprocess.run(call, env=environment, capture_output=True, encoding="utf-8", check=False)
    assert (done.stdout, done.stderr) == ("once\n2\n", "")


@pytest.mark.slow
def test_a_killed_client_goes_on_where_it_stopped(tmp_path, done):
    source, out, _ = done
    words = ("-m", "scara_iso", "fleet", str(source), "-o", str(tmp_path / "o"), "--workers", "1")
    client = started(*words)
    until(lambda: lines_of(tmp_path / "o" / "manifest.jsonl") >= 3)
    client.kill()
    client.wait()
    summary = scara_iso.fleet(source, tmp_path / "o", workers=1)
    assert summary.run.before >= 2
    assert results(tmp_path / "o") == results(out)


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="Ctrl-C of a process alone")
@pytest.mark.parametrize("lines", [1, 3], ids=["at the start", "in the middle"])
def test_ctrl_c_ends_the_processes_and_says_that_it_goes_on(tmp_path, done, lines):
    source, out, _ = done
    words = ["-m", "scara_iso", "fleet", str(source), "-o", str(tmp_path / "o"), "--workers", "1"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    with subprocess.Popen(
        [sys.executable, *words], env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True, start_new_session=True, preexec_fn=hears_ctrl_c,  # noqa: PLW1509
    ) as client:  # fmt: skip
        until(lambda: lines_of(tmp_path / "o" / "manifest.jsonl") >= lines)
        os.killpg(client.pid, signal.SIGINT)  # as a terminal does: all of them hear it
        said = client.communicate(timeout=60)
        assert client.returncode == 130
        assert said[0] == ""
        assert said[1].splitlines() == [
            "scara-iso: interrupted",
            "  the parts that are done are kept; the same command goes on where it stopped",
        ]
        until(lambda: not of_group(client.pid))
    scara_iso.fleet(source, tmp_path / "o", workers=1)
    assert results(tmp_path / "o") == results(out)


def hears_ctrl_c():
    """Hear it although these tests run in the background, where a shell has it ignored."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def text_of(path):
    try:
        return path.read_text()
    except OSError:
        return ""


def of_group(group):
    """Return the processes of a group that are alive, as far as this system shows them."""
    fields = [
        stat.rpartition(")")[2].split() for stat in map(text_of, Path("/proc").glob("[0-9]*/stat"))
    ]
    return [own for own in fields if own and own[2] == str(group) and own[0] != "Z"]


def alive(pid):
    try:
        os.kill(pid, 0)
    except OSError:
        return False
    state = Path(f"/proc/{pid}/stat")
    return not state.exists() or state.read_text().rpartition(")")[2].split()[0] != "Z"


@pytest.mark.slow
def test_processes_end_with_the_one_that_started_them():
    program = (
        "import os, time; from scara_iso.fleets.engines import open_processes; "
        "pool = open_processes(1); print(pool.submit(os.getpid).result(), "
        "pool.submit(os.getenv, 'OPENBLAS_NUM_THREADS').result(), flush=True); "
        "time.sleep(600)"
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    environment.pop("OPENBLAS_NUM_THREADS", None)
    with subprocess.Popen(
        [sys.executable, "-c", program], env=environment, stdout=subprocess.PIPE, text=True
    ) as client:
        worker, threads = map(int, client.stdout.readline().split())
        assert threads == 1  # of the matrices: processes share the cores
        assert alive(worker)
        client.kill()
    until(lambda: not alive(worker))


@pytest.mark.cluster
def test_what_only_listens_is_no_scheduler(tmp_path, done):
    pytest.importorskip("distributed")
    with socket.create_server(("127.0.0.1", 0)) as silent:
        place = f"dask://127.0.0.1:{silent.getsockname()[1]}"
        with pytest.raises(ServiceError, match="no Dask scheduler answers"):
            scara_iso.fleet(done[0], tmp_path / "o", engine=place)


@pytest.mark.cluster
def test_a_scheduler_without_workers_is_not_waited_for_without_end(tmp_path, done, monkeypatch):
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr(engines, "_FIRST_WORKER", 1)
    with distributed.LocalCluster(n_workers=0, dashboard_address=None) as cluster:
        place = cluster.scheduler_address.removeprefix("tcp://")
        with pytest.raises(ServiceError, match="has had no worker for 1 s") as found:
            scara_iso.fleet(done[0], tmp_path / "o", engine=f"dask://{place}")
    assert f"dask worker {place}" in found.value.remedy


@pytest.mark.cluster
def test_a_cluster_whose_worker_and_client_are_killed_gives_the_same(tmp_path):
    distributed = pytest.importorskip("distributed")
    source = fleet_of(tmp_path / "source", parts=8, robots=3)
    expected = scara_iso.fleet(source, tmp_path / "serial", workers=1)
    address = tmp_path / "scheduler.json"
    dask = ("-m", "distributed.cli.dask_scheduler", "--port", "0", "--no-dashboard",
            "--scheduler-file", str(address))  # fmt: skip
    worker = ("-m", "distributed.cli.dask_worker", "--scheduler-file", str(address),
              "--nthreads", "1", "--no-dashboard", "--no-nanny")  # fmt: skip
    processes = [started(*dask)]
    try:
        until(address.exists)
        place = json.loads(address.read_text())["address"].removeprefix("tcp://")
        processes += [started(*worker), started(*worker)]
        with distributed.Client(f"tcp://{place}", set_as_default=False) as client:
            client.wait_for_workers(2, timeout=60)
        words = ("-m", "scara_iso", "fleet", str(source), "-o", str(tmp_path / "o"),
                 "--engine", f"dask://{place}")  # fmt: skip
        manifest = tmp_path / "o" / "manifest.jsonl"
        client = started(*words)
        until(lambda: lines_of(manifest) >= 2)
        processes[1].kill()
        until(lambda: lines_of(manifest) >= 4)
        client.kill()
        client.wait()
        found = scara_iso.fleet(source, tmp_path / "o", engine=f"dask://{place}")
        assert 3 <= found.run.before
        assert results(tmp_path / "o") == results(tmp_path / "serial")
        assert [one.robot for one in found.found] == [one.robot for one in expected.found]
    finally:
        for process in reversed(processes):
            process.kill()
            process.wait()


def test_a_cluster_that_goes_away_is_no_defect():
    def gone():
        raise ServiceError("nobody is left")

    class Cluster(ThreadPoolExecutor):
        def submit(self, *_):
            future = Future()
            future.cancel()
            future.set_running_or_notify_cancel()
            return future

    for engine, said in (
        (Engine(partial(Cluster, 1), lambda: 1), "the cluster has gone away"),
        (Engine(partial(Cluster, 1), gone), "nobody is left"),
    ):
        with pytest.raises(ServiceError, match=said):
            list(done_by(engine, str, ["a"]))


def test_more_is_under_way_as_a_cluster_grows():
    sizes, most = iter([1, 1, 4, 4, 4, 4, 4, 4, 4]), []

    def size():
        most.append(next(sizes))
        return most[-1]

    gate = threading.Barrier(4, timeout=60)

    def work(item):
        if item >= 2:
            gate.wait()  # ends only where four are at work
        return item

    found = dict(done_by(Engine(partial(ThreadPoolExecutor, 4), size), work, range(6)))
    assert found == {k: k for k in range(6)}


def test_another_version_on_a_worker_is_refused(tmp_path, done, monkeypatch):
    source, _, _ = done
    monkeypatch.setattr("scara_iso.__version__", "99.0")
    with pytest.raises(DataError, match="a worker has"):
        scara_iso.fleet(source, tmp_path / "o", workers=1)


def test_copies_and_folders_that_are_not_looked_at_are_named(tmp_path):
    source = fleet_of(tmp_path / "source", parts=2)
    assert scara_iso.fleet(source, tmp_path / "out").run.doubts == ()
    shutil.copy(source / "part0.csv", source / "part0 - copy.csv")
    for name, held in (("old", "a.csv"), ("empty", ""), ("results", "manifest.jsonl")):
        (source / name).mkdir()
        shutil.copy(source / "part1.csv", source / name / (held or "readme.md"))
    shutil.copy(source / "part1.csv", source / "results" / "robots.csv")
    copies, folder = scara_iso.fleet(source, tmp_path / "out").run.doubts
    assert copies.startswith("part0 - copy.csv, part0.csv have the same bytes")
    assert folder == "folder old, 1 table in it: not looked at"


def test_the_robot_that_scatters_most_by_far_is_named_whatever_was_found_in_it(tmp_path, capsys):
    source, rng = tmp_path / "source", np.random.default_rng(8)
    source.mkdir()
    for robot in range(8):
        values = rng.normal(0, 0.012 if robot == 5 else 0.004, (31, 2))
        rows = [f"R{robot},t1,{k},{x:.3f},{y:.3f}" for k, (x, y) in enumerate(values, 1)]
        (source / f"{robot}.csv").write_text(HEAD + "\n".join(rows) + "\n", encoding="utf-8")
    assert main(["fleet", str(source), "-o", str(tmp_path / "out")]) == 0
    assert "Largest RP XY: R5, 0.0" in capsys.readouterr().out
    (source / "5.csv").unlink()
    assert main(["fleet", str(source), "-o", str(tmp_path / "out")]) == 0
    assert "Largest" not in capsys.readouterr().out
