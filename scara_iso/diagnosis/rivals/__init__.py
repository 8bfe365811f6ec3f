"""Which cycles would tell rivals apart."""
