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


def message_class(argument: Any, call: str) -> Any:
    """Return the message class that an argument stands for.

    Args:
        argument: a message class, AnyMsg, or the name of a type.
        call: the method and its arguments, for the error message.

    Raises:
        TypeError: it is none of these.
        UnknownTypeError: no definition of that name was found.
    """
    if isinstance(argument, str):
        return load_message(argument)
    if isinstance(argument, type) and issubclass(argument, (Message, AnyMsg)):
        return argument
    raise TypeError(_missing_type_error(argument, call, "message"))


def service_class(argument: Any, call: str) -> Any:
    """Return the service class that an argument stands for; like `message_class`."""
    if isinstance(argument, str):
        return load_service(argument)
    if isinstance(argument, type) and (issubclass(argument, Service) or _is_generated(argument)):
        return argument
    raise TypeError(_missing_type_error(argument, call, "service"))


def _is_generated(argument: Any) -> bool:
    """Return whether a class is a service's that genpy has generated, whose messages derive from our `Message`."""
    parts = (getattr(argument, name, None) for name in ("_request_class", "_response_class"))
    return all(isinstance(part, type) and issubclass(part, Message) for part in parts)


def check_callback(argument: Any, call: str, what: str, type_: Any = "") -> None:
    """Make sure that a callback can be called, and that it was not swapped with the type.

    Args:
        argument: the callback.
        call: the method and its arguments, such as ``subscribe(topic, type, callback)``.
        what: the name of the callback there.
        type_: the type argument of the same call.

    Raises:
        TypeError: it is not a function.
    """
    if _is_type(argument) and not _is_type(type_) and not isinstance(type_, str):
        raise TypeError(f"type and {what} are swapped: the order is {call}")
    if not callable(argument) or _is_type(argument):
        raise TypeError(f"{_name(call)}: {what} must be a function, not {_description(argument)}: the order is {call}")


def check_name(argument: Any, call: str) -> None:
    """Raise TypeError if a name is not a str, InvalidNameError if it is empty."""
    if not isinstance(argument, str):
        raise TypeError(f"{_name(call)}: the name must be a str, not {_description(argument)}: the order is {call}")
    if not argument:
        raise InvalidNameError(f"{_name(call)}: the name is empty: the order is {call}")


def check_text(argument: Any, what: str, none: bool = False) -> None:
    """Raise TypeError if the argument called ``what`` is not a str (or None, if ``none`` allows it)."""
    if not isinstance(argument, str) and not (none and argument is None):
        raise TypeError(f"{what} must be a str, not {_description(argument)}")


def check_seconds(argument: Any, what: str) -> None:
    """Make sure that the argument called ``what`` is a number of seconds.

    Raises:
        TypeError: it is not a number; a Duration is not one either.
        ValueError: it is nan.
    """
    if not _is_number(argument):
        hint = "; use its to_sec()" if hasattr(argument, "to_sec") else ""
        raise TypeError(f"{what} must be a number of seconds, not {_description(argument)}{hint}")
    if argument != argument:  # noqa: PLR0124 - so is nan
        raise ValueError(f"{what} must be a number of seconds, not nan")


def check_timeout(argument: Any) -> None:
    """Check a timeout like `check_seconds`, but allow None."""
    if argument is not None:
        check_seconds(argument, "timeout")


def check_raw_type(argument: Any) -> None:
    """Raise TypeError if it is neither a TopicType, which a publisher of AnyMsg may give, nor None."""
    if argument is not None and not isinstance(argument, TopicType):
        raise TypeError(f"raw_type must be a TopicType(name, md5sum, definition), not {_description(argument)}")


