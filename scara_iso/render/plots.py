"""Pictures as matplotlib figures, and as SVG or PNG files; the same input, the same bytes."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from scara_iso.base.errors import UsageError
from scara_iso.base.files import write_file
from scara_iso.diagnosis import JointScatter
from scara_iso.iso9283 import PlannedPose, PosePlan
from scara_iso.render.pictures import AREA, EDGE, INK, PLANE, SOLID, new_figure, own_style
from scara_iso.robot import Arm, Workspace
from scara_iso.run import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from scara_iso.diagnosis import ReachMap, SeparatingPlan


_LABEL, _MAKER = 20, "scara-iso"


@own_style()
def plot_plan(plan: PosePlan) -> Figure:
    """Return the workspace from above, and the solid with its diagonal plane and the poses."""
    figure = new_figure(11, 5.2, layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1, 1))
    _fill_workspace(left, plan.arm)
    left.plot(*plan.corners[[0, 1, 2, 3, 0], :2].T, color=SOLID, lw=1.5, label=plan.solid.value)
    _draw_poses(left, plan.arm, plan.poses)
    spec = right.get_subplotspec()
    right.remove()
    _draw_solid(figure.add_subplot(spec, projection="3d"), plan)
    return figure


@own_style()
def plot_separating(plan: SeparatingPlan) -> Figure:
    """Return the workspace from above, and the poses that tell the joints apart."""
    figure = new_figure(6.4, 6.4, layout="constrained")
    axes = figure.subplots()
    _fill_workspace(axes, plan.arm)
    _draw_poses(axes, plan.arm, plan.poses)
    return figure


@own_style()
def plot_reach(reach: ReachMap) -> Figure:
    """Return predicted RP over the reach, the measured poses, and the best and the worst place."""
    figure = new_figure(6.4, 5.2, layout="constrained")
    axes = figure.subplots()
    shown = axes.pcolormesh(reach.x, reach.y, reach.RP, cmap="cividis", rasterized=True)
    figure.colorbar(shown, ax=axes, label="RP in XY, 30 cycles [mm]")
    if reach.limit is not None:
        x, y, off = reach.x, reach.y, [-0.5, 0.5]
        axes.contourf(x, y, reach.kept, levels=off, colors="none", hatches=["////"])
        text = f"hatched: {reach.limit:g} mm is not kept"
        axes.plot([], [], "s", mfc="none", mec=INK, ms=8, ls="none", label=text)
    marks = (("best", reach.best, "v"), ("worst", reach.worst, "^"))
    for name, at, mark in marks:
        text = f"{name} {at.RP:.3g} mm"
        axes.plot(at.x_mm, at.y_mm, mark, mfc="white", mec=INK, ms=8, ls="none", label=text)
    for pose, place in reach.poses.items():
        axes.plot(*place, "o", color=PLANE, mec=INK, ms=5)
        axes.annotate(
            pose[:_LABEL],
            place,
            xytext=(4, 4),
            textcoords="offset points",
            fontsize=8,
            parse_math=False,
        )
    axes.set(aspect="equal", xlabel="x [mm]", ylabel="y [mm]", title="predicted repeatability")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=2, frameon=False)
    return figure


def check_picture(path: Path) -> None:
    """Raise `UsageError` for an ending that no picture has."""
    if path.suffix.lower() not in (".svg", ".png"):
        raise UsageError(
            f"{path.name}: pictures are written as SVG or PNG",
            remedy="let the name end in .svg or .png",
        )


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure as .svg or .png, without date or random names.

    Raises as `check_picture` and `write_file`.
    """
    check_picture(path)
    kind = path.suffix.lower().lstrip(".")
    drawn = BytesIO()
    made_by = {"Date": None, "Creator": _MAKER} if kind == "svg" else {"Software": _MAKER}
    with own_style({"svg.hashsalt": _MAKER}):
        figure.savefig(drawn, format=kind, dpi=150, metadata=made_by)
    write_file(path, drawn.getvalue())


def _draw_poses(axes: Axes, arm: Arm, poses: Sequence[PlannedPose]) -> None:
    axes.set_title("Workspace seen from above")
    first = poses[0]
    elbow = (
        arm.link_1_mm * np.cos(np.radians(first.joint_1_deg)),
        arm.link_1_mm * np.sin(np.radians(first.joint_1_deg)),
    )
    links = np.array([(0.0, 0.0), elbow, (first.x_mm, first.y_mm)])
    axes.plot(*links.T, "o-", color=INK, lw=3, ms=7, mfc="white", label="arm at P1")
    for place, names in _names_by_place(poses).items():
        axes.plot(*place, "o", color=PLANE, mec="black", ms=6, zorder=3)
        axes.annotate(names, place, (6, 5), textcoords="offset points", fontsize=9, zorder=4)
    axes.set(xlabel="x [mm]", ylabel="y [mm]", aspect="equal")
    axes.grid(lw=0.3)
    axes.set_axisbelow(False)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.1), ncols=3, fontsize=8, frameon=False)


