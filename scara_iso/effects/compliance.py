"""Deflection in proportion to the payload. Gravity loads Z of a SCARA, not X and Y."""

from scara_iso.effects import Parameter, proportional

EFFECT = proportional(
    name="compliance",
    of="payload_kg",
    size=Parameter("size", "c", "reading/kg", "deflection per kilogram"),
    cause="joints, links and bearings yield under the payload; expected in Z, where gravity acts",
    confirm_by="a static load test: hang known weights at the tool and read the deflection",
)
