"""The commands by what they are for, each with the first sentence of its own help.

So that the list is shown without importing them.
"""

from __future__ import annotations

GROUPS = {
    "Measure": {
        "test": "The whole test as a folder: make one, and see how far it is.",
        "plan": "Plan the test: largest cube in the workspace, diagonal plane, P1 to P5 with joint "
        "angles.",
        "ports": "List serial ports, the dialects of indicators, or what comes out of one port.",
        "record": "Record indicators into a table for analyze; every stored reading is safe on the "
        "disk.",
        "visits": "Turn a stream of 50 to 500 samples a second into one reading for each visit.",
        "gauge-study": "Say whether a dial is good enough: type 1 (Cg, Cgk), R&R, linearity, "
        "stability.",
    },
    "Understand": {
        "tables": "Show what is understood of a table, field by field, or why it is refused and "
        "what to do.",
        "analyze": "Repeatability of each pose, axis and plane, with intervals and findings.",
        "diagnose": "Say what besides scatter is in the readings: its effect, its cause, how much "
        "it explains.",
        "compare": "Compare runs with the first: means and RP, with intervals, a test, and its "
        "power.",
        "fleet": "Diagnose the tables of many robots; say which stand out though all were looked "
        "at.",
        "push": "Take lost motion, friction and stiffness of a joint from a force loop and a dial.",
        "backlash": "Deviation of the load through a gear's backlash, by the paper's model.",
    },
    "Report": {
        "report": "Write the test report: result, pictures, every intermediate value, diagnosis, "
        "raw data.",
    },
    "Learn": {
        "demo": "Walk through the paper's Table I: analysis, backlash, what of the print follows "
        "from it.",
        "explain": "Say what a finding, a characteristic or an effect means, and what to do.",
        "simulate": "Write readings of a model with scatter, effects and rounding, as a table.",
    },
    "Watch and validate": {
        "history": "Follow one robot over months: control charts, trend, when it meets a limit, "
        "services.",
        "selftest": "Compare this installation with references: exit 0, or 1 naming what differs.",
    },
}
COMMANDS = {
    name: f"scara_iso.cli.{name.replace('-', '_')}" for names in GROUPS.values() for name in names
}
