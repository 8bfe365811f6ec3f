"""How well `diagnose` finds, names and predicts: the tables of benchmarks/results/diagnosis.md.

    python benchmarks/diagnosis.py [--runs 300] [--seed 1] [--processes 2]
        [--only null families power naming calibrated rivals outside held gains speed]

Every table prints its seed. One core each for the worker processes.
"""

from __future__ import annotations

import argparse
import os
import time
import warnings
from collections import Counter
from multiprocessing import Pool

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from diagnosis_data import (
    CYCLE,
    HIGH,
    MIDDLE,
    NAME,
    OUTSIDE,
    OUTSIDE_NAMES,
    POWER,
    SIGMAS,
    TOGETHER,
    N,
    course,
    dial,
    noise as distributed,
    readings,
    scatter,
    shape,
    together,
)  # fmt: skip
from diagnosis_rivals import RIVALS

from scara_iso.diagnosis import LEVEL, UNKNOWN, Verdict
from scara_iso.diagnosis.engine.fit import fit, problem_of
from scara_iso.diagnosis.engine.search import ORDER_SHARE, chosen, find
from scara_iso.diagnosis.held_out import cross_validated
from scara_iso.diagnosis.readings import FLAG_LEVEL, diagnose_readings as diagnose
from scara_iso.effects import Chain, Process, Shape, find_effects
from scara_iso.run import AXES, Axis, Run

SEED = 1
SURE, NEAR = 0.9, 4.0
"""A name is sure from here; squares of scatter within which another course counts as true."""
warnings.filterwarnings("ignore")  # rivals complain about ties and constant input


def run_of(columns, sigma, covariates=None):
    """Return the run that a table of these readings (n, axes) gives."""
    resolution = None if sigma is None else 1.0
    axes = {
        name: Axis(name, columns[:, a], resolution=resolution)
        for a, name in zip(range(columns.shape[1]), AXES, strict=False)
    }
    return Run(CYCLE, axes, covariates=covariates or {})


def searched(run, rng, directions=None):
    """Return problem, terms and stages; None where no axis moves."""
    if all(np.ptp(axis.readings) == 0 for axis in run.axes.values()):
        return None
    problem = problem_of(run, directions=directions or {}, effects=find_effects())
    terms, stages = find(problem, rng)
    return problem, terms, stages


def problem_in(run):
    """Return the problem that a constant pose leaves; None where no axis moves."""
    if all(np.ptp(axis.readings) == 0 for axis in run.axes.values()):
        return None
    return problem_of(run, directions={}, effects=find_effects())


def detected(task):
    """Return whether the tests find structure in one run, without choosing its name."""
    rng, run = generated(task)
    problem = problem_in(run)
    if problem is None:
        return {"found": False, "flag": False}
    stage, _ = chosen(problem, (), rng, 0.0)
    flag = stage.marginal.gaussian_outlier <= FLAG_LEVEL
    return {"found": stage.p_value <= LEVEL, "flag": flag}


def named(task):
    """Return the summary of the first name given to one run."""
    rng, run = generated(task)
    problem = problem_in(run)
    return summary(problem and (problem, (), (chosen(problem, (), rng)[0],)))


def summary(found):
    """Return what the tables need of one search."""
    if found is None:
        return {"found": False, "flag": False, "best": None}
    _, terms, stages = found
    first = stages[0]
    flag = first.marginal.gaussian_outlier <= FLAG_LEVEL
    ended = stages[-1].choice is None or (terms and isinstance(terms[-1].form, Process))
    choice = first.choice
    return {
        "found": choice is not None,
        "flag": flag,
        "best": choice.best if choice else "outlier" if flag else None,
        "p": choice.probability[choice.best] if choice else None,
        "rivals": [choice.best, *(r.effect for r in choice.rivals)] if choice else ["outlier"],
        "unexplained": choice is not None and not ended,
    }


def generated(task):
    """Return the generator and the run of a task: one axis, or several that share a structure."""
    rng = np.random.default_rng(task[-1])
    if len(task) == 5:
        kind, size, sigma, noise, _ = task
        columns = readings(rng, kind, size, sigma, noise)[:, np.newaxis]
    else:
        kind, size, sigma, moved, axes, rho, noise, _ = task
        course = scatter(rng, axes, rho, noise)
        shared = (size * shape(rng, kind))[:, np.newaxis]
        course[:, :moved] += shared * rng.choice([-1, 1], moved)
        columns = np.stack([dial(rng, course[:, a], sigma) for a in range(axes)], axis=1)
    return rng, run_of(columns, sigma)


