"""ROS 2's parameter services and the parameter event topic (rcl_interfaces), as Python values. No I/O.

Their types have not changed since Humble. Nodes with other versions, which have other hashes, are left out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import IntEnum
from io import BytesIO
from typing import Any, NamedTuple

from pyros1.ground.errors import MessageError
from pyros1.msgs import DefinitionCache
from pyros1.msgs.digest import split_full_text
from pyros1.msgs.fill import fill_message
from pyros1.msgs.spec import parse_message
from pyros1.ros2_types.definitions import parse_types
from pyros1.ros2_types.distribution import distribution_types
from pyros1.ros2_types.nesting import LayeredTypes
from pyros1.ros2_types.ros1_definitions import ros1_definition
from pyros1.ros2_types.transcoding.transcoder import Transcoder
from pyros1.ros2_types.type_hash import service_hash, type_hash

LIST, DESCRIBE, GET, SET = "list_parameters", "describe_parameters", "get_parameters", "set_parameters"
SERVICE_TYPES = {
    LIST: "rcl_interfaces/srv/ListParameters",
    DESCRIBE: "rcl_interfaces/srv/DescribeParameters",
    GET: "rcl_interfaces/srv/GetParameters",
    SET: "rcl_interfaces/srv/SetParameters",
}
"""The last part of each called service's name, and its type."""
EVENT_TYPE = "rcl_interfaces/msg/ParameterEvent"
MAX_MESSAGE = 4 << 20
"""Maximum size in bytes of a response or an event."""
_DEFINITIONS = {
    LIST: "string[] prefixes\nuint64 depth\n---\nrcl_interfaces/ListParametersResult result\n",
    DESCRIBE: "string[] names\n---\nrcl_interfaces/ParameterDescriptor[] descriptors\n",
    GET: "string[] names\n---\nrcl_interfaces/ParameterValue[] values\n",
    SET: "rcl_interfaces/Parameter[] parameters\n---\nrcl_interfaces/SetParametersResult[] results\n",
}

Value = bool | int | float | str | list[bool] | list[int] | list[float] | list[str]
"""The value of a parameter; an array of bytes is a list of integers."""


class Kind(IntEnum):
    """The type of a parameter: the values of rcl_interfaces/msg/ParameterType."""

    NOT_SET = 0
    BOOL = 1
    INTEGER = 2
    DOUBLE = 3
    STRING = 4
    BYTE_ARRAY = 5
    BOOL_ARRAY = 6
    INTEGER_ARRAY = 7
    DOUBLE_ARRAY = 8
    STRING_ARRAY = 9


_FIELDS = {
    Kind.BOOL: "bool_value",
    Kind.INTEGER: "integer_value",
    Kind.DOUBLE: "double_value",
    Kind.STRING: "string_value",
    Kind.BYTE_ARRAY: "byte_array_value",
    Kind.BOOL_ARRAY: "bool_array_value",
    Kind.INTEGER_ARRAY: "integer_array_value",
    Kind.DOUBLE_ARRAY: "double_array_value",
    Kind.STRING_ARRAY: "string_array_value",
}
_SCALARS: dict[type, Kind] = {bool: Kind.BOOL, int: Kind.INTEGER, float: Kind.DOUBLE, str: Kind.STRING}


class Descriptor(NamedTuple):
    """A node's description of a parameter.

    Attributes:
        name: its name.
        text: its description and constraints.
        read_only: whether it cannot be changed.
        integers, doubles: the lowest and highest allowed number of that type; None for no limits.
    """

    name: str
    text: str
    read_only: bool
    integers: tuple[int, int] | None = None
    doubles: tuple[float, float] | None = None


class Event(NamedTuple):
    """Parameters of a node that have changed.

    Attributes:
        node: its full name.
        changed: the new values of parameters that were there before.
        has_others: whether parameters were added or deleted.
    """

    node: str
    changed: dict[str, Value | None]
    has_others: bool


