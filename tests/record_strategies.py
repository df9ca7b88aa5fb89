"""Hypothesis strategies for records, made from their annotations."""

from types import NoneType, UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from hypothesis import strategies as st

from armspan.records import EVENTS, OUTPUTS, Record

FINITE = st.floats(allow_nan=False, allow_infinity=False)
PLAIN: dict[Any, st.SearchStrategy[Any]] = {
    float: FINITE,
    int: st.integers(-(2**63), 2**63 - 1),
    bool: st.booleans(),
    str: st.text(max_size=8),
    NoneType: st.none(),
}


def values(kind: Any) -> st.SearchStrategy[Any]:
    if kind in PLAIN:
        return PLAIN[kind]
    origin, items = get_origin(kind), get_args(kind)
    if origin is Literal:
        return st.sampled_from(items)
    if origin in (Union, UnionType):
        return st.one_of(*map(values, items))
    assert origin is tuple, kind
    if items[-1] is Ellipsis:
        return st.lists(values(items[0]), max_size=4).map(tuple)
    return st.tuples(*map(values, items))


def records_of(kind: type[Record], **given: st.SearchStrategy[Any]) -> st.SearchStrategy[Record]:
    hints = get_type_hints(kind)
    return st.builds(kind, **{name: values(hints[name]) for name in kind.__struct_fields__} | given)


def records(**given: st.SearchStrategy[Any]) -> st.SearchStrategy[Record]:
    """Finite records of every type."""
    return st.one_of(*(records_of(kind, **given) for kind in (*EVENTS, *OUTPUTS)))
