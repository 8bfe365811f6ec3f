"""``python -m scara_iso`` is the command ``scara-iso``."""

from scara_iso.cli import run

run()
