"""What is published of a result: its JSON object and its JSON Schema, both from its frozen class.

The fields of the class are the keys of the object. One whose default is None is left out where it
is None; every other is always there. The docstring below a field says what it means, and
``Annotated[float, ("unit", "mm"), ("minimum", 0)]`` adds keywords of JSON Schema to a type. What a
field's ``metadata`` may say: `INTERNAL`, `MERGED`, or ``published("its key", by=a function)``.
"""

from __future__ import annotations

import ast
import inspect
import json
import math
import re
import textwrap
from collections.abc import Callable, Iterator, Mapping
from dataclasses import Field, dataclass, fields, is_dataclass
from enum import Enum
from functools import cache
from itertools import pairwise
from types import NoneType, UnionType
from typing import (
    Annotated,
    Any,
    Literal,
    NamedTuple,
    TypeAlias,
    TypeVar,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

import numpy as np

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

_HALF = re.compile("[\ud800-\udfff]")
"""Half a character, as a byte of a file's name that is no text; strict readers refuse it."""
_AS = "published"


@dataclass(frozen=True, slots=True)
class _As:
    """How a field is published."""

    key: str = ""
    by: Callable[[Any], Any] | None = None
    always: bool | None = None
    merged: bool = False

    def is_always_there(self, field: Field[Any]) -> bool:
        """Whether the object has the key also where its value is None."""
        return field.default is not None if self.always is None else self.always


INTERNAL: Mapping[str, None] = {_AS: None}
"""Of a field that the object leaves out."""


def published(
    key: str = "",
    *,
    by: Callable[[Any], Any] | None = None,
    always: bool | None = None,
    merged: bool = False,
) -> Mapping[str, _As]:
    """Return the metadata of a field that has another key, or is what a function makes of it.

    The function's return annotation is then the type in the schema. ``always`` says
    whether the key is there where its value is None, whatever the default; ``merged`` as `MERGED`.
    """
    return {_AS: _As(key, by, always, merged)}


ALWAYS = published(always=True)
"""Of a field whose default is None and whose key is always there."""
MERGED = published(merged=True)
"""Of a field whose keys stand among those of the object that holds it; none where it is None."""


def publish(kind: type[Published], found: object, **given: Any) -> Published:
    """Return a class of what a result holds under the same names, and of ``given``."""
    names = [field.name for field in fields(kind) if field.init]  # type: ignore[arg-type]
    own = {name: getattr(found, name) for name in names if hasattr(found, name)}
    return kind(**own | given)


def fill(result: object, **values: object) -> None:
    """Set fields of a frozen result that follow from its others, in its ``__post_init__``."""
    for name, value in values.items():
        object.__setattr__(result, name, value)


def to_json(result: Any) -> Any:
    """Return a result as JSON has it."""
    if is_dataclass(result):
        return dict(_members(result))
    if isinstance(result, Mapping):
        return {key: to_json(one) for key, one in result.items()}
    if isinstance(result, tuple | list):
        return [to_json(one) for one in result]
    if isinstance(result, Enum):
        return result.value
    return result.tolist() if hasattr(result, "tolist") else result


def to_text(document: Mapping[str, Any]) -> str:
    r"""Return one line of JSON, all ASCII; NaN and infinity are a programming error.

    Half a character is spelt by its code, ``\udcff``, as wherever text is shown.
    """
    text = json.dumps(document, allow_nan=False)
    if "\\ud" in text:
        line = json.dumps(document, ensure_ascii=False)
        whole = _HALF.sub(lambda half: rf"\\u{ord(half[0]):04x}", line)
        text = json.dumps(json.loads(whole))
    return text


def _members(result: Any) -> Iterator[tuple[str, Any]]:
    for field, shown in _shown(result):
        value = getattr(result, field.name)
        value = value if shown.by is None else shown.by(value)
        if shown.merged:
            yield from () if value is None else _members(value)
        elif value is not None or shown.is_always_there(field):
            yield shown.key or field.name, to_json(value)


def _shown(kind: Any) -> Iterator[tuple[Field[Any], _As]]:
    """Yield the fields of a class that are published, and how."""
    for field in fields(kind):
        shown = field.metadata.get(_AS, _As())
        if shown is not None:
            yield field, shown


def row_of(result: Any) -> Json:
    """Return the published texts and numbers of a result as a row of a table: NaN where None.

    An interval stands as its ends (``RP_low`` and ``RP_high`` of ``RP_interval``), a mapping as its
    values (``RP_X``), names in one text. What holds more than that is left out.
    """
    found: Json = {}
    for name, value in to_json(result).items():
        if name.endswith("interval"):
            ends = (name.removesuffix("interval") + end for end in ("low", "high"))
            found |= zip(ends, value or (math.nan, math.nan), strict=True)
        elif isinstance(value, dict):
            found |= {f"{name}_{key}": one for key, one in row_of(value).items()}
        elif not isinstance(value, list):
            found[name] = math.nan if value is None else value
        elif all(isinstance(one, str) for one in value):
            found[name] = ", ".join(value)
    return found


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
    for field, shown in _shown(kind):
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
