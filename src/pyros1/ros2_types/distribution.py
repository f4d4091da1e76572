"""The types of a ROS 2 distribution, from the rosbags library."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import UnknownTypeError
from pyros1.ground.suggest import did_you_mean
from pyros1.ros2_types.model import Field, FieldType, Length, MessageType, Types

if TYPE_CHECKING:
    from rosbags.interfaces.typing import FieldDesc, Typesdict

# A char in a .msg file is a uint8 in ROS 2, but rosbags takes it for an IDL char, so the hashes of types with a char,
# such as service_msgs/msg/ServiceEventInfo, and of all types that use them would be wrong.
_RENAMED_BASES = {"char": "uint8"}

# rosbags includes the field that rosidl adds to types without fields; `MessageType` does not.
_FILLER = "structure_needs_at_least_one_member"


def distribution_types(name: str = "jazzy") -> Types:
    """Return the message types of a distribution's standard packages.

    The types are converted on access, since a program uses only a few of hundreds.

    Args:
        name: name of the distribution, for example ``humble``.

    Raises:
        UnknownTypeError: rosbags does not have that distribution's types.
    """
    # rosbags is slow to import, and programs that know their types do not need it.
    from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415

    stores = {store.value[len("ros2_") :]: store for store in Stores if store.value.startswith("ros2_")}
    if name not in stores:
        hint = did_you_mean(name, stores) or f"; known: {', '.join(stores)}"
        raise UnknownTypeError(f"the types of the ROS 2 distribution {name!r} are not known{hint}")
    return _DistributionTypes(get_typestore(stores[name]).fielddefs)


class _DistributionTypes(Mapping[str, MessageType]):
    def __init__(self, definitions: Typesdict) -> None:
        self._definitions = definitions
        self._converted: dict[str, MessageType] = {}

    def __getitem__(self, name: str) -> MessageType:
        converted = self._converted.get(name)
        if converted is None:
            _, fields = self._definitions[name]
            converted = self._converted[name] = MessageType(
                name, tuple(Field(field, _convert(node)) for field, node in fields if field != _FILLER)
            )
        return converted

    def __contains__(self, name: object) -> bool:
        return name in self._definitions

    def __iter__(self) -> Iterator[str]:
        return iter(self._definitions)

    def __len__(self) -> int:
        return len(self._definitions)


def _convert(node: FieldDesc) -> FieldType:
    """Convert rosbags' description of a field's type."""
    from rosbags.interfaces import Nodetype  # noqa: PLC0415 - as above

    kind: Any
    value: Any
    kind, value = node
    length, size = Length.SINGLE, 0
    if kind == Nodetype.ARRAY:
        (kind, value), size = value
        length = Length.FIXED
    elif kind == Nodetype.SEQUENCE:
        (kind, value), size = value
        length = Length.BOUNDED if size else Length.UNBOUNDED
    if kind == Nodetype.NAME:
        return FieldType(value, length, size)
    base, string_bound = value
    return FieldType(_RENAMED_BASES.get(base, base), length, size, string_bound)
