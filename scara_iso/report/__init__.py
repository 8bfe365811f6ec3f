"""What is said about a result, decided once; `render` decides how it looks.

A report is sections of blocks: text, tables, strips and notices. Figures are rounded here and
nowhere else.
"""

from __future__ import annotations

from scara_iso.report.analysis import analysis_report
from scara_iso.report.backlash import backlash_report
from scara_iso.report.blocks import Block, Notice, Report, Section, Strip, Table, Text

__all__ = [
    "Block",
    "Notice",
    "Report",
    "Section",
    "Strip",
    "Table",
    "Text",
    "analysis_report",
    "backlash_report",
]
