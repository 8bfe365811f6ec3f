"""All reference checks, group by group; one that cannot be made is one that is not met."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from types import MappingProxyType

from scara_iso.validation.diagnoses import diagnosis_checks
from scara_iso.validation.nist import nist_checks
from scara_iso.validation.printed import paper_checks
from scara_iso.validation.result import ReferenceCheck
from scara_iso.validation.rules import rule_checks
from scara_iso.validation.sizes import unit_checks
from scara_iso.validation.streams import stream_checks
from scara_iso.validation.vectors import vector_checks

Group = Callable[[], Iterable[ReferenceCheck]]

GROUPS: Mapping[str, Group] = MappingProxyType(
    {
        "paper": paper_checks,
        "NIST StRD": nist_checks,
        "units": unit_checks,
        "characteristics": vector_checks,
        "procedure": rule_checks,
        "streams": stream_checks,
        "diagnosis": diagnosis_checks,
    }
)


def validate(groups: Mapping[str, Group] = GROUPS) -> Iterator[ReferenceCheck]:
    """Yield every check of every group; an error ends its group and is itself a failed check."""
    for group, checks in groups.items():
        try:
            yield from checks()
        except Exception as error:  # noqa: BLE001 - whatever it is, the reference is not met
            said = f"{type(error).__name__}: {error}"
            yield ReferenceCheck(group, "the rest of this group", "", "no error", said)
