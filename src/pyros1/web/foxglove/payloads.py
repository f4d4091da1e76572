"""Converts messages to and from the encodings that viewers use (no I/O, except for finding definitions)."""

from __future__ import annotations

import json
from typing import Any

from pyros1.ground.errors import LengthError, MessageError, UnknownTypeError
from pyros1.ground.timing import Time
from pyros1.msgs import DefinitionCache, Message, load_message
from pyros1.msgs.json_form import from_json, to_json
from pyros1.web.client_json import loads
from pyros1.web.foxglove.frames import ENCODINGS
from pyros1.web.foxglove.requests import ClientChannel, FrameError


def type_name(channel: ClientChannel) -> str:
    """Return the ROS 1 name of the type of a viewer's channel; some viewers write ``package/msg/Type``."""
    return channel.type.replace("/msg/", "/", 1)


def message_class(channel: ClientChannel) -> type[Message]:
    """Return the message class of a viewer's channel, made from the channel's definition if the type is not installed.

    Raises:
        MessageError: there is no definition, or it is invalid.
    """
    name = type_name(channel)
    try:
        return load_message(name)
    except UnknownTypeError:
        if not channel.schema:
            raise
        return DefinitionCache().get(name, "*", channel.schema)


def check_encoding(encoding: str) -> None:
    """Check that an encoding is supported.

    Raises:
        FrameError: the encoding is not supported.
    """
    if encoding not in ENCODINGS:
        raise FrameError(f"messages must be encoded as {' or '.join(ENCODINGS)}, not as {encoding[:100]!r}")


def decode(cls: type[Message], encoding: str, payload: bytes, now: Time) -> Message:
    """Return the message in a payload from a viewer.

    Args:
        cls: the message's class.
        encoding: one of `ENCODINGS`.
        payload: the encoded message.
        now: the time that replaces the word ``now`` in JSON.

    Raises:
        MessageError: the payload is not a message of this class in this encoding.
    """
    if encoding == "ros1":
        try:
            message: Message = cls._decode(payload, 0, len(payload), True)
        except LengthError as error:
            if error.surplus < 0:
                raise
            message = cls._decode(payload, 0, len(payload))  # trailing bytes are ignored, as in stock ROS
        return message
    try:
        value = loads(payload)
    except ValueError:
        raise MessageError("the message is not JSON") from None
    try:
        return from_json(cls, value, now)
    except MessageError:
        converted = _with_ros_times(value)
        if converted == value:
            raise
        return from_json(cls, converted, now)


def encode(message: Message, encoding: str) -> bytes:
    """Return a message as a payload for viewers, in one of the `ENCODINGS`.

    Raises:
        MessageError: a value does not fit its field.
    """
    if encoding == "ros1":
        return bytes(type(message)._encode(message))
    return json.dumps(_with_viewer_times(to_json(message)), allow_nan=False, separators=(",", ":")).encode()


def _with_viewer_times(value: Any) -> Any:
    """Return a value in which the fields of times are renamed to sec and nsec, as viewers expect."""
    if isinstance(value, list):
        return [_with_viewer_times(each) for each in value]
    if not isinstance(value, dict):
        return value
    if {*value} == {"secs", "nsecs"}:
        return {"sec": value["secs"], "nsec": value["nsecs"]}
    return {name: _with_viewer_times(each) for name, each in value.items()}


def _with_ros_times(value: Any) -> Any:
    """Return a value in which the fields of times have their ROS 1 names: secs and nsecs."""
    if isinstance(value, list):
        return [_with_ros_times(each) for each in value]
    if not isinstance(value, dict):
        return value
    if {*value} in ({"sec", "nsec"}, {"sec", "nanosec"}):
        return {"secs": value["sec"], "nsecs": value.get("nsec", value.get("nanosec"))}
    return {name: _with_ros_times(each) for name, each in value.items()}
