"""Maps ROS 1 types to ROS 2 types and back, and derives the types that ROS 2 does not have.

Without user-defined rules, the names are the same as in exported bags (`pyros1.bag.export`), so that recorded and
bridged topics have the same types.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pyros1.ground.errors import DefinitionError
from pyros1.msgs.digest import Digests
from pyros1.msgs.spec import Field as Ros1Field
from pyros1.msgs.spec import MessageSpec, ServiceSpec, is_type_name
from pyros1.ros2_types.definitions import full_type_name
from pyros1.ros2_types.mapping import TypeMapping
from pyros1.ros2_types.model import Field, FieldType, Length, MessageType, Types

_DERIVED_BASES = {
    "time": "builtin_interfaces/msg/Time",
    "duration": "builtin_interfaces/msg/Duration",
    # ROS 2 packages kept their .msg and .srv files, so a byte is still a byte, for example in
    # diagnostic_msgs/srv/SelfTest: with int8, the type would have a different hash. The 8 bits are the same, but a
    # ROS 1 byte ranges from -128 to 127, and a ROS 2 byte from 0 to 255.
    "byte": "byte",
    "char": "uint8",
}

MAX_TYPES = 1000
"""Maximum number of types to derive at a time, since the time to choose names grows quadratically."""

_PART_SUFFIXES = ("_Request", "_Response", "_Goal", "_Result", "_Feedback")


class Counterparts:
    """The ROS 2 counterparts of ROS 1 types, and vice versa.

    An object remembers the names that it has chosen, so use a single object in a program.

    Args:
        distribution_types: the types that ROS 2 is known to have: those of a distribution, and others.
        mapping: which types have different names in ROS 2.
        is_in_ros1: returns whether ROS 1 is known to have a message ``package/Type``, or, if its second argument is
            True, such a service.
    """

    def __init__(
        self,
        distribution_types: Types,
        mapping: TypeMapping | None = None,
        is_in_ros1: Callable[[str, bool], bool] = lambda name, is_service: True,
    ) -> None:
        # legal_names imports rosbags, which is slow, and which not every user of this module needs.
        from pyros1.ros2_types.legal_names import LegalNames  # noqa: PLC0415

        self._distribution_types = distribution_types
        self._names = LegalNames(distribution_types)
        self._new_legal_names = LegalNames
        self._mapping = mapping or TypeMapping()
        self._is_in_ros1 = is_in_ros1
        self._ros1_names: dict[str, str] = {}

    def to_ros2(self, name: str) -> str:
        """Return the name of a message type in ROS 2: ``std_msgs/msg/String`` for ``std_msgs/String``.

        Types that the distribution does not have get names that ROS 2 allows: ``mocap/msg/MyFrame`` for
        ``Mocap/my_frame``.

        Raises:
            DefinitionError: `name` is not of the form ``package/Type``.
        """
        _check_ros1_name(name)
        return self._to_ros2(name, "msg")

    def service_to_ros2(self, name: str) -> str:
        """Return the name of a service type in ROS 2, ``std_srvs/srv/SetBool`` for ``std_srvs/SetBool``.

        Raises:
            DefinitionError: `name` is not of the form ``package/Type``.
        """
        return self._to_ros2(name, "srv")

    def action_to_ros2(self, name: str) -> str:
        """Return the name of an action type in ROS 2: ``tutorials/action/Fibonacci`` for ``tutorials/Fibonacci``.

        Raises:
            DefinitionError: `name` is not of the form ``package/Type``.
        """
        return self._to_ros2(name, "action")

    def to_ros1(self, name: str) -> str:
        """Return the name of a type in ROS 1: ``std_msgs/String`` for ``std_msgs/msg/String``.

        This is the inverse of the other methods, for names that they have returned. If two ROS 1 types have the same
        ROS 2 type, the first rule decides, or else the name that is the same: ``tf2_msgs/TFMessage``, not
        ``tf/tfMessage``.

        Args:
            name: full name of a message, service or action, or of a part of a service or action:
                ``std_srvs/SetBoolRequest`` for ``std_srvs/srv/SetBool_Request``.

        Raises:
            DefinitionError: `name` is not legal.
        """
        package, folder, short = full_type_name(name).split("/")
        suffixes = () if folder == "msg" else _PART_SUFFIXES
        suffix = next((suffix for suffix in suffixes if short.endswith(suffix)), "")
        short = short.removesuffix(suffix)
        whole = f"{package}/{folder}/{short}"
        is_service = folder == "srv"
        ros1_name = self._mapping.to_ros1(
            whole, lambda each: self._is_in_ros1(each, is_service)
        ) or self._ros1_names.get(whole, f"{package}/{short}")
        return ros1_name + suffix[1:]

    def derive(self, spec: MessageSpec, resolve: Callable[[str], MessageSpec]) -> dict[str, MessageType]:
        """Return the ROS 2 types for a message type, without those that the distribution has.

        Args:
            spec: the definition in ROS 1.
            resolve: returns the definition of a message type by its name; its errors are passed on.

        Returns:
            Full name -> type, for the type and the types that it uses. The fields are in the same order as in ROS 1.
            Empty if the distribution has the type.

        Raises:
            DefinitionError: a type contains itself, is nested too deeply, uses more than 1000 types, or has an array of
                0 elements, which ROS 2 does not allow.
        """
        if self._mapping.to_ros2(spec.name, "msg", self._distribution_types) in self._distribution_types:
            return {}
        return self._derive_all([spec], resolve)

    def derive_service(self, spec: ServiceSpec, resolve: Callable[[str], MessageSpec]) -> dict[str, MessageType]:
        """Return the ROS 2 types for a service; arguments and errors as for `derive`.

        Returns:
            As for `derive`; with the types of request and response, ``package/srv/Type_Request`` and
            ``package/srv/Type_Response``.
        """
        name = self.service_to_ros2(spec.name)
        parts = {f"{name}_Request": spec.request, f"{name}_Response": spec.response}
        return self._derive_parts(parts, resolve)

    def derive_action(self, name: str, resolve: Callable[[str], MessageSpec]) -> dict[str, MessageType]:
        """Return the ROS 2 types for an action.

        Args:
            name: its name in ROS 1, ``package/Type``.
            resolve: as for `derive`; also finds ``package/TypeGoal``, ``package/TypeResult`` and
                ``package/TypeFeedback``.

        Returns:
            As for `derive`; with ``package/action/Type_Goal``, ``..._Result`` and ``..._Feedback``.

        Raises:
            DefinitionError: as for `derive`, or `name` is not of the form ``package/Type``.
        """
        ros2_name = self.action_to_ros2(name)
        parts = {f"{ros2_name}_{part}": resolve(name + part) for part in ("Goal", "Result", "Feedback")}
        return self._derive_parts(parts, resolve)

    def _to_ros2(self, name: str, folder: str) -> str:
        _check_ros1_name(name)
        return self._legal_type(name, self._mapping.to_ros2(name, folder, self._distribution_types))

    def _legal_type(self, ros1_name: str, ros2_name: str) -> str:
        legal = self._names.legal_type(ros2_name)
        if legal != ros2_name:
            self._ros1_names[legal] = ros1_name
        return legal

    def _derive_parts(
        self, parts: dict[str, MessageSpec], resolve: Callable[[str], MessageSpec]
    ) -> dict[str, MessageType]:
        types = self._derive_all(list(parts.values()), resolve, with_roots=False)
        return types | {name: MessageType(name, self._derive_fields(spec, name)) for name, spec in parts.items()}

    def _derive_all(
        self, roots: list[MessageSpec], resolve: Callable[[str], MessageSpec], *, with_roots: bool = True
    ) -> dict[str, MessageType]:
        specs = {spec.name: spec for spec in roots} if with_roots else {}
        digests = Digests(resolve)
        specs |= {name: resolve(name) for root in roots for name in digests.dependencies(root)}
        ros2_names = {name: self._mapping.to_ros2(name, "msg", self._distribution_types) for name in specs}
        missing = {name: spec for name, spec in specs.items() if ros2_names[name] not in self._distribution_types}
        if len(missing) > MAX_TYPES:
            raise DefinitionError(f"the type uses {len(missing)} types; the limit is {MAX_TYPES}", roots[0].name)
        # Register all names at once, so that those that are already legal stay the same.
        self._names.legal_types({ros2_names[name]: ([], []) for name in missing})
        derived = {}
        for name, spec in missing.items():
            new_name = self.to_ros2(name)
            derived[new_name] = MessageType(new_name, self._derive_fields(spec, new_name))
        return derived

    def _derive_fields(self, spec: MessageSpec, ros2_name: str) -> tuple[Field, ...]:
        types = [self._derive_field_type(spec, field) for field in spec.fields]
        rule = self._mapping.fields.get((spec.name, ros2_name))
        if rule is None:
            return tuple(map(Field, self._legal_field_names(spec), types))
        known = {field.name for field in spec.fields}
        if not known.issuperset(rule.fields) or any("." in path for path in rule.fields.values()):
            raise DefinitionError(
                f"the definition of {ros2_name} is needed, since its rule does not match all of its fields: "
                "use --ros2-packages",
                rule.place or None,
            )
        # If the ROS 2 type has other fields, they are not known.
        return tuple(
            Field(rule.fields[field.name], type)
            for field, type in zip(spec.fields, types, strict=True)
            if field.name in rule.fields
        )

    def _derive_field_type(self, spec: MessageSpec, field: Ros1Field) -> FieldType:
        base = _DERIVED_BASES.get(field.base, field.base) if field.is_builtin else self.to_ros2(field.base)
        if field.length is None:
            return FieldType(base)
        if field.length < 0:
            return FieldType(base, Length.UNBOUNDED)
        if field.length == 0:
            raise DefinitionError(
                f"field [{field.name}] is an array of 0 elements, which ROS 2 does not have", spec.name
            )
        return FieldType(base, Length.FIXED, field.length)

    def _legal_field_names(self, spec: MessageSpec) -> list[str]:
        # `LegalNames` takes types in rosbags' form; the fields' types do not matter for their names.
        fields: list[Any] = [(field.name, (None, None)) for field in spec.fields]
        ((_, legal_fields),) = self._new_legal_names(()).legal_types({"any/msg/Any": ([], fields)}).values()
        return [name for name, _ in legal_fields]


def _check_ros1_name(name: str) -> None:
    if not is_type_name(name):
        raise DefinitionError(f"[{name:.200}] is not a type name of the form package/Type")
