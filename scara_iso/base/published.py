"""What is published of a result: its JSON object, from its frozen class, as is its JSON Schema.

The fields of the class are the keys of the object. One whose default is None is left out where it
is None; every other is always there. The docstring below a field says what it means, and
``Annotated[float, ("unit", "mm"), ("minimum", 0)]`` adds keywords of JSON Schema to a type. What a
field's ``metadata`` may say: `INTERNAL`, `MERGED`, or ``published("its key", by=a function)``.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import Field, dataclass, fields, is_dataclass
from enum import Enum
from typing import (
    Annotated,
    Any,
    Literal,
    TypeAlias,
    TypeVar,
)

Json: TypeAlias = dict[str, Any]
Published = TypeVar("Published")

Size: TypeAlias = Annotated[float, ("minimum", 0)]
"""A number that has no sign."""
Probability: TypeAlias = Annotated[float, ("minimum", 0), ("maximum", 1)]
Count: TypeAlias = Annotated[int, ("minimum", 0)]
Interval: TypeAlias = tuple[float, float]
Unit: TypeAlias = Literal["mm", "deg"]
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
    for field, shown in shown_fields(result):
        value = getattr(result, field.name)
        value = value if shown.by is None else shown.by(value)
        if shown.merged:
            yield from () if value is None else _members(value)
        elif value is not None or shown.is_always_there(field):
            yield shown.key or field.name, to_json(value)


def shown_fields(kind: Any) -> Iterator[tuple[Field[Any], _As]]:
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
