"""Whether this program gives, on this machine, the figures that others computed or certified.

`data` holds the references: NIST's certified sets, recorded streams, tables with figures that were
summed up elsewhere. One module compares one kind of them; `validate` runs them all.
"""

from typing import TYPE_CHECKING

from scara_iso.base.faces import face

if TYPE_CHECKING:
    from scara_iso.validation.published import (
        PublishedValidation as PublishedValidation,
        published_validation as published_validation,
    )
    from scara_iso.validation.result import (
        Installation as Installation,
        ReferenceCheck as ReferenceCheck,
        Validation as Validation,
    )
    from scara_iso.validation.suite import validate as validate
else:
    __getattr__ = face(__name__)
