"""Effects of a user's own: from a file of their own, and from a model that defines them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from scara_iso.effects import OwnEffect, find_effects, find_gear_effects, own_effects
from scara_iso.errors import DataError
from scara_iso.files import read_toml
from scara_iso.toml_keys import KeyFaults, only

_KEY = "effect"


def read_effects(path: str | Path) -> tuple[OwnEffect, ...]:
    """Return the effects that a TOML file defines; docs/diagnosis.md gives its keys.

    Raises `NoInputError` for a file that cannot be read and `DataError` with every fault, each
    named by its key.
    """
    document = read_toml(path, "examples/my_effects.toml")
    faults = KeyFaults()
    only(document, {_KEY}, "file", faults)
    found = tuple(own_effects(document.get(_KEY, []), _KEY, _taken(), faults))
    if not document.get(_KEY):
        faults.add(_KEY, "missing: one [[effect]] for each, with name and formula")
    if faults:
        raise DataError(
            f"the effects cannot be read: {len(faults)} fault{'s' if len(faults) > 1 else ''}",
            where=str(path),
            remedy="docs/diagnosis.md shows such a file",
            faults=faults,
        )
    return found


def all_own(
    entries: object, given: Sequence[OwnEffect], faults: KeyFaults
) -> tuple[OwnEffect, ...]:
    """Return the effects ``given`` and those that the ``definition`` tables of a model define.

    One that stands in both must be the same.
    """
    defined = own_effects(entries, "definition", _taken(), faults)
    known: dict[str, OwnEffect] = {one.name: one for one in given}
    for one in defined:
        if one.name in known and dict(known[one.name].definition) != dict(one.definition):
            faults.add(f"definition {one.name}", "differs from the effect of that name beside it")
        known.setdefault(one.name, one)
    return tuple(known.values())


def _taken() -> set[str]:
    return {e.name for e in find_effects()} | {e.name for e in find_gear_effects()} | {"unknown"}
