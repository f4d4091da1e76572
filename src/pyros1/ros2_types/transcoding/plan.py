"""Matches the fields of a ROS 1 type with those of a ROS 2 type, for the transcoder.

Fields are matched by name or by a rule. ROS 2 allows no capital letters in names, so ROS 1's field ``K`` is ``k``
there. If a rule names a field in a nested message, such as ``header.stamp``, that message is replaced by its fields,
which have the same bytes.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple, TypeAlias

from pyros1.ground.errors import DefinitionError
from pyros1.msgs import spec as ros1
from pyros1.ros2_types import model as ros2
from pyros1.ros2_types.log_levels import ValueRule
from pyros1.ros2_types.mapping import FieldRules
from pyros1.ros2_types.transcoding.fields import Flat2, partners, ros1_fields, ros2_fields
from pyros1.ros2_types.transcoding.numbers import Convert, conversion

MAX_FIELDS = 5000
"""Maximum number of fields of both types, including nested types: compiling the code for each takes 0.4 ms."""
MAX_DEPTH = 64
"""Maximum depth of nested types."""

FILLER = "structure_needs_at_least_one_member"
"""Name of the ``uint8`` in an empty ROS 2 message."""

_TIME_NAMES = ("sec", "nanosec")
_TIME_BASES = frozenset(["int32", "uint32"])


class Numbers(NamedTuple):
    """Numbers of one size: a single number, a fixed array, or a time, which is two numbers.

    Attributes:
        width: size of each in bytes.
        amount: how many.
        in_ros1: whether the ROS 1 type has them; if not, nothing is written for ROS 1, and ROS 2 gets zeros.
        in_ros2: the same for ROS 2.
        is_sequence_number: whether it is the ``seq`` of a ROS 1 header.
    """

    width: int
    amount: int
    in_ros1: bool
    in_ros2: bool
    is_sequence_number: bool = False


class Changed(NamedTuple):
    """A number that both sides have, with different types or values.

    Attributes:
        ros1: code of its type in ROS 1, as in the module struct.
        ros2: the same for ROS 2.
        to_ros2: converts a value.
        to_ros1: the same in the other direction.
        label: as for `Text`.
    """

    ros1: str
    ros2: str
    to_ros2: Convert
    to_ros1: Convert
    label: str

    @property
    def in_ros1(self) -> bool:
        """Whether the ROS 1 type has it, as for `Numbers`."""
        return True

    @property
    def in_ros2(self) -> bool:
        """Whether the ROS 2 type has it, as for `Numbers`."""
        return True


class Text(NamedTuple):
    """A string.

    Attributes:
        in_ros1, in_ros2: as for `Numbers`.
        is_wide: whether it is a ``wstring`` in ROS 2.
        bound: maximum length in ROS 2; 0 if there is none.
        label: the field's name, for error messages.
    """

    in_ros1: bool
    in_ros2: bool
    is_wide: bool
    bound: int
    label: str


class Array(NamedTuple):
    """An array or sequence, except for fixed arrays of numbers on both sides.

    Attributes:
        element: each element.
        ros1: number of elements in ROS 1; -1 for any, None if ROS 1's type lacks the field.
        ros2: the same for ROS 2.
        bound: maximum number of elements in ROS 2; 0 if there is none.
        label: as for `Text`.
    """

    element: Node
    ros1: int | None
    ros2: int | None
    bound: int
    label: str

    @property
    def in_ros1(self) -> bool:
        """Whether the ROS 1 type has it, as for `Numbers`."""
        return self.ros1 is not None

    @property
    def in_ros2(self) -> bool:
        """Whether the ROS 2 type has it, as for `Numbers`."""
        return self.ros2 is not None


class Record(NamedTuple):
    """A message.

    Attributes:
        nodes: all fields.
        ros1: which of them the ROS 1 type has, in its order; None if it lacks the message.
        ros2: the same for ROS 2.
    """

    nodes: tuple[Node, ...]
    ros1: tuple[int, ...] | None
    ros2: tuple[int, ...] | None

    @property
    def in_ros1(self) -> bool:
        """Whether the ROS 1 type has it, as for `Numbers`."""
        return self.ros1 is not None

    @property
    def in_ros2(self) -> bool:
        """Whether the ROS 2 type has it, as for `Numbers`."""
        return self.ros2 is not None


Node: TypeAlias = Numbers | Changed | Text | Array | Record


class Planner:
    """Matches two types.

    Args:
        specs: the ROS 1 types by full names.
        types: the ROS 2 types.
        rules: the matching fields of types whose fields are not matched by name.

    Attributes:
        only_ros1: dotted names of fields that only the ROS 1 type has, without the fields inside them.
        only_ros2: the same for ROS 2.
    """

    def __init__(
        self, specs: Mapping[str, ros1.MessageSpec], types: ros2.Types, rules: FieldRules = MappingProxyType({})
    ) -> None:
        self._specs = specs
        self._types = types
        self._rules = rules
        self._count = 0
        self.only_ros1: list[str] = []
        self.only_ros2: list[str] = []

    def record(self, name1: str | None, name2: str | None, path: str = "", depth: int = 0) -> Record:
        """Match two message types.

        Args:
            name1: name of the ROS 1 type; None if there is none.
            name2: name of the ROS 2 type; None if there is none.
            path: dotted name of the field, followed by a dot; empty for the message itself.
            depth: how deeply it is nested.

        Raises:
            DefinitionError: a type is unknown, too large or nested too deeply, the types of two matching fields cannot
                be converted, or a rule names a field that does not exist.
        """
        if depth > MAX_DEPTH:
            raise DefinitionError(f"it contains itself, or is nested more than {MAX_DEPTH} deep", name1 or name2)
        rule = self._rules.get((name1 or "", name2 or ""))
        pairs = rule.fields if rule else {}
        try:
            fields1 = ros1_fields(name1, self._specs, pairs.keys())
            fields2 = ros2_fields(name2, self._types, pairs.values())
        except DefinitionError as error:
            raise DefinitionError(str(error), rule.place if rule and rule.place else None) from None
        is_filled = name2 is not None and not fields2
        if is_filled:
            fields2 = {FILLER: Flat2(ros2.Field(FILLER, ros2.FieldType("uint8")))}
        self._count += len(fields1) + len(fields2) + 1
        if self._count > MAX_FIELDS:
            raise DefinitionError(f"it has more than {MAX_FIELDS} fields", name1 or name2)
        names2 = dict(pairs) if rule else partners(fields1, fields2)
        both = name1 is not None and name2 is not None
        nodes: list[Node] = []
        indexes: dict[str, int] = {}
        for key1, flat1 in fields1.items():
            partner = names2.get(key1)
            is_seq = flat1.owner == ros1.HEADER_TYPE and flat1.field[:3] == ("seq", "uint32", None) and partner is None
            if both and partner is None and not is_seq:
                self.only_ros1.append(path + key1)
            field2 = None if partner is None else fields2[partner].field
            if partner is not None:
                indexes[partner] = len(nodes)
            value_rule = rule.values.get(key1) if rule else None
            node = self._field(flat1.field, field2, path + key1, depth, value_rule)
            if is_seq and isinstance(node, Numbers):
                node = node._replace(is_sequence_number=True)
            nodes.append(node)
        for key2, flat2 in fields2.items():
            if key2 not in indexes:
                if both and key2 != FILLER:
                    self.only_ros2.append(path + key2)
                indexes[key2] = len(nodes)
                nodes.append(self._field(None, flat2.field, path + key2, depth))
        return Record(
            tuple(nodes),
            None if name1 is None else tuple(range(len(fields1))),
            None if name2 is None else tuple(indexes[name] for name in fields2),
        )

    def _field(
        self,
        field1: ros1.Field | None,
        field2: ros2.Field | None,
        path: str,
        depth: int,
        value_rule: ValueRule | None = None,
    ) -> Node:
        """Match two fields; one of them may be None."""
        count1 = None if field1 is None else field1.length
        count2, bound = (None, 0) if field2 is None else _count_and_bound(field2.type)
        is_array = count1 is not None or count2 is not None
        mismatch = DefinitionError(f"{_ros1_text(field1)} of ROS 1 is not {_ros2_text(field2)} of ROS 2", path)
        if field1 and field2:
            if (count1 is None) != (count2 is None):
                raise mismatch
            if count1 is not None and count1 >= 0 and (count2 not in (-1, count1) or 0 < bound < count1):
                raise mismatch
        base1, type2 = field1 and field1.base, field2 and field2.type
        element = self._element(base1, type2, path, depth, mismatch, value_rule)
        if not is_array:
            return element
        counts = {count for count, field in ((count1, field1), (count2, field2)) if field}
        if isinstance(element, Numbers) and -1 not in counts:
            (count,) = counts
            return element._replace(amount=element.amount * (count or 0))
        return Array(element, count1, count2, bound, path)

    def _element(
        self,
        base1: str | None,
        type2: ros2.FieldType | None,
        path: str,
        depth: int,
        mismatch: DefinitionError,
        value_rule: ValueRule | None,
    ) -> Node:
        """Match the types of two fields, or of the elements of two arrays."""
        in1, in2 = base1 is not None, type2 is not None
        base2 = type2.base if type2 else None
        bound = type2.string_bound if type2 else 0
        if base1 in ("time", "duration"):
            if base2 is not None and not self._is_time(base2):
                raise mismatch
            return Numbers(4, 2, in1, in2)
        if base1 == "string" or base2 in ros2.STRINGS:
            if (in1 and base1 != "string") or (in2 and base2 not in ros2.STRINGS):
                raise mismatch
            return Text(in1, in2, base2 == "wstring", bound, path)
        code1 = ros1.STRUCT_CODES.get(base1 or "")
        code2 = ros2.STRUCT_CODES.get(base2 or "")
        if code1 or code2:
            if base1 is not None and base2 is not None:
                changed = conversion(base1, base2, path, value_rule)
                if changed is not None:
                    return Changed(code1 or "", code2 or "", *changed, path)
            return Numbers(struct.calcsize("<" + (code1 or code2 or "")), 1, in1, in2)
        return self.record(base1, base2, path + ".", depth + 1)

    def _is_time(self, name: str) -> bool:
        fields = self._types[name].fields if name in self._types else ()
        return tuple(field.name for field in fields) == _TIME_NAMES and all(
            field.type.base in _TIME_BASES and field.type.length is ros2.Length.SINGLE for field in fields
        )


def _count_and_bound(field_type: ros2.FieldType) -> tuple[int | None, int]:
    if field_type.length is ros2.Length.SINGLE:
        return None, 0
    if field_type.length is ros2.Length.FIXED:
        return field_type.size, 0
    return -1, field_type.size if field_type.length is ros2.Length.BOUNDED else 0


def _ros1_text(field: ros1.Field | None) -> str:
    return "nothing" if field is None else field.type


def _ros2_text(field: ros2.Field | None) -> str:
    if field is None:
        return "nothing"
    base, length, size, _ = field.type
    brackets = {
        ros2.Length.SINGLE: "",
        ros2.Length.FIXED: f"[{size}]",
        ros2.Length.BOUNDED: f"[<={size}]",
        ros2.Length.UNBOUNDED: "[]",
    }
    return base + brackets[length]