def one(task):
    """Return the summary of the whole search in one run."""
    rng, run = generated(task)
    return summary(searched(run, rng))


def answered(task):
    """Return what `diagnose` states of one run: its first name, or what it is not explained by."""
    _, run = generated(task)
    if problem_in(run) is None:
        return {"found": False}
    found = diagnose(run)
    first = found.effects[0] if found.effects else None
    return {
        "found": found.verdict is not Verdict.NOTHING,
        "unexplained": found.verdict is Verdict.UNEXPLAINED,
        "best": first and first.effect,
        "p": first.probability if first else 0.0,
    }


def tabled(pool, function, tasks):
    """Return the results of all tasks."""
    return pool.map(function, tasks, chunksize=10)


def percent(results, key):
    """Return how many per cent have ``key`` set."""
    return 100 * np.mean([bool(r[key]) for r in results])


def null(pool, runs):
    """Print false alarms on scatter only."""
    print("\n## False alarms on scatter only [%]: verdict (flagged readings beside it)")
    print(f"{'scatter':9s}" + "".join(f"{s or 'no rounding':>15}" for s in SIGMAS))
    for noise in ("normal", "t3", "skewed", "split"):
        row = []
        for sigma in SIGMAS:
            r = tabled(
                pool, detected, [("none", 0, sigma, noise, [SEED, 1, i]) for i in range(runs)]
            )
            row.append(f"{percent(r, 'found'):6.1f} ({percent(r, 'flag'):4.1f})")
        print(f"{noise:9s}" + "".join(f"{c:>15}" for c in row), flush=True)
    for noise, axes, rho in (("normal", 3, 0), ("normal", 3, 0.6), ("normal", 4, 0),
                             ("normal", 4, 0.6), ("t3", 4, 0.6), ("skewed", 4, 0)):  # fmt: skip
        row = []
        for sigma in (0.3, 0.5, 1.0):
            tasks = [("none", 0, sigma, 0, axes, rho, noise, [SEED, 2, i]) for i in range(runs)]
            row.append(f"sigma {sigma}: {percent(tabled(pool, detected, tasks), 'found'):4.1f}")
        print(f"{noise}, {axes} axes, correlation {rho}: " + "   ".join(row), flush=True)


FAMILIES = ("normal", "t5", "t3", "skewed", "uniform", "arcsine", "Laplace", "Cauchy", "lognormal")
KINDS = FAMILIES
LENGTHS, AXIS_COUNTS = (10, 12, 20, 30, 60, 100), (1, 3, 6)


def alarm(task):
    """Return whether scatter alone, of any length and number of axes, gives structure or order."""
    kind, n, axes, sigma, seed = task
    rng = np.random.default_rng(seed)
    columns = [dial(rng, distributed(rng, kind, n), sigma) for _ in range(axes)]
    read = {f"A{a}": Axis(f"A{a}", y, resolution=1.0) for a, y in enumerate(columns)}
    run = Run(np.arange(2, n + 2), read)
    problem = problem_in(run)
    if problem is None:
        return {"found": False, "order": False}
    stage, _ = chosen(problem, (), rng, 0.0)
    return {
        "found": stage.p_value <= LEVEL,
        "order": stage.order.p_value <= LEVEL * ORDER_SHARE,
    }


def families(pool, runs):
    """Print false alarms by distribution, number of cycles and of axes."""
    print(f"\n## False alarms [%], sigma 1 division, by cycles; axes {AXIS_COUNTS}: all tests, and")
    print("## (of these) the test of order at 0.95 of the level")
    print(f"{'scatter':10s}" + "".join(f"{n:>26}" for n in LENGTHS))
    for kind in KINDS:
        row, every = [], []
        for n in LENGTHS:
            cell = []
            for axes in AXIS_COUNTS:
                tasks = [(kind, n, axes, 1.0, [SEED, 10, i]) for i in range(runs)]
                found = tabled(pool, alarm, tasks)
                cell.append((percent(found, "found"), percent(found, "order")))
            row.append(" / ".join(f"{every:.0f} ({order:.0f})" for every, order in cell))
            every += cell
        mean = np.mean(every, axis=0)
        print(f"{kind:10s}" + "".join(f"{c:>26}" for c in row)
              + f"   mean {mean[0]:.1f} ({mean[1]:.1f})", flush=True)  # fmt: skip


