"""The watch over a recording: what all readings so far say, as a warning."""

from __future__ import annotations

from collections.abc import Iterator

from scara_iso.diagnosis import PAUSE, NextWay, Watched
from scara_iso.reporting.digits import words

_RIVALS = 2
_WORTH = 0.02
"""Chance of a right name that is worth more cycles."""
_STANDS_OUT = 0.5
"""Share from which a cause is called the likeliest: below, fewer than half are right (watch.py)."""
_UNKNOWN = "look at robot, fixture and indicator"
_YOURS = "The recording goes on; a test that is stopped early does not conform to ISO 9283"


def warning(watched: Watched) -> tuple[str, ...]:
    """Return the lines of an alarm: what, since when, what to do now; none where there is none."""
    if watched.says != "structure":
        return ()
    from scara_iso.effects import find_effects  # noqa: PLC0415 - no part of the start

    since = watched.since or 1
    named = {effect.name: effect for effect in find_effects()}
    effect = named.get(watched.effect or "")
    likeliest = _named(watched) if effect else f"nothing known fits yet{_others(watched)}"
    begun = f"since cycle {since}" if since > 2 else "from the start"
    do = effect.at_once if effect else _UNKNOWN
    strike = f"strike cycles {since}-{watched.cycle}, or" if since > 2 else "then"
    return (
        f"More than scatter: {likeliest}, {begun} (evidence {watched.evidence:.3g}, alarm at 20)",
        f"{do[0].upper()}{do[1:]}; {strike} start again",
        *_apart(watched),
        _YOURS,
    )


def _apart(watched: Watched) -> Iterator[str]:
    """Yield what would tell the rivals apart, and how well."""
    now, ways = watched.share or 0.0, watched.next or ()
    if ways and max(one.right for one in ways) < now + _WORTH:
        yield "Neither ten more cycles nor a pause will tell them apart"
    elif ways:
        then = ", ".join(f"{one.right:.0%} after {_way(one)}" for one in ways)
        yield f"Chance that the likeliest name is right: {now:.0%} now, {then}"


def _way(one: NextWay) -> str:
    behind = f"a pause as long as {PAUSE} cycles (p) and " if one.pause else ""
    return f"{behind}{one.cycles} cycles"


def _named(watched: Watched) -> str:
    """Return the likeliest effect with its share, and its rivals while there are any."""
    name = words(watched.effect or "")
    if watched.share is None:
        return f"likeliest {name}"
    so_far = "likeliest so far" if watched.rivals else "likeliest"
    if watched.share < _STANDS_OUT:
        so_far = "too early for a cause:"
    return f"{so_far} {name} ({watched.share:.0%}){_others(watched)}"


def _others(watched: Watched) -> str:
    """Return the likeliest rivals."""
    first = list((watched.rivals or {}).items())[:_RIVALS]
    return "".join(f" or {words(name)} ({share:.0%})" for name, share in first)
