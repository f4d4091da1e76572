"""Parses requests from viewers (no I/O)."""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pyros1.ground.errors import Error
from pyros1.web.client_json import loads

MAX_TEXT_LENGTH = 1 << 20
"""Maximum number of characters in a text frame."""
_MAX_ID = 1 << 32
_MAX_QUOTED_LENGTH = 100


class FrameError(Error):
    """A viewer has violated the protocol. The error message is sent to the viewer as a status."""


@dataclass(frozen=True)
class Subscribe:
    """Request to subscribe to channels. Each pair is the viewer's id of the subscription, and the channel's id."""

    pairs: tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class Unsubscribe:
    """Stop sending the messages of subscriptions, given by the viewer's ids."""

    subscriptions: tuple[int, ...]


@dataclass(frozen=True)
class ClientChannel:
    """A topic on which a viewer publishes.

    Attributes:
        id: the viewer's id of the channel.
        topic: the topic's name as the viewer wrote it.
        encoding: encoding of the messages, for example ``ros1``.
        type: the name of the message type as the viewer wrote it.
        schema: the type's definition; empty if the viewer did not send one.
    """

    id: int
    topic: str
    encoding: str
    type: str
    schema: str


@dataclass(frozen=True)
class ClientAdvertise:
    """The viewer will publish on further topics."""

    channels: tuple[ClientChannel, ...]


@dataclass(frozen=True)
class ClientUnadvertise:
    """The viewer stops publishing on the channels with these ids."""

    channels: tuple[int, ...]


@dataclass(frozen=True)
class ClientMessage:
    """Publish a message on one of the viewer's channels."""

    channel: int
    payload: bytes


@dataclass(frozen=True)
class CallService:
    """Call a service; ``service`` and ``call`` are ids."""

    service: int
    call: int
    encoding: str
    payload: bytes


@dataclass(frozen=True)
class GetParameters:
    """Send the values of the named parameters; without names, of all parameters."""

    names: tuple[str, ...]
    id: str | None


@dataclass(frozen=True)
class SetParameter:
    """A parameter's new value.

    Attributes:
        value: the value as JSON; ``None`` to delete the parameter.
        type: ``byte_array``, ``float64``, ``float64_array`` or empty.
    """

    name: str
    value: Any
    type: str


@dataclass(frozen=True)
class SetParameters:
    """Set or delete parameters; with an id, the new values are sent back."""

    parameters: tuple[SetParameter, ...]
    id: str | None


@dataclass(frozen=True)
class WatchParameters:
    """Report changes to the named parameters; without names, to all parameters that exist now."""

    names: tuple[str, ...]


@dataclass(frozen=True)
class UnwatchParameters:
    """Stop reporting changes to the named parameters; without names, to all parameters."""

    names: tuple[str, ...]


@dataclass(frozen=True)
class WatchGraph:
    """Report the publishers, subscribers and service providers, and changes to them."""


@dataclass(frozen=True)
class UnwatchGraph:
    """Stop reporting the publishers, subscribers and service providers."""


@dataclass(frozen=True)
class FetchAsset:
    """Send the file with a URI."""

    uri: str
    id: int


Request = (
    Subscribe
    | Unsubscribe
    | ClientAdvertise
    | ClientUnadvertise
    | ClientMessage
    | CallService
    | GetParameters
    | SetParameters
    | WatchParameters
    | UnwatchParameters
    | WatchGraph
    | UnwatchGraph
    | FetchAsset
)


def parse(frame: str | bytes) -> Request:
    """Parse a frame from a viewer, and return the request in it.

    Raises:
        FrameError: the frame is not a valid request.
    """
    return _parse_text(frame) if isinstance(frame, str) else _parse_bytes(frame)


def _parse_bytes(frame: bytes) -> Request:
    match frame[:1]:
        case b"\x01" if len(frame) >= 5:
            return ClientMessage(int.from_bytes(frame[1:5], "little"), frame[5:])
        case b"\x02" if len(frame) >= 13:
            service, call, length = struct.unpack_from("<III", frame, 1)
            if length > len(frame) - 13:
                raise FrameError("a service call is cut off")
            try:
                encoding = frame[13 : 13 + length].decode()
            except UnicodeDecodeError:
                raise FrameError("the encoding of a service call is not text") from None
            return CallService(service, call, encoding, frame[13 + length :])
        case b"\x01" | b"\x02":
            raise FrameError("a binary frame is cut off")
    raise FrameError(f"unknown binary frame {frame[:1].hex() or 'without an opcode'}")