class ParameterMessages:
    """Encodes requests, and decodes responses and events.

    Attributes:
        hashes: the hashes of the services in ROS 2, by the last parts of their names.
        event_hash: the hash of the topic's type.

    All methods raise MessageError if a message is invalid.
    """

    def __init__(self) -> None:
        parsed = [parse_types(SERVICE_TYPES[name], text) for name, text in _DEFINITIONS.items()]
        types = LayeredTypes(*parsed, distribution_types())
        self.hashes = {name: service_hash(type, types) for name, type in SERVICE_TYPES.items()}
        self.event_hash = type_hash(EVENT_TYPE, types)
        definitions = DefinitionCache()
        parts = [f"{type}_{part}" for type in SERVICE_TYPES.values() for part in ("Request", "Response")]
        self._codecs: dict[str, tuple[Any, Transcoder]] = {}  # ROS 1 class, and the converter for its messages
        for name in (*parts, EVENT_TYPE):
            ros1_name = _ros1_name(name)
            text = ros1_definition(name, types, _ros1_name, lambda _: None)
            specs = {each: parse_message(each, part) for each, part in split_full_text(ros1_name, text).items()}
            message_class = definitions.get(ros1_name, "*", text)
            self._codecs[name] = message_class, Transcoder(ros1_name, specs, name, types)

    def list_request(self) -> bytes:
        """Return a request for the names of all parameters."""
        return self._encode(LIST, prefixes=[], depth=0)

    def names_request(self, service: str, names: Sequence[str]) -> bytes:
        """Return a request for the descriptors or values of parameters.

        Args:
            service: DESCRIBE or GET.
            names: the parameters.
        """
        return self._encode(service, names=[*names])

    def set_parameters_request(self, values: Mapping[str, bool | int | float | str]) -> bytes:
        """Return a request to set parameters to values."""
        parameters = []
        for name, value in values.items():
            kind = _SCALARS[type(value)]
            parameters.append({"name": name, "value": {"type": int(kind), _FIELDS[kind]: value}})
        return self._encode(SET, parameters=parameters)

    def names(self, response: bytes) -> list[str]:
        """Return the names of a node's parameters, each once."""
        return [*dict.fromkeys(self._decode(f"{SERVICE_TYPES[LIST]}_Response", response).result.names)]

    def descriptors(self, response: bytes) -> list[Descriptor]:
        """Return the descriptors in a response."""
        decoded = self._decode(f"{SERVICE_TYPES[DESCRIBE]}_Response", response)
        return [_descriptor(each) for each in decoded.descriptors]

    def values(self, response: bytes) -> list[Value | None]:
        """Return the values in a response; None for a parameter without one."""
        return [_value(each) for each in self._decode(f"{SERVICE_TYPES[GET]}_Response", response).values]

    def results(self, response: bytes) -> list[str | None]:
        """Return, for each parameter, why it was not set; None if it was."""
        decoded = self._decode(f"{SERVICE_TYPES[SET]}_Response", response)
        return [None if each.successful else each.reason or "it gives no reason" for each in decoded.results]

    def event(self, body: bytes) -> Event:
        """Return the changes in an event."""
        decoded = self._decode(EVENT_TYPE, body)
        changed = {each.name: _value(each.value) for each in decoded.changed_parameters}
        return Event(decoded.node, changed, bool(decoded.new_parameters or decoded.deleted_parameters))

    def _encode(self, service: str, **fields: Any) -> bytes:
        message_class, transcoder = self._codecs[f"{SERVICE_TYPES[service]}_Request"]
        message, buffer = message_class(), BytesIO()
        fill_message(message, fields)
        message.serialize(buffer)
        return transcoder.to_cdr(buffer.getvalue())

    def _decode(self, name: str, body: bytes) -> Any:
        if len(body) > MAX_MESSAGE:
            raise MessageError(f"a {name} of {len(body)} bytes is too large; the limit is {MAX_MESSAGE >> 20} MB")
        message_class, transcoder = self._codecs[name]
        return message_class().deserialize(transcoder.from_cdr(body, 0))


def _ros1_name(name: str) -> str:
    package, _, short = name.split("/")
    return f"{package}/{short.replace('_', '')}"


def _descriptor(message: Any) -> Descriptor:
    integers, doubles = (
        next(((each.from_value, each.to_value) for each in ranges), None)
        for ranges in (message.integer_range, message.floating_point_range)
    )
    text = ". ".join(text.rstrip(".") for text in (message.description, message.additional_constraints) if text)
    return Descriptor(message.name, text, message.read_only, integers, doubles)


def _value(message: Any) -> Value | None:
    """Return the value in an rcl_interfaces/ParameterValue; None if it has none, or its type is not known."""
    field = _FIELDS.get(message.type)
    if field is None:
        return None
    value: Any = getattr(message, field)
    if message.type == Kind.BYTE_ARRAY:
        return [each & 0xFF for each in value]
    return [*value] if message.type > Kind.STRING else value
