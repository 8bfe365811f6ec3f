"""Tables that hide an effect, made by other equations than those of the catalogue.

Each module holds one physical cause; `FAMILIES` lists them with the names that say what happened.
A table is written and read like a technician's file, which says nothing of the effect.
"""

from undeclared.family import FAMILIES, OUTCOMES, Family, outcome

__all__ = ["FAMILIES", "OUTCOMES", "Family", "outcome"]
