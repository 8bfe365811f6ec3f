"""What came of every statement, counted: the tables and the figure of the page."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from benchmarks.study.judge import NOTHING, UNEXPLAINED
from benchmarks.study.mounts import PUBLISHED, Found
from benchmarks.study.trial import Verdicts
from benchmarks.study.windows import NEXT, Outcome

SURE = 0.9
BINS = (0.0, 0.5, 0.6, 0.7, 0.8, SURE, 0.97, 1.0 + 1e-9)
VERDICTS = ("right", "wrong", "undecided", "unjudged")


def wilson(hits: int, n: int) -> tuple[float, float]:
    """Return the 95 % interval of a share (Wilson 1927)."""
    if not n:
        return 0.0, 1.0
    z, p = 1.96, hits / n
    half = z * np.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    return tuple((p + z * z / (2 * n) + sign * half) / (1 + z * z / n) for sign in (-1, 1))


def share(hits: int, n: int) -> str:
    """Return a share with its count and 95 % interval."""
    low, high = wilson(hits, n)
    return f"{hits} of {n}: {hits / n:.0%} [{low:.0%}, {high:.0%}]" if n else "none"


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> Iterator[str]:
    """Yield the lines of a Markdown table."""
    yield f"| {' | '.join(head)} |"
    yield "|" + "---|" * len(head)
    yield from (f"| {' | '.join(map(str, row))} |" for row in rows)


def named(outcomes: Iterable[Outcome]) -> list[Outcome]:
    """Return those of which an effect was named."""
    return [one for one in outcomes if one.stated.probability is not None]


def sure(outcomes: Iterable[Outcome]) -> list[Outcome]:
    """Return those named with at least 90 %."""
    return [one for one in named(outcomes) if one.stated.probability >= SURE]


def counts(outcomes: Sequence[Outcome]) -> list[int]:
    """Return how many are right, wrong, undecided and unjudged."""
    return [sum(one.verdict == verdict for one in outcomes) for verdict in VERDICTS]


def by_set(outcomes: Sequence[Outcome]) -> Iterator[str]:
    """Yield a row for each series: tests, statements, and what came of names."""
    head = ("set", "series", "tests", "nothing", "unexplained", "named", *VERDICTS,
            "sure (0.9 and more)", "of them wrong")  # fmt: skip
    keys = dict.fromkeys((one.set, one.series) for one in outcomes)
    rows = [(*key, *_statements([o for o in outcomes if (o.set, o.series) == key])) for key in keys]
    rows.append(("**all**", "", *_statements(outcomes)))
    yield from table(head, rows)


def _statements(own: Sequence[Outcome]) -> list[int]:
    kinds = [sum(one.stated.names[0] == kind for one in own) for kind in (NOTHING, UNEXPLAINED)]
    certain = sure(own)
    return [len(own), *kinds, len(named(own)), *counts(named(own)), len(certain),
            sum(one.verdict == "wrong" for one in certain)]  # fmt: skip


def by_name(outcomes: Sequence[Outcome]) -> Iterator[str]:
    """Yield a row for each statement: what came of it, and whether the next readings go on so."""
    rows = []
    for name in sorted({one.stated.names[0] for one in outcomes}):
        own = [one for one in outcomes if one.stated.names[0] == name]
        judged = [one for one in own if one.verdict != "unjudged"]
        on, certain = sum(one.goes_on for one in judged), sure(own)
        rows.append((f"`{name}`", len(own), *counts(own), share(on, len(judged)), len(certain),
                     sum(one.verdict == "wrong" for one in certain)))  # fmt: skip
    head = ("stated", "tests", *VERDICTS, "the next readings go on from it", "sure", "wrong")
    yield from table(head, rows)


def reliability(outcomes: Sequence[Outcome]) -> list[tuple[str, int, float, int, int, int]]:
    """Return for each bin of stated probability: its words, n, mean stated, right, wrong, open."""
    found = []
    for low, high in pairwise(BINS):
        own = [one for one in named(outcomes) if low <= one.stated.probability < high]
        own = [one for one in own if one.verdict != "unjudged"]
        if own:
            mean = float(np.mean([one.stated.probability for one in own]))
            right, wrong, undecided, _ = counts(own)
            words = f"{low:g} to {min(high, 1):.2g}"
            found.append((words, len(own), mean, right, wrong, undecided))
    return found


def reliable(outcomes: Sequence[Outcome]) -> Iterator[str]:
    """Yield the table of stated probabilities."""
    rows = [
        (words, n, f"{mean:.2f}", right, wrong, undecided, share(right, right + wrong))
        for words, n, mean, right, wrong, undecided in reliability(outcomes)
    ]
    head = ("stated", "names", "mean", "right", "wrong", "undecided", "right of those decided")
    yield from table(head, rows)


def inside(outcomes: Iterable[Outcome], interval: str) -> tuple[int, int]:
    """Return how often RP of the next test lies in an interval, and of how many."""
    pairs = [(getattr(one.stated, interval), one.RP) for one in outcomes]
    pairs = [(ends, RP) for ends, RP in pairs if ends is not None]
    return sum(low <= RP <= high for (low, high), RP in pairs), len(pairs)


def next_tests(outcomes: Sequence[Outcome]) -> Iterator[str]:
    """Yield by set and by length how RP and the error of the next test agree with what was said."""
    groups = {name: [o for o in outcomes if o.set == name] for name in sets(outcomes)}
    groups |= {
        f"tests of {n}": [o for o in outcomes if o.rows == n] for n in (20, 30, 45, 60)
    } | {"**all**": list(outcomes)}  # fmt: skip
    rows = []
    for name, own in groups.items():
        null = [one for one in own if one.next_nothing]
        first = [one for one in own if one.stated.names[0] == NOTHING]
        rows.append((name, share(len(null), len(first)), share(*inside(null, "predicted")),
                     share(*inside(own, "predicted")), share(*inside(null, "sampling")),
                     error_ratio(null, 0), error_ratio(own, 1)))  # fmt: skip
    head = ("", "nothing, and nothing next", "RP in the prediction interval: nulls", "all",
            "in the sampling interval: nulls", "error: nulls", "error: all")  # fmt: skip
    yield from table(head, rows)


def error_ratio(outcomes: Sequence[Outcome], which: int) -> str:
    """Return the scatter of the next readings over the held-out error: median, and 5 to 95 %."""
    ratios = [one.scatter[which] / one.stated.held_out for one in outcomes if one.stated.held_out]
    if not ratios:
        return ""
    low, middle, high = np.quantile(ratios, [0.05, 0.5, 0.95])
    return f"{middle:.2f} ({low:.2f} to {high:.2f})"


def sets(outcomes: Iterable[Outcome]) -> list[str]:
    """Return the names of the sets in their order."""
    return list(dict.fromkeys(one.set for one in outcomes))


def trials(found: Verdicts) -> Iterator[str]:
    """Yield how often the judge is right and wrong on tables of known cause."""
    rows = []
    for cause, kinds in found.items():
        cells = [f"{kinds[k]['right']}, {kinds[k]['wrong']}, {kinds[k]['undecided']}"
                 for k in ("true", "false", NOTHING)]  # fmt: skip
        rows.append((f"`{cause}`", *cells))
    yield from table(("cause", "its own name", "a false name", "nothing"), rows)
    true, false = ([kinds[k] for kinds in found.values()] for k in ("true", "false"))
    n = sum(count.total() for count in true)
    yield ""
    yield (
        f"A true name is judged wrong in {share(sum(c['wrong'] for c in true), n)}, a false one "
        f"right in {share(sum(c['right'] for c in false), sum(count.total() for count in false))}."
    )


def mounts(found: Iterable[Found]) -> Iterator[str]:
    """Yield lost motion and RP by side of every mount beside the makers' figures."""
    rows = []
    for one in found:
        backlash, u, repeat, v = PUBLISHED[one.name]
        lost = f"{np.median(one.lost):.0f} ({one.lost.min():.0f} to {one.lost.max():.0f})"
        lost += f" + {one.compensated:.0f} compensated" if one.compensated else ""
        sides = f"{np.median(one.below):.0f}, {np.median(one.above):.0f}"
        makers = f"{backlash} ± {u}", f"{repeat} ± {v}"
        rows.append((one.name, lost, makers[0], sides, f"{one.inner:.0f}", makers[1]))
    head = (
        "mount",
        "vAP: median of the targets (range)",
        "makers' backlash",
        "RP from below, from above",
        "inner 95 % of deviations",
        "makers' unidirectional",
    )
    yield from table(head, rows)


