"""Tables and every characteristic of them, for the self test: `python tests/oracles/vectors.py`.

Readings are whole divisions of a seeded `random.Random`; figures are sums in plain Python, and
quantiles scipy's. Nothing of the program is used.
"""

# ruff: noqa: S311 - the generator makes readings

import json
import math
import random
import sys
from decimal import Decimal
from itertools import combinations
from pathlib import Path
from statistics import NormalDist, mean, stdev

from scipy.optimize import curve_fit
from scipy.stats import f as fisher, t as student, ttest_ind

sys.path.append(str(Path(__file__).parents[1]))
sys.path.append(str(Path(__file__).parents[1] / "support"))
import push_rig

from oracles.scatter import above, below, jackknife, limits, rp, rss, three_sigma

FOLDER = Path(__file__).parents[2] / "scara_iso" / "commands" / "data" / "vectors"
GAUSSIAN = {1: 2.60632, 2: 3.21872, 3: 3.61609}
ERROR = {1: 0.74737, 2: 0.57371, 3: 0.49973}
READING = math.sqrt(2) * 0.001 / math.sqrt(12)
"""Standard uncertainty of a difference of two readings of a division of 0.001."""
SUMS = "plain sums (tests/oracles/vectors.py) of ISO 9283 {}"
LIMITS = SUMS + ", interval as in docs/repeatability.md"


def table(head, columns):
    """Return a canonical table; the columns are texts of equal number."""
    stated = [f"# {line}" for line in head]
    rows = [",".join(row) for row in zip(*columns.values(), strict=True)]
    return "\n".join([*stated, ",".join(columns), *rows, ""])


def divisions(rng, n, sigma, about=0):
    """Return whole divisions scattered about a number of them."""
    return [about + round(rng.gauss(0, sigma)) for _ in range(n)]


def texts(counts, places=3):
    return [f"{count / 10**places:.{places}f}" for count in counts]


def figure(
    code, of, value, interval=None, u=None, *, pose=None, unit="mm", clause="", tolerance=1e-9
):
    source = (LIMITS if interval else SUMS).format(clause)
    return {
        "code": code, "pose": pose, "of": of, "unit": unit, "value": value,
        "interval": interval and list(interval), "u": u, "tolerance": tolerance, "source": source,
    }  # fmt: skip


def with_calibration(value, ends, U):
    low, high = ends
    return max(value - math.hypot(value - low, U), 0.0), value + math.hypot(high - value, U)


def quarter(ends, calibration=0.0):
    """Return the standard uncertainty of a scatter: of sampling a quarter of its interval."""
    return math.hypot((ends[1] - ends[0]) / 4, calibration)


def of_mean(values, reading_u):
    return math.hypot(stdev(values) / math.sqrt(len(values)), reading_u)


def student_mean(values, reading_u, value):
    reach = float(student.ppf(0.975, len(values) - 1)) * stdev(values) / math.sqrt(len(values))
    reach = math.hypot(reach, 2 * reading_u)
    return value - reach, value + reach


def covariance(a, b):
    """Return the covariance of two means of readings taken together."""
    products = [(x - mean(a)) * (y - mean(b)) for x, y in zip(a, b, strict=True)]
    return sum(products) / (len(a) - 1) / len(a)


def farthest(groups, pairs, reading_u):
    """Return the largest distance of two barycentres, its interval and u.

    Each group is a list of components. Above, the farthest that any pair may be apart (Welch along
    the line between them); below, allowing for the choice of the pair (Bonferroni) and, by Box's
    two moments of a sum of squares, for scatter alone being a distance.
    """
    found = []
    for a, b in ((groups[a], groups[b]) for a, b in pairs):
        apart = [mean(y) - mean(x) for x, y in zip(a, b, strict=True)]
        value = math.hypot(*apart)
        along = [one / value for one in apart]
        errors = [[[covariance(x, y) for x in g] for y in g] for g in (a, b)]
        traces = [sum(e[k][k] for k in range(len(e))) for e in errors]
        both = [[x + y for x, y in zip(*rows, strict=True)] for rows in zip(*errors, strict=True)]
        size = range(len(both))
        error = math.sqrt(sum(along[j] * both[j][k] * along[k] for j in size for k in size))
        trace = sum(traces)
        freedom = trace**2 / sum(
            t**2 / (len(g[0]) - 1) for t, g in zip(traces, (a, b), strict=True)
        )
        directions = trace**2 / sum(one**2 for row in both for one in row)
        below = math.sqrt(trace * float(fisher.ppf(1 - 0.05 / len(pairs), directions, freedom)))
        above = error * float(student.ppf(0.975, freedom))
        low, high = (math.hypot(reach, 2 * reading_u) for reach in (below, above))
        found.append((value, value - low, value + high, math.hypot(error, reading_u)))
    value, _, _, u = max(found)
    return value, (max(0.0, *(one[1] for one in found)), max(one[2] for one in found)), u


