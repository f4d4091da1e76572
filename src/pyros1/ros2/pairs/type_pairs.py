"""Pairs ROS 1 and ROS 2 types by name and hash, and makes converters for messages and calls.

For a service, the definition in a ROS 2 package on this machine is used if there is one, and otherwise the ROS 1
definition: pyros1 has no ROS 2 distribution's service definitions, but those of the standard packages are the same as
in ROS 1, except for the messages that they use.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import NamedTuple

from pyros1.bridge.exchange.topic_sender import LocalTopic
from pyros1.ground.errors import MessageError, UnknownTypeError
from pyros1.msgs import DefinitionCache, load_message, load_service
from pyros1.msgs.digest import split_full_text
from pyros1.msgs.spec import HEADER_TYPE, MessageSpec, ServiceSpec, parse_message, parse_service
from pyros1.ros2.bridge.actions.pairs import ActionPair, ActionPairs
from pyros1.ros2.pairs.lookup_cache import LookupCache, TimeBudget
from pyros1.ros2.zenoh.names import HUMBLE_HASH, dds_type
from pyros1.ros2_types.counterparts import Counterparts
from pyros1.ros2_types.distribution import distribution_types
from pyros1.ros2_types.mapping import TypeMapping
from pyros1.ros2_types.model import Types
from pyros1.ros2_types.nesting import LayeredTypes
from pyros1.ros2_types.rclpy_packages import RclpyPackages
from pyros1.ros2_types.ros1_definitions import ros1_definition
from pyros1.ros2_types.transcoding.transcoder import Transcoder
from pyros1.ros2_types.type_hash import service_hash, type_hash

DISTRIBUTIONS = ("jazzy", "kilted", "lyrical", "iron", "humble")
"""The ROS 2 distributions in which a hash is looked up, in this order."""

_HINT = "--ros2-packages names a folder with ROS 2 packages"


class TypePair(NamedTuple):
    """A ROS 1 message type and its counterpart in ROS 2.

    Attributes:
        ros1: its name in ROS 1.
        md5sum, definition: its md5 sum and full definition in ROS 1.
        ros2: its name in ROS 2.
        hash: its hash in ROS 2.
        transcoder: converts messages.
    """

    ros1: str
    md5sum: str
    definition: str
    ros2: str
    hash: str
    transcoder: Transcoder


class ServicePair(NamedTuple):
    """A ROS 1 service type and its counterpart in ROS 2.

    Attributes:
        ros1, md5sum: its name and md5 sum in ROS 1.
        ros2, hash: its name and hash in ROS 2.
        request, response: convert requests and responses.
    """

    ros1: str
    md5sum: str
    ros2: str
    hash: str
    request: Transcoder
    response: Transcoder


class TypePairs:
    """Finds pairs of ROS 1 and ROS 2 types, and caches successes and failures. Not thread-safe.

    Args:
        distribution: the ROS 2 distribution whose types are used by default.
        mapping: which types and fields have different names in ROS 2; None for the standard mapping.
        installed: the types of ROS 2 packages on this machine; they are tried first.
        budget: limits the time for looking up types that ROS 2 programs name, since they may name any; None for the
            default budget.
        beside_rclpy: the types of the packages that rclpy can use; if given, no others are used.

    Attributes:
        known: the known ROS 2 types, by name.
        actions: finds the types of actions.

    Raises:
        UnknownTypeError: the distribution is not known.
    """

    def __init__(
        self,
        distribution: str = "jazzy",
        mapping: TypeMapping | None = None,
        installed: Types = MappingProxyType({}),
        budget: TimeBudget | None = None,
        beside_rclpy: RclpyPackages | None = None,
    ) -> None:
        self._default = distribution
        self._beside_rclpy = beside_rclpy
        self._distributions: dict[str, Types] = {
            distribution: distribution_types(distribution) if beside_rclpy is None else beside_rclpy
        }
        self._installed = installed
        self._mapping = mapping or TypeMapping()
        self.known = LayeredTypes(installed, self._distributions[distribution])
        self._counterparts = Counterparts(self.known, self._mapping, _is_in_ros1)
        self._definitions = DefinitionCache(prefer_installed=True)
        # ROS 2 may name any types, and a lookup takes up to 20 ms; types that ROS 1 publishes are always looked up.
        budget = budget or TimeBudget()
        self._found = LookupCache[TypePair](budget)
        self._found_services = LookupCache[ServicePair](budget)
        self.actions = ActionPairs(
            self._counterparts,
            self._all_types,
            self.known,
            self._mapping.fields,
            self._definitions,
            LookupCache[ActionPair](budget),
        )

    def name_in_ros2(self, type: str) -> str:
        """Return the ROS 2 name of a ROS 1 message type.

        Raises:
            DefinitionError: `type` is not of the form ``package/Type``.
        """
        return self._counterparts.to_ros2(type)

    def for_ros1(self, type: str, md5sum: str, definition: str, hash: str | None = None) -> TypePair:
        """Return the pair of types for a ROS 1 type.

        Args:
            type, md5sum, definition: the type.
            hash: the hash that ROS 2 expects; None for the default distribution's.

        Raises:
            Error: it is not known, or ROS 2 expects another type of this name.
        """
        # The definition is part of the key, since a lookup that failed may succeed with another definition.
        key = (type, md5sum, hash, definition)
        pair = self._found.get(key, lambda: self._for_ros1(type, md5sum, definition, hash), is_limited=hash is not None)
        self._found.put((type, md5sum, pair.hash, definition), pair)
        return pair

    def for_ros2(self, type: str, hash: str, local: LocalTopic | None = None) -> TypePair:
        """Return the pair of types for a ROS 2 type.

        Args:
            type, hash: the type.
            local: the ROS 1 topic with the same name, if there is one.

        Raises:
            Error: its definition is not known.
        """
        is_same = local is not None and self._counterparts.to_ros2(local.type) == type
        if local is not None and is_same:
            return self.for_ros1(local.type, local.md5sum, local.definition, hash)
        return self._found.get((type, hash), lambda: self._for_ros2(type, hash), is_limited=True)

    def service_for_ros1(self, type: str, md5sum: str, hash: str | None = None) -> ServicePair:
        """Return the pair of types for a ROS 1 service type.

        Args:
            type, md5sum: the type of the service.
            hash: the hash that ROS 2 expects; None for the default distribution's.

        Raises:
            Error: its definition is not known here, or ROS 2 expects another type of this name.
        """
        key = (type, md5sum, hash)
        return self._found_services.get(key, lambda: self._service(type, md5sum, hash), is_limited=hash is not None)

    def service_for_ros2(self, type: str, hash: str) -> ServicePair:
        """Return the pair of types for a ROS 2 service type.

        Args:
            type, hash: the type of the service.

        Raises:
            Error: ROS 1 has no service type of this name here, or a different one.
        """
        return self._found_services.get(
            (type, hash), lambda: self._service(self._ros1_service(type), "*", hash), is_limited=True
        )

    def _ros1_service(self, type: str) -> str:
        """Return the ROS 1 name of a ROS 2 service type: the name given by rules, or the same name if only that is
        known here.
        """
        name = self._counterparts.to_ros1(type)
        package, _, short = type.split("/")
        same_name = f"{package}/{short}"
        return name if _is_in_ros1(name, True) or not _is_in_ros1(same_name, True) else same_name

    def has_ros2_definition(self, type: str) -> bool:
        """Return whether a message or service type has its own ROS 2 definition, not only the ROS 1 definition."""
        return type in self.known or f"{type}_Request" in self.known

    def _for_ros1(self, type: str, md5sum: str, definition: str, hash: str | None) -> TypePair:
        message_class = self._definitions.get(type, md5sum, definition)
        if message_class._md5sum != md5sum:
            raise MessageError(f"the definition of {type} that its publisher sends does not match its md5sum")
        text = message_class._full_text
        specs = _specs(type, text)
        name = _checked(self._counterparts.to_ros2(type))
        for types in self._candidates(name, type, specs, hash):
            own_hash = hash if hash == HUMBLE_HASH else type_hash(name, types)
            if hash is None or hash == own_hash:
                transcoder = Transcoder(type, specs, name, types, self._mapping.fields)
                return TypePair(type, md5sum, text, name, own_hash or "", transcoder)
        raise UnknownTypeError(
            self._rclpy_problem(name) or f"ROS 2 expects a definition of {name} that is not known here; {_HINT}"
        )

    def _for_ros2(self, type: str, hash: str) -> TypePair:
        name = self._counterparts.to_ros1(type)
        try:
            message_class = load_message(name)
            return self._for_ros1(name, message_class._md5sum, message_class._full_text, hash)
        except MessageError:
            pass
        rule = self._mapping.fields.get((name, type))
        if rule is not None and _installed(name) is None:
            raise UnknownTypeError(
                f"the definition of {name} is not known here, and its field names differ from those of {type}; "
                f"install a ROS 1 package with {name}"
            )
        for types in self._candidates(type, name, {}, hash):
            if hash in (HUMBLE_HASH, type_hash(type, types)):
                text = ros1_definition(type, types, self._counterparts.to_ros1, _installed)
                message_class = self._definitions.get(name, "*", text)
                transcoder = Transcoder(name, _specs(name, text), type, types, self._mapping.fields)
                return TypePair(name, message_class._md5sum, text, type, hash, transcoder)
        if problem := self._rclpy_problem(type):
            raise UnknownTypeError(problem)
        if self.has_ros2_definition(type):
            raise UnknownTypeError(f"ROS 2 has a definition of {type} that is not known here; {_HINT}")
        raise UnknownTypeError(f"the definition of {type} is not known here; install a ROS 1 package with {name}")

    def _service(self, type: str, md5sum: str, hash: str | None) -> ServicePair:
        service_class = load_service(type)
        if md5sum not in ("*", service_class._md5sum):
            raise MessageError(f"the definition of {type} installed here differs from the provider's")
        texts = split_full_text(type, service_class._full_text)
        spec = parse_service(type, texts[type])
        specs = _specs(type, service_class._full_text, {each.name: each for each in (spec.request, spec.response)})
        name = _checked(self._counterparts.service_to_ros2(type))
        if problem := self._rclpy_problem(name):
            raise UnknownTypeError(problem)
        fields = self._mapping.fields
        for types in self._service_candidates(name, spec, specs, hash):
            own_hash = hash if hash == HUMBLE_HASH else service_hash(name, types)
            if hash is None or hash == own_hash:
                request = Transcoder(spec.request.name, specs, f"{name}_Request", types, fields)
                response = Transcoder(spec.response.name, specs, f"{name}_Response", types, fields)
                return ServicePair(type, service_class._md5sum, name, own_hash or "", request, response)
        raise UnknownTypeError(f"ROS 2 has another definition of {name} than ROS 1 has here")

    def _all_types(self, hash: str | None) -> Iterator[Types]:
        """Yield the types of each distribution that can have a type with a given hash."""
        order = ("humble",) if hash == HUMBLE_HASH else (self._default, *DISTRIBUTIONS)
        if self._beside_rclpy is not None:
            order = (self._default,)
        for distribution in dict.fromkeys(order):
            if distribution not in self._distributions:
                self._distributions[distribution] = distribution_types(distribution)
            yield self._distributions[distribution]

    def _rclpy_problem(self, name: str) -> str:
        """Return why rclpy cannot use a type; empty if it can, or if the bridge does not use rclpy."""
        return "" if self._beside_rclpy is None else self._beside_rclpy.problem(name)

    def _candidates(self, name: str, root: str, specs: dict[str, MessageSpec], hash: str | None) -> Iterator[Types]:
        """Yield sets of ROS 2 types that may contain the right type of that name: those of distributions, and the one
        derived from the ROS 1 definition, if that is given.
        """
        if name in self._installed:
            yield self.known
        yield from (types for types in self._all_types(hash) if name in types)
        if root in specs and self._beside_rclpy is None:
            yield LayeredTypes(self._counterparts.derive(specs[root], specs.__getitem__), self.known)

    def _service_candidates(
        self, name: str, spec: ServiceSpec, specs: dict[str, MessageSpec], hash: str | None
    ) -> Iterator[Types]:
        """Yield sets of ROS 2 types that may contain the right service of that name."""
        if f"{name}_Request" in self._installed:
            yield self.known
        derived = {} if self._beside_rclpy is not None else self._counterparts.derive_service(spec, specs.__getitem__)
        for distribution in self._all_types(hash):
            yield LayeredTypes(derived, distribution, self.known)


def _checked(name: str) -> str:
    """Return a type's name in ROS 2, after checking it.

    Raises:
        InvalidNameError: it is too long for a key.
    """
    dds_type(name)
    return name


def _is_in_ros1(name: str, is_service: bool) -> bool:
    try:
        (load_service if is_service else load_message)(name)
    except MessageError:
        return False
    return True


def _installed(name: str) -> MessageSpec | None:
    try:
        message_class = load_message(name)
    except MessageError:
        return None
    return parse_message(name, split_full_text(name, message_class._full_text)[name])


def _specs(type: str, text: str, service: Mapping[str, MessageSpec] | None = None) -> dict[str, MessageSpec]:
    """Return the types in the full text of a definition.

    Args:
        type, text: the type's name and full text.
        service: the request and response, if it is a service.
    """
    texts = split_full_text(type, text)
    if service is not None:
        del texts[type]
    specs = {name: parse_message(name, part) for name, part in texts.items()} | dict(service or {})
    if HEADER_TYPE not in specs:
        specs[HEADER_TYPE] = parse_message(HEADER_TYPE, "uint32 seq\ntime stamp\nstring frame_id\n")
    return specs
