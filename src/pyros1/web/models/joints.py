"""Prepares and checks data for the joints panel (no I/O)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from pyros1.ground.names import is_legal_name
from pyros1.urdf.joints import SLIDERS_TOPIC, JointStates, Options, read_options
from pyros1.urdf.model import UrdfError
from pyros1.web.server.wire import RequestError

MAX_JOINTS = 1_000
"""Maximum number of joints displayed, and of joints that one request may move."""
_MAX_SOURCES = 20


def describe(states: JointStates) -> list[dict[str, Any]]:
    """Return name, type, lower, upper and zero of the first `MAX_JOINTS` joints; for mimic joints, also ``follows``."""
    return [_joint(states, name) for name in states.names[:MAX_JOINTS]]


def _joint(states: JointStates, name: str) -> dict[str, Any]:
    mimic = states.followers.get(name)
    joint = states.free_joints[mimic.joint if mimic else name]
    limits = [joint.lower, joint.zero, joint.upper]
    if mimic:
        limits = [position * mimic.multiplier + mimic.offset for position in limits]
    description = {
        "name": name,
        "type": states.joint_types[name],
        "lower": min(limits[::2]),
        "upper": max(limits[::2]),
        "zero": limits[1],
    }
    return {**description, "follows": mimic.joint} if mimic else description


def publisher_options(params: object) -> Options:
    """Return the options of a node that publishes joints, or the defaults if its parameters are not valid options."""
    values = params if isinstance(params, Mapping) else {}
    try:
        return read_options(values.get)
    except UrdfError:
        return Options()


def position_topics(node: str, params: object) -> list[str]:
    """Return the topics on which a node that publishes joints may accept positions, the preferred topic first.

    Args:
        node: the node's full name.
        params: the node's private parameters.
    """
    listed = params.get("source_list", []) if isinstance(params, Mapping) else []
    names = [name for name in listed if isinstance(name, str) and name] if isinstance(listed, (list, tuple)) else []
    namespace = node.rpartition("/")[0]
    full_names = [name if name.startswith("/") else f"{namespace}/{name}" for name in names[:_MAX_SOURCES]]
    return [f"{node}/{SLIDERS_TOPIC}", *filter(is_legal_name, full_names)]


def check_positions(requested_positions: object) -> dict[str, float]:
    """Check the joint positions requested by a page, and return them.

    Args:
        requested_positions: an object that maps joints to positions in radians or metres.

    Raises:
        RequestError: the value is not an object of this form.
    """
    if not isinstance(requested_positions, dict) or len(requested_positions) > MAX_JOINTS:
        raise RequestError(f"positions must be an object with at most {MAX_JOINTS} joints")
    for position in requested_positions.values():
        if isinstance(position, bool) or not isinstance(position, (int, float)) or not math.isfinite(position):
            raise RequestError("a position must be a number")
    return requested_positions
