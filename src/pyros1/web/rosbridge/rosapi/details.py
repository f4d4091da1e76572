"""rosapi's services that describe message and service types, field by field."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pyros1.msgs import Message, load_message, load_service
from pyros1.msgs.spec import BUILTINS
from pyros1.web.robot import Robot
from pyros1.web.rosbridge.rosapi import Services

_NO_ARRAY = -1
_ANY_LENGTH = 0
_TIME_TYPES = ("time", "duration")


def _message_details(_: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    type_name = args["type"]
    if type_name in BUILTINS:
        return {"typedefs": [_time_definition(type_name)] if type_name in _TIME_TYPES else []}
    return _definitions(load_message(type_name))


def _request_details(_: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    return _definitions(load_service(args["type"])._request_class)


def _response_details(_: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    return _definitions(load_service(args["type"])._response_class)


def _definitions(cls: type[Message]) -> dict[str, Any]:
    return {"typedefs": list(_nested_definitions(cls, set()))}


def _nested_definitions(cls: type[Message], seen: set[str]) -> Iterator[dict[str, Any]]:
    """Yield the definition of a class, and of each type that its fields use, once each."""
    seen.add(cls._type)
    yield _definition(cls)
    for field_type in cls._slot_types:
        base_type = field_type.partition("[")[0]
        if base_type in seen:
            continue
        if base_type in _TIME_TYPES:
            seen.add(base_type)
            yield _time_definition(base_type)
        elif base_type in cls._classes:
            yield from _nested_definitions(cls._classes[base_type], seen)


def _time_definition(type_name: str) -> dict[str, Any]:
    return {
        "type": type_name,
        "fieldnames": ["secs", "nsecs"],
        "fieldtypes": ["int32", "int32"],
        "fieldarraylen": [_NO_ARRAY, _NO_ARRAY],
        "examples": ["0", "0"],
        "constnames": [],
        "constvalues": [],
    }


def _definition(cls: type[Message]) -> dict[str, Any]:
    fields = [
        (name, *field_type.partition("[")) for name, field_type in zip(cls.__slots__, cls._slot_types, strict=True)
    ]
    constants = sorted(cls._text_source[1].constants, key=lambda constant: constant.name)
    return {
        "type": cls._type,
        "fieldnames": [name for name, *_ in fields],
        "fieldtypes": [base_type for _, base_type, *_ in fields],
        "fieldarraylen": [_array_length(bracket, length_text) for *_, bracket, length_text in fields],
        "examples": [_example(base_type, bracket, cls) for _, base_type, bracket, _ in fields],
        "constnames": [constant.name for constant in constants],
        "constvalues": [str(constant.value) for constant in constants],
    }


def _array_length(bracket: str, length_text: str) -> int:
    if not bracket:
        return _NO_ARRAY
    return int(length_text[:-1]) if length_text != "]" else _ANY_LENGTH


def _example(base_type: str, bracket: str, cls: type[Message]) -> str:
    if bracket:
        return "[]"
    if base_type in cls._classes or base_type in _TIME_TYPES:
        return "{}"
    return {"string": "", "bool": "False", "float32": "0.0", "float64": "0.0"}.get(base_type, "0")


SERVICES: Services = {
    "message_details": (("type",), _message_details),
    "service_request_details": (("type",), _request_details),
    "service_response_details": (("type",), _response_details),
}
