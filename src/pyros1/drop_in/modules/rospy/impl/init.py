"""Starts nodes in stock ROS; in pyros1, only `rospy.init_node` does that."""

from __future__ import annotations

from typing import Any

from rosgraph.roslogging import RosStreamHandler

__all__ = ["RosStreamHandler", "start_node"]


def start_node(
    environ: Any, resolved_name: str, master_uri: str | None = None, port: int = 0, tcpros_port: int = 0
) -> Any:
    """Raise NotImplementedError: only `rospy.init_node` starts a program's node.

    Raises:
        NotImplementedError: always.
    """
    raise NotImplementedError("pyros1 has no rospy.impl.init.start_node: use rospy.init_node")
