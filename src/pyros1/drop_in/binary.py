"""Converts binary parameters to the form that programs written for stock expect."""

from __future__ import annotations

from typing import Any


def bytes_to_binary(value: Any) -> Any:
    """Return a parameter's value with `xmlrpc.client.Binary` instead of bytes, also inside lists and dicts.

    Args:
        value: pyros1's value, which is not modified. If it contains no bytes, the result may be the same object.
    """
    if isinstance(value, bytes):
        from xmlrpc.client import Binary  # noqa: PLC0415 - rarely needed

        return Binary(value)
    if isinstance(value, dict):
        return {key: bytes_to_binary(item) for key, item in value.items()}
    if isinstance(value, list):
        return [bytes_to_binary(item) for item in value]
    return value
