"""The figures of many robots: those of `analyze`, whoever adds them up."""

import json
from functools import partial
from glob import escape

import duckdb
import numpy as np
import pandas as pd
import pytest

import scara_iso
from scara_iso.commands import main
from scara_iso.diagnosis import CyclesWanted
from scara_iso.fleets import ReadAs, Task
from scara_iso.fleets.figures import figures_of
from scara_iso.fleets.parts import part_at
from scara_iso.fleets.runs import Piece


def table(robot, rng, *, cycles=range(1, 32), poses=("P1", "P2"), at=0.0, size=0.003, test="t"):
    """Return the rows of one table, pose by pose in each cycle."""
    rows = [(robot, test, pose, cycle) for cycle in cycles for pose in poses]
    found = pd.DataFrame(rows, columns=["robot", "test", "pose", "cycle"])
    readings = (at + rng.normal(0, size, (len(rows), 3))).round(3)
    return found.assign(**dict(zip("XYZ", readings.T, strict=True)))


def several(rng):
    """Return tables as most are, and others, by robot."""
    one = {
        "plain": table("plain", rng),
        "far": table("far", rng, at=412.345),
        "one pose": table("one pose", rng, poses=("P7",)),
        "coarse": table("coarse", rng, size=0.0004),
        "stuck": table("stuck", rng).assign(Z=0.123),
        "two levels": table("two levels", rng).assign(X=lambda t: 0.1 + t["cycle"] % 2 / 100),
        "no Z": table("no Z", rng).assign(Z=np.nan),
        "first gone": table("first gone", rng, cycles=range(2, 32)),
        "a gap": table("a gap", rng).query("cycle != 9"),
        "twice": table("twice", rng).replace({"cycle": {9: 10}}),
        "short": table("short", rng, cycles=range(1, 20)),
        "uneven": table("uneven", rng).query("cycle != 1 or pose != 'P2'"),
        "not read": table("not read", rng).assign(Y=lambda t: t["Y"].where(t["cycle"] != 5)),
        "absurd": table("absurd", rng).assign(Y=lambda t: t["Y"] + 1e12),
        "no pose": table("no pose", rng).assign(test=None),
    }
    return one | {"other test": table("plain", rng, test="u")}


def parquet(path, frame):
    path.parent.mkdir(exist_ok=True)
    duckdb.sql(f"COPY frame TO '{path}' (FORMAT parquet)")
    return path


def expected(frame, **options):
    """Return RP and barycentre of each pose by `analyze`, or what it says instead."""
    frame = frame.drop(columns=["robot", "test"]).dropna(axis=1, how="all")
    run = scara_iso.Run.from_frame(frame.reset_index(drop=True), unit="mm", resolution=0.001)
    found = {}
    for pose in scara_iso.analyze(run, **options).poses:
        own = {name: (axis.RP, axis.mean) for name, axis in pose.axes.items()}
        radial = {name: getattr(pose, name) for name in ("XY", "XYZ")}
        own |= {name: (one.RP, None) for name, one in radial.items() if one is not None}
        found[pose.label] = own
    return found


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    folder = tmp_path_factory.mktemp("figures")
    frames = several(np.random.default_rng(3))
    frame = pd.concat(frames.values())
    parquet(folder / "source" / "all.parquet", frame)
    (folder / "source" / "broken.parquet").write_bytes(b"PAR1 and no more")
    found = scara_iso.fleet_figures(folder / "source", folder / "out", unit="mm", resolution=0.001)
    rows = duckdb.sql(f"FROM '{found.files}/*.parquet'").df()
    return frames, found, rows


