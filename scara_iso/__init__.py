"""ISO 9283 repeatability of SCARA robots from digital dial indicators."""

__version__ = "0.1.0"
