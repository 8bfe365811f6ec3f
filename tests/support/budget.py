"""How many examples a property is tried on: a share by profile of what its test asks for."""

from hypothesis import settings

WHOLE = 100


def examples(count, **options):
    """Return settings of that many examples in the profile `whole`, and of fewer in a quick one."""
    return settings(max_examples=max(5, count * settings.default.max_examples // WHOLE), **options)
