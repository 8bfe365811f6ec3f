"""The pose that a title, a heading or a line names."""

from __future__ import annotations

import re

from scara_iso.tables.names import LONGEST_NAME, clean

_NUMBERED = r"(?:p|pose|point|punkt)[ _.-]?0*([1-9][0-9]{0,2})"
_BRACKETS = re.compile(r"[(\[][^()\[\]]*[)\]]\s*$")
_POSE = re.compile(rf"(?<![a-z0-9]){_NUMBERED}(?![a-z0-9])")
_LINE = re.compile(r"#?\s*(?:pose|point|punkt)\s*[:=]\s*(\S.{0,30})", re.IGNORECASE)
_BEFORE = re.compile(rf"{_NUMBERED}[ _:.-]+(\S.*)", re.IGNORECASE)
_BEHIND = re.compile(rf"(\S.*?)[ _:.-]+{_NUMBERED}( ?[\[(/,].*)?", re.IGNORECASE)


def pose_in(title: str) -> str | None:
    """Return the pose that a name such as ``run_P3`` or ``Pose 3`` holds, None without one."""
    found = set(_POSE.findall(title.lower()))
    return f"P{found.pop()}" if len(found) == 1 else None


def pose_alone(text: str) -> str | None:
    """Return the pose of a line or cell that says nothing else: ``P3``, ``Pose 3``, ``pose: A``.

    What stands in brackets behind it, such as its coordinates, is not read.
    """
    text = _BRACKETS.sub("", text).strip(" \t*=-_")
    stated = _LINE.fullmatch(text)
    whole = _POSE.fullmatch(text.lower())
    return stated[1].strip() if stated else f"P{whole[1]}" if whole else None


def pose_and_name(heading: str) -> tuple[str, str] | None:
    """Return the pose that a heading such as ``P1 X [mm]`` names, and the heading without it."""
    text = clean(heading) if len(heading) <= LONGEST_NAME else ""
    if found := _BEFORE.fullmatch(text):
        return f"P{found[1]}", found[2]
    found = _BEHIND.fullmatch(text)
    return (f"P{found[2]}", f"{found[1]}{found[3] or ''}") if found else None
