"""A memory in front of a pure function: each diagnosis and picture is made once a session."""

import functools
import io
import pickle
from types import FunctionType, MappingProxyType

_KNOWN = {}


class _Arguments(pickle.Pickler):
    """Write arguments by their values: functions by name, views of dicts as dicts."""

    def reducer_override(self, value):
        if isinstance(value, MappingProxyType):
            return dict, (dict(value),)
        if isinstance(value, FunctionType):
            return str, (f"{value.__module__}.{value.__qualname__}",)
        return NotImplemented


def once(function):
    """Return ``function`` with a memory of its answers, by the values of its arguments."""

    @functools.wraps(function)
    def remembered(*args, **options):
        written = io.BytesIO()
        _Arguments(written).dump((function.__qualname__, args, sorted(options.items())))
        key = written.getvalue()
        if key not in _KNOWN:
            _KNOWN[key] = function(*args, **options)
        return _KNOWN[key]

    return remembered


def forget():
    """Let everything be computed anew, for a test that compares two computations."""
    _KNOWN.clear()
