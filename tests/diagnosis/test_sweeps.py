"""Sweeps of reversals: read strictly, traced to what the model lacks."""

import json
import math

import numpy as np
import openpyxl
import pytest

from scara_iso.base.errors import DataError, NoInputError
from scara_iso.commands import main
from scara_iso.diagnosis import diagnose_sweep
from scara_iso.diagnosis.sweeps import read_sweep

FIRST_JOINT = ["--Im", "2.65e-4", "--IL", "4.749", "--arcmin", "12"]


def sweep_file(tmp_path, rows, header="Im,IL,arcmin,deviation_rad"):
    path = tmp_path / "sweep.csv"
    path.write_text("\n".join([header, *rows, ""]), encoding="utf-8")
    return path


def reversals(inertia_of_motor, *, rng=None, scatter=0.0):
    gap = math.radians(12 / 60)
    for load in (0.5, 1.0, 2.0, 3.0, 4.749, 8.0):
        moved = -gap / (1 + load / inertia_of_motor)
        yield f"2.65e-4,{load},12,{moved + (rng.normal(0, scatter) if rng else 0):.8e}"


def closed(tmp_path, capsys, rows):
    path = sweep_file(tmp_path, rows)
    assert main(["backlash", *FIRST_JOINT, "--measured", str(path), "--json"]) == 0
    return json.loads(capsys.readouterr().out, parse_constant=pytest.fail)


def test_columns_in_any_order_with_comments_and_semicolons(tmp_path):
    path = sweep_file(
        tmp_path, ["# by hand", "12;-1e-3;4.749;2.65e-4;7"], "arcmin;deviation_rad;IL;Im;operator"
    )
    found = read_sweep(path)
    assert found.sweep.I_m.tolist() == [2.65e-4]
    assert found.sweep.gap.tolist() == [math.radians(12 / 60)]
    assert found.deviation.tolist() == [-1e-3]
    assert found.uncertainty is None


def test_sizes_take_the_sign_of_eq_16(tmp_path):
    found = read_sweep(sweep_file(tmp_path, ["1,1,1,2e-4", "1,1,1,3e-4"]))
    assert np.all(found.deviation < 0)
    assert "sizes" in found.notes[0]


@pytest.mark.parametrize(
    ("rows", "header", "said"),
    [
        (["1,1,1,nan"], None, "line 2, column 4: 'nan' is not a number"),
        (["0,1,1,1"], None, "line 2, column 1: Im: 0 is not positive"),
        (["1,1,1"], None, "line 2: 3 fields, the header has 4"),
        (["1,1,1"], "Im,IL,arcmin", "column deviation_rad is missing"),
        (["1,1,1,1,1"], "Im,Im,IL,arcmin,deviation_rad", "column Im is there twice"),
        ([], None, "at least one row"),
        (['1,1,1,"1', "1,1,1,1"], None, "line 2: unexpected end of data"),
        (["1;1;12,5;1.5"], "Im;IL;arcmin;deviation_rad", "commas and points both occur"),
        (["1;1;1,234;1"], "Im;IL;arcmin;deviation_rad", "could have a decimal comma or group"),
        (["0,5,1,12,0,1"], None, "line 2: 6 fields, the header has 4"),
        (["1 kg,1,1,1"], None, "line 2, column 1: Im: 1 has a unit, 'kg'"),
        (["1,1,1," + "0" * 200_000 + "x"], None, "line 2, column 4"),
    ],
)
def test_what_is_no_sweep_is_refused(tmp_path, rows, header, said):
    path = sweep_file(tmp_path, rows, header or "Im,IL,arcmin,deviation_rad")
    with pytest.raises(DataError) as caught:
        read_sweep(path)
    assert said in "\n".join(str(fault) for fault in caught.value.faults)


def test_quoted_numbers_of_a_sweep(tmp_path):
    found = read_sweep(
        sweep_file(tmp_path, ['"1","2","3","-4e-4"'], '"Im","IL","arcmin","deviation_rad"')
    )
    assert found.deviation.tolist() == [-4e-4]


GERMAN = "Im;IL;arcmin;deviation_rad\n2,65E-04;0,5;12;-1,85E-06\n2,65E-04;4,749;12;-1,9E-07\n"