def draw(outcomes: Sequence[Outcome], path: Path) -> None:
    """Write the figure: stated against right, and RP of the next test by set."""
    import matplotlib as mpl  # noqa: PLC0415 - for this only

    mpl.use("svg")
    mpl.rcParams.update({"svg.hashsalt": "study", "svg.fonttype": "none", "font.size": 9})
    from matplotlib import pyplot as plt  # noqa: PLC0415

    figure, (left, right) = plt.subplots(1, 2, figsize=(8.4, 3.6), layout="constrained")
    left.plot([0, 1], [0, 1], color="0.7", lw=1)
    for _, n, mean, hits, wrong, undecided in reliability(outcomes):
        low, high = wilson(hits, hits + wrong)
        left.plot([mean, mean], [hits / n, (hits + undecided) / n], color="0.8", lw=5)
        left.plot([mean, mean], [low, high], color="C0", lw=1.2)
        left.plot(mean, hits / max(hits + wrong, 1), "o", color="C0", ms=5)
    left.set(xlabel="probability stated", ylabel="right of those decided", xlim=(0.2, 1.02),
             ylim=(0, 1.02), title="Names")  # fmt: skip
    names = [*sets(outcomes), "all"]
    for k, name in enumerate(names):
        own = [one for one in outcomes if name in (one.set, "all")]
        groups = [("nulls", [o for o in own if o.next_nothing], "C0"), ("all", own, "C1")]
        for shift, (label, group, colour) in zip((-0.12, 0.12), groups, strict=True):
            hits, n = inside(group, "predicted")
            low, high = wilson(hits, n)
            right.plot([k + shift] * 2, [low, high], color=colour, lw=1.2)
            right.plot(k + shift, hits / max(n, 1), "o", color=colour, ms=5,
                       label=None if k else f"{label} pairs")  # fmt: skip
    right.axhline(0.95, color="0.7", lw=1)
    right.set(
        xticks=range(len(names)),
        xticklabels=names,
        ylim=(0, 1.02),
        ylabel=f"RP of the next {NEXT} in the interval",
        title="Prediction interval of RP",
    )
    right.legend(loc="lower left", frameon=False)
    figure.savefig(path, format="svg", metadata={"Date": None})
