"""Definitions of messages as the page's forms need them. Pure but for the definitions."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pyros1.ground.errors import MessageError
from pyros1.msgs import Message, load_message
from pyros1.msgs.json_form import to_json

_DEEPEST = 12


def form(cls: type[Message]) -> dict[str, Any]:
    """Return what a form for a message needs.

    Returns:
        - type: its name
        - text: its definition
        - fields: a list of name, type, and the fields of the type or null
        - default: a message with default values, as JSON
    """
    return {"type": cls._type, "text": cls._full_text, "fields": _fields(cls, 0), "default": to_json(cls())}


def numbers(cls: type[Message], path: str, depth: int = 0) -> Iterator[str]:
    """Yield the paths of the fields of a message that are numbers; of arrays, those of the first element."""
    for name, kind in zip(cls.__slots__, cls._slot_types, strict=True):
        base, bracket, _ = kind.partition("[")
        inner = f"{path}/{name}[0]" if bracket else f"{path}/{name}"
        if "/" not in base:
            if base != "string":
                yield inner
        elif depth < _DEEPEST:
            try:
                yield from numbers(load_message(base), inner, depth + 1)
            except MessageError:
                continue


def _fields(cls: type[Message], depth: int) -> list[list[Any]]:
    return [[name, kind, _inner(kind, depth)] for name, kind in zip(cls.__slots__, cls._slot_types, strict=True)]


def _inner(kind: str, depth: int) -> list[list[Any]] | None:
    base = kind.partition("[")[0]
    if "/" not in base or depth >= _DEEPEST:
        return None
    try:
        return _fields(load_message(base), depth + 1)
    except MessageError:
        return None