def check_positive(argument: Any, what: str, unit: str, maximum: float = inf) -> None:
    """Make sure that the argument called ``what`` is a number above 0 and at most ``maximum``.

    Raises:
        TypeError: it is not a number.
        ValueError: it is not within these bounds.
    """
    if not _is_number(argument):
        hint = "; use its to_sec()" if hasattr(argument, "to_sec") else ""
        raise TypeError(f"{what} must be a number of {unit}, not {_description(argument)}{hint}")
    if not 0 < argument <= maximum:
        bounds = "above 0" if maximum == inf else f"above 0 and at most {maximum:g}"
        raise ValueError(f"{what} must be {bounds} {unit}, not {argument}")


def check_headers(argument: Any) -> None:
    """Raise TypeError if it is neither a mapping of str to str (more fields of a connection header) nor None."""
    if argument is None:
        return
    if not isinstance(argument, Mapping):
        raise TypeError(f'headers must be a dict of strings, such as {{"key": "value"}}, not {_description(argument)}')
    for key, value in argument.items():
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
        raise TypeError(f"Node: environ must be a dict of environment variables, not {_description(environ)}")
    if wait_for_master is not None:
        check_seconds(wait_for_master, "Node: wait_for_master")
    _check_ports(ports)
    return None if argv is None else _words(argv)


def _check_ports(argument: Any) -> None:
    what = "Node: ports must be two port numbers, 0 for any, such as (0, 40000)"
    if (
        not isinstance(argument, (tuple, list))
        or len(argument) != 2
        or not all(isinstance(port, int) for port in argument)
    ):
        raise TypeError(f"{what}, not {_description(argument)}; for a range set PYROS1_PORTS, or __ports:= in argv")
    if not all(0 <= port < 65536 for port in argument):
        raise OverflowError(f"{what}, not {argument!r}: port must be 0-65535")  # which sockets raise, and so stock


def _words(argument: Any) -> list[str]:
    if isinstance(argument, (str, bytes)) or not isinstance(argument, Iterable):
        raise TypeError(f'argv must be a list of strings, such as ["_rate:=10"], not {_description(argument)}')
    words = list(argument)
    for word in words:
        if not isinstance(word, str):
            raise TypeError(f"argv must hold only strings, not {_description(word)}")
    return words


def _is_number(argument: Any) -> bool:
    return hasattr(type(argument), "__float__")


def check_queue_size(argument: Any, minimum: int) -> None:
    """Raise TypeError or ValueError if it is not a queue size: None, or a whole number of at least ``minimum``."""
    if argument is None:
        return
    if not hasattr(type(argument), "__index__"):  # numpy's integers have this method, too
        raise TypeError(f"queue_size must be a whole number or None, not {argument!r}")
    if argument < minimum:
        raise ValueError(f"queue_size must be at least {minimum}, or None, not {argument}")


def _name(call: str) -> str:
    return call.partition("(")[0]


def _is_type(argument: Any) -> bool:
    return isinstance(argument, type) and issubclass(argument, (Message, AnyMsg, Service))


def _description(argument: Any) -> str:
    if isinstance(argument, type):
        return f"the class {argument.__name__}"
    if isinstance(argument, ModuleType):
        return f"the module {argument.__name__}"
    if callable(argument) and hasattr(argument, "__name__"):
        return f"the function {argument.__name__}"
    return f"{argument!r:.80}"


def _missing_type_error(argument: Any, call: str, kind: str) -> str:
    name = getattr(argument, "_type", None)
    hint = f"give a class, such as {_EXAMPLE[kind]}"
    if isinstance(name, str) and _is_type(argument):
        hint = f"[{name}] is a {'message' if kind == 'service' else 'service'}"
    elif isinstance(name, str) and isinstance(argument, type) and hasattr(argument, "_md5sum"):
        hint = f'it is from another library: give the name "{name}"'
    elif isinstance(argument, Message):
        hint = f"it is a message: give its class, {name}"
    elif isinstance(argument, ModuleType):
        hint = f"give a class of that module, or a type's name, such as {_EXAMPLE[kind].rpartition(' ')[2]}"
    return f"{_name(call)}: the type must be a {kind} type, not {_description(argument)}; {hint}"
