"""`Run` is read-only, checked once, and survives pandas."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, strategies as st
from hypothesis.extra.numpy import arrays

from scara_iso.base.errors import DataError, Fault
from scara_iso.base.quantities import Dimension
from scara_iso.run import Axis, Run

readings = arrays(np.float64, 5, elements=st.floats(-90, 90))


@given(x=readings, theta=readings, temperature=readings)
def test_a_frame_and_back_is_the_same_run(x, theta, temperature):
    run = Run(
        cycle=np.array([1, 2, 1, 2, 3]),
        axes={
            "theta": Axis("theta", theta, Dimension.ANGLE, 0.01),
            "X": Axis("X", x, resolution=0.001, uncertainty=0.0005, command={"P1": 1.0}),
        },
        pose=np.array(["P1", "P1", "P2", "P2", "P2"]),
        covariates={"temperature_C": temperature},
        metadata={"robot": "FUM"},
    )
    back = Run.from_frame(run.to_frame())
    assert list(back.axes) == ["X", "theta"]
    for name, axis in run.axes.items():
        assert np.array_equal(back.axes[name].readings, axis.readings)
        assert back.axes[name].dimension is axis.dimension
        assert back.axes[name].resolution == axis.resolution
        assert back.axes[name].uncertainty == axis.uncertainty
        assert back.axes[name].command == axis.command
    assert np.array_equal(back.cycle, run.cycle)
    assert np.array_equal(back.pose, run.pose)
    assert np.array_equal(back.covariates["temperature_C"], temperature)
    assert back.metadata == run.metadata


def test_a_plain_frame_takes_unit_and_resolution():
    run = Run.from_frame(pd.DataFrame({"Y": [81, 35], "speed": [1, 2]}), unit="0.01 mm",
                         resolution=1)  # fmt: skip
    assert run.axes["Y"].readings.tolist() == [0.81, 0.35]
    assert run.axes["Y"].resolution == 0.01
    assert run.cycle.tolist() == [1, 2]
    assert run.covariates["speed"].tolist() == [1, 2]


@pytest.mark.parametrize("name", ["target", "Punkt", "station", "measuring_point", "Pose"])
def test_a_frame_s_poses_go_by_the_names_that_a_table_s_go_by(name):
    """Zeroed at each pose, the three would pass for one; nothing but the name tells them apart."""
    frame = pd.DataFrame({name: [1, 2, 3] * 2, "X": [0.0, 0.1, 0.2, 0.0, 0.1, 0.2]})
    run = Run.from_frame(frame, unit="mm")
    assert run.covariates == {}
    assert run.pose.tolist() == ["1", "2", "3"] * 2
    assert run.cycle.tolist() == [1, 1, 1, 2, 2, 2]
    renamed = frame.assign(pose="P1", cycle=range(6)).rename(columns={name: "target"})
    both = Run.from_frame(renamed, unit="mm")
    assert set(both.pose) == {"P1"}


@pytest.mark.parametrize(
    ("frame", "said"),
    [
        ({"X": [1.0, 2.0], "target": ["a", "b"], "Punkt": ["a", "b"]}, "all name the pose"),
        ({"X": [1.0, np.nan]}, "row 2"),
        ({"X": ["a", "b"]}, "not numeric"),
        ({"X": [1.0, 2.0], "cycle": [1.0, 1.5]}, "not whole"),
        ({"speed": [1.0, 2.0]}, "no axis is called speed"),
        ({"X": []}, "at least one cycle"),
        ({"X": [1.0, 1e300]}, "beyond any dial"),
        ({"X": [1.0, 2.0], "P2 X": [5.0, 6.0]}, "'P2 X' name a pose each"),
        ({"X": [1.0, 2.0], "Y_Pose 2 [mm]": [5.0, 6.0]}, "name a pose each"),
        ({"P1_X": [1.0, 2.0], "P2_X_mm": [5.0, 6.0]}, "'P1_X', 'P2_X_mm' name a pose each"),
        ({"X": [1.0, 2.0], "Y [mm]": [5.0, 6.0]}, "no axis is called Y .mm."),
        ({"X": [1.0, 2.0], "Y_mm": [5.0, 6.0]}, "no axis is called Y_mm"),
    ],
)
def test_a_frame_that_is_no_run_is_refused(frame, said):
    with pytest.raises(DataError, match=said):
        Run.from_frame(pd.DataFrame(frame), unit="mm")


def test_columns_of_a_frame_that_mean_one_axis_are_refused():
    frame = pd.DataFrame([[1.0, 2.0], [1.0, 3.0]], columns=["X", "X"])
    with pytest.raises(DataError, match="several columns are called X"):
        Run.from_frame(frame, unit="mm")
    with pytest.raises(DataError) as refused:
        Run.from_frame(frame.set_axis(["X", "X_um"], axis=1), unit="mm")
    assert "drop(columns=['X_um'])" in refused.value.remedy


def test_a_plain_frame_without_a_unit_is_refused():
    with pytest.raises(DataError, match="no unit stated for X, theta"):
        Run.from_frame(pd.DataFrame({"theta": [1.0, 2.0], "X": [1.0, 2.0]}))


def test_an_error_lists_its_faults_once():
    error = DataError("2 faults", where="t.csv", faults=[Fault("2 faults"), Fault("no number", 3)])
    assert str(error) == "t.csv: 2 faults\n  line 3: no number"


def test_a_run_and_its_axes_say_what_they_are_in_a_line():
    run = Run(np.arange(300), {"X": Axis("X", np.zeros(300))})
    assert repr(run) == "<Run: X; 300 rows, 1 pose(s)>"
    assert "array" not in repr(run.axes["X"])


def test_shapes_must_agree():
    with pytest.raises(DataError, match="temperature_C"):
        Run(np.arange(3), {"X": Axis("X", np.zeros(3))}, covariates={"temperature_C": np.zeros(2)})


def test_nothing_can_be_written_into_a_run():
    source = np.zeros(3)
    run = Run(np.arange(3), {"X": Axis("X", source)})
    source[0] = 1
    assert run.axes["X"].readings[0] == 0
    with pytest.raises(ValueError, match="read-only"):
        run.axes["X"].readings[0] = 1
    with pytest.raises(TypeError):
        run.axes["Y"] = run.axes["X"]


def test_what_a_run_was_made_of_may_change_afterwards():
    metadata, axes = {"robot": "A"}, {"X": Axis("X", np.zeros(2))}
    run = Run(np.arange(2), axes, metadata=metadata)
    metadata["robot"] = "B"
    axes.clear()
    assert (dict(run.metadata), list(run.axes)) == ({"robot": "A"}, ["X"])


def test_angles_are_unwrapped_and_lengths_are_not():
    turns = np.array([359.0, 1.0, 0.5, 358.5])
    run = Run(
        np.arange(4), {"X": Axis("X", turns), "theta": Axis("theta", turns, Dimension.ANGLE)}
    ).unwrapped()
    assert run.axes["X"].readings.tolist() == turns.tolist()
    assert np.ptp(run.axes["theta"].readings) == pytest.approx(2.5)


def test_poses_come_in_order_of_first_appearance():
    run = Run(np.arange(5), {"X": Axis("X", np.zeros(5))}, pose=np.array(list("BABCA")))
    found = [(label, rows.tolist()) for label, rows in run.rows_by_pose()]
    assert found == [("B", [0, 2]), ("A", [1, 4]), ("C", [3])]


@pytest.mark.parametrize("stated", [{"resolution": -1.0}, {"resolution": 0.0},
                                    {"resolution": np.nan}, {"uncertainty": np.inf}])  # fmt: skip
def test_a_resolution_or_uncertainty_that_is_none(stated):
    with pytest.raises(DataError, match="axis X"):
        Axis("X", np.zeros(3), **stated)


def test_an_axis_goes_by_its_own_name():
    with pytest.raises(DataError, match="axis X"):
        Run(np.arange(3), {"X": Axis("Y", np.zeros(3))})


@pytest.mark.parametrize(
    ("head", "said"),
    [({}, ""), ({"simulated": ""}, ""), ({"simulated": "X Y"}, "(X Y)"),
     ({"simulated[P2]": "X", "simulated[P3]": "Y"}, "(X at P2, Y at P3)")],
)  # fmt: skip
def test_readings_of_no_dial_are_said_be_it_at_one_pose(head, said):
    run = Run(np.arange(1, 3), {"X": Axis("X", np.zeros(2))}, metadata=head)
    assert run.simulated == (said and f"SIMULATED readings {said}: no robot was measured")
