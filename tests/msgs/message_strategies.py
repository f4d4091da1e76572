"""Hypothesis strategies for messages of any class."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hypothesis import strategies as st

from pyros1.ground.timing import Duration, Time
from pyros1.msgs import Message
from pyros1.msgs.base import nested_classes

_INTS = {"int8": (-(2**7), 2**7 - 1), "uint8": (0, 2**8 - 1), "int16": (-(2**15), 2**15 - 1), "uint16": (0, 2**16 - 1)}
_INTS |= {"int32": (-(2**31), 2**31 - 1), "uint32": (0, 2**32 - 1), "int64": (-(2**63), 2**63 - 1)}
_INTS |= {"uint64": (0, 2**64 - 1)}
_INTS |= {"byte": _INTS["int8"], "char": _INTS["uint8"]}


def values(base: str, classes: Mapping[str, type[Message]]) -> st.SearchStrategy[Any]:
    """Values of a single field of the type, in the form that decoding gives."""
    if base in _INTS:
        return st.integers(*_INTS[base])
    simple: dict[str, Any] = {
        "bool": st.booleans(),
        "float32": st.floats(width=32, allow_nan=False),
        "float64": st.floats(allow_nan=False),
        "string": st.text(st.characters(exclude_categories=["Cs"]), max_size=20),
        "time": st.builds(Time, st.integers(0, 2**32 - 1), st.integers(0, 10**9 - 1)),
        "duration": st.builds(Duration, st.integers(-(2**31), 2**31 - 1), st.integers(0, 10**9 - 1)),
    }
    return simple[base] if base in simple else messages(classes[base])


def fields(slot_type: str, classes: Mapping[str, type[Message]]) -> st.SearchStrategy[Any]:
    """Values of a field, arrays included."""
    base, bracket, count = slot_type.partition("[")
    if not bracket:
        return values(base, classes)
    low, high = (0, 4) if count == "]" else (int(count[:-1]),) * 2
    if base in ("uint8", "char"):
        return st.binary(min_size=low, max_size=max(high, low))
    items = st.lists(values(base, classes), min_size=low, max_size=high)
    return items.map(tuple) if base in _INTS or base.startswith("float") else items


def messages(cls: type[Message]) -> st.SearchStrategy[Any]:
    """Messages of a class."""
    classes = nested_classes(cls)
    return st.tuples(*(fields(slot_type, classes) for slot_type in cls._slot_types)).map(lambda all_: cls(*all_))
