"""Calls that send and cancel action goals (https://wiki.ros.org/actionlib)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import count
from typing import Any

from pyros1.web.models.forms import form as form_of
from pyros1.web.robot import Robot
from pyros1.web.server.wire import RequestError
from pyros1.web.views.view import string_arg

_goal_numbers = count(1)


def form(robot: Robot, args: Mapping[str, Any]) -> dict[str, Any]:
    """Return the form for an action's goals; see `pyros1.web.models.forms.form`. Args: action."""
    name = string_arg(args, "action")
    robot.check_visible(f"{name}/goal")
    action_goal = robot.types.find_on(f"{name}/goal", _goal_type(robot, name))
    field_types = dict(zip(action_goal.__slots__, action_goal._slot_types, strict=True))
    if field_types.get("goal") not in action_goal._classes or "goal_id" not in field_types:
        raise RequestError(f"{action_goal._type} is not the type of an action's goals")
    return form_of(action_goal._classes[field_types["goal"]])


def send(robot: Robot, args: Mapping[str, Any]) -> dict[str, Any]:
    """Send a goal; return its id, and the number of servers to which it was sent. Args: action, value (the goal)."""
    name = string_arg(args, "action")
    robot.check_visible(f"{name}/goal")
    now = robot.node.now()
    goal_id = f"{robot.node.name}-{next(_goal_numbers)}-{now.secs}.{now.nsecs:09d}"
    stamp = {"secs": now.secs, "nsecs": now.nsecs}
    value = {
        "header": {"stamp": stamp},
        "goal_id": {"stamp": stamp, "id": goal_id},
        "goal": args.get("value"),
    }
    servers = robot.publishers.publish(f"{name}/goal", _goal_type(robot, name), value)
    return {"id": goal_id, "subscribers": servers}


def cancel(robot: Robot, args: Mapping[str, Any]) -> dict[str, Any]:
    """Tell an action's servers to cancel a goal; return the number of servers. Args: action, id (empty: all goals)."""
    topic = f"{string_arg(args, 'action')}/cancel"
    robot.check_visible(topic)
    servers = robot.publishers.publish(topic, "actionlib_msgs/GoalID", {"id": string_arg(args, "id")})
    return {"subscribers": servers}


def _goal_type(robot: Robot, name: str) -> str:
    type_name = robot.type_of(f"{name}/goal")
    if "/" not in type_name:
        raise RequestError(f"the type of {name}/goal is unknown")
    return type_name


CALLS: dict[str, Callable[[Robot, Mapping[str, Any]], Any]] = {"form": form, "send": send, "cancel": cancel}
CHANGES = frozenset({"send", "cancel"})
