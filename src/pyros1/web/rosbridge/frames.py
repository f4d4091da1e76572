"""Creates the WebSocket frames sent to clients (no I/O)."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import Any

from pyros1.web.rosbridge import png
from pyros1.web.rosbridge.operations import BridgeError, Id

_encode = json.JSONEncoder(ensure_ascii=True, allow_nan=False, separators=(",", ":")).encode


def to_json(value: Any) -> str:
    """Return a value as JSON, with null for NaN and infinity."""
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


def to_cbor(value: Any) -> bytes:
    """Return a value as CBOR.

    Raises:
        BridgeError: cbor2 is not installed.
    """
    return bytes(_cbor().dumps(value))


def with_cbor_tag(tag: int, data: bytes) -> Any:
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


def compress_and_split(frame: str, compression: str, fragment_size: int | None, id: str) -> Iterator[str]:
    """Yield a frame in the form that the client has requested: unchanged, as a PNG image, or in fragments.

    Args:
        frame: a JSON document.
        compression: ``png`` for a PNG image; any other value for none.
        fragment_size: maximum number of characters per fragment; None to send the frame in one piece.
        id: the id for the fragments.

    Raises:
        BridgeError: Pillow is not installed.
    """
    if compression == "png":
        frame = to_json({"op": "png", "data": png.pack(frame)})
    if fragment_size is None or len(frame) <= fragment_size:
        yield frame
        return
    total = -(-len(frame) // fragment_size)
    for number in range(total):
        data = frame[number * fragment_size : (number + 1) * fragment_size]
        yield to_json({"op": "fragment", "id": id, "data": data, "num": number, "total": total})
