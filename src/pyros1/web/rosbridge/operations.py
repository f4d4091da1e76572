"""Parses the operations that clients request: JSON objects with a field ``op`` (no I/O).

See https://github.com/RobotWebTools/rosbridge_suite/blob/ros1/ROSBRIDGE_PROTOCOL.md.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from pyros1.ground.errors import Error

Id = str | int | None
COMPRESSIONS = ("none", "png", "cbor", "cbor-raw")
LEVELS = ("none", "error", "warning", "info")
MAX_CALL_SECONDS = 600.0
"""Maximum timeout in seconds for service calls."""
_MAX_NAME_LENGTH = 1000
_MIN_FRAGMENT_SIZE = 16
_MAX_NUMBER = 1 << 31


class BridgeError(Error):
    """A frame is not a valid operation, or the operation failed. The client receives the error message.

    Attributes:
        id: the operation's id; None if it is unknown.
    """

    def __init__(self, message: str, id: Id = None) -> None:
        super().__init__(message)
        self.id = id


@dataclass(frozen=True)
class Advertise:
    """The client will publish on a topic."""

    topic: str
    type: str
    latch: bool
    queue_size: int


@dataclass(frozen=True)
class Unadvertise:
    """Withdraw the client's advertisement of a topic. If the operation has an id, only the advertisement made with that
    id is withdrawn.
    """

    topic: str


@dataclass(frozen=True)
class Publish:
    """Publish a message, given as JSON. ``latch`` has no effect if the client has already advertised the topic."""

    topic: str
    message: Any
    latch: bool = False


@dataclass(frozen=True)
class Subscribe:
    """Send the messages on a topic to the client.

    Attributes:
        type: the expected message type; empty if any type will do.
        throttle: minimum number of seconds between two messages.
        queue_length: maximum number of queued messages; 0 for the default.
        fragment_size: maximum number of characters in a frame; None for no limit.
    """

    topic: str
    type: str
    throttle: float
    queue_length: int
    fragment_size: int | None
    compression: str
    key: Id


@dataclass(frozen=True)
class Unsubscribe:
    """End the client's subscription to a topic.

    Attributes:
        key: the id of the subscription; None to end all of the client's subscriptions to the topic.
    """

    topic: str
    key: Id


@dataclass(frozen=True)
class CallService:
    """Call a service. The timeout is in seconds."""

    service: str
    args: Any
    timeout: float
    fragment_size: int | None
    compression: str


@dataclass(frozen=True)
class AdvertiseService:
    """The client starts to provide a service."""

    service: str
    type: str


@dataclass(frozen=True)
class UnadvertiseService:
    """The client stops providing a service."""

    service: str


@dataclass(frozen=True)
class ServiceResponse:
    """The client responds to a call to a service that it provides; ``result`` is whether the call succeeded."""

    service: str
    values: Any
    result: bool


@dataclass(frozen=True)
class SetLevel:
    """Set the lowest severity of the status messages that the client wants to receive."""

    level: str


@dataclass(frozen=True)
class Part:
    """A fragment of a frame, or a PNG image that contains a frame."""

    op: str
    data: str
    number: int
    total: int


Action = (
    Advertise
    | Unadvertise
    | Publish
    | Subscribe
    | Unsubscribe
    | CallService
    | AdvertiseService
    | UnadvertiseService
    | ServiceResponse
    | SetLevel
)


def parse(frame: object) -> tuple[Id, Action | Part]:
    """Check a frame, and return the id of its operation, and the operation.

    Args:
        frame: the frame as a JSON value.

    Raises:
        BridgeError: the frame is not a valid operation.
    """
    if not isinstance(frame, dict):
        raise BridgeError("an operation must be a JSON object with a string 'op'")
    value = frame.get("id")
    id = value if isinstance(value, (str, int)) and not isinstance(value, bool) else None
    op = frame.get("op")
    if not isinstance(op, str):
        raise BridgeError("an operation must be a JSON object with a string 'op'", id)
    parser = _PARSERS.get(op)
    if parser is None:
        raise BridgeError(f"unknown operation {op[:50]!r}", id)
    try:
        return id, parser(frame, id)
    except BridgeError as error:
        raise BridgeError(f"{op}: {error}", id) from None


def _string(frame: Mapping[str, Any], name: str, default: str | None = None) -> str:
    value = frame.get(name)
    if value is None and default is not None:
        return default
    if not isinstance(value, str):
        raise BridgeError(f"{name} must be a string")
    return value


def _name(frame: Mapping[str, Any], name: str, default: str | None = None) -> str:
    value = _string(frame, name, default)
    if len(value) > _MAX_NAME_LENGTH or not value.isascii() or not (value or default is not None):
        raise BridgeError(f"{name} is not a valid name")
    return value


def _number(
    frame: Mapping[str, Any], name: str, default: float, minimum: float = 0, maximum: float = _MAX_NUMBER
) -> float:
    value = frame.get(name)
    if value is None:
        return default
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not minimum <= value <= maximum:
        raise BridgeError(f"{name} must be a number of at least {minimum:g}")
    return value


def _count(frame: Mapping[str, Any], name: str, default: int, minimum: int = 0) -> int:
    return int(_number(frame, name, default, minimum))


def _boolean(frame: Mapping[str, Any], name: str, default: bool) -> bool:
    value = frame.get(name)
    if value is None:
        return default
    if not isinstance(value, bool):
        raise BridgeError(f"{name} must be true or false")
    return value


def _choice(frame: Mapping[str, Any], name: str, choices: tuple[str, ...]) -> str:
    value = _string(frame, name, "none")
    if value not in choices:
        raise BridgeError(f"{name} must be one of {', '.join(choices)}")
    return value


def _fragment_size(frame: Mapping[str, Any]) -> int | None:
    if not frame.get("fragment_size"):
        return None
    return max(_MIN_FRAGMENT_SIZE, _count(frame, "fragment_size", 0))


def _call(frame: Mapping[str, Any], _: Id) -> CallService:
    timeout = _number(frame, "timeout", 0.0) or MAX_CALL_SECONDS
    compression = _choice(frame, "compression", COMPRESSIONS)
    return CallService(
        _name(frame, "service"), frame.get("args"), min(timeout, MAX_CALL_SECONDS), _fragment_size(frame), compression
    )


def _subscribe(frame: Mapping[str, Any], id: Id) -> Subscribe:
    return Subscribe(
        _name(frame, "topic"),
        _name(frame, "type", ""),
        _number(frame, "throttle_rate", 0) / 1000,
        _count(frame, "queue_length", 0),
        _fragment_size(frame),
        _choice(frame, "compression", COMPRESSIONS),
        id,
    )


def _auth(frame: Mapping[str, Any], _: Id) -> Action:
    raise BridgeError(
        "this server does not use rosauth; only `pyros1 web` needs a token, which is in the link that it prints: "
        "put it into the address, ws://HOST:PORT/?token=TOKEN"
    )


def _part(frame: Mapping[str, Any], id: Id) -> Part:
    total = _count(frame, "total", 1, 1)
    number = _count(frame, "num", 0)
    if total > 1 and id is None:
        raise BridgeError("fragments need an id")
    if number >= total:
        raise BridgeError(f"there is no fragment {number} of {total}")
    return Part(_string(frame, "op"), _string(frame, "data"), number, total)


_PARSERS: dict[str, Callable[[Mapping[str, Any], Id], Action | Part]] = {
    "advertise": lambda frame, _: Advertise(
        _name(frame, "topic"), _name(frame, "type"), _boolean(frame, "latch", False), _count(frame, "queue_size", 100)
    ),
    "unadvertise": lambda frame, _: Unadvertise(_name(frame, "topic")),
    "publish": lambda frame, _: Publish(_name(frame, "topic"), frame.get("msg"), _boolean(frame, "latch", False)),
    "subscribe": _subscribe,
    "unsubscribe": lambda frame, id: Unsubscribe(_name(frame, "topic"), id),
    "call_service": _call,
    "advertise_service": lambda frame, _: AdvertiseService(_name(frame, "service"), _name(frame, "type")),
    "unadvertise_service": lambda frame, _: UnadvertiseService(_name(frame, "service")),
    "service_response": lambda frame, _: ServiceResponse(
        _name(frame, "service"), frame.get("values"), _boolean(frame, "result", True)
    ),
    "set_level": lambda frame, _: SetLevel(_choice(frame, "level", LEVELS)),
    "auth": _auth,
    "fragment": _part,
    "png": _part,
}
