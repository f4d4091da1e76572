"""Message classes that stock's tf2_ros also has under its own name; they are made when first used."""

from __future__ import annotations

from typing import Any

_HOMES = {
    "FrameGraph": "tf2_msgs.srv",
    "FrameGraphResponse": "tf2_msgs.srv",
    "GoalStatus": "actionlib_msgs.msg",
    "Header": "std_msgs.msg",
    "LookupTransformAction": "tf2_msgs.msg",
    "LookupTransformGoal": "tf2_msgs.msg",
    "TFMessage": "tf2_msgs.msg",
    "TransformStamped": "geometry_msgs.msg",
}


def __getattr__(name: str) -> Any:
    from importlib import import_module

    if name in _HOMES:
        return getattr(import_module(f"pyros1.msgs.{_HOMES[name]}"), name)
    if name == "BufferServer":
        raise AttributeError("stock's tf2_ros has no BufferServer in Python; pyros1.tf has one, for pyros1.Node")
    raise AttributeError(f"pyros1 has no tf2_ros.{name}")
