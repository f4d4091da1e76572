"""Userdata in messages: as other programs of smach send and read it, but without running what they send.

It is a pickled dictionary (protocol 2) in base64. A pickle can name any function for the reader to call, so only plain
values are read: numbers, text, bytes, and lists, tuples, sets and dictionaries of them.
"""

from __future__ import annotations

import base64
import binascii
import io
import pickle
import pickletools
from typing import Any


class _Plain(pickle.Unpickler):
    def find_class(self, module_name: str, global_name: str) -> Any:
        raise pickle.UnpicklingError(f"{module_name}.{global_name} is not a plain value")


def encode(values: dict[str, Any]) -> str:
    """Return userdata as text; values that cannot be pickled are left out."""
    try:
        data = pickle.dumps(values, 2)
    except Exception:  # noqa: BLE001  any class may refuse, in its own way
        data = pickle.dumps({key: value for key, value in values.items() if _fits(value)}, 2)
    return base64.b64encode(data).decode()


def _fits(value: Any) -> bool:
    try:
        pickle.dumps(value, 2)
    except Exception:  # noqa: BLE001  as above
        return False
    return True


def decode(text: str) -> dict[str, Any]:
    """Return the userdata of a message.

    Raises:
        ValueError: it is not userdata, or has more than plain values.
    """
    if not text:
        return {}
    try:
        data = base64.b64decode(text, validate=True)
    except (binascii.Error, ValueError):
        data = text.encode("latin-1", "replace")  # older senders leave the base64 out
    try:
        # A place in the reader's memo costs memory up to that place.
        if any(isinstance(arg, int) and arg > len(data) for op, arg, _ in pickletools.genops(data) if "PUT" in op.name):
            raise ValueError("not userdata")
        values = _Plain(io.BytesIO(data)).load()
    except Exception as error:  # a broken pickle raises nearly anything
        raise ValueError(f"cannot read userdata: {error}") from error
    if not isinstance(values, dict) or not all(isinstance(key, str) for key in values):
        raise ValueError("cannot read userdata: not a dictionary of names")
    return values


__all__ = ["decode", "encode"]
