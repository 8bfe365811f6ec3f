"""Every result of the package: it never changes, and arrays in it do not make `==` an array."""

import dataclasses
from importlib import import_module
from pkgutil import walk_packages

import pytest

import scara_iso


def dataclasses_of_the_package():
    names = [m.name for m in walk_packages(scara_iso.__path__, "scara_iso.")]
    for name in names:
        if name.endswith("__main__"):
            continue
        for kind in vars(import_module(name)).values():
            if (
                isinstance(kind, type)
                and dataclasses.is_dataclass(kind)
                and kind.__module__ == name
            ):
                yield kind


HOLD_STATE = {
    "Settings",
    "Stream",
    "_Frames",
    "_Sheet",
}  # what this call of the program was asked for; places in a file
KINDS = sorted(set(dataclasses_of_the_package()), key=lambda kind: kind.__qualname__)


def test_there_are_results_to_look_at():
    assert len(KINDS) > 100


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__qualname__)
def test_a_result_never_changes(kind):
    assert kind.__dataclass_params__.frozen == (kind.__name__ not in HOLD_STATE)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__qualname__)
def test_a_result_that_holds_arrays_is_compared_as_one_object(kind):
    types = [str(field.type) for field in dataclasses.fields(kind) if field.compare]
    if any("Array" in text and "Callable" not in text for text in types):
        assert kind.__eq__ is object.__eq__