def _parse_text(text: str) -> Request:
    if len(text) > MAX_TEXT_LENGTH:
        raise FrameError(f"a text frame must have at most {MAX_TEXT_LENGTH} characters")
    try:
        request = loads(text)
    except ValueError:
        raise FrameError("a text frame must be JSON") from None
    if not isinstance(request, dict) or not isinstance(request.get("op"), str):
        raise FrameError("a text frame must be a JSON object with a string 'op'")
    parser = _PARSERS.get(request["op"])
    if parser is None:
        raise FrameError(f"unknown op {request['op'][:_MAX_QUOTED_LENGTH]!r}")
    return parser(request)


def _subscribe(request: dict[str, Any]) -> Request:
    return Subscribe(tuple((_id(each, "id"), _id(each, "channelId")) for each in _objects(request, "subscriptions")))


def _advertise(request: dict[str, Any]) -> Request:
    return ClientAdvertise(
        tuple(
            ClientChannel(
                _id(each, "id"),
                _string(each, "topic"),
                _string(each, "encoding"),
                _string(each, "schemaName"),
                _string(each, "schema", ""),
            )
            for each in _objects(request, "channels")
        )
    )


def _set_parameters(request: dict[str, Any]) -> Request:
    parameters = (
        SetParameter(_string(each, "name"), each.get("value"), _string(each, "type", ""))
        for each in _objects(request, "parameters")
    )
    return SetParameters(tuple(parameters), _request_id(request))


_PARSERS: dict[str, Callable[[dict[str, Any]], Request]] = {
    "subscribe": _subscribe,
    "unsubscribe": lambda request: Unsubscribe(_ids(request, "subscriptionIds")),
    "advertise": _advertise,
    "unadvertise": lambda request: ClientUnadvertise(_ids(request, "channelIds")),
    "getParameters": lambda request: GetParameters(_strings(request, "parameterNames"), _request_id(request)),
    "setParameters": _set_parameters,
    "subscribeParameterUpdates": lambda request: WatchParameters(_strings(request, "parameterNames")),
    "unsubscribeParameterUpdates": lambda request: UnwatchParameters(_strings(request, "parameterNames")),
    "subscribeConnectionGraph": lambda request: WatchGraph(),
    "unsubscribeConnectionGraph": lambda request: UnwatchGraph(),
    "fetchAsset": lambda request: FetchAsset(_string(request, "uri"), _id(request, "requestId")),
}


def _list(request: dict[str, Any], name: str) -> list[Any]:
    value = request.get(name)
    if not isinstance(value, list):
        raise FrameError(f"{name} must be a list")
    return value


def _objects(request: dict[str, Any], name: str) -> list[dict[str, Any]]:
    values = _list(request, name)
    if not all(isinstance(each, dict) for each in values):
        raise FrameError(f"{name} must be a list of objects")
    return values


def _strings(request: dict[str, Any], name: str) -> tuple[str, ...]:
    values = _list(request, name)
    if not all(isinstance(each, str) for each in values):
        raise FrameError(f"{name} must be a list of strings")
    return tuple(values)


def _ids(request: dict[str, Any], name: str) -> tuple[int, ...]:
    values = _list(request, name)
    return tuple(_number(each, name) for each in values)


def _id(request: dict[str, Any], name: str) -> int:
    return _number(request.get(name), name)


def _number(value: Any, name: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < _MAX_ID:
        raise FrameError(f"{name} must be a number from 0 to {_MAX_ID - 1}")
    return value


def _string(request: dict[str, Any], name: str, default: str | None = None) -> str:
    value = request.get(name)
    if value is None and default is not None:
        return default
    if not isinstance(value, str):
        raise FrameError(f"{name} must be a string")
    return value


def _request_id(request: dict[str, Any]) -> str | None:
    value = request.get("id")
    if value is not None and not isinstance(value, str):
        raise FrameError("id must be a string")
    return value
