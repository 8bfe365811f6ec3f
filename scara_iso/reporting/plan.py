"""The report on a planned test, and its visits as a table for a robot program."""

from __future__ import annotations

from collections.abc import Iterator

from scara_iso.iso9283 import PosePlan
from scara_iso.reporting.blocks import Block, Cell, Number, Report, Section, Table, Text
from scara_iso.tables import PLAIN, SheetLocale, write_rows


def plan_report(plan: PosePlan, robot: str = "") -> Report:
    """Return the report on a plan: size, poses, how they are visited."""
    return (
        Section("", tuple(_verdict(plan, robot))),
        Section("poses", (_poses(plan),)),
        Section("corners", (_corners(plan),)),
        Section("visits", tuple(_visits(plan))),
    )


def visits_csv(plan: PosePlan, locale: SheetLocale = PLAIN) -> str:
    """Return one cycle's visits as CSV, one row each in their order."""
    rows = plan.rows()
    cells = [[round(v, 6) if isinstance(v, float) else v for v in row.values()] for row in rows]
    return locale.bom + write_rows([list(rows[0]), *cells], locale)


def _verdict(plan: PosePlan, robot: str) -> Iterator[Block]:
    x, y, z = plan.size_mm
    yield Text(f"ISO 9283 test{f' of {robot}' if robot else ''}", "strong")
    yield Text(f"largest {plan.solid.value}: {x:.1f} x {y:.1f} x {z:.1f} mm", "strong")
    if plan.stroke_limits:
        yield Text("the stroke limits the cube; `solid=box` takes the largest area instead", "warn")
    low = plan.m_over_diagonal
    yield Text(
        f"plane {plan.plane.value}, elbow {plan.elbow.value}; m = {plan.m_mm:.1f} mm = "
        f"{low:.3g} L of the diagonal L = {plan.diagonal_mm:.1f} mm, within (0.1 ± 0.02) L"
    )
    yield Text(
        "the paper speaks of nine diagonal planes; a cube has six through opposite edges, and the "
        "standard names four of them, of which this is one",
        "quiet",
    )
    yield Text(
        "L is the diagonal of the plane (ISO 9283), which is also a diagonal of the solid (paper)",
        "quiet",
    )


def _poses(plan: PosePlan) -> Table:
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (
            pose.name,
            *(Number(v, ".1f") for v in (pose.x_mm, pose.y_mm, pose.z_mm)),
            *(Number(v, ".2f") for v in (pose.joint_1_deg, pose.joint_2_deg)),
            Number(pose.joint_3_mm, ".1f"),
            Number(pose.joint_4_deg, ".2f"),
            Number(pose.singularity_deg, ".1f"),
        )
        for pose in plan.poses
    )
    header = ("pose", "x", "y", "z", "joint 1", "joint 2", "joint 3", "joint 4", "singular")
    note = "mm and degrees in the base frame; singular: degrees of joint 2 from straight or folded"
    return Table(header, rows, note)


def _corners(plan: PosePlan) -> Table:
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (f"C{k}", *(Number(v, ".1f") for v in corner))
        for k, corner in enumerate(plan.corners.tolist(), 1)
    )
    return Table(("corner", "x", "y", "z"), rows)


def _of(rated: float | None, unit: str) -> str:
    return "" if rated is None else f" ({rated:g} {unit})"


def _visits(plan: PosePlan) -> Iterator[Block]:
    how = plan.conditions
    yield Text(
        f"{how.cycles} cycles, {how.used} used, each from P1 through {', '.join(how.order)}; "
        f"{how.velocity_percent:g} % of the rated velocity{_of(plan.rated.velocity_mm_s, 'mm/s')}, "
        f"{how.load_percent:g} % of the rated load{_of(plan.rated.load_kg, 'kg')}, "
        f"{how.dwell_s:g} s at each pose before its reading"
    )
    yield Text(
        "each pose is approached from the one before, along a line, so always from the same side"
    )
    missing = [
        name for name, value in (("velocity_mm_s", plan.rated.velocity_mm_s),
                                 ("load_kg", plan.rated.load_kg)) if value is None
    ]  # fmt: skip
    if missing:
        yield Text(f"the model states no rated {' and '.join(missing)}: add [rated]", "warn")
    yield Text(
        "measure the stabilisation time first: it fixes the dwell (6.10); -o FILE.csv writes the "
        "visits for a robot program, -o FILE.toml the test.toml of a folder",
        "quiet",
    )
