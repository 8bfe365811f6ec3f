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
from dataclasses import MISSING, fields, is_dataclass
from enum import Enum
from itertools import pairwise
from types import UnionType
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
Probability: TypeAlias = Annotated[float, ("minimum", 0), ("maximum", 1)]
Count: TypeAlias = Annotated[int, ("minimum", 0)]
Interval: TypeAlias = tuple[float, float]
Unit: TypeAlias = Literal["mm", "deg"]
_TYPES = {
    "float": "number",
    "float64": "number",
    "int": "integer",
    "int64": "integer",
    "str": "string",
    "bool": "boolean",
    "NoneType": "null",
}


def publish(kind: type[Published], found: object, **given: Any) -> Published:
    """Return a published class of what a result holds under the same names, and of ``given``."""
    return kind(
        **{
            field.name: given[field.name] if field.name in given else getattr(found, field.name)
            for field in fields(kind)  # type: ignore[arg-type]
        }
    )


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


def schema(title: str, *kinds: Any) -> Json:
    """Return the JSON Schema of an object of one of these classes; every object is closed."""
    found = [_of(kind) for kind in kinds]
    whole = found[0] if len(found) == 1 else {"oneOf": found}
    held = sorted(_reached(kinds), key=lambda kind: kind.__name__)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": title,
        **whole,
        "$defs": {kind.__name__: _defined(kind) for kind in held},
    }


def _of(hint: Any) -> Json:
    """Return the schema of a type."""
    origin, within = get_origin(hint), get_args(hint)
    if origin is None:
        held = is_dataclass(hint) or issubclass(hint, Enum)
        name = hint.__name__
        return {"$ref": f"#/$defs/{name}"} if held else {"type": _TYPES[name]}
    if origin is Annotated:
        return _of(within[0]) | dict(within[1:])
    if origin in (Union, UnionType):
        return {"anyOf": [_of(one) for one in within]}
    if origin is Literal:
        return {"enum": sorted(within, key=str)} if len(within) > 1 else {"const": within[0]}
    return _container(origin, within)


def _container(kind: Any, held: tuple[Any, ...]) -> Json:
    """Return the schema of a mapping, of a tuple of any length or of these types, of an array."""
    if kind is Mapping:
        named = {} if held[0] is str else {"propertyNames": _of(held[0])}
        return {"type": "object", **named, "additionalProperties": _of(held[1])}
    if kind is not tuple:
        return {"type": "array", "items": _of(get_args(held[1])[0])}
    if held[-1] is Ellipsis:
        return {"type": "array", "items": _of(held[0])}
    items, n = [_of(one) for one in held], len(held)
    return {"type": "array", "minItems": n, "maxItems": n, "prefixItems": items, "items": False}


def _defined(kind: type[Any]) -> Json:
    """Return the schema of an enumeration, or of a class with what is said of its fields."""
    head = {"title": kind.__name__, "description": inspect.getdoc(kind)}
    if issubclass(kind, Enum):
        return {**head, "enum": sorted(one.value for one in kind)}
    hints, said = get_type_hints(kind, include_extras=True), _said(kind)
    always = {field.name: field.default is MISSING for field in fields(kind)}
    found = {
        name: {
            **(_of(hints[name]) if there else _never_null(hints[name])),
            **({"description": said[name]} if name in said else {}),
        }
        for name, there in always.items()
    }
    return {
        **head,
        "type": "object",
        "properties": found,
        "required": [name for name, there in always.items() if there],
        "additionalProperties": False,
    }


def _never_null(hint: Any) -> Json:
    """Return the schema of a field that is left out where it is None."""
    found = _of(hint)
    kinds = [kind for kind in found.pop("anyOf", []) if kind != {"type": "null"}]
    return found | (kinds[0] if len(kinds) == 1 else {"anyOf": kinds} if kinds else {})


def _reached(kinds: tuple[Any, ...]) -> set[type[Any]]:
    """Return the classes and enumerations among types, and those of their fields."""
    found: set[type[Any]] = set()
    for kind in kinds:
        if inspect.isclass(kind) and is_dataclass(kind):
            found |= {kind, *_reached(tuple(get_type_hints(kind).values()))}
        elif inspect.isclass(kind) and issubclass(kind, Enum):
            found.add(kind)
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
