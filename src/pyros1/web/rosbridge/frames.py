"""Frames sent to clients. Pure."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import Any

from pyros1.web.rosbridge import picture
from pyros1.web.rosbridge.operations import BridgeError, Id

_encode = json.JSONEncoder(ensure_ascii=True, allow_nan=False, separators=(",", ":")).encode


def to_json(value: Any) -> str:
    """Return a value as JSON, with null for NaN and infinity."""
    try:
        return _encode(value)
    except ValueError:
        return _encode(_finite(value))


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {name: _finite(child) for name, child in value.items()}
    if isinstance(value, list):
        return [_finite(child) for child in value]
    return value


def to_cbor(value: Any) -> bytes:
    """Return a value as CBOR.

    Raises:
        BridgeError: cbor2 is not installed.
    """
    return bytes(_cbor().dumps(value))


def tagged(tag: int, data: bytes) -> Any:
    """Return bytes with a CBOR tag.

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
    """Return the response to a call, to be encoded."""
    return {"op": "service_response", **_id_field(id), "service": service, "values": values, "result": result}


def call(service: str, id: str, args: Any) -> str:
    """Return the frame that calls a service of the client."""
    return to_json({"op": "call_service", "id": id, "service": service, "args": args})


def _id_field(id: Id) -> dict[str, Any]:
    return {} if id is None else {"id": id}


def packed(frame: str, compression: str, fragment_size: int | None, id: str) -> Iterator[str]:
    """Yield a frame in the form that the client has requested, perhaps in several fragments.

    Args:
        frame: a JSON document.
        compression: ``png``, or any other value for none.
        fragment_size: maximum number of characters in each fragment; None for no fragments.
        id: the fragments' id, if there are several.

    Raises:
        BridgeError: Pillow is not installed.
    """
    if compression == "png":
        frame = to_json({"op": "png", "data": picture.pack(frame)})
    if fragment_size is None or len(frame) <= fragment_size:
        yield frame
        return
    total = -(-len(frame) // fragment_size)
    for number in range(total):
        data = frame[number * fragment_size : (number + 1) * fragment_size]
        yield to_json({"op": "fragment", "id": id, "data": data, "num": number, "total": total})
