"""Read-only views of objects, for userdata that a state declares as input but not as output."""

from __future__ import annotations

import copy
import operator
from collections.abc import Callable
from enum import Enum
from pathlib import PurePath
from types import BuiltinFunctionType, FunctionType, MethodType, ModuleType
from typing import Any

from smach.log import logerr

_VALUES = (str, bytes, int, float, complex, tuple, list, dict, set, frozenset)
_PLAIN_TYPES = (*_VALUES, Enum, PurePath, type, ModuleType, FunctionType, BuiltinFunctionType, BaseException)


def get_const(obj: Any) -> Any:
    """Return a read-only view of an object; plain values, messages and functions are returned unchanged."""
    if isinstance(obj, MethodType):
        owner = get_const(obj.__self__)
        return obj if owner is obj.__self__ else MethodType(obj.__func__, owner)
    if isinstance(obj, _PLAIN_TYPES) or type(obj) is Const or not hasattr(obj, "__dict__") or hasattr(obj, "_md5sum"):
        return obj
    return Const(obj)


class Const:
    """A view of an object; the object's methods work as long as they set no attributes.

    Setting or deleting an attribute or an item raises TypeError.
    """

    __slots__ = ("_object",)

    def __init__(self, obj: Any) -> None:
        object.__setattr__(self, "_object", obj)

    @property
    def __class__(self) -> type:  # so that isinstance() sees the class of the object
        return type(object.__getattribute__(self, "_object"))

    @__class__.setter
    def __class__(self, value: type) -> None:
        raise TypeError("the class of a value that was only declared as input cannot be changed")

    def __getattr__(self, name: str) -> Any:
        value = getattr(object.__getattribute__(self, "_object"), name)
        if isinstance(value, MethodType) and value.__self__ is object.__getattribute__(self, "_object"):
            return MethodType(value.__func__, self)
        return get_const(value)

    def __setattr__(self, name: str, value: Any) -> None:
        _raise_read_only(name)

    def __delattr__(self, name: str) -> None:
        _raise_read_only(name)

    def __setitem__(self, key: Any, value: Any) -> None:
        _raise_read_only(key)

    def __delitem__(self, key: Any) -> None:
        _raise_read_only(key)

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        return object.__getattribute__(self, "_object")(*args, **kwargs)

    def __copy__(self) -> Any:
        return copy.copy(object.__getattribute__(self, "_object"))

    def __deepcopy__(self, memo: dict[int, Any]) -> Any:
        return copy.deepcopy(object.__getattribute__(self, "_object"), memo)

    def __reduce_ex__(self, protocol: Any) -> Any:
        return object.__getattribute__(self, "_object").__reduce_ex__(protocol)


def _raise_read_only(name: Any) -> None:
    text = f"Attempting to set '{name}' but this member is read-only: declare its key as input and output."
    logerr(text)
    raise TypeError(text)


def _make_read_only_operator(function: Callable[..., Any]) -> Callable[..., Any]:
    def call(self: Any, *args: Any) -> Any:
        return get_const(function(object.__getattribute__(self, "_object"), *args))

    return call


# Python looks up special methods in the class, without calling __getattr__.
for _function in (len, iter, repr, str, hash, bool, int, float):
    setattr(Const, f"__{_function.__name__}__", _make_read_only_operator(_function))
for _name in ("getitem", "contains", "eq", "ne", "lt", "le", "gt", "ge", "add", "sub", "mul", "truediv", "neg"):
    setattr(Const, f"__{_name}__", _make_read_only_operator(getattr(operator, _name)))

__all__ = ["Const", "get_const"]
