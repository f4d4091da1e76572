"""Fills messages with plain values, as ``rostopic pub`` and ``rosservice call`` do with YAML arguments (G26)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pyros1.ground.errors import MessageError
from pyros1.ground.timing import Duration, Time, TVal
from pyros1.msgs.base import Message, message_class
from pyros1.msgs.spec import HEADER_TYPE


def fill_message(message: Any, args: Any, now: Time | None = None, keys: Mapping[str, Any] | None = None) -> None:
    """Set a message's fields to plain values.

    Args:
        message: the message or time to fill; fields that are not given keep their values.
        args: a list with one value for each field in order, or a dict of field names to values, or a list that contains
            one such dict. A nested message is again a list or dict. A time is a number of nanoseconds, ``[secs,
            nsecs]``, or a dict. The string ``now`` stands for the current time; the string ``auto`` in place of a
            header stands for a header with that time.
        now: the current time; None if the strings ``now`` and ``auto`` are not accepted.
        keys: string -> the time or message that it stands for.

    Raises:
        MessageError: a value does not fit its field; the message names the field.
    """
    if isinstance(args, dict):
        args = [args]
    _Filler(now, keys or {}).fill(message, [] if args is None else args, "")


class _Filler:
    def __init__(self, now: Time | None, keys: Mapping[str, Any]) -> None:
        self.now = now
        self.keys = keys

    def fill(self, target: Any, args: Any, prefix: str) -> None:
        """Fill a message or a time: ``args`` is a dict, a list with one dict, or a list of all values."""
        if isinstance(args, (list, tuple)) and len(args) == 1 and isinstance(args[0], dict):
            args = args[0]
        types = {"secs": "", "nsecs": ""}
        if not isinstance(target, TVal):
            cls = message_class(type(target))
            types = dict(zip(cls.__slots__, cls._slot_types, strict=True))
        if isinstance(args, dict):
            for name, value in args.items():
                if name not in types:
                    raise MessageError(f"No field name [{prefix}{name}]")
                self.set_field(target, name, types[name], "" if value is None else value, prefix)
        elif isinstance(args, (list, tuple)):
            if len(args) != len(types):
                amount = "Too many" if len(args) > len(types) else "Not enough"
                raise MessageError(f"{amount} arguments:\n * Given: {list(args)}\n * Expected: {list(types)}")
            for (name, slot_type), value in zip(types.items(), args, strict=True):
                self.set_field(target, name, slot_type, value, prefix)
        else:
            raise MessageError(f"invalid msg_args type: {args}")
        if isinstance(target, TVal):
            self._normalise(target, prefix)

    def set_field(self, target: Any, name: str, slot_type: str, value: Any, prefix: str) -> None:
        """Set one field of ``target``."""
        if isinstance(target, TVal):
            if type(value) is not int:
                raise MessageError(f"Field [{prefix}{name}] must be an integer instead of: {type(value).__name__}")
            setattr(target, name, value)
            return
        cls = message_class(type(target))
        base, bracket, count = slot_type.partition("[")
        path = prefix + name
        if bracket:
            setattr(target, name, self._make_array(cls, base, count, value, path))
        elif base in cls._classes or base in ("time", "duration"):
            setattr(target, name, self._make_object(cls, base, value, getattr(target, name), path))
        else:
            setattr(target, name, value)

    def _make_array(self, cls: type[Message], base: str, count: str, value: Any, path: str) -> Any:
        if base in ("uint8", "char") and isinstance(value, (str, bytes)):
            return value
        if not isinstance(value, (list, tuple)):
            raise MessageError(f"Field [{path}] must be a list or tuple instead of: {type(value).__name__}")
        if count != "]" and len(value) != int(count[:-1]):
            raise MessageError(f"Field [{path}] has incorrect number of elements: {len(value)} != {count[:-1]}")
        if base not in cls._classes and base not in ("time", "duration"):
            return value
        return [self._make_object(cls, base, item, None, path) for item in value]

    def _make_object(self, cls: type[Message], base: str, value: Any, current: Any, path: str) -> Any:
        """Return a time or message with the values in ``value``: ``current``, or a new object if ``current`` is
        None.
        """
        if isinstance(value, str):
            if value in self.keys:
                return self.keys[value]
            if value == "now" and self.now is not None:
                return self.now
            if value == "auto" and self.now is not None and base == HEADER_TYPE:
                return cls._classes[base](stamp=self.now)
            raise MessageError(f"No key named [{value}]")
        time_class = {"time": Time, "duration": Duration}.get(base)
        if time_class is not None and type(value) is int:
            try:
                return time_class(0, value)
            except TypeError as error:
                raise MessageError(f"Field [{path}]: {error}") from error
        if current is None:
            current = cls._classes[base]() if time_class is None else time_class()
        self.fill(current, value, path + ".")
        return current

    @staticmethod
    def _normalise(value: TVal, prefix: str) -> None:
        value.canon()
        if isinstance(value, Time) and value.secs < 0:
            raise MessageError(f"Field [{prefix.rstrip('.')}]: time values must be positive")