def power(pool, runs):
    """Structure found, one axis."""
    print("\n## Structure found [%] (with flagged readings)")
    print(f"{'effect':16s}" + "".join(f"{s or 'no rounding':>13}" for s in SIGMAS))
    for kind, size in POWER:
        row = []
        for sigma in SIGMAS:
            tasks = [(kind, size, sigma, "normal", [SEED, 3, i]) for i in range(runs)]
            r = tabled(pool, detected, tasks)
            either = 100 * np.mean([x["found"] or x["flag"] for x in r])
            row.append(f"{percent(r, 'found'):4.0f} ({either:3.0f})")
        print(f"{kind:11s} {size:<4}" + "".join(f"{c:>13}" for c in row), flush=True)


def naming(pool, runs):
    """Named right given found, calibration, rivals."""
    print("\n## Named right given found [%]")
    for sigma in (0.5, 0.7, 1.0):
        for label, cells in (("middle", MIDDLE), ("high", HIGH)):
            right, stated, held, counts = [], [], [], []
            for kind, size in cells:
                tasks = [(kind, size, sigma, "normal", [SEED, 4, i]) for i in range(runs)]
                r = [x for x in tabled(pool, named, tasks) if x["best"] is not None]
                ok = [x["best"] == NAME[kind] for x in r]
                right.append(100 * np.mean(ok))
                stated += [(x["p"], o) for x, o in zip(r, ok, strict=True) if x["p"]]
                held += [NAME[kind] in x["rivals"] for x in r]
                counts += [len(x["rivals"]) for x in r]
            cells_text = " ".join(f"{k} {p:.0f}" for (k, _), p in zip(cells, right, strict=True))
            print(f"sigma {sigma} {label}: mean {np.mean(right):.1f}   {cells_text}")
            print(f"   truth among rivals {100 * np.mean(held):.1f} %, {np.mean(counts):.1f} long;"
                  f" {calibration(np.array(stated))}", flush=True)  # fmt: skip


def calibration(stated):
    """Return stated probability, how often right, and the count, in bins."""
    text = []
    for low, high in ((0.3, 0.5), (0.5, 0.7), (0.7, 0.8), (0.8, 0.9), (0.9, 0.97), (0.97, 1.01)):
        chosen = stated[(stated[:, 0] >= low) & (stated[:, 0] < high)]
        if len(chosen):
            mean, right = 100 * chosen.mean(axis=0)
            text.append(f"{mean:.0f}:{right:.0f} ({len(chosen)})")
    return "stated:right (runs) " + ", ".join(text)


def stated(task):
    """Return the probability of the first name, and whether it is right: any of ``names`` is.

    And whether it is right or as near to the truth as courses that BIC cannot tell apart.
    """
    names, kinds, *sized, seed = task
    rng = np.random.default_rng(seed)
    if len(kinds) == 2:
        run = run_of(together(rng, kinds, *sized), sized[-1])
    else:
        run = run_of(readings(rng, *kinds, *sized)[:, np.newaxis], sized[-2])
    problem = problem_in(run)
    choice = problem and chosen(problem, (), rng)[0].choice
    if not choice:
        return None
    right = near = choice.best in names
    if not right and len(kinds) == 1:
        truth = course(np.random.default_rng(seed), *kinds, sized[0])
        near = departure(problem, choice.best, truth) <= NEAR
    return choice.probability[choice.best], right, near


def departure(problem, effect, truth):
    """Return the sum of squares that the effect's best form leaves of a course in scatters."""
    forms = [member.form for member in problem.members if member.effect == effect]
    courses = [form.columns for form in forms if isinstance(form, Shape)]
    if any(isinstance(form, Chain) for form in forms):  # two levels, each cycle on either
        courses += list(np.tri(len(truth), k=-1)[1:, np.argsort(np.argsort(truth)), np.newaxis])
    left = [truth - x @ np.linalg.lstsq(x, truth, rcond=None)[0]
            for x in (np.insert(columns, 0, 1, axis=1) for columns in courses)]  # fmt: skip
    return min((float(one @ one) for one in left), default=np.inf)