def scatter(of, components, steps, U=0.0):
    """Return RP of components in mm with its interval."""
    q = len(components)
    ends = limits(rp, GAUSSIAN[q], ERROR[q], components, steps)
    value = rp(components)
    return figure("RP", of, value, with_calibration(value, ends, U), quarter(ends, U / 2),
                  clause="7.2.2", tolerance=2e-8)  # fmt: skip


def one_pose():
    """X, Y, Z in mm with a calibrated dial on its command pose, theta in degrees."""
    rng = random.Random(1)
    counts = {"X": divisions(rng, 31, 6, 112), "Y": divisions(rng, 31, 9, -40),
              "Z": divisions(rng, 31, 5, 360), "theta": divisions(rng, 31, 8, 20)}  # fmt: skip
    head = ["unit: mm", "unit_theta: deg", "resolution: 0.001", "indicator_uncertainty: 0.0005",
            "dial_zero: command", "command_X: 0.1", "command_Y: 0", "command_Z: 0.4"]  # fmt: skip
    columns = {"cycle": [str(k) for k in range(1, 32)], **{n: texts(c) for n, c in counts.items()}}
    used = {name: [count / 1000 for count in found[1:]] for name, found in counts.items()}
    found = [scatter(of, [used[a] for a in of], [0.001] * len(of), 0.001)
             for of in ("X", "Y", "Z", "XY", "XYZ")]  # fmt: skip
    value, root = rss([used["X"], used["Y"]]), math.sqrt(2)
    ends = limits(rss, root * GAUSSIAN[1], ERROR[1] / root, [used["X"], used["Y"]], [0.001] * 2)
    found.append(figure("RP_rss", "XY", value, with_calibration(value, ends, 0.001),
                        quarter(ends, 0.0005), clause="the paper's eq. 23",
                        tolerance=2e-8))  # fmt: skip
    value = three_sigma([used["theta"]])
    ends = limits(three_sigma, 3.0, math.sqrt(0.5), [used["theta"]], [0.001])
    found.append(figure("RP_a", "theta", value, ends, quarter(ends), unit="deg", clause="7.2.2",
                        tolerance=2e-8))  # fmt: skip
    reading_u = math.hypot(0.001 / math.sqrt(12), 0.0005)
    command = {"X": 0.1, "Y": 0.0, "Z": 0.4}
    off = {name: mean(used[name]) - at for name, at in command.items()}
    reaches = []
    for name, value in off.items():
        ends = student_mean(used[name], reading_u, value)
        reaches.append(ends[1] - value)
        found.append(figure("AP", name, value, ends, of_mean(used[name], reading_u),
                            clause="7.2.1", tolerance=1e-6))  # fmt: skip
    value, reach = math.hypot(*off.values()), math.hypot(*reaches)
    u = max(of_mean(used[name], reading_u) for name in off)
    found.append(figure("AP", "XYZ", value, (value - reach, value + reach), u, clause="7.2.1",
                        tolerance=1e-6))  # fmt: skip
    return {"one_pose.csv": table(head, columns)}, None, found


