"""What users hand to a node, checked where they hand it over, in words about what was probably meant."""

from __future__ import annotations

from types import ModuleType
from typing import Any

from pyros1.msgs import AnyMsg, Message, Service, load_message, load_service

_EXAMPLE = {
    "message": 'pyros1.msgs.std_msgs.msg.String, or a type\'s name, such as "std_msgs/String"',
    "service": 'pyros1.msgs.std_srvs.srv.SetBool, or a type\'s name, such as "std_srvs/SetBool"',
}


def message_class(given: Any, call: str) -> Any:
    """Return the message class that is meant.

    Args:
        given: a message class, AnyMsg, or a type's name.
        call: what was called, for the error's text.

    Raises:
        TypeError: it is none of these.
        UnknownTypeError: no definition of that name was found.
    """
    if isinstance(given, str):
        return load_message(given)
    if isinstance(given, type) and issubclass(given, (Message, AnyMsg)):
        return given
    raise TypeError(_no_type(given, call, "message"))


def service_class(given: Any, call: str) -> Any:
    """Return the service class that is meant; as `message_class`."""
    if isinstance(given, str):
        return load_service(given)
    if isinstance(given, type) and issubclass(given, Service):
        return given
    raise TypeError(_no_type(given, call, "service"))


def check_callback(given: Any, call: str, what: str, type_: Any = "") -> None:
    """Make sure that a callback can be called, and that it did not change places with the type.

    Args:
        given: the callback.
        call: what was called and how it is called, such as ``subscribe(topic, type, callback)``.
        what: what the callback is called there.
        type_: the type handed over with it.

    Raises:
        TypeError: it is none.
    """
    if _is_type(given) and not _is_type(type_) and not isinstance(type_, str):
        raise TypeError(f"type and {what} have changed places: the order is {call}")
    if not callable(given) or _is_type(given):
        raise TypeError(f"{_name(call)}: {what} must be a function, not {_described(given)}: the order is {call}")


def check_name(given: Any, call: str) -> None:
    """Raise TypeError if a name is no text."""
    if not isinstance(given, str):
        raise TypeError(f"{_name(call)}: the name must be a str, not {_described(given)}: the order is {call}")


def check_queue_size(given: Any, least: int) -> None:
    """Raise TypeError or ValueError if it is no size of a queue: None, or a number from ``least`` on."""
    if given is None:
        return
    if not isinstance(given, int):
        raise TypeError(f"queue_size must be a whole number or None, not {given!r}")
    if given < least:
        raise ValueError(f"queue_size must be at least {least}, or None, not {given}")


def _name(call: str) -> str:
    return call.partition("(")[0]


def _is_type(given: Any) -> bool:
    return isinstance(given, type) and issubclass(given, (Message, AnyMsg, Service))


def _described(given: Any) -> str:
    if isinstance(given, type):
        return f"the class {given.__name__}"
    if isinstance(given, ModuleType):
        return f"the module {given.__name__}"
    if callable(given) and hasattr(given, "__name__"):
        return f"the function {given.__name__}"
    return f"{given!r:.80}"


def _no_type(given: Any, call: str, kind: str) -> str:
    name = getattr(given, "_type", None)
    hint = f"give a class, such as {_EXAMPLE[kind]}"
    if isinstance(name, str) and _is_type(given):
        hint = f"[{name}] is a {'message' if kind == 'service' else 'service'}"
    elif isinstance(name, str) and isinstance(given, type) and hasattr(given, "_md5sum"):
        hint = f'it is of another library: give the name "{name}"'
    elif isinstance(given, Message):
        hint = f"it is a message: give its class, {name}"
    elif isinstance(given, ModuleType):
        hint = f"give a class of it, or a type's name, such as {_EXAMPLE[kind].rpartition(' ')[2]}"
    return f"{_name(call)}: the type must be a {kind} type, not {_described(given)}; {hint}"