def calibrated(pool, runs):
    """Print how often a name is right by what is stated of one effect, of two, and outside."""
    print(
        "\n## Stated and right, sigma 0.7: the first name of one effect, of two, and of structure"
    )
    print("## outside the catalogue, of which unknown is the right name; then, what leaves at most")
    print(f"## {NEAR:g} squares of scatter of the true course being right as well")
    groups = {
        "one": [((NAME[kind],), (kind,), size, 0.7, "normal") for kind, size in (*MIDDLE, *HIGH)],
        "two": [(tuple(NAME[kind] for kind in kinds), kinds, axes, 0.7)
                for kinds in TOGETHER for axes in (1, 2)],
        "outside": [((UNKNOWN, OUTSIDE_NAMES.get(kind)), (kind,), size, 0.7, "normal")
                    for kind, size in OUTSIDE],
    }  # fmt: skip
    for i, (group, cells) in enumerate(groups.items()):
        tasks = [
            (*cell, [SEED, 11 + i, c, run]) for c, cell in enumerate(cells) for run in range(runs)
        ]
        found = np.array([one for one in tabled(pool, stated, tasks) if one])
        for right in (1, 2) if group == "outside" else (1,):
            print(f"{group}: right {100 * found[:, right].mean():.1f} %; "
                  f"{calibration(found[:, [0, right]])}", flush=True)  # fmt: skip


def rival_names(task):
    """Return what each rival says about one run."""
    kind, size, sigma, noise, seed = task
    y = readings(np.random.default_rng(seed), kind, size, sigma, noise)
    if np.ptp(y) == 0:
        return dict.fromkeys(RIVALS)
    said = {}
    for name, rival in RIVALS.items():
        try:
            said[name] = rival(y)
        except ImportError:
            said[name] = "not installed"
    return said


def rivals(pool, runs):
    """Print what other methods make of the same data."""
    print("\n## Rivals: effect named on scatter only [%]; right at sigma 0.7 [% of found]")
    empty = {}
    for sigma in (0.3, 0.5, 0.7, 1.0):
        tasks = [("none", 0, sigma, "normal", [SEED, 1, i]) for i in range(runs)]
        empty[sigma] = tabled(pool, rival_names, tasks)
    cells = {}
    for label, structures in (("middle", MIDDLE), ("high", HIGH)):
        for kind, size in structures:
            tasks = [(kind, size, 0.7, "normal", [SEED, 4, i]) for i in range(runs)]
            cells[label, kind] = tabled(pool, rival_names, tasks)
    for name in RIVALS:
        if empty[0.5][0][name] == "not installed":
            print(f"{name}: not installed, skipped (extra: benchmark)")
            continue
        alarms = [f"{s}: {100 * np.mean([r[name] is not None for r in e]):.0f}"
                  for s, e in empty.items()]  # fmt: skip
        right = {}
        for (label, kind), r in cells.items():
            found = [x[name] for x in r if x[name] is not None]
            right.setdefault(label, []).append(np.mean([f == NAME[kind] for f in found]))
        means = [f"{label} {100 * np.mean(v):.0f}" for label, v in right.items()]
        print(f"{name:8s} alarms {' '.join(alarms)}   right: {' '.join(means)}", flush=True)


def outside(pool, runs):
    """Structure that is in no catalogue."""
    print("\n## Outside the catalogue, sigma 0.7: found, unexplained given found, wrong name > 0.9")
    every = {}
    for kind, size in OUTSIDE:
        tasks = [(kind, size, 0.7, "normal", [SEED, 5, i]) for i in range(runs)]
        r = tabled(pool, answered, tasks)
        found = [x for x in r if x["found"]]
        sure = [x["p"] >= SURE and not x["unexplained"] for x in found]
        every.setdefault(kind, []).append((percent(found, "unexplained"), 100 * np.mean(sure)))
        names = Counter(x["best"] for x in found if not x["unexplained"]).most_common(3)
        print(f"{kind:12s} {size}: {percent(r, 'found'):4.0f} {every[kind][-1][0]:4.0f} "
              f"{every[kind][-1][1]:4.1f}   named {names}", flush=True)  # fmt: skip
    means = np.mean([np.mean(v, axis=0) for v in every.values()], axis=0)
    print(f"mean over the five: unexplained {means[0]:.0f}, wrong name > 0.9 {means[1]:.1f}")


