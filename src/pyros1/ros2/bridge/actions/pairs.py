"""Pairs ROS 1 and ROS 2 action types, and makes converters for goals, results and feedback.

As for services, ROS 1's definitions are used: pyros1 has no ROS 2 distribution's action definitions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from io import BytesIO
from typing import Any, NamedTuple

from pyros1.ground.errors import MessageError, UnknownTypeError
from pyros1.msgs import DefinitionCache, load_message
from pyros1.msgs.digest import split_full_text
from pyros1.msgs.spec import HEADER_TYPE, MessageSpec, parse_message
from pyros1.ros2.pairs.lookup_cache import LookupCache
from pyros1.ros2.zenoh.names import HUMBLE_HASH
from pyros1.ros2_types.counterparts import Counterparts
from pyros1.ros2_types.interfaces import action_types
from pyros1.ros2_types.mapping import FieldRules
from pyros1.ros2_types.model import Field, FieldType, Length, MessageType, Types
from pyros1.ros2_types.nesting import LayeredTypes
from pyros1.ros2_types.transcoding.transcoder import Transcoder
from pyros1.ros2_types.type_hash import service_hash, type_hash
from pyros1.wire.handshake import TopicType

CANCEL_TYPE = "action_msgs/srv/CancelGoal"
STATUS_TYPE = "action_msgs/msg/GoalStatusArray"
_GOAL_INFO = FieldType("action_msgs/msg/GoalInfo")
_CANCEL_PARTS = {
    each.name: each
    for each in (
        MessageType(f"{CANCEL_TYPE}_Request", (Field("goal_info", _GOAL_INFO),)),
        MessageType(
            f"{CANCEL_TYPE}_Response",
            (
                Field("return_code", FieldType("int8")),
                Field("goals_canceling", FieldType(_GOAL_INFO.base, Length.UNBOUNDED)),
            ),
        ),
    )
}
_UUID = "unique_identifier_msgs/UUID"
_UUID_SPEC = parse_message(_UUID, "uint8[16] uuid\n")
_PARTS = ("Goal", "Result", "Feedback")


class ActionHashes(NamedTuple):
    """The type hashes of an action's services and topics in ROS 2."""

    send_goal: str
    get_result: str
    feedback: str
    cancel_goal: str
    status: str


class ActionPair(NamedTuple):
    """A ROS 1 action type and its counterpart in ROS 2.

    Attributes:
        ros1: its name in ROS 1, ``actionlib_tutorials/Fibonacci``.
        goal, result, feedback: the types of its topics in ROS 1.
        ros2: its name in ROS 2.
        hashes: its hashes there.
        to_goal, to_result, to_feedback: convert a UUID and a goal, a one-byte status and a result, and a UUID and
            feedback; in ROS 1's encoding, the two simply follow each other.
        empty_result: a result with default values, in ROS 1's encoding.
    """

    ros1: str
    goal: TopicType
    result: TopicType
    feedback: TopicType
    ros2: str
    hashes: ActionHashes
    to_goal: Transcoder
    to_result: Transcoder
    to_feedback: Transcoder
    empty_result: bytes


