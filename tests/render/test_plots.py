"""Pictures: written, the same bytes each time, and refused where they cannot be."""

import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from scara_iso import diagnose, gauge_study
from scara_iso.base.errors import CannotCreateError, UsageError
from scara_iso.iso9283.poses import DiagonalPlane, make_plan
from scara_iso.render.plots import _names_by_place, plot_plan, save_figure
from scara_iso.reporting.pictures import diagnosis_pictures
from scara_iso.robot.arm import Arm, Workspace

EXAMPLES = Path(__file__).parents[2] / "examples"
ARM = Arm(400, 300, (-130, 130), (-145, 145), (0, 200))
PLAN = make_plan(ARM)


@pytest.mark.parametrize("ending", ["svg", "png"])
def test_the_same_plan_gives_the_same_bytes(tmp_path, ending):
    first, second = tmp_path / f"a.{ending}", tmp_path / f"b.{ending}"
    save_figure(plot_plan(PLAN), first)
    save_figure(plot_plan(PLAN), second)
    assert first.read_bytes() == second.read_bytes()
    assert b"date" not in first.read_bytes().lower()


def test_another_plan_gives_another_picture_that_is_well_formed(tmp_path):
    first, second = tmp_path / "a.svg", tmp_path / "b.svg"
    save_figure(plot_plan(PLAN), first)
    save_figure(plot_plan(make_plan(ARM, m_over_diagonal=0.12)), second)
    assert first.read_bytes() != second.read_bytes()
    assert ET.parse(first).getroot().tag.endswith("svg")  # noqa: S314 - our own picture


def test_poses_that_coincide_from_above_have_their_names_at_one_place():
    names = ", ".join(_names_by_place(PLAN.poses).values()).split(", ")
    assert sorted(names) == sorted(pose.name for pose in PLAN.poses)
    once, twice = PLAN.poses[:2], [PLAN.poses[0], replace(PLAN.poses[0], name="P9")]
    assert [*_names_by_place(once).values()] == [pose.name for pose in once]
    assert [*_names_by_place(twice).values()] == [f"{PLAN.poses[0].name}, P9"]


def test_what_is_shaded_is_what_the_arm_reaches():
    shaded = plot_plan(PLAN).axes[0].collections[0].get_paths()
    places = np.array([(500.0, 0), (0, 500), (20, 0), (-600, 0), (700, 100), (0, -690)])
    reached = Workspace.of(ARM).contains(places)
    assert 0 < reached.sum() < len(places)
    for place, inside in zip(places, reached, strict=True):
        assert any(path.contains_point(place) for path in shaded) == inside


def solid_of(plan):
    return plot_plan(plan).axes[1]


def test_the_cube_is_drawn_by_its_twelve_edges():
    lines = [line for line in solid_of(PLAN).lines if line.get_linestyle() == "-"]
    edges = [np.array(line.get_data_3d()).T for line in lines if line.get_marker() == "None"]
    assert len({tuple(sorted(map(tuple, edge.round(6)))) for edge in edges}) == 12
    for begin, end in edges:
        along = np.abs(end - begin) > 1e-9
        assert along.sum() == 1
        assert np.abs(end - begin)[along] == pytest.approx(np.array(PLAN.size_mm)[along])


@pytest.mark.parametrize("plane", DiagonalPlane)
def test_the_plane_is_seen_from_the_side_that_shows_most_of_it(plane):
    plan = make_plan(ARM, plane=plane)
    corners = plan.corners[[c - 1 for c in plane.corners]]
    shown = {azim: area_seen(corners, azim) for azim in range(-150, 180, 30) if azim % 90}
    assert shown[solid_of(plan).azim] == pytest.approx(max(shown.values()))


def area_seen(corners, azim, elev=25):
    a, e = np.radians([azim, elev])
    across = corners @ [-np.sin(a), np.cos(a), 0]
    up = corners @ [-np.cos(a) * np.sin(e), -np.sin(a) * np.sin(e), np.cos(e)]
    return abs(across @ np.roll(up, -1) - up @ np.roll(across, -1)) / 2


def test_every_panel_of_a_gauge_study_names_its_axes():
    study = gauge_study(EXAMPLES / "dial_crossed.csv")
    figure = study.plot()
    assert all(axes.get_xlabel() and axes.get_ylabel() for axes in figure.axes)


def test_a_diagnosis_is_drawn_axis_by_axis_the_learned_course_with_its_band():
    found = diagnose(EXAMPLES / "unexplained.csv")
    pictures = list(diagnosis_pictures(found))
    assert [one.title for one in pictures] == list(found.series.measured)
    for one in pictures:
        readings, left = one.panels
        assert [curve.look for curve in readings.curves] == ["band", "points", "dashed", "line"]
        low, high = readings.curves[0].ends
        assert np.all((low < readings.curves[-1].y) & (readings.curves[-1].y < high))
        after = found.series.measured[one.title] - found.series.predicted_after[one.title]
        assert left.curves[-1].y == pytest.approx(after)


def test_a_picture_that_cannot_be_written_says_why(tmp_path):
    with pytest.raises(UsageError, match="SVG or PNG"):
        save_figure(plot_plan(PLAN), tmp_path / "plan.jpg")
    with pytest.raises(CannotCreateError, match="cannot be written: No such"):
        save_figure(plot_plan(PLAN), tmp_path / "nowhere" / "plan.svg")
