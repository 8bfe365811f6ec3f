"""Names of the code as a reader says them."""


def words(name: str) -> str:
    """Return an effect's or a verdict's name in words: ``warm_up`` is ``warm up``."""
    return name.replace("_", " ").replace("-", " ")
