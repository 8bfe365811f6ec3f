"""The tests beside the cycles at the poses: a drift test (7.6), and joints pushed to and fro."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from scara_iso.iso9283.checks.parts_missing import not_recorded
from scara_iso.iso9283.figures import Conformity
from scara_iso.iso9283.results import Analysis, Characteristic, Finding, LimitCheck, gravest

if TYPE_CHECKING:
    from scara_iso.iso9283.pushed_joint import PushResult

_DRIFT, _PUSH = "drift", "push"


@dataclass(frozen=True, eq=False, slots=True)
class Beside:
    """What a whole test holds beside its conditions; empty where that is nothing."""

    drift: Analysis | None = None
    """Of the drift test, its rows under the label of its pose."""
    pushes: Mapping[str, PushResult] = field(default_factory=dict)
    """By name of the part: ``push``, or ``push-joint_1`` of several."""
    missing: tuple[str, ...] = ()
    """Parts that are planned and not recorded."""

    def __bool__(self) -> bool:
        return bool(self.drift or self.pushes or self.missing)

    @property
    def characteristics(self) -> tuple[Characteristic, ...]:
        """Every figure; those of several joints are of ``joint_1`` and ``joint_1 reading``."""
        of_drift = () if self.drift is None else self.drift.characteristics
        return (*of_drift, *(one for name in self.pushes for one in self._of_push(name)))

    @property
    def limits(self) -> tuple[LimitCheck, ...]:
        """The figures that were held against a limit."""
        of_drift = () if self.drift is None else self.drift.limits
        pushed = (one.limit for name in self.pushes for one in self._of_push(name))
        return (*of_drift, *(check for check in pushed if check is not None))

    @property
    def conformity(self) -> Conformity | None:
        """The gravest verdict; None where no limit was given."""
        return gravest(self.limits)

    @property
    def simulated(self) -> bool:
        """Whether readings of the drift test are of no dial."""
        return self.drift is not None and bool(self.drift.run.metadata.get("simulated"))

    def findings(self) -> Iterator[Finding]:
        """Yield what the drift test has to say, as of the pose ``drift``, and what is missing."""
        for found in () if self.drift is None else self.drift.findings:
            yield replace(found, pose=_DRIFT)
        if self.missing:
            yield not_recorded(", ".join(self.missing))

    def added_to(self, analysis: Analysis) -> Analysis:
        """Return an analysis of the poses with these figures and findings, none of them twice."""
        said = {(one.code, one.axis, one.message) for one in analysis.findings}
        new = (one for one in self.findings() if (one.code, one.axis, one.message) not in said)
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