@pytest.mark.parametrize("name", sorted(several(np.random.default_rng(3))))
def test_the_figures_are_those_of_analyze(done, name):
    frames, found, rows = done
    test = frames[name]["test"].iloc[0] or ""
    robot = frames[name]["robot"].iloc[0]
    own = rows[(rows["robot"] == robot) & (rows["test"] == test)]
    errors = [one.error for one in found.failed if (one.robot, one.test) == (robot, test)]
    if errors:
        with pytest.raises(scara_iso.DataError) as refused:
            expected(frames[name])
        assert refused.value.what in errors[0]
        assert len(own) == len(errors) == 1
        return
    rel = 1e-10 if name == "far" else 1e-12  # the barycentre of 412.345 mm is rounded
    poses = expected(frames[name])
    labels = {str(label): row for label, row in own.set_index("pose", drop=False).iterrows()}
    assert len(labels) == len(poses) == len(own)
    for label, figures in poses.items():
        row = labels.get(str(label), own.iloc[0])
        for figure, (RP, mean) in figures.items():
            assert row[f"RP_{figure}"] == pytest.approx(RP, rel=rel, abs=1e-18)
            assert mean is None or row[f"mean_{figure}"] == pytest.approx(mean, rel=1e-12)
        assert set(figures) == {f for f in ("X", "Y", "Z", "theta", "XY", "XYZ")
                                if not np.isnan(row[f"RP_{f}"])}  # fmt: skip


def test_only_the_odd_tables_are_read_one_by_one(tmp_path, monkeypatch):
    rng = np.random.default_rng(8)
    frame = pd.concat([table(f"R{k}", rng) for k in range(9)] + [table("odd", rng).iloc[:-1]])
    frame = frame.sample(frac=1, random_state=1)  # rows stand in no order
    path = parquet(tmp_path / "a.parquet", frame.sort_values("robot"))
    asked = []
    of_all = scara_iso.fleets.parts.tables_in
    monkeypatch.setattr("scara_iso.fleets.figures.tables_in",
                        lambda *a: asked.append(a[-1]) or of_all(*a))  # fmt: skip
    made = figures_of(Piece((part_at(path),)), Task(ReadAs("um"), CyclesWanted()))
    assert asked == [{("odd", "t")}]
    assert (made.tables, made.failed) == (10, 1)
    (tmp_path / "out.parquet").write_bytes(made.rows)
    rows = duckdb.sql(f"FROM '{tmp_path}/out.parquet' WHERE error IS NULL").df()
    read = {(row["robot"], row["pose"]): row["RP_XY"] for _, row in rows.iterrows()}
    own = frame[frame["robot"] == "R4"].sort_values(["cycle", "pose"])
    assert read["R4", "P2"] == pytest.approx(expected(own)["P2"]["XY"][0] / 1000, rel=1e-12)


@pytest.mark.parametrize(
    "change",
    [
        lambda frame: frame.assign(level=1.5),
        lambda frame: frame.assign(approach=1),
        lambda frame: frame.assign(cycle=frame["cycle"].astype(float)),
        lambda frame: frame.drop(columns="cycle"),
        lambda frame: frame.assign(X=frame["X"].map(str)),
    ],
)
def test_columns_that_have_to_be_judged_are_left_to_the_reader(tmp_path, change):
    frame = table("R", np.random.default_rng(2))
    path = parquet(tmp_path / "a.parquet", change(frame))
    made = figures_of(Piece((part_at(path),)), Task(ReadAs("mm"), CyclesWanted()))
    assert (made.tables, made.failed, made.errors) == (1, 0, {})
    (tmp_path / "out.parquet").write_bytes(made.rows)
    found = duckdb.sql(f"FROM '{tmp_path}/out.parquet'").select("pose", "RP_XY").fetchall()
    assert dict(found) == pytest.approx({k: v["XY"][0] for k, v in expected(frame).items()})


def test_other_cycles_by_option(tmp_path):
    frame = table("R", np.random.default_rng(2), cycles=range(1, 51))
    parquet(tmp_path / "s" / "a.parquet", frame)
    for options in ({"cycles": 50}, {"all_count": True, "cycles": 50}):
        to = tmp_path / f"o{len(options)}"
        found = scara_iso.fleet_figures(tmp_path / "s", to, unit="mm", **options)
        wanted = expected(frame, **options)
        assert found.worst[0].RP["X"] == pytest.approx(max(o["X"][0] for o in wanted.values()))


