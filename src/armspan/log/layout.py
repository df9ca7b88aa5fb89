"""What writer and reader agree on: topics, the header's place, the schema of each record type."""

from functools import cache
from inspect import cleandoc
from typing import Any, TypeAlias

import msgspec

from armspan.records import EVENTS, OUTPUTS, Record

HEADER = "armspan"
"""Name of the Metadata record that holds a session's header."""

MAGIC = b"\x89MCAP0\r\n"
"""The first bytes of every log."""

TOPICS = "/armspan/"
"""What the topics of all record types begin with."""

TYPES: dict[str, type[Record]] = {kind.__name__: kind for kind in (*EVENTS, *OUTPUTS)}
"""The record types of this version by name."""

_Schema: TypeAlias = dict[str, Any]


@cache
def schema_of(kind: type[Record]) -> bytes:
    """JSON Schema of a record type, in the form that MCAP viewers can take.

    Foxglove Studio and Lichtblick drop a whole channel unless its schema is an object at the top and each
    property has one plain ``type``, with plain items where it is an array. So references are resolved, an
    array of equal items says so, a property that may be null is described by what it is otherwise and marked
    ``nullable``, and an array of arrays is left out (it is in the messages all the same).
    """
    schema = msgspec.json.schema(kind)["$defs"][kind.__name__]
    fields = {name: _viewable(field) for name, field in schema["properties"].items()}
    schema["properties"] = {name: field for name, field in fields.items() if field is not None}
    # Python 3.13 strips the indent of docstrings by itself, older ones do not: the bytes shall be the same.
    schema["description"] = cleandoc(schema["description"])
    return msgspec.json.encode(schema)


def _viewable(field: _Schema) -> _Schema | None:
    if "anyOf" in field:
        plain = _viewable(next(kind for kind in field["anyOf"] if kind != {"type": "null"}))
        return None if plain is None else plain | {"nullable": True}
    if "enum" in field:
        return {"type": "string"} | field
    if "prefixItems" in field:
        kept = {name: value for name, value in field.items() if name != "prefixItems"}
        field = kept | {"items": field["prefixItems"][0]}
    nested = field["type"] == "array" and field["items"]["type"] == "array"
    return None if nested else field
