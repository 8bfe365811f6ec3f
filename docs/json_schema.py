"""The JSON Schema of what is published of a result: from its class, as scara_iso.base.published.

`docs/generate.py` writes docs/schemas and the pages with it.
"""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import is_dataclass
from enum import Enum
from functools import cache
from itertools import pairwise
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, NamedTuple, Union, get_args, get_origin, get_type_hints

import numpy as np

from scara_iso.base.published import Json, shown_fields

_TYPES = {
    "float": "number",
    "float64": "number",
    "int": "integer",
    "int64": "integer",
    "str": "string",
    "bool": "boolean",
    "NoneType": "null",
}


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
    if issubclass(kind, Mapping):
        named = {} if held[0] is str else {"propertyNames": _of(held[0])}
        return {"type": "object", **named, "additionalProperties": _of(held[1])}
    if kind is np.ndarray:
        return {"type": "array", "items": _of(get_args(held[1])[0])}
    if kind is not tuple or held[-1] is Ellipsis:
        return {"type": "array", "items": _of(held[0])}
    items, n = [_of(one) for one in held], len(held)
    return {"type": "array", "minItems": n, "maxItems": n, "prefixItems": items, "items": False}


def _defined(kind: type[Any]) -> Json:
    """Return the schema of an enumeration, or of a class with what is said of its fields."""
    head = {"title": kind.__name__, "description": inspect.getdoc(kind)}
    if issubclass(kind, Enum):
        return {**head, "enum": sorted(one.value for one in kind)}
    keys = {key.name: key for key in _keys(kind)}.values()  # the later of a name, as in `to_json`
    return {
        **head,
        "type": "object",
        "properties": {
            key.name: {
                **(_of(key.hint) if key.always else _never_null(key.hint)),
                **({"description": key.meaning} if key.meaning else {}),
            }
            for key in keys
        },
        "required": [key.name for key in keys if key.required],
        "additionalProperties": False,
    }


class _Key(NamedTuple):
    """A key of an object."""

    name: str
    hint: Any
    meaning: str
    always: bool
    """Its value may be None, if the type says so."""
    required: bool


def _keys(kind: type[Any]) -> Iterator[_Key]:
    """Yield the keys of the object of a class."""
    meanings = _docstrings(kind)  # type: ignore[arg-type] # a class is hashable
    for field, shown in shown_fields(kind):
        name = shown.key or field.name
        hint = _hint(kind, field.name) if shown.by is None else _hint(shown.by, "return")
        if shown.merged:
            kinds = [one for one in get_args(hint) or (hint,) if one is not NoneType]
            always = kinds == [hint]
            yield from (key._replace(required=key.required and always) for key in _keys(kinds[0]))
            continue
        always = shown.is_always_there(field)
        yield _Key(name, hint, meanings.get(field.name, ""), always, always)


def _hint(of: Any, name: str) -> Any:
    """Return the type of a field or of what a function returns; no other name need be known."""
    owner = next(one for one in getattr(of, "__mro__", (of,)) if name in one.__annotations__)
    alone = {"__annotations__": {name: owner.__annotations__[name]}, "__module__": owner.__module__}
    return get_type_hints(type(name, (), alone), include_extras=True)[name]


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
            found |= {kind, *_reached(tuple(key.hint for key in _keys(kind)))}
        elif inspect.isclass(kind) and issubclass(kind, Enum):
            found.add(kind)
        else:
            found |= _reached(get_args(kind))
    return found


@cache
def _docstrings(kind: type[Any]) -> Mapping[str, str]:
    """Return the docstrings below the fields of a class and of its bases."""
    found: dict[str, str] = {}
    for one in reversed([base for base in kind.__mro__ if is_dataclass(base)]):
        body = ast.parse(textwrap.dedent(inspect.getsource(one))).body[0].body  # type: ignore[attr-defined]
        for field, below in pairwise(body):
            match field, below:
                case ast.AnnAssign(target=ast.Name(name)), ast.Expr(ast.Constant(str(text))):
                    found[name] = " ".join(text.replace("``", "`").split())
    return found