def _names_by_place(poses: Sequence[PlannedPose]) -> dict[tuple[float, float], str]:
    names: dict[tuple[float, float], str] = {}
    for pose in poses:
        place = (pose.x_mm, pose.y_mm)
        names[place] = f"{names[place]}, {pose.name}" if place in names else pose.name
    return names


def _fill_workspace(axes: Axes, arm: Arm) -> None:
    workspace = Workspace.of(arm)
    reach = 1.02 * arm.reach()[1]
    grid = np.linspace(-reach, reach, 500)
    inside = workspace.contains(np.stack(np.meshgrid(grid, grid), axis=-1))
    axes.contourf(grid, grid, inside.astype(np.float64), levels=[0.5, 1.5], colors=[AREA])
    for k, line in enumerate(workspace.outline()):
        axes.plot(*line.T, color=EDGE, lw=1, label="reached by either elbow" if k == 0 else None)


def _draw_solid(axes: Any, plan: PosePlan) -> None:
    x, y, z = plan.size_mm
    axes.set_title(
        f"{plan.solid.value.capitalize()} of {x:.0f} × {y:.0f} × {z:.0f} mm, "
        f"plane {plan.plane.value}\nm = {plan.m_over_diagonal:g} L = {plan.m_mm:.1f} mm"
    )
    corners = plan.corners
    edges = [(k, (k + 1) % 4) for k in range(4)] + [(k, k + 4) for k in range(4)]
    edges += [(4 + a, 4 + b) for a, b in edges[:4]]
    for a, b in edges:
        axes.plot(*corners[[a, b]].T, color=SOLID, lw=1.2)
    number = [c - 1 for c in plan.plane.corners]
    axes.plot_trisurf(*corners[number].T, triangles=[(0, 1, 2), (0, 2, 3)], color=PLANE, alpha=0.25)
    for a, b in ((number[0], number[2]), (number[1], number[3])):
        axes.plot(*corners[[a, b]].T, color=PLANE, lw=1, ls="--")
    middle = corners.mean(axis=0)
    for k, corner in enumerate(corners, start=1):
        axes.text(
            *(corner + 0.08 * (corner - middle)),
            f"C{k}",
            color=SOLID,
            fontsize=9,
            ha="center",
            va="center",
        )
    for pose in plan.poses:
        place = (pose.x_mm, pose.y_mm, pose.z_mm)
        axes.plot(*([v] for v in place), "o", color=PLANE, mec="black", ms=6)
        axes.text(*place, f"  {pose.name}", fontsize=9)
    for name, values in zip("xyz", corners.T, strict=True):
        ticks = [values.min(), values.mean(), values.max()]
        axes.set(**{f"{name}ticks": ticks, f"{name}ticklabels": [f"{t:.0f}" for t in ticks]})
        axes.set(**{f"{name}label": f"{name} [mm]"})
    axes.tick_params(labelsize=8)
    axes.set_box_aspect((x, y, z), zoom=0.9)
    axes.view_init(elev=25, azim=_azimuth(corners[number]))


def _azimuth(plane: FloatArray) -> float:
    """Return the side in degrees from which a plane, its corners given, is seen most openly."""
    normal = np.cross(plane[1] - plane[0], plane[2] - plane[0])
    sides = np.array([-60.0, -30.0, 30.0, 60.0, 120.0, 150.0, -150.0, -120.0])
    turns = np.radians(sides)
    eyes = np.stack([np.cos(turns), np.sin(turns), np.full(8, np.tan(np.radians(25)))], axis=-1)
    return float(sides[np.argmax(np.abs(eyes @ normal).round(6))])


_ENDINGS = (".png", ".svg", ".csv")


def check_map(path: Path) -> None:
    """Raise `UsageError` for an ending that no map has."""
    if path.suffix.lower() not in _ENDINGS:
        raise UsageError(
            f"{path.name}: a map is written as a picture or a table",
            remedy=f"let the name end in {', '.join(_ENDINGS)}",
        )


def save_map(found: JointScatter, path: Path) -> None:
    """Write the map of ``found`` to ``path``, as its ending says.

    Raises as `check_map` and `write_file`.
    """
    check_map(path)
    if found.reach is None:
        return
    if path.suffix.lower() == ".csv":
        write_file(path, _rows(found.reach).encode())
    else:
        save_figure(plot_reach(found.reach), path)


def _rows(reach: ReachMap) -> str:
    """Return a line for each place that the arm reaches [mm], with a limit whether it is kept."""
    limited = reach.limit is not None
    lines = ["x_mm,y_mm,RP_mm,low_mm,high_mm" + (",kept" if limited else "")]
    kept = reach.kept
    for row, column in np.argwhere(~np.isnan(reach.RP)):
        cell = (reach.RP[row, column], reach.low[row, column], reach.high[row, column])
        place = f"{reach.x[column]:.3f},{reach.y[row]:.3f}"
        line = ",".join([place, *(f"{value:.6f}" for value in cell)])
        lines.append(f"{line},{kept[row, column]:.0f}" if limited else line)
    return "\n".join(lines) + "\n"