def held(task):
    """Return log ratios of error after to before: cross-validated, true, in sample."""
    kind, size, sigma, _, seed = task
    rng = np.random.default_rng(seed)
    course = size * rng.choice([-1, 1]) * shape(rng, kind)
    offset = rng.uniform(-0.5, 0.5)
    read = (lambda c: np.round(offset + sigma * c)) if sigma else (lambda c: c)
    y = read(course + rng.normal(size=N))
    found = searched(run_of(y[:, np.newaxis], sigma), rng)
    if found is None or not found[1]:
        return None
    problem, terms, stages = found
    fitted = fit(terms, problem.residual.values, np.arange(N), N)
    unseen = cross_validated(problem, fitted, stages, rng)
    fresh = read(course + rng.normal(size=(400, N)))
    before = np.sqrt(((fresh - y.mean()) ** 2).mean())
    after = np.sqrt(((fresh - fitted.predicted[:, 0]) ** 2).mean())
    inside = (y - fitted.predicted[:, 0]).std() / y.std()
    return [float(np.log(unseen.after[0] / unseen.before[0])), float(np.log(after / before)),
            float(np.log(inside))]  # fmt: skip


def held_out(pool, runs):
    """Bias of the cross-validated error ratio."""
    print("\n## Error after / before: log bias of cross-validation, and of the in-sample ratio")
    every = []
    for kind, size in (("step", 2), ("step", 3), ("linear", 3), ("warm_up", 4), ("periodic", 2),
                       ("alternating", 2)):  # fmt: skip
        tasks = [(kind, size, 0.7, "normal", [SEED, 6, i]) for i in range(runs)]
        r = np.array([x for x in tabled(pool, held, tasks) if x is not None])
        every.append(r)
        report_bias(f"{kind} {size}", r)
    report_bias("all", np.concatenate(every))


def report_bias(label, r):
    """Print mean log biases with their standard error."""
    bias = r - r[:, 1:2]
    error = bias.std(axis=0) / np.sqrt(len(r))
    print(f"{label:14s} true ratio {np.exp(r[:, 1].mean()):.3f}   cross-validated "
          f"{bias[:, 0].mean():+.3f} +/- {error[0]:.3f}   in sample {bias[:, 2].mean():+.3f}",
          flush=True)  # fmt: skip


