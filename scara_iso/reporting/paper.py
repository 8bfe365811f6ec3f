"""The paper's printed figures beside those that its own Table I gives."""

from __future__ import annotations

from scara_iso.iso9283 import PoseResult
from scara_iso.reporting.blocks import Cell, Number, Section, Table, Text
from scara_iso.reporting.digits import four_digits
from scara_iso.robot import (
    PRINTED_DEVIATION_MM,
    PRINTED_FREE_PLAY_MM,
    PRINTED_L_BAR_MM,
    PRINTED_RP_MM,
    PRINTED_S_MM,
    PRINTED_XY_MM,
    Backlash,
)


def paper_section(table_1: PoseResult, gear: Backlash) -> Section:
    """Return the paper's printed figures (Tables I and II, eq. 21-23) beside recomputed ones.

    ``table_1`` is the analysis of the paper's Table I, ``gear`` its first joint.
    """
    x, reflected = table_1.axes["X"], gear.reflected
    rows = [
        ("l_bar X (eq. 4)", PRINTED_L_BAR_MM["X"], x.l_bar),
        ("S X (eq. 5)", PRINTED_S_MM["X"], x.S_l),
        *(
            (f"RP {name} (eq. 6)", printed, table_1.axes[name].RP)
            for name, printed in PRINTED_RP_MM.items()
        ),
        ("RP XY (eq. 23)", PRINTED_XY_MM, table_1.XY.RP_rss if table_1.XY else None),
        ("RP XY (ISO 9283, radial)", None, table_1.XY.RP if table_1.XY else None),
        ("deviation (eq. 21)", PRINTED_DEVIATION_MM, gear.as_given.deviation_mm),
        ("free play (eq. 22)", PRINTED_FREE_PLAY_MM, gear.free_play_mm),
        (f"through 1:{gear.ratio:g}", None, reflected.deviation_mm if reflected else None),
    ]
    table = Table(
        ("in mm", "printed", "recomputed", "recomputed/printed"),
        tuple(_row(label, printed, found) for label, printed, found in rows),
    )
    said = (
        "The paper's RP do not follow from its own table; this tool prints what the readings give."
    )
    return Section("which printed figures of the paper follow from its data", (Text(said), table))


def _row(label: str, printed: float | None, found: float | None) -> tuple[Cell, ...]:
    if found is None:
        return (label, "", "", "")
    if printed is None:
        return (label, "-", four_digits(found), "")
    return (label, four_digits(printed), four_digits(found), Number(found / printed, ".2f"))
