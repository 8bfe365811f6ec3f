"""Results of several poses, found by number or by name."""

from __future__ import annotations

from typing import TYPE_CHECKING, SupportsIndex, overload

if TYPE_CHECKING:
    from scara_iso.iso9283.results import PoseResult


class Poses(tuple["PoseResult", ...]):
    """The poses in their order: ``poses[0]`` and ``poses["P1"]``; `KeyError` for another name."""

    __slots__ = ()

    @overload
    def __getitem__(self, at: SupportsIndex | str) -> PoseResult: ...
    @overload
    def __getitem__(self, at: slice) -> tuple[PoseResult, ...]: ...

    def __getitem__(self, at: SupportsIndex | str | slice) -> PoseResult | tuple[PoseResult, ...]:
        if not isinstance(at, str):
            return super().__getitem__(at)
        for pose in self:
            if pose.label == at:
                return pose
        raise KeyError(f"no pose {at!r}: there is {', '.join(str(p.label) for p in self)}")