class ActionPairs:
    """Finds pairs of ROS 1 and ROS 2 action types, and remembers what it has found. Not thread-safe.

    Args:
        counterparts: gives the types' names on the other side.
        all_types: yields the types of each distribution that can have a type with a given hash; None for any hash.
        default: the types of the default distribution, and of packages on this machine.
        fields: which fields have different names in ROS 2.
        definitions: finds the classes for ROS 1 definitions.
        found: caches the pairs.
    """

    def __init__(
        self,
        counterparts: Counterparts,
        all_types: Callable[[str | None], Iterator[Types]],
        default: Types,
        fields: FieldRules,
        definitions: DefinitionCache,
        found: LookupCache[ActionPair],
    ) -> None:
        self._counterparts = counterparts
        self._all_types = all_types
        self._default = default
        self._fields = fields
        self._definitions = definitions
        self._found = found

    def for_ros1(self, type: str, topics: Mapping[str, TopicType], hash: str | None = None) -> ActionPair:
        """Return the pair of types for a ROS 1 action type.

        Args:
            type: its name, ``package/Type``.
            topics: the known types of the topics ``goal``, ``result`` and ``feedback``; the other definitions must be
                installed.
            hash: the hash of the service ``send_goal`` that ROS 2 expects; None for the default distribution's.

        Raises:
            Error: a definition is not known, or ROS 2 expects another type of this name.
        """
        words = [word for name, topic in sorted(topics.items()) for word in (name, topic.md5sum, topic.definition)]
        return self._found.get(
            (type, hash, *words), lambda: self._find(type, topics, hash), is_limited=hash is not None
        )

    def for_ros2(self, type: str, hash: str) -> ActionPair:
        """Return the pair of types for a ROS 2 action type.

        Args:
            type: its name, ``package/action/Type``.
            hash: the hash of its service ``send_goal``.

        Raises:
            Error: ROS 1 has no action of this name here, or a different one.
        """
        return self._found.get(
            (type, hash), lambda: self._find(self._counterparts.to_ros1(type), {}, hash), is_limited=True
        )

    def _find(self, type: str, topics: Mapping[str, TopicType], hash: str | None) -> ActionPair:
        classes: dict[str, Any] = {part: self._class(type, part, topics.get(part.lower())) for part in _PARTS}
        specs = _specs(type, (each._full_text for each in classes.values()))
        name = self._counterparts.action_to_ros2(type)
        for known in self._candidates(name, type, specs, hash):
            types = LayeredTypes(action_types(name, known), known)
            hashes = _hashes(name, types, hash)
            if hash is None or hash == hashes.send_goal:
                result = BytesIO()
                classes["Result"]().result.serialize(result)
                goal_type, result_type, feedback_type = (
                    TopicType(each._type, each._md5sum, each._full_text) for each in classes.values()
                )
                return ActionPair(
                    type,
                    goal_type,
                    result_type,
                    feedback_type,
                    name,
                    hashes,
                    Transcoder(f"{type}SendGoal", specs, f"{name}_SendGoal_Request", types, self._fields),
                    Transcoder(f"{type}GetResult", specs, f"{name}_GetResult_Response", types, self._fields),
                    Transcoder(f"{type}FeedbackMessage", specs, f"{name}_FeedbackMessage", types, self._fields),
                    result.getvalue(),
                )
        raise UnknownTypeError(f"ROS 2 has another definition of {name} than ROS 1 has here")

    def _candidates(self, name: str, type: str, specs: Mapping[str, MessageSpec], hash: str | None) -> Iterator[Types]:
        """Yield sets of ROS 2 types that may contain the right parts of the action."""
        if f"{name}_Goal" in self._default:
            yield self._default
        derived = self._counterparts.derive_action(type, specs.__getitem__)
        for distribution in self._all_types(hash):
            yield LayeredTypes(derived, distribution, self._default)

    def _class(self, type: str, part: str, topic: TopicType | None) -> Any:
        """Return the class of the messages on a topic."""
        name = f"{type}Action{part}"
        if topic is None:
            return load_message(name)
        found = self._definitions.get(name, topic.md5sum, topic.definition)
        if found._md5sum != topic.md5sum:
            raise MessageError(f"the definition of {name} that its publisher sends does not match its md5sum")
        return found


def _specs(type: str, texts: Iterable[str]) -> dict[str, MessageSpec]:
    """Return the types in the full texts of an action's messages, and ROS 1 equivalents of ROS 2's action messages."""
    specs = {HEADER_TYPE: parse_message(HEADER_TYPE, "uint32 seq\ntime stamp\nstring frame_id\n"), _UUID: _UUID_SPEC}
    for part, text in zip(_PARTS, texts, strict=True):
        specs |= {
            name: parse_message(name, definition)
            for name, definition in split_full_text(f"{type}Action{part}", text).items()
        }
    for name, text in {
        f"{type}SendGoal": f"{_UUID} goal_id\n{type}Goal goal\n",
        f"{type}GetResult": f"int8 status\n{type}Result result\n",
        f"{type}FeedbackMessage": f"{_UUID} goal_id\n{type}Feedback feedback\n",
    }.items():
        specs[name] = parse_message(name, text)
    return specs


def _hashes(name: str, types: Types, hash: str | None) -> ActionHashes:
    if hash == HUMBLE_HASH:
        return ActionHashes(*[HUMBLE_HASH] * len(ActionHashes._fields))
    return ActionHashes(
        service_hash(f"{name}_SendGoal", types),
        service_hash(f"{name}_GetResult", types),
        type_hash(f"{name}_FeedbackMessage", types),
        service_hash(CANCEL_TYPE, LayeredTypes(_CANCEL_PARTS, types)),
        type_hash(STATUS_TYPE, types),
    )
