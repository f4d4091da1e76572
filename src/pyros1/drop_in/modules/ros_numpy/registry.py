"""Registry of converters by message type."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from pyros1.drop_in.module_attributes import module_getattr

_F = TypeVar("_F", bound=Callable[..., Any])

_to_numpy: dict[tuple[str, bool], Callable[..., Any]] = {}
_from_numpy: dict[tuple[str, bool], Callable[..., Any]] = {}

__getattr__ = module_getattr(__name__)


def converts_to_numpy(msgtype: Any, plural: bool = False) -> Callable[[_F], _F]:
    """Return a decorator for a function that converts a message to an array.

    Args:
        msgtype: the message's class.
        plural: whether the function takes a list of messages.
    """

    def register(function: _F) -> _F:
        _to_numpy[msgtype._type, plural] = function
        return function

    return register


def converts_from_numpy(msgtype: Any, plural: bool = False) -> Callable[[_F], _F]:
    """Return a decorator for a function that converts an array to a message; see `converts_to_numpy`."""

    def register(function: _F) -> _F:
        _from_numpy[msgtype._type, plural] = function
        return function

    return register


def numpify(msg: Any, *args: Any, **kwargs: Any) -> Any:
    """Convert a message, or a list of them, to an array.

    Args:
        msg: the message or the list.
        *args, **kwargs: further arguments of the function that converts it.

    Raises:
        ValueError: there is no such function, or the list is empty.
    """
    if msg is None:
        return None
    plural = isinstance(msg, (list, tuple))
    if plural and not msg:
        raise ValueError("Cannot determine the type of an empty Collection")
    type_name = (msg[0] if plural else msg)._type
    function = _to_numpy.get((type_name, plural))
    if function is None:
        supported_types = ", ".join(name + ("[]" if is_list else "") for name, is_list in _to_numpy)
        raise ValueError(
            f"Unable to convert message {type_name}{'[]' if plural else ''} - only supports {supported_types}"
        )
    return function(msg, *args, **kwargs)


def msgify(msg_type: Any, numpy_obj: Any, *args: Any, **kwargs: Any) -> Any:
    """Convert an array to a message.

    Args:
        msg_type: the message's class.
        numpy_obj: the array.
        *args, **kwargs: further arguments of the function that converts it.

    Raises:
        ValueError: there is no such function.
    """
    function = _from_numpy.get((msg_type._type, kwargs.pop("plural", False)))
    if function is None:
        supported_types = ", ".join(name + ("[]" if is_list else "") for name, is_list in _from_numpy)
        raise ValueError(f"Unable to build message {msg_type._type} - only supports {supported_types}")
    return function(numpy_obj, *args, **kwargs)