def five_readings():
    """As few as have an interval: RP, and AP with Student's quantile of four degrees of freedom."""
    counts = [12, 3, -4, 9, 1]
    used = [count / 1000 for count in counts]
    columns = {"cycle": [str(k) for k in range(1, 7)], "X": texts([40, *counts])}
    reading_u = 0.001 / math.sqrt(12)
    ends = student_mean(used, reading_u, mean(used))
    found = [scatter("X", [used], [0.001]),
             figure("AP", "X", mean(used), ends, of_mean(used, reading_u), clause="7.2.1",
                    tolerance=4e-6)]  # fmt: skip
    head = ["unit: mm", "resolution: 0.001", "dial_zero: command", "command_X: 0"]
    return {"five_readings.csv": table(head, columns)}, 6, found


def two_poses_in_inches():
    """P1 and P2 in each cycle on one scale, in inches: RD and AD."""
    rng = random.Random(2)
    at = {"P1": {"X": 0, "Y": 0}, "P2": {"X": 15748, "Y": 7874}}
    counts = {n: [rng.gauss(0, 4) + at[p][n] for _ in range(31) for p in at] for n in "XY"}
    counts = {n: [round(count) for count in found] for n, found in counts.items()}
    head = ["unit: inch", "resolution: 0.0001", "dial_zero: command",
            *(f"command_{n}[{p}]: {at[p][n] / 1e4:.4f}" for p in at for n in "XY")]  # fmt: skip
    columns = {"pose": ["P1", "P2"] * 31, "cycle": [str(k) for k in range(1, 32) for _ in at],
               **{n: texts(c, 4) for n, c in counts.items()}}  # fmt: skip

    def mm(count):
        return float(Decimal(count) * Decimal("0.0001") * Decimal("25.4"))

    apart = {n: [mm(b - a) for a, b in zip(c[2::2], c[3::2], strict=True)]
             for n, c in counts.items()}  # fmt: skip
    commanded = {n: mm(at["P2"][n]) for n in "XY"}
    step, found = 0.00254, []
    D = {"X": apart["X"], "Y": apart["Y"],
         "XY": [math.hypot(x, y) for x, y in zip(apart["X"], apart["Y"], strict=True)]}  # fmt: skip
    D_c = {**commanded, "XY": math.hypot(*commanded.values())}
    reading_u = math.sqrt(2) * step / math.sqrt(12)
    for of, distances in D.items():
        ends = limits(three_sigma, 3.0, math.sqrt(0.5), [distances], [math.sqrt(2) * step])
        found.append(figure("RD", of, three_sigma([distances]), ends, quarter(ends), pose="P1-P2",
                            clause="7.3", tolerance=2e-8))  # fmt: skip
        value = mean(distances) - D_c[of]
        ends = student_mean(distances, reading_u, value)
        found.append(figure("AD", of, value, ends, of_mean(distances, reading_u), pose="P1-P2",
                            clause="7.3", tolerance=1e-6))  # fmt: skip
    return {"two_poses.csv": table(head, columns)}, None, found


def three_directions():
    """One pose approached along +x, +y and +z: vAP."""
    rng = random.Random(3)
    ways = {"+x": (0, 0), "+y": (30, -5), "+z": (8, 22)}
    rows = [[w, k, round(rng.gauss(x, 5)), round(rng.gauss(y, 5))]
            for k in range(1, 32) for w, (x, y) in ways.items()]  # fmt: skip
    columns = {"approach": [r[0] for r in rows], "cycle": [str(r[1]) for r in rows],
               "X": texts(r[2] for r in rows), "Y": texts(r[3] for r in rows)}  # fmt: skip
    used = {w: [(r[2] / 1000, r[3] / 1000) for r in rows if r[0] == w and r[1] > 1] for w in ways}
    both = [[list(one) for one in zip(*found, strict=True)] for found in used.values()]
    groups = {"X": [[b[0]] for b in both], "Y": [[b[1]] for b in both], "XY": both}
    pairs = list(combinations(range(3), 2))
    found = [figure("vAP", of, *farthest(group, pairs, READING), clause="7.2.3")
             for of, group in groups.items()]  # fmt: skip
    head = ["unit: mm", "resolution: 0.001"]
    return {"three_directions.csv": table(head, columns)}, None, found


