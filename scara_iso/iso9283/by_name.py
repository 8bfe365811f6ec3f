"""Results of several poses, found by number or by name."""

from __future__ import annotations

from typing import Protocol, SupportsIndex, TypeVar, overload


class Labelled(Protocol):
    """What belongs to a pose."""

    @property
    def label(self) -> str | None:
        """Name of the pose, None for the only one."""


OfPose = TypeVar("OfPose", bound=Labelled)


class Poses(tuple[OfPose, ...]):
    """The poses in their order: ``poses[0]`` and ``poses["P1"]``; `KeyError` for another name."""

    __slots__ = ()

    @overload
    def __getitem__(self, at: SupportsIndex | str) -> OfPose: ...
    @overload
    def __getitem__(self, at: slice) -> tuple[OfPose, ...]: ...

    def __getitem__(self, at: SupportsIndex | str | slice) -> OfPose | tuple[OfPose, ...]:
        if not isinstance(at, str):
            return super().__getitem__(at)
        for pose in self:
            if pose.label == at:
                return pose
        there = ", ".join(pose.label for pose in self if pose.label is not None)
        said = f"there is {there}" if there else "the table names none, take poses[0]"
        raise KeyError(f"no pose {at!r}: {said}")