@pytest.mark.parametrize(
    "data",
    [
        GERMAN.encode(),
        GERMAN.replace("\n", "\r\n").encode("cp1252"),
        GERMAN.encode("utf-16"),
        ("sep=;\n" + GERMAN + ";;;\n").encode("utf-8-sig"),
        GERMAN.replace(";", "\t").encode(),
        GERMAN.replace(";", "   ").replace("-1", "\u22121").encode(),
    ],
)
def test_a_sweep_as_a_german_spreadsheet_saves_it(data):
    found = read_sweep(data)
    assert found.sweep.I_m.tolist() == [2.65e-4, 2.65e-4]
    assert found.sweep.I_L.tolist() == [0.5, 4.749]
    assert found.deviation.tolist() == [-1.85e-6, -1.9e-7]


def test_a_sweep_in_a_workbook(tmp_path):
    book = openpyxl.Workbook()
    book.active.append(["notes"])
    sheet = book.create_sheet("sweep")
    sheet.append(["# by hand"])
    sheet.append(["IL", "Im", "arcmin", "u_rad", "deviation_rad", "who"])
    sheet.append([0.5, 2.65e-4, 12, 1e-8, -1.85e-6, "A"])
    sheet.append([])
    sheet.append([4.749, 2.65e-4, 12, 1e-8, -1.9e-7, "B"])
    path = tmp_path / "sweep.xlsx"
    book.save(path)
    found = read_sweep(path)
    assert found.sweep.I_L.tolist() == [0.5, 4.749]
    assert found.uncertainty.tolist() == [1e-8, 1e-8]
    sheet["E3"] = "#DIV/0!"
    book.save(path)
    with pytest.raises(DataError) as caught:
        read_sweep(path)
    assert "sweep!E3" in str(caught.value.faults[0])


@pytest.mark.parametrize("sweeps", [0, 2])
def test_a_workbook_of_no_sweep_or_of_several_is_refused(tmp_path, sweeps):
    book = openpyxl.Workbook()
    book.active.append(["notes"])
    for name in "AB"[:sweeps]:
        sheet = book.create_sheet(name)
        sheet.append(["Im", "IL", "arcmin", "deviation_rad"])
        sheet.append([2.65e-4, 0.5, 12, -1.85e-6])
    book.save(tmp_path / "sweep.xlsx")
    with pytest.raises(
        DataError, match="'A' and 'B' hold" if sweeps else "no sheet holds"
    ) as found:
        read_sweep(tmp_path / "sweep.xlsx")
    assert (found.value.remedy == "leave one") is (sweeps == 2)


def test_no_such_sweep(tmp_path):
    with pytest.raises(NoInputError):
        read_sweep(tmp_path / "nowhere.csv")


def test_a_sweep_that_follows_eq_16_has_nothing_to_explain(tmp_path, capsys, rng):
    document = closed(tmp_path, capsys, reversals(2.65e-4, rng=rng, scatter=1e-8))
    assert document["verdict"] == "nothing-to-explain"
    assert document["effects"] == []


def test_a_rotor_seen_through_the_gear_is_found(tmp_path, capsys, rng):
    document = closed(tmp_path, capsys, reversals(2500 * 2.65e-4, rng=rng, scatter=5e-6))
    (found,) = document["effects"]
    assert found["effect"] == "reflected_inertia"
    assert found["parameters"]["N"] == pytest.approx(50, rel=0.03)
    low, high = found["intervals"]["N"]
    assert low <= 50 <= high
    error = document["error"]
    assert error["after"]["held_out_rms"] < error["before"]["rms"] / 20


def test_it_is_said_on_the_terminal(tmp_path, capsys):
    path = sweep_file(tmp_path, reversals(2500 * 2.65e-4))
    assert main(["backlash", *FIRST_JOINT, "--measured", str(path)]) == 0
    out = capsys.readouterr().out
    assert "reflected inertia" in out
    assert "held out" in out


@pytest.mark.parametrize("u", [1e-7, 1e-8])
def test_the_command_takes_the_uncertainty_of_each_row(u, tmp_path, capsys):
    rows = "".join(f"2.65e-4,{0.4 + k / 2},12,{u:g},{-1.85e-6 / (1 + k):g}\n" for k in range(6))
    (tmp_path / "sweep.csv").write_text(f"Im,IL,arcmin,u_rad,deviation_rad\n{rows}")
    words = ["backlash", "--Im", "2.65e-4", "--IL", "4.749", "--arcmin", "12"]
    assert main([*words, "--measured", str(tmp_path / "sweep.csv"), "--json"]) == 0
    read = read_sweep(tmp_path / "sweep.csv")
    expected = diagnose_sweep(read.sweep, read.deviation, uncertainty=np.full(6, u))
    assert json.loads(capsys.readouterr().out)["p_value"] == pytest.approx(expected.p_value)
