"""Numeric types of fields (https://wiki.ros.org/msg#Fields)."""

from __future__ import annotations

from pyros1.drop_in.module_attributes import module_getattr
from pyros1.msgs.spec import STRUCT_CODES

_TYPE_NAMES = "int8 uint8 bool int16 uint16 int32 uint32 int64 uint64 float32 float64 char byte"

SIMPLE_TYPES_DICT = {name: STRUCT_CODES[name] for name in _TYPE_NAMES.split()}
SIMPLE_TYPES = list(SIMPLE_TYPES_DICT)

__getattr__ = module_getattr(__name__)


def is_simple(type_: str) -> bool:
    """Return whether a type is a single number."""
    return type_ in SIMPLE_TYPES  # a list, so the value need not be hashable