def test_of_a_part_that_can_no_longer_be_read_nothing_is_left(tmp_path):
    path = parquet(tmp_path / "s" / "a.parquet", table("R", np.random.default_rng(2)))
    assert scara_iso.fleet_figures(tmp_path / "s", tmp_path / "o", unit="mm").tables == 1
    path.write_bytes(b"PAR1 and no more")
    found = scara_iso.fleet_figures(tmp_path / "s", tmp_path / "o", unit="mm")
    assert (list(found.run.failed), found.tables, found.worst) == (["a.parquet"], 0, ())


def test_the_page_and_its_object(done, tmp_path, capsys):
    frames, found, rows = done
    source, out = found.run.folder.parent / "source", found.run.folder
    call = partial(main, ["fleet", str(source), "-o", str(out), "--figures", "--unit", "mm",
                          "--resolution", "0.001", "--json"])  # fmt: skip
    assert call() == 65  # some cannot be read
    said = json.loads(capsys.readouterr().out)
    assert said["parts"]["done_before"] == 2
    assert list(said["parts"]["failed"]) == ["broken.parquet"]
    assert said["tables"] == found.tables == len(frames) - len(found.failed)
    assert said["worst"][0]["robot"] == rows.loc[rows["RP_XY"].idxmax(), "robot"]
    assert main(["fleet", str(source), "-o", str(out), "--unit", "mm"]) == 65  # of other options
    assert "figures was True and is None" in capsys.readouterr().err
    assert main(["fleet", str(tmp_path), "-o", str(tmp_path / "o"), "--figures"]) == 66


@pytest.mark.parametrize("work", [scara_iso.fleet_figures, scara_iso.fleet])
def test_no_letter_of_a_name_is_a_pattern_or_a_column(tmp_path, rng, monkeypatch, work):
    monkeypatch.chdir(tmp_path)
    one, other, third = (table(robot, rng, at=0.2) for robot in ("one", "other", "third"))
    for folder, name in (("plain", "second.parquet"), ("X=7/robot=evil", "par[tr].parquet")):
        (tmp_path / folder).mkdir(parents=True)
        parquet(tmp_path / folder / "part.parquet", one)
        parquet(tmp_path / folder / name, other)
    parquet(tmp_path / "neighbour" / "part.parquet", third)
    rows = {}
    for source, to in (("neighbour", "a out"), ("plain", "out"), ("X=7/robot=evil", "[ab] out")):
        found = work(tmp_path / source, to, unit="mm", resolution=0.001)
        assert found.tables == (1 if source == "neighbour" else 2)
        sql = "FROM read_parquet(?, hive_partitioning = false)"
        frame = duckdb.sql(sql, params=[f"{escape(to)}/parts/*.parquet"]).df()
        rows[source] = frame.drop(columns="part", errors="ignore").sort_values("robot")
    pd.testing.assert_frame_equal(
        rows["plain"].reset_index(drop=True), rows["X=7/robot=evil"].reset_index(drop=True)
    )


def test_small_tables_share_a_file_of_results_that_a_change_makes_anew(tmp_path):
    source, to = tmp_path / "s", tmp_path / "o"
    source.mkdir()
    rng = np.random.default_rng(4)

    def write(name):
        rows = "".join(f"{k},{x:.3f}\n" for k, x in enumerate(rng.normal(0, 0.01, 31), 1))
        (source / name).write_text(f"# unit: mm\ncycle,X\n{rows}", encoding="utf-8")

    for name in ("a.csv", "b.csv", "c.csv"):
        write(name)
    (source / "b2.csv").write_text("", encoding="utf-8")
    parquet(source / "z.parquet", table("R", rng))
    first = scara_iso.fleet_figures(source, to, unit="mm")
    assert (first.tables, len(list(first.files.glob("*")))) == (4, 2)
    assert scara_iso.fleet_figures(source, to, unit="mm").run.before == 5
    (source / "b2.csv").unlink()
    write("b.csv")
    found = scara_iso.fleet_figures(source, to, unit="mm")
    assert (found.run.before, found.tables, found.twice) == (1, 4, ())
    rows = duckdb.sql(f"FROM '{found.files}/*.parquet'").df()
    own = rows.set_index("part")["RP_X"]["b.csv"]
    assert own == scara_iso.analyze(source / "b.csv").poses[0].axes["X"].RP
