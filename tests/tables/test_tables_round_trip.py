"""What is written is read back to the same run, and no text in it can do harm."""

import csv
import re
from pathlib import Path

import numpy as np
import pytest
from budget import examples
from hypothesis import assume, example, given, strategies as st

from scara_iso.base.errors import DataError
from scara_iso.base.quantities import Dimension
from scara_iso.run import Axis, Run
from scara_iso.tables import find_locale, read_table, write_table
from scara_iso.tables.vocabulary.names import read_unit

EXAMPLE = Path(__file__).parents[2] / "examples" / "fum_scara_table1.csv"
finite = st.floats(-1e9, 1e9)
sizes = st.none() | st.sampled_from([0.001, 0.0005, 0.01, 1e-7]) | st.floats(1e-9, 1e3)
printable = st.characters(exclude_categories=("C", "Z"), include_characters=" ")
written = st.text(printable | st.sampled_from("=+-@,;'\"#:"), max_size=30).map(str.strip)
texts = written.filter(lambda text: read_unit(text) is None)  # another unit than that of readings
keys = st.from_regex(r"[a-z][a-z0-9_]{0,10}", fullmatch=True).filter(
    lambda key: not re.match("unit|resolution|indicator_unc|command_|einheit", key)
)
labels = st.text(printable | st.sampled_from("=+-@'"), min_size=1, max_size=20).map(str.strip)


@st.composite
def runs(draw):
    rows = draw(st.integers(1, 6))
    column = st.lists(finite, min_size=rows, max_size=rows).map(np.array)
    names = draw(st.lists(st.sampled_from(["X", "Y", "Z", "theta"]), min_size=1, unique=True))
    near = st.lists(st.floats(-90, 90), min_size=rows, max_size=rows).map(np.array)
    angle = draw(st.booleans())  # whose readings lie within half a turn
    axes = {
        name: Axis(
            name,
            draw(near if angle and name == "theta" else column),
            Dimension.ANGLE if angle and name == "theta" else Dimension.LENGTH,
            draw(sizes),
            draw(sizes),
            draw(st.none() | finite),
        )
        for name in names
    }
    covariates = st.sampled_from(["time_s", "temperature_C", "approach", "speed", "Kraft", "=a"])
    counts = st.lists(st.integers(0, 10**9), min_size=rows, max_size=rows)
    poses = st.lists(labels.filter(is_label), min_size=rows, max_size=rows)
    return Run(
        cycle=np.array(draw(counts)),
        axes=axes,
        pose=draw(st.none() | poses.map(np.array)),
        covariates=draw(st.dictionaries(covariates, column, max_size=3)),
        metadata=draw(st.dictionaries(keys, texts, max_size=4)),
    )


def is_label(text):
    """A footer's name is no pose, and neither is nothing."""
    from scara_iso.tables.vocabulary.words import names_a_footer  # noqa: PLC0415

    return bool(text) and not names_a_footer(text)


@pytest.mark.parametrize(
    "metadata", [{"a": ",0"}, {"a,b": "0"}, {"a": " ,"}, {"robot,_old": "x: y"}]
)
def test_a_comma_does_not_cut_a_metadata_line(metadata):
    run = Run(np.array([1]), {"X": Axis("X", np.array([0.1]))}, metadata=metadata)
    back = read_table(write_table(run).encode()).metadata
    assert dict(back) == {key: value.strip() for key, value in metadata.items()}


def test_a_remark_on_a_statement_is_made_once_however_often_a_table_is_written():
    rows = "".join(f"{k},{0.5 + k % 7 / 1000}\n" for k in range(1, 32))
    run = read_table(f"# unit: mm\n# note: stand was loose, until noon\ncycle,X\n{rows}".encode())
    for _ in range(2):
        run = read_table(write_table(run).encode())
        assert len(run.origin.remarks) == 1
        assert "# remarked" not in write_table(run)


SAYS_AN_AXIS = Run(np.array([1]), {"X": Axis("X", np.array([0.1]))}, metadata={"a": "0X"})


