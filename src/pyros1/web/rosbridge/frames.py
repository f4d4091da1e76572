"""Creates the WebSocket frames sent to clients (no I/O)."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from functools import lru_cache
from itertools import groupby
from typing import Any

from pyros1.msgs import Message
from pyros1.web.rosbridge import png
from pyros1.web.rosbridge.json_text import write_message
from pyros1.web.rosbridge.operations import BridgeError, Id
from pyros1.web.server.sending import LargeFrame

_encode = json.JSONEncoder(ensure_ascii=True, allow_nan=False, separators=(",", ":")).encode

LARGE_BYTES = 16 << 10
"""Size in bytes above which data is not copied more often than necessary."""
_CBOR_BYTES, _CBOR_MAP, _CBOR_TAG = 2, 5, 6
"""Major types of CBOR."""


def to_json(value: Any) -> str:
    """Return a value as JSON, with null for NaN and infinity.

    Args:
        value: a JSON value, a message, or a dict whose values may be messages.
    """
    pieces: list[str | bytes] = []
    _write_json(value, pieces.append)
    return as_text(_text_frame(pieces))


def _write_json(value: Any, add: Callable[[str | bytes], object]) -> None:
    if isinstance(value, Message):
        write_message(value, add)
    elif isinstance(value, dict) and any(isinstance(child, Message) for child in value.values()):
        separator = "{"
        for name, child in value.items():
            add(f"{separator}{_encode(name)}:")
            _write_json(child, add)
            separator = ","
        add("}")
    else:
        add(_json_text(value))


def _json_text(value: Any) -> str:
    try:
        return _encode(value)
    except ValueError:
        return _encode(_replace_non_finite(value))


def _replace_non_finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {name: _replace_non_finite(child) for name, child in value.items()}
    if isinstance(value, list):
        return [_replace_non_finite(child) for child in value]
    return value


def publish(topic: str, message: Message) -> str | LargeFrame:
    """Return the frame with a message on a topic."""
    pieces: list[str | bytes] = [_start_of_publish(topic)]
    write_message(message, pieces.append)
    pieces.append("}")
    return _text_frame(pieces)


def _text_frame(pieces: list[str | bytes]) -> str | LargeFrame:
    if bytes not in map(type, pieces):
        return "".join(pieces)  # type: ignore[arg-type]  # they are strings
    encoded: list[bytes] = []
    for kind, run in groupby(pieces, type):
        same: list[Any] = list(run)
        encoded += same if kind is bytes else ("".join(same).encode("ascii"),)
    return LargeFrame(tuple(encoded), sum(map(len, encoded)), is_text=True)


def as_text(frame: str | LargeFrame) -> str:
    """Return a text frame as a string."""
    return frame if isinstance(frame, str) else str(b"".join(frame.pieces), "ascii")


@lru_cache(1000)
def _start_of_publish(topic: str) -> str:
    return f'{{"op":"publish","topic":{_encode(topic)},"msg":'


def to_cbor(value: Any) -> bytes:
    """Return a value as CBOR.

    Raises:
        BridgeError: cbor2 is not installed.
    """
    pieces: list[Any] = []
    _write_cbor(value, pieces, _cbor())
    return b"".join(pieces)


def publish_cbor(topic: str, message: dict[str, Any], size: int) -> bytes | LargeFrame:
    """Return the CBOR frame with a message on a topic.

    Args:
        topic: the topic's name.
        message: the message's value.
        size: total size in bytes of the data in the message.

    Raises:
        BridgeError: cbor2 is not installed.
    """
    cbor2 = _cbor()
    start = _start_of_publish_cbor(topic)
    if size <= LARGE_BYTES:
        encoded: bytes = cbor2.dumps(message)
        return start + encoded
    pieces: list[Any] = [start]
    _write_cbor(message, pieces, cbor2)
    return LargeFrame(tuple(pieces), sum(map(len, pieces)), is_text=False)


@lru_cache(1000)
def _start_of_publish_cbor(topic: str) -> bytes:
    names = [_cbor().dumps(each) for each in ("op", "publish", "topic", topic, "msg")]
    return b"".join((_cbor_head(_CBOR_MAP, 3), *names))


def _write_cbor(value: Any, pieces: list[Any], cbor2: Any) -> None:
    """Add the encoded value to ``pieces``. Large data is added without cbor2, which would copy it several times."""
    if isinstance(value, dict) and any(_contains_large_data(child) for child in value.values()):
        pieces.append(_cbor_head(_CBOR_MAP, len(value)))
        for name, child in value.items():
            pieces.append(cbor2.dumps(name))
            _write_cbor(child, pieces, cbor2)
    elif isinstance(value, cbor2.CBORTag) and _contains_large_data(value.value):
        pieces += (_cbor_head(_CBOR_TAG, value.tag), _cbor_head(_CBOR_BYTES, len(value.value)), value.value)
    elif _contains_large_data(value):
        pieces += (_cbor_head(_CBOR_BYTES, len(value)), value)
    else:
        pieces.append(cbor2.dumps(value))


def _contains_large_data(value: Any) -> bool:
    if isinstance(value, dict):
        return any(map(_contains_large_data, value.values()))
    data = getattr(value, "value", value)  # of a CBORTag
    return isinstance(data, (bytes, memoryview)) and len(data) > LARGE_BYTES


def _cbor_head(major_type: int, number: int) -> bytes:
    """Return the beginning of a data item (RFC 8949, section 3)."""
    if number < 24:
        return bytes((major_type << 5 | number,))
    size = next(size for size in (1, 2, 4, 8) if number < 1 << 8 * size)
    return bytes((major_type << 5 | 23 + size.bit_length(),)) + number.to_bytes(size, "big")


def with_cbor_tag(tag: int, data: bytes | memoryview) -> Any:
    """Return bytes with a CBOR tag, to be encoded by `to_cbor`.

    Raises:
        BridgeError: cbor2 is not installed.
    """
    return _cbor().CBORTag(tag, data)


def _cbor() -> Any:
    try:
        import cbor2  # noqa: PLC0415 - optional
    except ImportError:
        raise BridgeError("CBOR needs cbor2: pip install 'pyros1[web]'") from None
    return cbor2


def status(level: str, message: str, id: Id = None) -> str:
    """Return the frame with a status message."""
    return to_json({"op": "status", **_id_field(id), "level": level, "msg": message})


def response(service: str, id: Id, values: Any, result: bool) -> dict[str, Any]:
    """Return the response to a client's service call, not encoded yet."""
    return {"op": "service_response", **_id_field(id), "service": service, "values": values, "result": result}


def call(service: str, id: str, args: Any) -> str:
    """Return the frame that calls a service which the client provides."""
    return to_json({"op": "call_service", "id": id, "service": service, "args": args})


def _id_field(id: Id) -> dict[str, Any]:
    return {} if id is None else {"id": id}


def compress(frame: str, compression: str) -> str:
    """Return a frame in the form that the client has requested: as a PNG image, or unchanged.

    Args:
        frame: a JSON document.
        compression: ``png`` for a PNG image; any other value for none.
    """
    return f'{{"op":"png","data":"{png.pack(frame)}"}}' if compression == "png" else frame


def split(frame: str, fragment_size: int | None, id: str) -> Iterator[str]:
    """Yield a frame in fragments, if it is too large for the client.

    Args:
        frame: a JSON document.
        fragment_size: maximum number of characters per fragment; None to send the frame in one piece.
        id: the id for the fragments.
    """
    if fragment_size is None or len(frame) <= fragment_size:
        yield frame
        return
    total = -(-len(frame) // fragment_size)
    for number in range(total):
        data = frame[number * fragment_size : (number + 1) * fragment_size]
        yield to_json({"op": "fragment", "id": id, "data": data, "num": number, "total": total})
