"""The content of a robot description, as far as it concerns moving links: https://wiki.ros.org/urdf/XML. Pure."""

from __future__ import annotations

from dataclasses import dataclass, field

from pyros1.ground.errors import Error
from pyros1.tf.rotation import IDENTITY, Transform, Vector

MOVING_TYPES = frozenset({"revolute", "continuous", "prismatic"})
"""Types of joints whose position is a single number."""
JOINT_TYPES = MOVING_TYPES | {"fixed", "floating", "planar"}


MAX_WARNINGS = 50


class UrdfError(Error):
    """A robot description, or a parameter of its publishers, is invalid; the message says which part, and often how to
    fix it.
    """


@dataclass(frozen=True)
class Limit:
    """A joint's range, in radians or metres.

    Attributes:
        lower, upper: the limits.
        soft_lower, soft_upper: the limits of its safety_controller; None if it has none.
    """

    lower: float = 0.0
    upper: float = 0.0
    soft_lower: float | None = None
    soft_upper: float | None = None


@dataclass(frozen=True)
class Mimic:
    """How a joint follows another one: its position is ``multiplier`` times that of ``joint``, plus ``offset``."""

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class Joint:
    """A joint.

    Attributes:
        name: its name.
        type: one of `JOINT_TYPES`.
        parent, child: the links that it connects.
        origin: the child's pose in the parent at position 0.
        axis: unit vector in the child's frame; (0, 0, 0) for a joint that cannot move.
        limit: its range; None if no range is specified.
        mimic: the joint that it follows; None if it does not follow another joint.
    """

    name: str
    type: str
    parent: str
    child: str
    origin: Transform = IDENTITY
    axis: Vector = (1.0, 0.0, 0.0)
    limit: Limit | None = None
    mimic: Mimic | None = None


@dataclass(frozen=True)
class Robot:
    """A robot.

    Attributes:
        name: its name.
        links: names of its links, in the order of the description.
        joints: its joints by name, in the order of the description.
        warnings: problems that do not prevent the robot's use.
    """

    name: str
    links: tuple[str, ...]
    joints: dict[str, Joint]
    warnings: tuple[str, ...] = field(default=())


def limit_warnings(warnings: list[str]) -> list[str]:
    """Return at most `MAX_WARNINGS` of the warnings, followed by the number of any others."""
    num_more = len(warnings) - MAX_WARNINGS
    return [*warnings[:MAX_WARNINGS], f"and {num_more} more like these"] if num_more > 0 else warnings
