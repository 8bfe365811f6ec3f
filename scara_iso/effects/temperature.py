"""Thermal growth: in proportion to a recorded temperature, centred on its mean."""

from scara_iso.effects import Parameter, proportional

EFFECT = proportional(
    name="temperature",
    of="temperature*",
    recorded="T: the recorded temperature",
    size=Parameter("size", "α", "reading/°C", "change per degree"),
    cause="thermal growth of links, base, fixture or indicator stand",
    confirm_by="hold the temperature constant, or heat one part on purpose: the reading must "
    "follow with the same coefficient",
)
