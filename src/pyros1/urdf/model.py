"""The links and joints in a robot description (https://wiki.ros.org/urdf/XML), and how they move (no I/O)."""

from __future__ import annotations

from dataclasses import dataclass, field

from pyros1.ground.errors import Error
from pyros1.tf.rotation import IDENTITY, Transform, Vector

MOVING_TYPES = frozenset({"revolute", "continuous", "prismatic"})
"""Types of joints whose position is a single number."""
JOINT_TYPES = MOVING_TYPES | {"fixed", "floating", "planar"}


MAX_WARNINGS = 50


class UrdfError(Error):
    """A robot description or a related parameter is invalid.

    The error message says which part is invalid, and often how to fix it.
    """


@dataclass(frozen=True)
class Limit:
    """A joint's range, in radians or metres.

    Attributes:
        lower, upper: the limits.
        soft_lower, soft_upper: the limits of the joint's safety_controller; None if it specifies none.
    """

    lower: float = 0.0
    upper: float = 0.0
    soft_lower: float | None = None
    soft_upper: float | None = None


@dataclass(frozen=True)
class Mimic:
    """The rule by which a joint follows another one: its position is the position of ``joint``, times ``multiplier``,
    plus ``offset``.
    """

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class Joint:
    """A joint, which connects two links.

    Attributes:
        name: the joint's name.
        type: one of `JOINT_TYPES`.
        parent, child: the names of the links that the joint connects.
        origin: the child's pose in the parent at position 0.
        axis: unit vector in the child's frame; (0, 0, 0) for a joint that cannot move.
        limit: the joint's range; None if no range is specified.
        mimic: the rule by which the joint follows another joint; None if it does not.
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
    """A robot, as described by its links and joints.

    Attributes:
        name: the robot's name.
        links: names of the links, in the order of the description.
        joints: the joints by name, in the order of the description.
        warnings: problems in the description that do not prevent its use.
    """

    name: str
    links: tuple[str, ...]
    joints: dict[str, Joint]
    warnings: tuple[str, ...] = field(default=())


def truncate_warnings(warnings: list[str]) -> list[str]:
    """Return the first `MAX_WARNINGS` warnings; if there are more, add a line with the number of omitted ones."""
    num_more = len(warnings) - MAX_WARNINGS
    return [*warnings[:MAX_WARNINGS], f"and {num_more} more like these"] if num_more > 0 else warnings
