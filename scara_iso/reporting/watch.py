"""The watch over a recording: what all readings so far say, as a warning."""

from __future__ import annotations

from scara_iso.diagnosis import Watched
from scara_iso.reporting.digits import words

_RIVALS = 2
_STANDS_OUT = 0.5
"""Share from which a cause is called the likeliest: below, fewer than half are right (watch.py)."""
_UNKNOWN = "look at robot, fixture and indicator"
_YOURS = "A test that is stopped early does not conform to ISO 9283"


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
        _YOURS,
    )


def _named(watched: Watched) -> str:
    name = words(watched.effect or "")
    if watched.share is None:
        return f"likeliest {name}"
    so_far = "likeliest so far" if watched.rivals else "likeliest"
    if watched.share < _STANDS_OUT:
        so_far = "too early for a cause:"
    return f"{so_far} {name} ({watched.share:.0%}){_others(watched)}"


def _others(watched: Watched) -> str:
    first = list((watched.rivals or {}).items())[:_RIVALS]
    return "".join(f" or {words(name)} ({share:.0%})" for name, share in first)
