"""What is published of a result: its JSON object and its JSON Schema, both from one frozen class.

A published class is a standard frozen dataclass. Its fields are the keys of the object. A field
without a default is always there; one with a default is left out where it holds it. The docstring
below a field says what it means, and ``Annotated[float, ("unit", "mm"), ("minimum", 0)]`` adds
keywords of JSON Schema to a type.
"""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from itertools import pairwise
from types import NoneType, UnionType
from typing import (
    Annotated,
    Any,
    Literal,
    TypeAlias,
    TypeVar,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

Json: TypeAlias = dict[str, Any]
Published = TypeVar("Published")

Size: TypeAlias = Annotated[float, ("minimum", 0)]
"""A number that has no sign."""
Count: TypeAlias = Annotated[int, ("minimum", 0)]
Interval: TypeAlias = tuple[float, float]
Unit: TypeAlias = Literal["mm", "deg"]


def publish(kind: type[Published], found: object, **given: Any) -> Published:
    """Return a published class of what a result holds under the same names, and of ``given``."""
    return kind(**{
        field.name: given[field.name] if field.name in given else getattr(found, field.name)
        for field in fields(kind)  # type: ignore[arg-type]
    })  # fmt: skip


def to_json(result: Any) -> Any:
    """Return a result as JSON has it: a field that holds its default is left out."""
    if is_dataclass(result):
        held = [(field, getattr(result, field.name)) for field in fields(result)]
        return {field.name: to_json(one) for field, one in held if one is not field.default}
    if isinstance(result, Mapping):
        return {key: to_json(one) for key, one in result.items()}
    if isinstance(result, tuple | list):
        return [to_json(one) for one in result]
    if isinstance(result, Enum):
        return result.value
    return result.tolist() if hasattr(result, "tolist") else result


def schema(title: str, *kinds: type[Any]) -> Json:
    """Return the JSON Schema of an object of one of these classes; every object is closed."""
    import msgspec.json  # noqa: PLC0415 - for the pages, in no run

    found, components = msgspec.json.schema_components(
        kinds, schema_hook=_of_array, ref_template="#/$defs/{name}"
    )
    for kind in _reached(kinds):
        _complete(components[kind.__name__], kind)
    whole = found[0] if len(found) == 1 else {"oneOf": list(found)}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": title, **whole, "$defs": dict(sorted(components.items())),
    }  # fmt: skip


def _of_array(kind: type[Any]) -> Json:
    """Return the schema of an array of numbers."""
    if kind.__module__ != "numpy":
        raise NotImplementedError(kind)
    return {"type": "array", "items": {"type": "number"}}


def _complete(found: Json, kind: type[Any]) -> None:
    """Close the object of a class, and add what its fields say beside their types."""
    found["additionalProperties"] = False
    said, hints = _said(kind), get_type_hints(kind, include_extras=True)
    for name, one in found["properties"].items():
        if "default" in one:  # then it is left out, and never null
            del one["default"]
            _without_null(one)
        _add_keywords(one, hints[name])
        if len(one.get("enum", ())) == 1:
            one["const"] = one.pop("enum")[0]
        if name in said:
            one["description"] = said[name]


def _without_null(found: Json) -> None:
    kinds = [kind for kind in found.pop("anyOf", []) if kind != {"type": "null"}]
    found |= kinds[0] if len(kinds) == 1 else {"anyOf": kinds} if kinds else {}


def _add_keywords(found: Json, hint: Any) -> None:
    """Add the keywords of a type, of those that it may be, and of what it contains."""
    found |= dict(getattr(hint, "__metadata__", ()))
    bare = hint.__origin__ if hasattr(hint, "__metadata__") else hint
    kinds = [one for one in get_args(bare) if one not in (NoneType, Ellipsis)]
    if get_origin(bare) is Mapping and get_origin(kinds[0]) is Literal:
        found["propertyNames"] = {"enum": list(get_args(kinds[0]))}
    if get_origin(bare) in (Union, UnionType):
        within = [one for one in found.get("anyOf", [found]) if one != {"type": "null"}]
    else:
        held = [found.get("items"), found.get("additionalProperties")]
        within = found.get("prefixItems") or [one for one in held if isinstance(one, dict)]
    for one, kind in zip(within, kinds[len(kinds) - len(within) :], strict=True):
        _add_keywords(one, kind)


def _reached(kinds: tuple[Any, ...]) -> set[type[Any]]:
    """Return the classes among types, and those of their fields."""
    found: set[type[Any]] = set()
    for kind in kinds:
        if inspect.isclass(kind) and is_dataclass(kind):
            found |= {kind, *_reached(tuple(get_type_hints(kind).values()))}
        else:
            found |= _reached(get_args(kind))
    return found


def _said(kind: type[Any]) -> dict[str, str]:
    """Return the docstrings below the fields of a class and of its bases."""
    found: dict[str, str] = {}
    for one in reversed([base for base in kind.__mro__ if is_dataclass(base)]):
        body = ast.parse(textwrap.dedent(inspect.getsource(one))).body[0].body  # type: ignore[attr-defined]
        for field, below in pairwise(body):
            match field, below:
                case ast.AnnAssign(target=ast.Name(name)), ast.Expr(ast.Constant(str(text))):
                    found[name] = " ".join(text.replace("``", "`").split())
    return found
