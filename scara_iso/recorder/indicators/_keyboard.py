"""What is typed, or comes as key presses: a number with its point or comma, alone on its line.

No plug-in of this folder, since no instrument sends it on a serial line: it may have any number of
digits, so a lost one leaves no trace but the number of decimals.
"""

from scara_iso.recorder.indicators._grammar import line_dialect

KEYBOARD = line_dialect(
    key="keyboard",
    instruments="a person at the keyboard, or an indicator whose cable types its readings",
    line="9600 8N1",
    reading=rb" *(?P<sign>[+-]?)(?P<digits>[0-9]{1,5}[.,][0-9]{1,6}) *",
    form="{number}",
    fill=" ",
    units={None: ""},
    longest_frame=32,
    digits=6,
    decimals=(3, 1, 2, 4, 5),
    source="none: the grammar is this program's",
    confidence="low",
    unverified=("the digits: a line typed has no parity and no checksum",),
)
