"""Encodes userdata for messages, compatibly with other programs that use smach, but without running their code.

Userdata is a pickled dictionary (protocol 2) in base64. A pickle can name any function for the reader to call, so only
plain values are read: numbers, text, bytes, and lists, tuples, sets and dictionaries of them.
"""

from __future__ import annotations

import base64
import binascii
import io
import pickle
import pickletools
from typing import Any


class _PlainUnpickler(pickle.Unpickler):
    def find_class(self, module_name: str, global_name: str) -> Any:
        match module_name, global_name:  # protocol 2 encodes sets and bytes as function calls
            case (("__builtin__" | "builtins"), "set"):
                return set
            case (("__builtin__" | "builtins"), "frozenset"):
                return frozenset
            case (("__builtin__" | "builtins"), "bytes"):
                return lambda: b""
            case "_codecs", "encode":
                return lambda text, _: str(text).encode("latin-1")
        raise pickle.UnpicklingError(f"{module_name}.{global_name} is not a plain value")


def encode(values: dict[str, Any]) -> str:
    """Return userdata as text; values that cannot be pickled are left out."""
    try:
        data = pickle.dumps(values, 2)
    except Exception:  # noqa: BLE001  classes refuse pickling with any exception
        data = pickle.dumps({key: value for key, value in values.items() if _is_picklable(value)}, 2)
    return base64.b64encode(data).decode()


def _is_picklable(value: Any) -> bool:
    try:
        pickle.dumps(value, 2)
    except Exception:  # noqa: BLE001  classes refuse pickling with any exception
        return False
    return True


def decode(text: str) -> dict[str, Any]:
    """Return the userdata of a message.

    Raises:
        ValueError: the text is not userdata, or contains more than plain values.
    """
    if not text:
        return {}
    try:
        data = base64.b64decode(text, validate=True)
    except (binascii.Error, ValueError):
        data = text.encode("latin-1", "replace")  # older senders do not use base64
    try:
        _check_safety(data)
        values = _PlainUnpickler(io.BytesIO(data)).load()
    except Exception as error:  # a broken pickle can raise nearly any exception
        raise ValueError(f"cannot read userdata: {error}") from error
    if not isinstance(values, dict) or not all(isinstance(key, str) for key in values):
        raise ValueError("cannot read userdata: not a dictionary of names")
    return values


def _check_safety(data: bytes) -> None:
    """Reject pickles that would harm the reader even though they contain no classes.

    The memo uses memory up to its highest index. Keys are hashed: very deeply nested tuples crash Python, and if each
    tuple contains the next one twice, the time doubles with each level.
    """
    stack: list[tuple[int, int] | None] = []  # depth and size of each value; None for a mark
    memo: dict[int, tuple[int, int] | None] = {}
    for op, arg, _ in pickletools.genops(data):
        if "PUT" in op.name or op.name == "MEMOIZE":
            index = int(arg or 0) if "PUT" in op.name else len(memo)
            if index > len(data):
                raise ValueError("not userdata")
            memo[index] = stack[-1]
        elif "GET" in op.name:
            stack.append(memo[int(arg or 0)])
        elif op.name == "DUP":
            stack.append(stack[-1])
        elif op.name == "MARK":
            stack.append(None)
        else:
            parts = []
            before = op.stack_before
            if pickletools.markobject in before or (op.name == "POP" and stack[-1] is None):
                while (part := stack.pop()) is not None:
                    parts.append(part)
                before = before[: before.index(pickletools.markobject)] if op.name != "POP" else []
            parts += [part for part in (stack.pop() for _ in before) if part is not None]
            depth = 1 + max((deep for deep, _ in parts), default=0)
            size = 1 + sum(size for _, size in parts)
            if op.name in _HASHED and (depth > _MAX_DEPTH or size > max(len(data), _MAX_SIZE)):
                raise ValueError("nested too deeply, or the same value is repeated too often")
            stack += [(depth, size)] * len(op.stack_after)


_HASHED = ("TUPLE", "TUPLE1", "TUPLE2", "TUPLE3", "FROZENSET")
_MAX_DEPTH = 500
_MAX_SIZE = 1_000_000

__all__ = ["decode", "encode"]