def covariate(task):
    """Return the summary of one run with a covariate that acts."""
    kind, size, sigma, seed = task
    rng = np.random.default_rng(seed)
    approach = rng.permutation(np.repeat([-1.0, 1.0], N // 2))
    payload = rng.permutation(np.repeat([1.0, 2.0, 3.0], N // 3))
    trend = np.linspace(0, 1, N) + 0.15 * rng.normal(size=N)
    acting = {"approach": approach / 2, "payload": (payload - 2) / 2, "temperature": trend}[kind]
    y = dial(rng, size * acting + rng.normal(size=N), sigma)
    recorded = {"approach": approach, "payload_kg": payload, "temperature_C": 20 + trend}
    return summary(searched(run_of(y[:, np.newaxis], sigma, recorded), rng))


def geometry(task):
    """Return whether a step along joint 1 is found, knowing the arm or not."""
    size, sigma, known, seed = task
    rng = np.random.default_rng(seed)
    joint = {"joint 1": {"X": 0.8, "Y": 0.6, "Z": 0.0}, "joint 2": {"X": -0.2, "Y": 1.0, "Z": 0.0}}
    course = rng.normal(size=(N, 3)) + size * np.outer(shape(rng, "step"), [0.8, 0.6, 0.0])
    columns = np.stack([dial(rng, course[:, a], sigma) for a in range(3)], axis=1)
    return summary(searched(run_of(columns, sigma), rng, joint if known else None))


def knowing(task):
    """Return the name given to one run whose scatter is known beforehand."""
    rng, run = generated(task)
    if problem_in(run) is None:
        return summary(None)
    scatter_read = np.sqrt(task[2] ** 2 + 1 / 12)
    known = dict.fromkeys(run.axes, scatter_read)
    problem = problem_of(run, directions={}, effects=find_effects(), sigma=known)
    return summary((problem, (), (chosen(problem, (), rng)[0],)))


def gains(pool, runs):
    """More data of the right kind: several axes, covariates, geometry, a second run."""
    print("\n## Gains at sigma 0.7: found [%], named right of found [%]")
    for kind, size in (("step", 1), ("periodic", 1), ("linear", 1.5)):
        row = []
        for label, moved, axes in (("one axis", 1, 1), ("two runs or axes", 2, 2),
                                   ("three axes", 3, 3)):  # fmt: skip
            tasks = [(kind, size, 0.7, moved, axes, 0, "normal", [SEED, 7, i]) for i in range(runs)]
            row.append(f"{label} {said(tabled(pool, named, tasks), NAME[kind])}")
        print(f"{kind} of {size} sigma: " + ", ".join(row), flush=True)
    for kind, size in (("approach", 2), ("payload", 3), ("temperature", 3)):
        tasks = [(kind, size, 0.7, [SEED, 8, i]) for i in range(runs)]
        print(f"{kind} of {size} sigma: {said(tabled(pool, covariate, tasks), NAME[kind])}")
    for known in (False, True):
        tasks = [(1.6, 0.7, known, [SEED, 9, i]) for i in range(runs)]
        print(f"step of 1.6 sigma along joint 1, arm {'known' if known else 'not known'}: "
              f"{said(tabled(pool, geometry, tasks), 'step')}", flush=True)  # fmt: skip

    for function, label in ((named, "not known"), (knowing, "known")):
        means = []
        for structures in (MIDDLE, HIGH):
            right, counts = [], []
            for kind, size in structures:
                tasks = [(kind, size, 0.7, "normal", [SEED, 4, i]) for i in range(runs)]
                found = [r for r in tabled(pool, function, tasks) if r["best"] is not None]
                right.append(100 * np.mean([r["best"] == NAME[kind] for r in found]))
                counts.append(np.mean([len(r["rivals"]) for r in found]))
            means.append(f"{np.mean(right):.1f} ({np.mean(counts):.2f})")
        print(f"scatter {label}: named right, middle and high sizes (best and rivals): {means}",
              flush=True)  # fmt: skip


def said(results, name):
    """Return found and named right as text."""
    found = [r for r in results if r["found"]]
    right = 100 * np.mean([r["best"] == name for r in found]) if found else np.nan
    return f"{percent(results, 'found'):.0f} / {right:.0f}"


def speed(_pool, _runs):
    """Time of one whole diagnosis: 4 axes, covariates, 999 permutations, cross-validation."""
    rng = np.random.default_rng(SEED)
    course = scatter(rng, 4, 0.3) + 3 * shape(rng, "warm_up")[:, None] * [1, 0.7, 0, 0.5]
    columns = np.round(5 * course)
    recorded = {"temperature_C": 20 + rng.normal(size=N), "payload_kg": rng.choice([1.0, 2.0], N),
                "approach": rng.choice([-1.0, 1.0], N)}  # fmt: skip
    run = run_of(columns, 1.0, recorded)
    diagnose(run)
    start = time.process_time()
    for _ in range(5):
        diagnose(run)
    print(f"\n## One diagnosis, four axes: {(time.process_time() - start) / 5:.2f} s on one core")


TABLES = {
    "null": null,
    "families": families,
    "power": power,
    "naming": naming,
    "calibrated": calibrated,
    "rivals": rivals,
    "outside": outside,
    "held": held_out,
    "gains": gains,
    "speed": speed,
}


def main():
    """Print the tables that were asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=300)
    parser.add_argument("--only", nargs="*", choices=TABLES, default=list(TABLES))
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--lengths", nargs="*", type=int, default=LENGTHS, help="of families")
    parser.add_argument("--axes", nargs="*", type=int, default=AXIS_COUNTS, help="of families")
    parser.add_argument("--kinds", nargs="*", choices=FAMILIES, default=FAMILIES, help="likewise")
    options = parser.parse_args()
    globals().update(LENGTHS=options.lengths, AXIS_COUNTS=options.axes, KINDS=options.kinds)
    globals()["SEED"] = options.seed
    print(f"seed {SEED}, {options.runs} runs a cell, n = {N}")
    with Pool(options.processes, initializer=os.nice, initargs=(10,)) as pool:
        for name in options.only:
            start = time.perf_counter()
            TABLES[name](pool, options.runs)
            print(f"({name}: {time.perf_counter() - start:.0f} s)", flush=True)


if __name__ == "__main__":
    main()
