"""Checks of the arguments of a node's methods, with hints at what was probably meant."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import inf
from types import ModuleType
from typing import Any

from pyros1.ground.errors import InvalidNameError
from pyros1.msgs import AnyMsg, Message, Service, load_message, load_service
from pyros1.wire.handshake import TopicType

_EXAMPLE = {
    "message": 'pyros1.msgs.std_msgs.msg.String, or a type\'s name, such as "std_msgs/String"',
    "service": 'pyros1.msgs.std_srvs.srv.SetBool, or a type\'s name, such as "std_srvs/SetBool"',
}


def message_class(given: Any, call: str) -> Any:
    """Return the message class that an argument stands for.

    Args:
        given: a message class, AnyMsg, or the name of a type.
        call: the method and its arguments, for the error message.

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
    """Return the service class that an argument stands for; like `message_class`."""
    if isinstance(given, str):
        return load_service(given)
    if isinstance(given, type) and (issubclass(given, Service) or _is_generated(given)):
        return given
    raise TypeError(_no_type(given, call, "service"))


def _is_generated(given: Any) -> bool:
    """Return whether a class is a service's that genpy has generated, whose messages derive from our `Message`."""
    parts = (getattr(given, name, None) for name in ("_request_class", "_response_class"))
    return all(isinstance(part, type) and issubclass(part, Message) for part in parts)


def check_callback(given: Any, call: str, what: str, type_: Any = "") -> None:
    """Make sure that a callback can be called, and that it was not swapped with the type.

    Args:
        given: the callback.
        call: the method and its arguments, such as ``subscribe(topic, type, callback)``.
        what: the name of the callback there.
        type_: the type argument of the same call.

    Raises:
        TypeError: it is not a function.
    """
    if _is_type(given) and not _is_type(type_) and not isinstance(type_, str):
        raise TypeError(f"type and {what} are swapped: the order is {call}")
    if not callable(given) or _is_type(given):
        raise TypeError(f"{_name(call)}: {what} must be a function, not {_described(given)}: the order is {call}")


def check_name(given: Any, call: str) -> None:
    """Raise TypeError if a name is not a str, InvalidNameError if it is empty."""
    if not isinstance(given, str):
        raise TypeError(f"{_name(call)}: the name must be a str, not {_described(given)}: the order is {call}")
    if not given:
        raise InvalidNameError(f"{_name(call)}: the name is empty: the order is {call}")


def check_text(given: Any, what: str, none: bool = False) -> None:
    """Raise TypeError if the argument called ``what`` is not a str (or None, if ``none`` allows it)."""
    if not isinstance(given, str) and not (none and given is None):
        raise TypeError(f"{what} must be a str, not {_described(given)}")


def check_seconds(given: Any, what: str) -> None:
    """Make sure that the argument called ``what`` is a number of seconds.

    Raises:
        TypeError: it is not a number; a Duration is not one either.
        ValueError: it is nan.
    """
    if not _is_number(given):
        hint = "; use its to_sec()" if hasattr(given, "to_sec") else ""
        raise TypeError(f"{what} must be a number of seconds, not {_described(given)}{hint}")
    if given != given:  # noqa: PLR0124 - so is nan
        raise ValueError(f"{what} must be a number of seconds, not nan")


def check_timeout(given: Any) -> None:
    """Check a timeout like `check_seconds`, but allow None."""
    if given is not None:
        check_seconds(given, "timeout")


def check_raw_type(given: Any) -> None:
    """Raise TypeError if it is neither a TopicType, which a publisher of AnyMsg may give, nor None."""
    if given is not None and not isinstance(given, TopicType):
        raise TypeError(f"raw_type must be a TopicType(name, md5sum, definition), not {_described(given)}")


def check_positive(given: Any, what: str, unit: str, most: float = inf) -> None:
    """Make sure that the argument called ``what`` is a number above 0 and at most ``most``.

    Raises:
        TypeError: it is not a number.
        ValueError: it is not within these bounds.
    """
    if not _is_number(given):
        hint = "; use its to_sec()" if hasattr(given, "to_sec") else ""
        raise TypeError(f"{what} must be a number of {unit}, not {_described(given)}{hint}")
    if not 0 < given <= most:
        bounds = "above 0" if most == inf else f"above 0 and at most {most:g}"
        raise ValueError(f"{what} must be {bounds} {unit}, not {given}")


def check_headers(given: Any) -> None:
    """Raise TypeError if it is neither a mapping of str to str (more fields of a connection header) nor None."""
    if given is None:
        return
    if not isinstance(given, Mapping):
        raise TypeError(f'headers must be a dict of strings, such as {{"key": "value"}}, not {_described(given)}')
    for key, value in given.items():
        if not isinstance(key, str) or not isinstance(value, str):
            raise TypeError(f"headers must have strings as keys and values, not {key!r:.40}: {value!r:.40}")


def check_node(
    name: Any, namespace: Any, argv: Any, master_uri: Any, environ: Any, wait_for_master: Any, ports: Any
) -> list[str] | None:
    """Raise TypeError or ValueError if an argument of `Node` is wrong; return the words of argv, or None."""
    check_text(name, "Node: name")
    check_text(namespace, "Node: namespace", none=True)
    check_text(master_uri, "Node: master_uri", none=True)
    if environ is not None and not isinstance(environ, Mapping):
        raise TypeError(f"Node: environ must be a dict of environment variables, not {_described(environ)}")
    if wait_for_master is not None:
        check_seconds(wait_for_master, "Node: wait_for_master")
    _check_ports(ports)
    return None if argv is None else _words(argv)


def _check_ports(given: Any) -> None:
    what = "Node: ports must be two port numbers, 0 for any, such as (0, 40000)"
    if not isinstance(given, (tuple, list)) or len(given) != 2 or not all(isinstance(port, int) for port in given):
        raise TypeError(f"{what}, not {_described(given)}; for a range set PYROS1_PORTS, or __ports:= in argv")
    if not all(0 <= port < 65536 for port in given):
        raise OverflowError(f"{what}, not {given!r}: port must be 0-65535")  # which sockets raise, and so stock


def _words(given: Any) -> list[str]:
    if isinstance(given, (str, bytes)) or not isinstance(given, Iterable):
        raise TypeError(f'argv must be a list of strings, such as ["_rate:=10"], not {_described(given)}')
    words = list(given)
    for word in words:
        if not isinstance(word, str):
            raise TypeError(f"argv must hold only strings, not {_described(word)}")
    return words


def _is_number(given: Any) -> bool:
    return hasattr(type(given), "__float__")


def check_queue_size(given: Any, least: int) -> None:
    """Raise TypeError or ValueError if it is not a queue size: None, or a whole number of at least ``least``."""
    if given is None:
        return
    if not hasattr(type(given), "__index__"):  # numpy's integers have this method, too
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
        hint = f'it is from another library: give the name "{name}"'
    elif isinstance(given, Message):
        hint = f"it is a message: give its class, {name}"
    elif isinstance(given, ModuleType):
        hint = f"give a class of that module, or a type's name, such as {_EXAMPLE[kind].rpartition(' ')[2]}"
    return f"{_name(call)}: the type must be a {kind} type, not {_described(given)}; {hint}"
