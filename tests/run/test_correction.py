"""The correction of a dial: the certificate's curve and the cosine, against hand computation."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st

import scara_iso
from scara_iso.commands import main, new_test
from scara_iso.reporting import document
from scara_iso.run import Axis, Correction
from scara_iso.tables import write_table

SHOWN = [0.010, 0.014, 0.009, 0.012, 0.011, 0.013]


def table(*statements, readings=SHOWN, axis="X"):
    rows = [f"{k},{x:.3f}" for k, x in enumerate(readings, 1)]
    head = ["unit: mm", "resolution: 0.001", "first_cycle: counts", *statements]
    lines = [*(f"# {line}" for line in head), f"cycle,{axis}", *rows, ""]
    return "\n".join(lines).encode()


def readings(*statements, **options):
    return scara_iso.read_table(table(*statements, **options)).axes["X"].readings


def test_the_error_is_interpolated_and_taken_off():
    found = readings("correction_X: 0 0; 5 0.010; 10 -0.002", readings=[1.0, 5.0, 7.5])
    assert found == pytest.approx([0.998, 4.990, 7.496])  # 1/5 of 0.010; at the point; halfway


def test_a_display_that_was_zeroed_counts_from_the_error_at_its_zero():
    stated = ("correction_X: 0 0.001; 2 0.003; 4 0.001", "correction_zero_X: 2")
    found = readings(*stated, readings=[-1.0, 0.0, 1.0])
    assert found == pytest.approx([-0.999, 0.0, 1.001])  # both sides of the zero err by -0.001


def test_a_plunger_that_stands_at_an_angle_travels_too_far():
    found = readings("alignment_X: 10", readings=[1.0, 2.0])
    assert found == pytest.approx([math.cos(math.radians(10)), 2 * math.cos(math.radians(10))])


def test_what_the_dial_showed_is_kept_and_said(tmp_path):
    run = scara_iso.read_table(table("correction_X: -1 0; 1 0.1"))
    assert run.axes["X"].displayed == pytest.approx(SHOWN)
    assert run.axes["X"].readings != pytest.approx(SHOWN)
    analysis = scara_iso.analyze(run, cycles=6)
    (said,) = [one for one in analysis.findings if one.code == "corrected"]
    assert "2 points" in said.message
    assert "doubtful-resolution" not in {one.code for one in analysis.findings}
    page = tmp_path / "r.md"
    scara_iso.report(run, to=page, cycles=6)
    assert "X displayed" in page.read_text("utf-8")


def test_nothing_is_corrected_twice():
    run = scara_iso.read_table(table("correction_X: -1 0; 1 0.1"))
    again = scara_iso.read_table(write_table(run).encode())
    assert again.axes["X"].readings == pytest.approx(run.axes["X"].readings)
    assert again.axes["X"].displayed is None


def test_uncertainties_add_as_independent():
    stated = (
        "indicator_uncertainty: 0.003",
        "correction_uncertainty_X: 0.004",
        "correction_X: 0 0; 1 0.001",
        "alignment_X: 10",
        "alignment_uncertainty_X: 1",
    )
    axis = scara_iso.read_table(table(*stated)).axes["X"]
    u = math.radians(1)
    reach = 0.005  # of the readings
    cosine = reach * math.hypot(math.tan(math.radians(10)) * u, math.sqrt(2) * u**2)
    assert axis.uncertainty == pytest.approx(math.sqrt(0.003**2 + 0.004**2 + cosine**2))
    assert axis.certified == 0.003


@pytest.mark.parametrize(
    ("statements", "words"),
    [
        (["correction_X: 0.010 0; 1 0"], "1 readings (0.009) are not on the curve from 0.01 to 1"),
        (["correction_X: 0 0; 5 0.001", "correction_zero_X: 4.99"], "zero at 4.99"),
        (["correction_X: 0 0; 5 0.001", "dial_zero: command"], "was zeroed at the command pose"),
        (["correction_X: 0 0; 0 1"], "rising"),
        (["correction_X: 0 0"], "two points"),
        (["correction_X: 0 0; 1 0.5"], "10%"),
        (["correction_X: 0 0; 1,5 0.01"], "is not '0 0;"),
        (["correction_zero_X: 1"], "not given"),
        (["correction_uncertainty_X: -1"], "a number"),
        (["alignment_X: 60"], "angle of 60"),
        (["alignment_uncertainty_X: 1"], "not given"),
        (["correction_Y: 0 0; 1 0.001"], "not an axis"),
    ],
)
def test_what_cannot_be_applied_is_refused(statements, words):
    with pytest.raises(scara_iso.DataError) as told:
        scara_iso.read_table(table(*statements))
    assert words in str(told.value)


def test_an_angle_has_no_cosine_error():
    with pytest.raises(scara_iso.DataError, match="cosine"):
        scara_iso.read_table(
            table("alignment_theta: 2", axis="theta").replace(b"unit: mm", b"unit: deg")
        )


@given(
    st.lists(st.floats(-1e-3, 1e-3), min_size=2, max_size=8),
    st.lists(st.floats(-0.9, 0.9), min_size=1, max_size=20),
)
def test_a_reading_is_moved_by_no_more_than_the_largest_error(errors, values):
    nominal = np.linspace(-1, 1, len(errors))
    correction = Correction(tuple(zip(nominal.tolist(), errors, strict=True)))
    axis = Axis("X", np.array(values))
    moved = correction.applied(axis, reach=1.0).readings - axis.readings
    assert np.all(np.abs(moved) <= max(map(abs, errors)) + 1e-12)


def test_a_folder_corrects_what_its_instruments_state(tmp_path, capsys):
    folder = tmp_path / "a"
    new_test(folder, "examples/fum_scara.toml")
    gauge = ["X=opto-rs232@sim:?pace=0&value=0.02&seed=3"]
    plain = scara_iso.record(folder, gauge, trigger="timer:2").axes["X"].readings
    toml = folder / "test.toml"
    before = toml.read_text("utf-8")

    def state(curve):
        section = f"[instrument.X]\ncorrection = {curve}\nalignment_deg = 8\n\n[environment]"
        toml.write_text(before.replace("[environment]", section), "utf-8")

    state([[0, 0], [0.01, 0.0001]])
    assert main(["analyze", str(folder)]) == 65
    assert "nothing is extrapolated" in capsys.readouterr().err
    state([[0, 0], [1, 0.01]])
    wanted = plain * 0.99 * math.cos(math.radians(8))
    found = scara_iso.analyze(folder)  # a part that was recorded before the curve was stated
    assert found.run.axes["X"].readings == pytest.approx(wanted)
    again = scara_iso.record(folder, gauge, trigger="timer:2", part="P1-v100-l100", repeat="again")
    assert again.axes["X"].readings == pytest.approx(wanted)
    assert scara_iso.analyze(folder).run.axes["X"].readings == pytest.approx(wanted)
    scara_iso.record(folder, ["X=opto-rs232@sim:?pace=0&value=0.2&seed=4"], trigger="timer:2")
    found = scara_iso.analyze(folder)  # two poses, each corrected by its own amounts
    assert [one.pose for one in found.findings if one.code == "corrected"] == ["P1", "P2"]
    sections = document(scara_iso.report(folder).dossier).sections
    budget = str([one for one in sections if one.heading.startswith("Uncert")])
    assert "correction curve" in budget
    assert "cosine error" not in budget
    state([[0, 0]])
    assert main(["test", "status", str(folder)]) == 65
    assert "instrument.X" in capsys.readouterr().err
