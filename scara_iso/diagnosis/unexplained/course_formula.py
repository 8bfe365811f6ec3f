"""A formula for a course of no name, from a small grammar, if it foretells cycles it has not seen.

The grammar: sums of two, and products with a period, of trend, parabola, exponential, period, two
levels and threshold, each with a coefficient of its own. In each fold the formula is chosen anew by
BIC, "no course" among them. The same is done with the cycles in random orders: a formula is offered
only where its error on unseen cycles is below that of none, and below that of all but 5 % of the
orders. Scatter that changes moves no mean and is left to its own effect.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from scara_iso.diagnosis.tuning import LEVEL
from scara_iso.effects import as_column
from scara_iso.run import FloatArray, IntArray

_FOLDS, _ORDERS = 5, 99
_TAUS, _PERIODS = (0.07, 0.15, 0.3), (1.0, 0.6, 0.4, 0.28, 0.2, 0.14)
"""Of the run."""
_PLACES = 10
"""So many cycles are tried for a change of level, and of slope."""
_DUST = 1e-9


@dataclass(frozen=True, eq=False, slots=True)
class _Term:
    """Columns (n, k), each as it is written, and how many numbers were chosen for it."""

    columns: FloatArray
    texts: tuple[str, ...]
    numbers: int


@dataclass(frozen=True, slots=True)
class FormulaFound:
    """A formula in ``k``, the cycle, that foretells unseen cycles better than none."""

    text: str
    held_out_rms: float
    """Root mean square error on unseen cycles, the formula chosen anew for each fold."""
    alone_rms: float
    """The same of a constant."""
    p_value: float
    """Share of random orders of the cycles that a formula foretells as well."""


@dataclass(frozen=True, eq=False, slots=True)
class _Bank:
    """Every formula on the rows of a fold, ready for many orders of readings at once.

    ``basis`` (formulas, seen, k) is orthonormal beside the mean, ``onto`` (formulas, unseen, k)
    takes its coefficients to the unseen rows, ``cost`` is that of its numbers in BIC.
    """

    basis: FloatArray
    onto: FloatArray
    cost: FloatArray

    def squares(self, seen: FloatArray, unseen: FloatArray) -> FloatArray:
        """Return summed squares on unseen readings (rows, orders) of the formulas chosen."""
        mean = seen.mean(axis=0)
        parts = np.einsum("fsk,so->fko", self.basis, seen - mean)
        left = np.maximum(((seen - mean) ** 2).sum(axis=0) - (parts**2).sum(axis=1), _DUST**2)
        chosen = np.argmin(len(seen) * np.log(left) + self.cost[:, np.newaxis], axis=0)
        each = np.arange(seen.shape[1])
        foretold = mean + np.einsum("ouk,ok->uo", self.onto[chosen], parts[chosen, :, each])
        return np.asarray(((unseen - foretold) ** 2).sum(axis=0))


def formula_for(
    y: FloatArray, cycle: IntArray, rng: np.random.Generator, *, level: float = LEVEL
) -> FormulaFound | None:
    """Return the formula of residuals y (n,) over the cycles (n,), None where none foretells.

    ``level`` is the share of random orders that may be foretold as well.
    """
    n = len(y)
    formulas = list(_formulas(cycle))
    orders = np.stack([y, *(rng.permutation(y) for _ in range(_ORDERS))], axis=1)
    squares, alone = np.zeros(1 + _ORDERS), np.zeros(1 + _ORDERS)
    for unseen in np.array_split(rng.permutation(n), _FOLDS):
        rows = np.delete(np.arange(n), unseen)
        seen, held = orders[rows], orders[unseen]
        squares += _bank(formulas, rows, unseen).squares(seen, held)
        alone += ((held - seen.mean(axis=0)) ** 2).sum(axis=0)
    share = squares / alone
    p_value = float((share <= share[0]).mean())
    text = _written(formulas, y) if share[0] < 1 and p_value <= level else ""
    if not text:
        return None
    with_it, without = (float(np.sqrt(one[0] / n)) for one in (squares, alone))
    return FormulaFound(text, with_it, without, p_value)


def _formulas(cycle: IntArray) -> Iterator[_Term]:
    """Yield every formula; the first moves nothing."""
    yield _Term(np.zeros((len(cycle), 0)), (), 0)
    terms, waves = list(_terms(cycle)), list(_waves(cycle))
    yield from terms
    yield from waves
    yield from (_sum(a, b) for a, b in combinations([*terms, *waves], 2))
    yield from (_product(a, b) for a in terms for b in waves)


def _terms(cycle: IntArray) -> Iterator[_Term]:
    n, first = len(cycle), int(cycle[0])
    k = cycle - float(first)
    since = f"(k - {first})"
    yield _Term(as_column(k), (since,), 0)
    yield _Term(np.stack([k, k**2], axis=1), (since, f"{since}**2"), 0)
    for tau in (round(share * n, 1) for share in _TAUS):
        yield _Term(as_column(np.exp(-k / tau)), (f"exp(-{since} / {tau:g})",), 1)
    for row in sorted(set(np.linspace(2, n - 3, _PLACES).round().astype(int).tolist())):
        at = int(cycle[row])
        yield _Term(as_column(cycle >= at), (f"(k >= {at})",), 1)
        yield _Term(as_column(np.maximum(cycle - at, 0)), (f"max(k - {at}, 0)",), 1)


def _waves(cycle: IntArray) -> Iterator[_Term]:
    n, k = len(cycle), cycle - float(cycle[0])
    for period in (round(share * n, 1) for share in _PERIODS):
        speed = float(f"{2 * np.pi / period:.4g}")
        angle = np.asarray(speed * k)
        written = f"{speed:g} * (k - {int(cycle[0])})"
        yield _Term(
            np.stack([np.sin(angle), np.cos(angle)], axis=1),
            (f"sin({written})", f"cos({written})"),
            1,
        )


def _sum(one: _Term, other: _Term) -> _Term:
    columns = np.concatenate([one.columns, other.columns], axis=1)
    return _Term(columns, (*one.texts, *other.texts), one.numbers + other.numbers)


def _product(one: _Term, wave: _Term) -> _Term:
    columns = one.columns[:, -1:] * wave.columns
    texts = tuple(f"{one.texts[-1]} * {text}" for text in wave.texts)
    return _Term(columns, texts, one.numbers + wave.numbers)


def _bank(formulas: Sequence[_Term], rows: IntArray, unseen: IntArray) -> _Bank:
    width = max(term.columns.shape[1] for term in formulas)
    every = np.zeros((len(formulas), len(rows) + len(unseen), width))
    at = np.concatenate([rows, unseen])
    for i, term in enumerate(formulas):
        every[i, :, : term.columns.shape[1]] = term.columns[at]
    every -= every[:, : len(rows)].mean(axis=1, keepdims=True)
    whole = np.linalg.norm(every[:, : len(rows)], axis=1)
    for k in range(width):  # Gram and Schmidt on the seen rows, carried to the unseen ones
        for j in range(k):
            share = (every[:, : len(rows), j] * every[:, : len(rows), k]).sum(axis=1)
            every[:, :, k] -= share[:, np.newaxis] * every[:, :, j]
        length = np.linalg.norm(every[:, : len(rows), k], axis=1)
        free = length > 1e-6 * whole[:, k]
        every[:, :, k] *= np.where(free, 1 / np.maximum(length, 1e-300), 0.0)[:, np.newaxis]
    cost = [np.log(len(rows)) * (t.columns.shape[1] + t.numbers) for t in formulas]
    return _Bank(every[:, : len(rows)], every[:, len(rows) :], np.array(cost))


def _written(formulas: Sequence[_Term], y: FloatArray) -> str:
    """Return the formula of least BIC on all of y (n,) with its coefficients; empty for none."""
    n, best, text = len(y), np.inf, ""
    for term in formulas:
        design = np.concatenate([np.ones((n, 1)), term.columns], axis=1)
        coefficients = np.linalg.lstsq(design, y, rcond=1e-9)[0]
        left = float(((y - design @ coefficients) ** 2).sum())
        bic = n * np.log(max(left, _DUST**2)) + np.log(n) * (design.shape[1] + term.numbers)
        if bic < best:
            best, text = bic, _text(coefficients, term.texts)
    return text


def _text(coefficients: FloatArray, texts: Sequence[str]) -> str:
    if not texts:
        return ""
    constant, *others = coefficients.tolist()
    parts = [
        f" {'-' if size < 0 else '+'} {abs(size):.4g} * {text}"
        for size, text in zip(others, texts, strict=True)
    ]
    return f"{constant:.4g}{''.join(parts)}"
