"""Parses the requests of viewers (pure)."""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pyros1.ground.errors import Error
from pyros1.web.client_json import loads

MAX_TEXT = 1 << 20
"""Maximum number of characters in a text frame."""
_MAX_ID = 1 << 32
_MAX_QUOTED_LENGTH = 100


class FrameError(Error):
    """A viewer has violated the protocol. The error message is sent to the viewer as a status."""


@dataclass(frozen=True)
class Subscribe:
    """Send the messages of channels, given as pairs of the viewer's subscription id and the channel's id."""

    pairs: tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class Unsubscribe:
    """End subscriptions."""

    subscriptions: tuple[int, ...]


@dataclass(frozen=True)
class ClientChannel:
    """A topic on which a viewer publishes.

    Attributes:
        id: the viewer's id of the channel.
        topic: the name as written by the viewer.
        encoding: encoding of the messages, for example ``ros1``.
        type: the name of the message type.
        schema: the type's definition; empty if the viewer did not send one.
    """

    id: int
    topic: str
    encoding: str
    type: str
    schema: str


@dataclass(frozen=True)
class ClientAdvertise:
    """Publish on more topics."""

    channels: tuple[ClientChannel, ...]


@dataclass(frozen=True)
class ClientUnadvertise:
    """Stop publishing on some topics."""

    channels: tuple[int, ...]


@dataclass(frozen=True)
class ClientMessage:
    """Publish a message."""

    channel: int
    payload: bytes


@dataclass(frozen=True)
class CallService:
    """Call a service."""

    service: int
    call: int
    encoding: str
    payload: bytes


@dataclass(frozen=True)
class GetParameters:
    """Send the values of parameters; if there are no names, of all parameters."""

    names: tuple[str, ...]
    id: str | None


@dataclass(frozen=True)
class SetParameter:
    """A parameter's new value.

    Attributes:
        value: the value as JSON, ``None`` if the parameter is to be deleted.
        type: ``byte_array``, ``float64``, ``float64_array`` or empty.
    """

    name: str
    value: Any
    type: str


@dataclass(frozen=True)
class SetParameters:
    """Set parameters."""

    parameters: tuple[SetParameter, ...]
    id: str | None


@dataclass(frozen=True)
class WatchParameters:
    """Report changes of parameters; if there are no names, of all existing ones."""

    names: tuple[str, ...]


@dataclass(frozen=True)
class UnwatchParameters:
    """Stop reporting changes of parameters; if there are no names, of all."""

    names: tuple[str, ...]


@dataclass(frozen=True)
class WatchGraph:
    """Report the publishers, subscribers and service providers."""


@dataclass(frozen=True)
class UnwatchGraph:
    """Stop reporting the publishers, subscribers and service providers."""


@dataclass(frozen=True)
class FetchAsset:
    """Send a file."""

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
    """Return the request in a frame.

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
    if len(text) > MAX_TEXT:
        raise FrameError(f"a text frame must have at most {MAX_TEXT} characters")
    try:
        value = loads(text)
    except ValueError:
        raise FrameError("a text frame must be JSON") from None
    if not isinstance(value, dict) or not isinstance(value.get("op"), str):
        raise FrameError("a text frame must be a JSON object with a string 'op'")
    parser = _PARSERS.get(value["op"])
    if parser is None:
        raise FrameError(f"unknown op {value['op'][:_MAX_QUOTED_LENGTH]!r}")
    return parser(value)


def _subscribe(value: dict[str, Any]) -> Request:
    return Subscribe(tuple((_id(each, "id"), _id(each, "channelId")) for each in _objects(value, "subscriptions")))


def _advertise(value: dict[str, Any]) -> Request:
    return ClientAdvertise(
        tuple(
            ClientChannel(
                _id(each, "id"),
                _string(each, "topic"),
                _string(each, "encoding"),
                _string(each, "schemaName"),
                _string(each, "schema", ""),
            )
            for each in _objects(value, "channels")
        )
    )


def _set_parameters(value: dict[str, Any]) -> Request:
    found = (
        SetParameter(_string(each, "name"), each.get("value"), _string(each, "type", ""))
        for each in _objects(value, "parameters")
    )
    return SetParameters(tuple(found), _request_id(value))


_PARSERS: dict[str, Callable[[dict[str, Any]], Request]] = {
    "subscribe": _subscribe,
    "unsubscribe": lambda value: Unsubscribe(_ids(value, "subscriptionIds")),
    "advertise": _advertise,
    "unadvertise": lambda value: ClientUnadvertise(_ids(value, "channelIds")),
    "getParameters": lambda value: GetParameters(_strings(value, "parameterNames"), _request_id(value)),
    "setParameters": _set_parameters,
    "subscribeParameterUpdates": lambda value: WatchParameters(_strings(value, "parameterNames")),
    "unsubscribeParameterUpdates": lambda value: UnwatchParameters(_strings(value, "parameterNames")),
    "subscribeConnectionGraph": lambda value: WatchGraph(),
    "unsubscribeConnectionGraph": lambda value: UnwatchGraph(),
    "fetchAsset": lambda value: FetchAsset(_string(value, "uri"), _id(value, "requestId")),
}


def _list(value: dict[str, Any], name: str) -> list[Any]:
    found = value.get(name)
    if not isinstance(found, list):
        raise FrameError(f"{name} must be a list")
    return found


def _objects(value: dict[str, Any], name: str) -> list[dict[str, Any]]:
    found = _list(value, name)
    if not all(isinstance(each, dict) for each in found):
        raise FrameError(f"{name} must be a list of objects")
    return found


def _strings(value: dict[str, Any], name: str) -> tuple[str, ...]:
    found = _list(value, name)
    if not all(isinstance(each, str) for each in found):
        raise FrameError(f"{name} must be a list of strings")
    return tuple(found)


def _ids(value: dict[str, Any], name: str) -> tuple[int, ...]:
    found = _list(value, name)
    return tuple(_number(each, name) for each in found)


def _id(value: dict[str, Any], name: str) -> int:
    return _number(value.get(name), name)


def _number(value: Any, name: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < _MAX_ID:
        raise FrameError(f"{name} must be a number from 0 to {_MAX_ID - 1}")
    return value


def _string(value: dict[str, Any], name: str, default: str | None = None) -> str:
    found = value.get(name)
    if found is None and default is not None:
        return default
    if not isinstance(found, str):
        raise FrameError(f"{name} must be a string")
    return found


def _request_id(value: dict[str, Any]) -> str | None:
    found = value.get("id")
    if found is not None and not isinstance(found, str):
        raise FrameError("id must be a string")
    return found
