"""The joint states that joint_state_publisher publishes: limits, positions, and joints that follow others (no I/O)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite, pi
from typing import Any

from pyros1.ground.terminal_text import one_line
from pyros1.urdf.model import MOVING_TYPES, Joint, Mimic, Robot, UrdfError, truncate_warnings

MAX_SOURCE_TOPICS = 100
SLIDERS_TOPIC = "sliders"
"""Private topic of joint_state_publisher, on which a web page sets the positions of joints."""


@dataclass(frozen=True)
class Options:
    """Options for publishing joints, named like stock's parameters.

    Attributes:
        rate: messages per second.
        source_list: topics that provide joint states.
        zeros: joint -> initial position in radians or metres.
        dependent_joints: joint -> rule by which it follows another joint.
        use_mimic_tags: whether joints follow other joints as the description's mimic tags say.
        use_smallest_joint_limits: whether the limits in safety_controller tags also apply.
        publish_default_positions, publish_default_velocities, publish_default_efforts: whether default values are
            published before a source provides any.
        delta: distance, in radians or metres, by which free joints move before each message, back and forth between
            their limits; 0 if they do not move.
    """

    rate: float = 10.0
    source_list: tuple[str, ...] = ()
    zeros: Mapping[str, float] = field(default_factory=dict)
    dependent_joints: Mapping[str, Mimic] = field(default_factory=dict)
    use_mimic_tags: bool = True
    use_smallest_joint_limits: bool = True
    publish_default_positions: bool = True
    publish_default_velocities: bool = False
    publish_default_efforts: bool = False
    delta: float = 0.0


def read_options(get: Callable[[str, Any], Any]) -> Options:
    """Read the options from parameters.

    Args:
        get: takes a parameter's name and default, and returns its value.

    Raises:
        UrdfError: a value has the wrong type; the message names the parameter.
    """
    topics = get("source_list", [])
    if not isinstance(topics, (list, tuple)) or not all(isinstance(topic, str) for topic in topics):
        raise UrdfError("the parameter source_list must be a list of topics")
    if len(topics) > MAX_SOURCE_TOPICS:
        raise UrdfError(f"the parameter source_list has more than {MAX_SOURCE_TOPICS} topics")
    rate = _read_number(get("rate", 10), "rate")
    if rate <= 0:
        raise UrdfError("the parameter rate must be above 0")
    flags = {
        name: bool(get(name, default))
        for name, default in (
            ("use_mimic_tags", True),
            ("use_smallest_joint_limits", True),
            ("publish_default_positions", True),
            ("publish_default_velocities", False),
            ("publish_default_efforts", False),
        )
    }
    return Options(
        rate=rate,
        source_list=tuple(topics),
        zeros={
            name: _read_number(value, f"zeros/{name}")
            for name, value in _read_mapping(get("zeros", {}), "zeros").items()
        },
        dependent_joints={
            name: _read_dependent_joint(value, f"dependent_joints/{name}")
            for name, value in _read_mapping(get("dependent_joints", {}), "dependent_joints").items()
        },
        delta=_read_number(get("delta", 0.0), "delta"),
        **flags,
    )


@dataclass
class FreeJoint:
    """The state of a joint that does not follow another joint.

    Attributes:
        joint: the joint's description.
        lower, upper: the limits in radians or metres; for a continuous joint, half a turn in each direction.
        zero: the initial position, at which the joint counts as centred, in radians or metres.
        position, velocity, effort: the current values; None for values that are not known.
    """

    joint: Joint
    lower: float
    upper: float
    zero: float
    position: float | None = None
    velocity: float | None = None
    effort: float | None = None
    _moves_back: bool = False

    def step(self, distance: float) -> None:
        """Move by ``distance`` in the current direction; if this exceeds a limit, stop there and reverse the
        direction.
        """
        position = (self.zero if self.position is None else self.position) + (
            -distance if self._moves_back else distance
        )
        if not self.lower <= position <= self.upper:
            self._moves_back = position > self.upper
            position = min(max(position, self.lower), self.upper)
        self.position = position


class JointStates:
    """The states of all movable joints of a robot.

    Args:
        robot: the robot's description.
        options: how the states are published.

    Attributes:
        names: names of the movable joints, in the order of the description.
        joint_types: name of a movable joint -> its type.
        free_joints: the joints that do not follow another joint, by name.
        followers: joint -> rule by which it follows a free joint, directly or through other joints.
        warnings: problems that do not prevent publishing.
    """

    def __init__(self, robot: Robot, options: Options) -> None:
        self.options = options
        self.warnings = list(robot.warnings)
        joints = {name: joint for name, joint in robot.joints.items() if joint.type in MOVING_TYPES}
        leaders = {name: joint.mimic for name, joint in joints.items() if joint.mimic and options.use_mimic_tags}
        leaders.update({name: mimic for name, mimic in options.dependent_joints.items() if name in joints})
        for name in [*options.zeros, *options.dependent_joints]:
            if name not in joints:
                self.warnings.append(f"{_escaped(name)} has a parameter, but there is no movable joint of this name")
        for name in [name for name, mimic in leaders.items() if mimic.joint not in joints]:
            self.warnings.append(
                f"joint {_escaped(name)} follows {_escaped(leaders.pop(name).joint)}, which does not move"
            )
        self.followers = _resolve_mimic_joints(leaders, self.warnings)
        self.warnings = truncate_warnings(self.warnings)
        self.names = tuple(joints)
        self.joint_types = {name: joint.type for name, joint in joints.items()}
        self.free_joints = {
            name: self._make_free_joint(joint) for name, joint in joints.items() if name not in self.followers
        }

    def apply(
        self,
        names: Sequence[str],
        positions: Sequence[float] = (),
        velocities: Sequence[float] = (),
        efforts: Sequence[float] = (),
    ) -> None:
        """Apply the values in a message from a source.

        Unknown joints, joints that follow other joints, and non-finite numbers are ignored.
        """
        for index, name in enumerate(names):
            joint = self.free_joints.get(name)
            if joint is None:
                continue
            if index < len(positions) and isfinite(positions[index]):
                joint.position = positions[index]
            if index < len(velocities) and isfinite(velocities[index]):
                joint.velocity = velocities[index]
            if index < len(efforts) and isfinite(efforts[index]):
                joint.effort = efforts[index]

    def step(self) -> None:
        """Move the free joints by the option ``delta``."""
        if self.options.delta:
            for joint in self.free_joints.values():
                joint.step(self.options.delta)

    def message_fields(self) -> tuple[list[str], list[float], list[float], list[float]]:
        """Return the names, positions, velocities and efforts of all movable joints.

        The positions, velocities or efforts are empty if no joint has such a value.
        """
        free_joints = self.free_joints.values()
        # As in stock ROS, positions are always published if there are followers.
        has_positions = bool(self.followers) or any(joint.position is not None for joint in free_joints)
        positions = [self._position(name) for name in self.names] if has_positions else []
        has_velocities = any(joint.velocity is not None for joint in free_joints)
        velocities = [self._velocity(name) for name in self.names] if has_velocities else []
        has_efforts = any(joint.effort is not None for joint in free_joints)
        efforts = [self._leader(name).effort or 0.0 for name in self.names] if has_efforts else []
        return list(self.names), positions, velocities, efforts

    def _leader(self, name: str) -> FreeJoint:
        follower = self.followers.get(name)
        return self.free_joints[follower.joint if follower else name]

    def _position(self, name: str) -> float:
        position = self._leader(name).position
        if position is None:
            return 0.0
        follower = self.followers.get(name)
        return position * follower.multiplier + follower.offset if follower else position

    def _velocity(self, name: str) -> float:
        follower = self.followers.get(name)
        return (self._leader(name).velocity or 0.0) * (follower.multiplier if follower else 1.0)

    def _make_free_joint(self, joint: Joint) -> FreeJoint:
        lower, upper = joint_limits(joint, self.options.use_smallest_joint_limits)
        zero = self.options.zeros.get(joint.name, (lower + upper) / 2 if lower > 0 or upper < 0 else 0.0)
        free_joint = FreeJoint(joint, lower, upper, zero)
        if self.options.publish_default_positions:
            free_joint.position = zero
        if self.options.publish_default_velocities:
            free_joint.velocity = 0.0
        if self.options.publish_default_efforts:
            free_joint.effort = 0.0
        return free_joint


def joint_limits(joint: Joint, uses_soft_limits: bool = True) -> tuple[float, float]:
    """Return a joint's range, in radians or metres.

    Args:
        joint: a joint whose type is in `MOVING_TYPES`.
        uses_soft_limits: whether the limits of the joint's safety_controller also apply.
    """
    if joint.type == "continuous" or joint.limit is None:
        return -pi, pi
    limit = joint.limit
    lower, upper = limit.lower, limit.upper
    if uses_soft_limits:
        lower = lower if limit.soft_lower is None else max(lower, limit.soft_lower)
        upper = upper if limit.soft_upper is None else min(upper, limit.soft_upper)
    return lower, max(lower, upper)


def _resolve_mimic_joints(leaders: Mapping[str, Mimic], warnings: list[str]) -> dict[str, Mimic]:
    """Return the rule by which each follower follows a free joint, directly or through other joints.

    If joints follow each other in a cycle, one of them is treated as a free joint, and a warning is appended to
    ``warnings``.
    """
    resolved: dict[str, Mimic] = {}
    free: set[str] = set()
    for name in leaders:
        path: dict[str, None] = {}
        current = name
        while current in leaders and current not in resolved and current not in free and current not in path:
            path[current] = None
            current = leaders[current].joint
        if current in path:
            free.add(current)
            warnings.append(f"joint {_escaped(current)} follows itself, so it is treated as a free joint")
        for follower in reversed(path):
            if follower not in free:
                mimic = leaders[follower]
                leader = resolved.get(mimic.joint, Mimic(mimic.joint))
                resolved[follower] = Mimic(
                    leader.joint,
                    mimic.multiplier * leader.multiplier,
                    mimic.multiplier * leader.offset + mimic.offset,
                )
    return resolved


def _read_dependent_joint(value: object, name: str) -> Mimic:
    values = _read_mapping(value, name)
    parent = values.get("parent")
    if not isinstance(parent, str):
        raise UrdfError(f"the parameter {_escaped(name)} must have a parent: the name of a joint")
    factor, offset = (
        _read_number(values.get("factor", 1.0), f"{name}/factor"),
        _read_number(values.get("offset", 0.0), name),
    )
    return Mimic(parent, factor, offset)


def _read_mapping(value: object, name: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise UrdfError(f"the parameter {_escaped(name)} must be a mapping: joint -> value")
    return value


def _read_number(value: object, name: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not isfinite(value):
        raise UrdfError(f"the parameter {_escaped(name)} must be a number")
    return float(value)


def _escaped(name: str) -> str:
    return one_line(name, 200)
