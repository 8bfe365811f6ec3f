"""Results that never change: a dataclass whose methods are written once, not compiled per class.

The standard decorator writes six functions for each class and compiles them, which takes ten times
as long as to find the fields; a command that says ten lines would wait longer for it than for its
figures. In everything else it is the standard's: `fields`, `replace`, `match`, copies, pickles,
signatures, and what a type checker reads.
"""

from __future__ import annotations

import copyreg
import dataclasses
from types import MappingProxyType

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from dataclasses import dataclass as dataclass  # noqa: PLC0414 - shown to others
    from inspect import Signature
    from typing import Any

_MISSING = dataclasses.MISSING
_put = object.__setattr__  # a frozen class refuses its own


def _dataclass(
    *, frozen: bool, eq: bool = True, slots: bool = False
) -> Callable[[type[Any]], type[Any]]:
    """Return the decorator of a class none of whose bases is a dataclass."""

    def decorate(kind: type[Any]) -> type[Any]:
        made: Any = dataclasses.dataclass(init=False, repr=False, eq=False, slots=slots)(kind)
        made.__dataclass_params__.frozen = frozen
        made.__signature__ = _Signature()
        methods = {**_SHARED, "__init__": _init_of(made), **(_comparison_of(made) if eq else {})}
        for name, method in methods.items():
            if name not in vars(kind):
                setattr(made, name, method)
        return made  # type: ignore[no-any-return]

    return decorate


if not TYPE_CHECKING:
    dataclass = _dataclass


def _unchanging(shown: dict[Any, Any]) -> MappingProxyType[Any, Any]:
    return MappingProxyType(shown)


# So a mapping that never changes goes to another process too, as what it shows.
copyreg.pickle(MappingProxyType, lambda one: (_unchanging, (dict(one),)))


def _init_of(kind: type[Any]) -> Callable[..., None]:
    names = tuple(field.name for field in dataclasses.fields(kind))
    absent = {field.name: _default_of(field) for field in dataclasses.fields(kind)}
    finish = getattr(kind, "__post_init__", None)

    def init(self: object, *values: object, **named: object) -> None:
        given = {**dict(zip(names, values, strict=False)), **named}
        if len(given) < len(values) + len(named) or not given.keys() <= absent.keys():
            raise TypeError(f"{kind.__name__} takes each of {', '.join(names)} once")
        for name in names:
            _put(self, name, given[name] if name in given else absent[name]())
        if finish:
            finish(self)

    return init


def _default_of(field: dataclasses.Field[Any]) -> Callable[[], object]:
    """Return what gives the value of a field that none is given for."""
    default, factory = field.default, field.default_factory

    def stated() -> object:
        if default is _MISSING:
            raise TypeError(f"{field.name} is not given")
        return default

    return stated if factory is _MISSING else factory


def _comparison_of(kind: type[Any]) -> dict[str, Callable[..., Any]]:
    names = tuple(field.name for field in dataclasses.fields(kind) if field.compare)

    def compared(one: object) -> tuple[Any, ...]:
        return tuple(getattr(one, name) for name in names)

    def equal(one: object, other: object) -> bool:
        return compared(one) == compared(other) if type(one) is type(other) else NotImplemented

    return {"__eq__": equal, "__hash__": lambda one: hash(compared(one))}


class _Shared:
    """What every such class has."""

    def __repr__(self) -> str:
        shown = (f"{f.name}={getattr(self, f.name)!r}" for f in _fields(self) if f.repr)
        return f"{type(self).__qualname__}({', '.join(shown)})"

    def __setattr__(self, name: str, value: object) -> None:
        raise dataclasses.FrozenInstanceError(f"cannot assign to field {name!r}")

    def __delattr__(self, name: str) -> None:
        raise dataclasses.FrozenInstanceError(f"cannot delete field {name!r}")

    def __getstate__(self) -> list[Any]:
        return [getattr(self, field.name) for field in _fields(self)]

    def __setstate__(self, state: list[Any]) -> None:
        for field, value in zip(_fields(self), state, strict=True):
            _put(self, field.name, value)


_SHARED = {name: method for name, method in vars(_Shared).items() if callable(method)}


def _fields(one: Any) -> tuple[dataclasses.Field[Any], ...]:
    return dataclasses.fields(one)


class _Signature:
    """Is made where `help` asks for it."""

    def __get__(self, _: object, kind: type[Any]) -> Signature:
        from inspect import Parameter, Signature  # noqa: PLC0415 - no start of the program asks

        return Signature(
            [
                Parameter(
                    field.name, Parameter.POSITIONAL_OR_KEYWORD, annotation=field.type,
                    default=Parameter.empty if field.default is _MISSING else field.default,
                )
                for field in dataclasses.fields(kind)
            ]
        )  # fmt: skip