@example(SAYS_AN_AXIS, find_locale(None))
@examples(100)
@given(runs(), st.sampled_from([None, "de", "en"]).map(find_locale))
def test_written_and_read_is_the_same_run(run, locale):
    # Numbers that rise through several poses count their visits: those are read as cycles.
    assume(run.pose is None or len(run) < 2 or np.any(np.diff(run.cycle) < 1))
    text = write_table(run, locale)
    back = read_table(text.encode())
    assert back.cycle.tolist() == run.cycle.tolist()
    assert list(back.axes) == list(run.axes)
    for name, axis in run.axes.items():
        got = back.axes[name]
        assert got.readings.tolist() == axis.readings.tolist()
        for key in ("dimension", "resolution", "uncertainty", "command"):
            assert getattr(got, key) == getattr(axis, key), key
    assert (back.pose is None) == (run.pose is None)
    if run.pose is not None:
        assert back.pose.tolist() == run.pose.tolist()
    assert {n: v.tolist() for n, v in back.covariates.items()} == {
        n: v.tolist() for n, v in run.covariates.items()
    }
    assert dict(back.metadata) == dict(run.metadata)
    assert write_table(back, locale) == text


@examples(60)
@given(runs())
def test_no_text_becomes_a_formula_in_a_spreadsheet(run):
    for row in csv.reader(write_table(run).split("\n")):
        for cell in row:
            assert not re.match(r"\s*[=+@-]", cell) or re.fullmatch(r"[+-]?[0-9.e+-]+", cell)


@examples(60)
@given(st.dictionaries(keys, texts, max_size=4), st.sampled_from([",", ";"]))
def test_no_metadata_become_a_formula_whatever_the_separator(metadata, separator):
    run = Run(cycle=np.array([1]), axes={"X": Axis("X", np.ones(1))}, metadata=metadata)
    for row in csv.reader(write_table(run).split("\n"), delimiter=separator):
        assert not any(re.match(r"\s*[=+@-]", cell) for cell in row)


def test_the_canonical_form_to_the_letter():
    run = Run(
        cycle=np.array([1, 2]),
        axes={
            "X": Axis("X", np.array([0.112, -0.1]), resolution=0.001),
            "Y": Axis("Y", np.array([0.8115, 0.81]), resolution=0.001),
            "theta": Axis("theta", np.array([0.5, 0.25]), Dimension.ANGLE, 0.01),
        },
        covariates={"time_s": np.array([0.0, 9.5]), "approach": np.array([1.0, -1.0])},
        metadata={"robot": "FUM SCARA", "note": "a\n# unit: inch\r\nb", "firmware": "v1,=2+3"},
    )
    assert write_table(run) == (
        "# unit: mm\n# unit_theta: deg\n# resolution: 0.001\n# resolution_theta: 0.01\n"
        '# robot: FUM SCARA\n# note: a # unit: inch b\n"# firmware: v1,=2+3"\n'
        "cycle,X,Y,theta,time_s,approach\n"
        "1,0.112,0.8115,0.50,0.0,+1\n2,-0.100,0.810,0.25,9.5,-1\n"
    )


@pytest.mark.parametrize("name", ["cycle", "n", "X_mm", "comment", "pose", "", "Theta"])
def test_a_covariate_whose_name_means_something_else_is_refused(name):
    run = Run(cycle=np.array([1]), axes={"X": Axis("X", np.ones(1))}, covariates={name: np.ones(1)})
    with pytest.raises(DataError, match="cannot hold"):
        write_table(run)


def test_the_example_is_table_one_of_the_paper():
    run = read_table(EXAMPLE)
    assert len(run) == 30
    means = {name: axis.readings.mean() * 100 for name, axis in run.axes.items()}
    # READING.md, section 2
    expected = {"X": 9.73333, "Y": 80.53333, "Z": 36.9, "theta": 47.66667}
    assert means == pytest.approx(expected, abs=5e-6)
    assert [axis.resolution for axis in run.axes.values()] == [0.01, 0.01, 0.01, 0.005]
    assert run.metadata["first_cycle_discarded"] == "true"
    assert read_table(write_table(run).encode()).axes["X"].readings.tolist() == (
        run.axes["X"].readings.tolist()
    )


def test_what_a_table_remarks_goes_on_into_the_one_that_is_made_of_it():
    rows = "".join(f"{k},0.5{k:02},{'touched' if k == 9 else ''}\n" for k in range(1, 32))
    head = "# cycle 7 not counted; outlier\n# unit: mm\n"
    run = read_table(f"{head}cycle,X,remark\n{rows}".encode())
    assert len(run.origin.remarks) == 2
    again = read_table(write_table(run).encode())
    assert again.origin.remarks == run.origin.remarks
    assert write_table(again) == write_table(run)
