"""What ``compare`` publishes of a comparison: schema ``scara-iso/compare/1``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal

from scara_iso.base.published import Count, publish
from scara_iso.comparison.decision import (
    LEVEL,
    Comparison,
    Contrast,
    Difference,
    Pair,
    Probability,
    Significance,
)
from scara_iso.iso9283 import (
    Analysis,
    PublishedCharacteristic,
    PublishedFinding,
    published_characteristic,
    published_finding,
)


@dataclass(frozen=True, kw_only=True)
class MeanContrast(Significance, Difference):
    """The mean of an axis before and after."""

    quantity: Literal["mean"]
    """What is compared."""


@dataclass(frozen=True, kw_only=True)
class SpreadContrast(Contrast):
    """The scatter of an axis, a plane or space before and after."""

    quantity: Literal["RP", "three_sigma"]
    """Repeatability, or 3 S of an angle."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CountedCycles:
    """How many cycles each pose has."""

    read: Count
    """Cycles in the table."""
    used: Count
    """Cycles that count."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparedRun:
    """One of the runs."""

    source: str
    """The file."""
    read_as: str
    """How the file was understood."""
    metadata: Mapping[str, str]
    """What the file states."""
    cycles: CountedCycles
    """For each pose."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedPair:
    """A run against the first."""

    after: ComparedRun
    """The run that is compared."""
    spreads: tuple[SpreadContrast, ...]
    """One for each pose, axis and plane."""
    means: tuple[MeanContrast, ...]
    """One for each pose and axis."""
    findings: tuple[PublishedFinding, ...]
    """What the comparison must be read with."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparisonTest:
    """How chance was judged."""

    method: str
    """In words."""
    level: Probability
    """Chance that any figure of a quantity is shown where nothing changed."""
    shuffles: Count
    """Number of permutations."""
    seed: int
    """Of the permutations."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedComparison:
    """``compare`` of two runs or more."""

    schema: Literal["scara-iso/compare/1"]
    """Name and number of this schema."""
    unit: Literal["mm"]
    """Of every length."""
    test: ComparisonTest
    """Of all figures together."""
    before: ComparedRun
    """The first run."""
    pairs: Annotated[tuple[PublishedPair, ...], ("minItems", 1)]
    """One for each run after the first."""
    characteristics: tuple[PublishedCharacteristic, ...] | None = None
    """Exchangeability of several robots, where it is asked for."""


def published_comparison(found: Comparison) -> PublishedComparison:
    """Return what ``compare`` says."""
    return PublishedComparison(
        schema="scara-iso/compare/1",
        unit="mm",
        test=ComparisonTest(
            method="studentised permutation of centred cycles, single-step maximum",
            level=LEVEL,
            shuffles=found.shuffles,
            seed=found.seed,
        ),
        before=_run(found.pairs[0].before),
        pairs=tuple(map(_pair, found.pairs)),
        characteristics=tuple(map(published_characteristic, found.characteristics)) or None,
    )


def _pair(found: Pair) -> PublishedPair:
    return PublishedPair(
        after=_run(found.after),
        spreads=tuple(publish(SpreadContrast, one) for one in found.spreads),
        means=tuple(publish(MeanContrast, one) for one in found.means),
        findings=tuple(map(published_finding, found.findings)),
    )


def _run(found: Analysis) -> ComparedRun:
    origin = found.run.origin
    return ComparedRun(
        source=origin.source,
        read_as=origin.understood,
        metadata=found.run.metadata,
        cycles=publish(CountedCycles, found.cycles),
    )
