"""The diagnoses of several tables, or of the poses of one."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scara_iso.base.display import Displayed
from scara_iso.diagnosis import Diagnosis
from scara_iso.reporting import Failure
from scara_iso.run import frame_of

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False, slots=True)
class Diagnoses(Displayed):
    """Several diagnoses, found by number or by name: ``found[0]``, ``found["P1"]``."""

    names: tuple[str, ...]
    """File of each table, or label of each pose."""
    found: tuple[Diagnosis | Failure, ...]
    """In that order; a `Failure` where a table could not be diagnosed."""

    def __len__(self) -> int:
        return len(self.found)

    def __iter__(self) -> Iterator[Diagnosis | Failure]:
        return iter(self.found)

    def __getitem__(self, at: int | str) -> Diagnosis | Failure:
        if not isinstance(at, str):
            return self.found[at]
        if at not in self.names:
            raise KeyError(f"no diagnosis of {at!r}: there is {', '.join(self.names)}")
        return self.found[self.names.index(at)]

    def __repr__(self) -> str:
        said = (one.verdict.value if isinstance(one, Diagnosis) else "failed" for one in self)
        counts = ", ".join(f"{count} {word}" for word, count in Counter(said).items())
        return f"<Diagnoses of {len(self)}: {counts}>"

    def to_frame(self) -> pd.DataFrame:
        """Return a pandas table, a row for each: name, verdict, effects, p_value, failure."""
        return frame_of([_row(*one) for one in zip(self.names, self.found, strict=True)], {})


def _row(name: str, found: Diagnosis | Failure) -> dict[str, Any]:
    if isinstance(found, Failure):
        return {
            "name": name,
            "verdict": None,
            "effects": "",
            "p_value": float("nan"),
            "failure": found.message,
        }
    effects = ", ".join(effect.effect for effect in found.effects)
    return {
        "name": name,
        "verdict": found.verdict.value,
        "effects": effects,
        "p_value": found.p_value,
        "failure": None,
    }
