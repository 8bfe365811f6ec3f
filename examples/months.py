"""Two years of one simulated robot whose wear begins in month 9: writes the tables of months/."""

import random
from pathlib import Path

FOLDER = Path(__file__).parent / "months"
SIGMA = 0.0045  # mm, of X and of Y while nothing wears
FIRST, GROWTH = 9, 0.07  # the month from which on sigma grows by so much of itself a month
HEAD = """\
# unit: mm
# resolution: 0.001
# robot: SCARA 600
# serial_number: 4711
# date: {date}
# payload: 2 kg
# velocity: 100 %
# simulated: yes
# source: examples/months.py, not measured
cycle,X,Y
"""


def table(month: int, rng: random.Random) -> str:
    """Return the table of a month, from 1; the fixture is put up anew for each."""
    date = f"{2024 + (month - 1) // 12}-{(month - 1) % 12 + 1:02d}-05"
    sigma = SIGMA * (1 + GROWTH * max(0, month - FIRST))
    x, y = rng.gauss(0.4, 0.008), rng.gauss(0.7, 0.008)
    rows = [
        f"{cycle},{rng.gauss(x, sigma):.3f},{rng.gauss(y, sigma):.3f}" for cycle in range(1, 32)
    ]
    return HEAD.format(date=date) + "\n".join(rows) + "\n"


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    rng = random.Random(24)  # noqa: S311 - readings
    for month in range(1, 25):
        text = table(month, rng)
        date = text.split("# date: ")[1][:7]
        (FOLDER / f"{date}.csv").write_text(text, encoding="utf-8")
    events = "date,what\n2024-04-18,joint 1 greased\n"
    (FOLDER / "events.csv").write_text(events, encoding="utf-8")
