"""Which effect it is, and what else it could be."""