def two_directions():
    """One pose approached from two sides along one axis: vAP with Welch's interval."""
    rng, sides = random.Random(8), {"+x": (0, 5), "+y": (30, 9)}
    rows = [(side, k, round(rng.gauss(*law))) for k in range(1, 32) for side, law in sides.items()]
    columns = {"approach": [r[0] for r in rows], "cycle": [str(r[1]) for r in rows],
               "X": texts(r[2] for r in rows)}  # fmt: skip
    one, other = ([r[2] / 1000 for r in rows if r[0] == side and r[1] > 1] for side in sides)
    value = abs(mean(other) - mean(one))
    ends = ttest_ind(other, one, equal_var=False).confidence_interval()
    reach = math.hypot((ends.high - ends.low) / 2, 2 * math.sqrt(2) * 0.001 / math.sqrt(12))
    found = [figure("vAP", "X", value, (value - reach, value + reach), clause="7.2.3",
                    tolerance=2e-8)]  # fmt: skip
    return {"two_directions.csv": table(["unit: mm", "resolution: 0.001"], columns)}, None, found


def drift():
    """Sixteen blocks of ten visits over five hours that warm up: dAP, dRP, steady_after."""
    rng, tau, blocks = random.Random(4), 0.8, range(16)
    rows = [[b, v, 1200 * b + 12 * v] for b in blocks for v in range(1, 11)]
    moved = [1 - math.exp(-r[2] / 3600 / tau) for r in rows]
    x = [round(rng.gauss(60 * m, 4)) for m in moved]
    y = [round(rng.gauss(-25 * m, 4)) for m in moved]
    columns = {"block": [str(r[0]) for r in rows], "cycle": [str(r[1]) for r in rows],
               "time_s": [str(r[2]) for r in rows], "X": texts(x), "Y": texts(y)}  # fmt: skip
    of = {n: [[c / 1000 for c in counts[10 * b : 10 * b + 10]] for b in blocks]
          for n, counts in (("X", x), ("Y", y))}  # fmt: skip
    groups = {"X": [[b] for b in of["X"]], "Y": [[b] for b in of["Y"]],
              "XY": [list(b) for b in zip(of["X"], of["Y"], strict=True)]}  # fmt: skip
    found = []
    for name, group in groups.items():
        later = [(0, b) for b in blocks if b]
        found.append(figure("dAP", name, *farthest(group, later, READING), clause="7.6"))
        found.append(figure("dRP", name, *_changed(group, 0.001), clause="7.6", tolerance=2e-8))
    found.append(figure("steady_after", "XY", _steady(of), unit="h", clause="7.6", tolerance=0.01))
    return {"drift.csv": table(["unit: mm", "resolution: 0.001"], columns)}, None, found


