"""The tests beside the cycles at the poses: a drift test (7.6), and joints pushed to and fro."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Annotated

from scara_iso.base.published import INTERNAL, MERGED, fill
from scara_iso.iso9283.checks.parts_missing import not_recorded
from scara_iso.iso9283.figures import Conformity
from scara_iso.iso9283.results import (
    Analysed,
    Analysis,
    Characteristic,
    Finding,
    Head,
    LimitCheck,
    gravest,
)

if TYPE_CHECKING:
    from scara_iso.iso9283.pushed_joint import PushResult

_DRIFT, _PUSH = "drift", "push"


@dataclass(frozen=True, eq=False, slots=True)
class OtherTests:
    """The tests beside the poses: drift and push tests; empty where there are none."""

    drift: Analysis | None = field(default=None, metadata=INTERNAL)
    """Of the drift test, its rows under the label of its pose."""
    pushes: Mapping[str, PushResult] = field(default_factory=dict, metadata=INTERNAL)
    """By name of the part: ``push``, or ``push-joint_1`` of several."""
    characteristics: tuple[Characteristic, ...] = field(init=False)
    """Their figures; those of several joints are of ``joint_1`` and ``joint_1 reading``."""
    limits: tuple[LimitCheck, ...] = field(init=False)
    """One for each figure that was held against a limit."""
    conformity: Conformity | None = field(init=False)
    """Of these limits together, the gravest; None where none was given."""
    findings: tuple[Finding, ...] = field(init=False)
    """What the checks say of the drift test, as of the pose ``drift``, and what is missing."""
    missing: tuple[str, ...] = ()
    """Parts that are not recorded."""

    def __post_init__(self) -> None:
        pushed = [one for name in self.pushes for one in self._of_push(name)]
        limits = [one.limit for one in pushed if one.limit is not None]
        findings = [not_recorded(", ".join(self.missing))] if self.missing else []
        if self.drift is not None:
            pushed = [*self.drift.characteristics, *pushed]
            limits = [*self.drift.limits, *limits]
            findings = [*(replace(one, pose=_DRIFT) for one in self.drift.findings), *findings]
        fill(
            self,
            characteristics=tuple(pushed),
            limits=tuple(limits),
            conformity=gravest(one.verdict for one in limits),
            findings=tuple(findings),
        )

    def __bool__(self) -> bool:
        return bool(self.drift or self.pushes or self.missing)

    @property
    def simulated(self) -> bool:
        """Whether readings of the drift test are of no dial."""
        return self.drift is not None and bool(self.drift.run.simulated)

    def added_to(self, analysis: Analysis) -> Analysis:
        """Return an analysis of the poses with these figures and findings, none of them twice."""
        said = {(one.code, one.axis, one.message) for one in analysis.findings}
        new = (one for one in self.findings if (one.code, one.axis, one.message) not in said)
        return replace(
            analysis,
            findings=(*analysis.findings, *new),
            limits=(*analysis.limits, *self.limits),
            characteristics=(*analysis.characteristics, *self.characteristics),
        )

    def _of_push(self, name: str) -> Iterator[Characteristic]:
        joint = name.removeprefix(_PUSH).removeprefix("-")
        for found in self.pushes[name].characteristics:
            if not joint:
                yield found
                continue
            of = joint if found.of == "joint" else f"{joint} {found.of}"
            check = found.limit and replace(found.limit, figure=f"{found.code} {of}")
            yield replace(found, of=of, limit=check)


@dataclass(frozen=True, kw_only=True)
class ConditionAnalysis(Analysed):
    """What one condition of a test's folder would give by itself."""

    velocity: float
    """Per cent of the rated one."""
    load: float
    """Per cent of the rated one."""


@dataclass(frozen=True, kw_only=True)
class FolderAnalysis(Head):
    """``analyze`` of a test's folder with several conditions."""

    conditions: Annotated[tuple[ConditionAnalysis, ...], ("minItems", 2)]
    """One for each velocity and load."""
    other_tests: OtherTests | None = field(default=None, metadata=MERGED)
    """Figures, limits and findings of the tests beside them."""