def drift_of_scatter():
    """Six blocks of ten visits, the scatter of the last six times as wide: dRP clear of 0."""
    rng, found = random.Random(12), []
    x = [count for b in range(6) for count in divisions(rng, 10, 24 if b == 5 else 4)]
    columns = {"block": [str(k // 10) for k in range(60)],
               "cycle": [str(k % 10 + 1) for k in range(60)],
               "time_s": [str(1200 * (k // 10) + 12 * (k % 10)) for k in range(60)],
               "X": texts(x)}  # fmt: skip
    blocks = [[[count / 1000 for count in x[10 * b : 10 * b + 10]]] for b in range(6)]
    found.append(figure("dRP", "X", *_changed(blocks, 0.001), clause="7.6", tolerance=2e-8))
    head = ["unit: mm", "resolution: 0.001"]
    return {"drift_of_scatter.csv": table(head, columns)}, None, found


def _changed(blocks, step):
    """Return the largest change of RP since the first block, its interval and u.

    Differences by Zou and Donner, of intervals whose error is that of all blocks together.
    """
    q, n = len(blocks[0]), len(blocks[0][0])
    found = [rp(block) for block in blocks]
    together = math.sqrt(mean(jackknife(rp, block)[0] ** 2 * (n - 1) for block in blocks))
    error = max(together, ERROR[q]) / math.sqrt(n - 1)

    def reaches(share):
        z = NormalDist().inv_cdf((1 + share) / 2)
        down = [value * (1 - below(error, z)) for value in found]
        up = [value * (above(error, z) - 1) for value in found]
        for k, value in enumerate(found[1:], 1):
            fell, rose = math.hypot(down[k], up[0]), math.hypot(up[k], down[0])
            least, most = (fell, rose) if value >= found[0] else (rose, fell)
            yield abs(value - found[0]), math.hypot(least, step), math.hypot(most, step)

    alone, chosen = list(reaches(0.95)), list(reaches(1 - 0.05 / (len(blocks) - 1)))
    value, least, most = max(alone)
    low = max(0.0, *(change - reach for change, reach, _ in chosen))
    return value, (low, max(change + reach for change, _, reach in alone)), (least + most) / 4


def _steady(of):
    """Return the hours after which a tenth is left, by least squares of both axes together."""
    hours = [(1200 * b + 12 * 5.5 - 12) / 3600 for b in range(16)]
    means = [mean(block) for block in of["X"]] + [mean(block) for block in of["Y"]]

    def course(t, c, a, d, e, tau):
        decay = [math.exp(-h / tau) for h in t[:16]]
        return [c + a * one for one in decay] + [d + e * one for one in decay]

    (_, _, _, _, tau), _ = curve_fit(course, hours * 2, means, (0.06, -0.06, -0.02, 0.02, 1.0))
    return math.log(10) * float(tau)


def arrivals():
    """Three arrivals that count, each with its stabilisation time and overshoot."""
    times, beyond = ["0.150", "0.120", "0.180", "0.144"], ["0.0210", "0.0150", "0.0330", "0.0240"]
    columns = {"cycle": ["1", "2", "3", "4"], "X": ["0.010", "0.012", "0.009", "0.013"],
               "stabilisation_X_s": times, "overshoot_X_mm": beyond}  # fmt: skip
    head = ["unit: mm", "resolution: 0.001", "stream_rate_hz: 500"]
    found = []
    for code, clause, values, u, unit in (
        ("stabilisation_time", "7.4", times, math.sqrt(2 / 12) / 500, "s"),
        ("overshoot", "7.5", beyond, 0.001 / math.sqrt(12), "mm"),
    ):
        used = [float(value) for value in values[1:]]
        low, high = student_mean(used, u, mean(used))
        ends = max(low, 0.0), high
        found.append(figure(code, "X", mean(used), ends, of_mean(used, u), unit=unit,
                            clause=clause, tolerance=1e-9))  # fmt: skip
    return {"arrivals.csv": table(head, columns)}, 4, found


def force():
    """A spring of 500 N/mm behind no play and no friction, in three loops: 0.2 mm/100 N."""
    up = list(range(-100, 101, 20))
    steps = [0, 20, 40, 60, 80, *(up[::-1] + up[1:-1]) * 3, 100]
    columns = {
        "cycle": [str(k) for k in range(1, len(steps) + 1)],
        "X": [f"{0.5 + F / 500:.3f}" for F in steps],
        "force_N": list(map(str, steps)),
    }
    found = [figure("compliance", "X", 0.2, unit="mm/100 N", clause="10", tolerance=1e-4)]
    head = ["unit: mm", "resolution: 0.001", "covariates: force_N"]
    return {"force.csv": table(head, columns)}, len(steps), found


def robots():
    """Three robots that run one program: exchangeability."""
    rng = random.Random(5)
    places, tables, readings = ((0, 0), (10, 4), (40, -12)), {}, {"X": [], "Y": []}
    for serial, (x, y) in zip("ABC", places, strict=True):
        X, Y = divisions(rng, 31, 5, x), divisions(rng, 31, 5, y)
        head = ["unit: mm", "resolution: 0.001", f"serial_number: {serial}", "dial_zero: fixture"]
        columns = {"cycle": [str(k) for k in range(1, 32)], "X": texts(X), "Y": texts(Y)}
        tables[f"robot_{serial}.csv"] = table(head, columns)
        readings["X"].append([count / 1000 for count in X[1:]])
        readings["Y"].append([count / 1000 for count in Y[1:]])
    pairs = list(combinations(range(3), 2))
    groups = {"X": [[one] for one in readings["X"]], "Y": [[one] for one in readings["Y"]],
              "XY": [list(both) for both in zip(*readings.values(), strict=True)]}  # fmt: skip
    found = [figure("exchangeability", of, *farthest(own, pairs, READING), clause="7.7")
             for of, own in groups.items()]  # fmt: skip
    return tables, None, found


def coarse_dial():
    """Dials of 0.01 on two divisions: RP anywhere from 0 to what stays hidden in them."""
    rng = random.Random(6)
    counts = {n: [rng.choice((50, 51)) for _ in range(31)] for n in ("X", "Y", "Z", "theta")}
    columns = {
        "cycle": [str(k) for k in range(1, 32)],
        **{n: texts(c, 2) for n, c in counts.items()},
    }
    used = {n: [count / 100 for count in c[1:]] for n, c in counts.items()}
    found = [_hidden("RP", of, rp, GAUSSIAN[len(of)], ERROR[len(of)], [used[a] for a in of])
             for of in ("X", "XY", "XYZ")]  # fmt: skip
    found.append(_hidden("RP_a", "theta", three_sigma, 3.0, math.sqrt(0.5), [used["theta"]]))
    head = ["unit: mm", "unit_theta: deg", "resolution: 0.01"]
    return {"coarse_dial.csv": table(head, columns)}, None, found


def _hidden(code, of, measure, gaussian, error, components):
    inside = NormalDist().inv_cdf((1 + 0.05 ** (1 / 30)) / 2)
    value = measure(components)
    high = max(value * above(error / math.sqrt(29)), gaussian * 0.02 / 2 / inside)
    unit = "deg" if of == "theta" else "mm"
    return figure(code, of, value, (0.0, high), high / 4, unit=unit, clause="7.2.2", tolerance=2e-8)


def past_a_full_turn():
    """Theta about 0 and 360 degrees: the scatter of hundredths, not of a turn."""
    rng = random.Random(7)
    counts = divisions(rng, 31, 8)
    columns = {"cycle": [str(k) for k in range(1, 32)],
               "theta": texts(count % 360_000 for count in counts)}  # fmt: skip
    used = [[count / 1000 for count in counts[1:]]]
    ends = limits(three_sigma, 3.0, math.sqrt(0.5), used, [0.001])
    found = [figure("RP_a", "theta", three_sigma(used), ends, quarter(ends), unit="deg",
                    clause="7.2.2", tolerance=2e-8)]  # fmt: skip
    return {"past_a_full_turn.csv": table(["unit: deg", "resolution: 0.001"], columns)}, None, found


def push():
    """A joint of 500 N/mm with 0.04 mm of play and 6 N of friction, pushed at 0.25 m."""
    stiffness, half_play, friction, arm = 500.0, 0.02, 6.0, 250.0
    force, reading = push_rig.readings(
        None, stiffness=stiffness, half_play=half_play, friction=friction
    )
    columns = {"force_N": [f"{F:g}" for F in force], "reading": [f"{x:.6f}" for x in reading]}
    arcmin = 60 * math.degrees(1 / arm)
    play, width = 2 * half_play, 2 * friction / stiffness
    figures = {
        ("lost_motion", "reading", "mm"): play,
        ("friction_width", "reading", "mm"): width,
        ("hysteresis", "reading", "mm"): play + width,
        ("compliance", "reading", "mm/100 N"): 100 / stiffness,
        ("friction_force", "reading", "N"): friction,
        ("lost_motion", "joint", "arcmin"): play * arcmin,
        ("hysteresis", "joint", "arcmin"): (play + width) * arcmin,
        ("friction_torque", "joint", "N m"): friction * arm / 1000,
        ("stiffness", "joint", "N m/arcmin"): stiffness * arm / 1000 / arcmin,
    }
    clause = "10 and service manuals"
    found = [
        figure(code, of, value, unit=unit, clause=clause, tolerance=2e-5 * value)
        for (code, of, unit), value in figures.items()
    ]
    return {"push.csv": table(["unit: mm"], columns)}, None, found


def push_with_scatter():
    """A joint that scatters on a dial of 0.001, fitted through the joint's own rest positions.

    The intervals are those of a general least-squares fit of that model, by finite differences.
    """
    rng, n = random.Random(11), len(push_rig.forces())
    law = {"stiffness": 420.0, "half_play": 0.031, "friction": 9.0}
    force, exact = push_rig.readings(None, **law)
    reading = [round(x + rng.gauss(0, 0.0003), 3) for x in exact.tolist()]
    columns = {"force_N": [f"{F:g}" for F in force], "reading": [f"{x:.3f}" for x in reading]}
    first = int(force.argmax())
    ends = [k for k in range(first, n) if abs(force[k]) == 100]
    loop = [min((k - first) // 40, 2) for k in range(first, n)]

    def rests(_, compliance, half_play, friction, *zeros):
        x = push_rig.positions(
            tuple(force.tolist()), stiffness=1 / compliance, half_play=half_play, friction=friction
        )
        return [at + zeros[k] for at, k in zip(x[first:].tolist(), loop, strict=True)]

    guess = (1 / 400, 0.03, 8.0, 0.3, 0.3, 0.3)
    fit, errors = curve_fit(rests, force[first:], reading[first:], guess, xtol=1e-12, ftol=1e-12)
    left = [a - b for a, b in zip(rests(None, *fit), reading[first:], strict=True)]
    freedom = n - first - len(fit)
    residual = math.sqrt(sum(one**2 for one in left) / freedom)
    c, b, friction = map(float, fit[:3])
    high, low = ([reading[k] for k in ends if (force[k] > 0) == up] for up in (True, False))
    sampling = {
        "lost_motion": (2 * b, _along(errors, (0, 2, 0)), "mm"),
        "friction_width": (2 * c * friction, _along(errors, (2 * friction, 0, 2 * c)), "mm"),
        "hysteresis": (
            2 * (b + c * friction), _along(errors, (2 * friction, 2, 2 * c)), "mm"
        ),
        "deflection": (mean(high) - mean(low), residual * math.sqrt(2 / 3), "mm"),
        "compliance": (100 * c, 100 * _along(errors, (1, 0, 0)), "mm/100 N"),
        "friction_force": (friction, _along(errors, (0, 0, 1)), "N"),
    }  # fmt: skip
    rounding = {"compliance": READING / 200 * 100, "friction_force": READING / (2 * c)}
    found = []
    for code, (value, error, unit) in sampling.items():
        added = rounding.get(code, READING)
        reach = math.hypot(float(student.ppf(0.975, freedom)) * error, 2 * added)
        found.append(figure(code, "reading", value, (value - reach, value + reach),
                            math.hypot(error, added), unit=unit, clause="10 and service manuals",
                            tolerance=2e-6 * abs(value)))  # fmt: skip
    by_reading = {one["code"]: one for one in found}["compliance"]
    C, u, (low, high) = (by_reading[name] for name in ("value", "u", "interval"))
    whole = 100 * 0.25 / (60 * math.degrees(1 / 250))
    found.append(figure("stiffness", "joint", whole / C, (whole / high, whole / low),
                        whole * u / C**2, unit="N m/arcmin", clause="10 and service manuals",
                        tolerance=2e-6 * whole / C))  # fmt: skip
    head = ["unit: mm", "resolution: 0.001"]
    return {"push_with_scatter.csv": table(head, columns)}, None, found


def _along(covariance, slope):
    size = range(len(slope))
    return math.sqrt(sum(slope[j] * covariance[j][k] * slope[k] for j in size for k in size))


VECTORS = (one_pose, five_readings, two_poses_in_inches, three_directions, two_directions, drift,
           drift_of_scatter, arrivals, force,
           robots, coarse_dial, past_a_full_turn, push, push_with_scatter)  # fmt: skip


def made():
    """Return the bytes of every file by its name."""
    described, files = [], {}
    for vector in VECTORS:
        tables, cycles, figures = vector()
        files |= {name: text.encode() for name, text in tables.items()}
        name = vector.__name__.replace("_", " ")
        described.append(
            {"name": name, "tables": list(tables), "cycles": cycles, "figures": figures}
        )
    return {**files, "vectors.json": (json.dumps(described, indent=1) + "\n").encode()}


if __name__ == "__main__":
    for name, data in made().items():
        (FOLDER / name).write_bytes(data)
