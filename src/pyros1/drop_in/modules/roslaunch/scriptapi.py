"""Launches single nodes from a program."""

from __future__ import annotations

from typing import Any

from roslaunch.core import Master, Node, RLException
from roslaunch.parent import ROSLaunchParent
from roslaunch.pmon import Process
from roslaunch.rlutil import get_or_generate_uuid

__all__ = ["Master", "Node", "RLException", "ROSLaunch"]


class ROSLaunch:
    """Launches nodes, and starts a master if none is running.

    Attributes:
        parent: the ROSLaunchParent.
    """

    def __init__(self) -> None:
        self.started = False
        self.parent = ROSLaunchParent(
            get_or_generate_uuid(None, False), [], roslaunch_strs=[], show_summary=False, process_listeners=[]
        )

    def load(self, f: Any) -> None:
        """Add a launch file, before `start`."""
        self.parent.roslaunch_files.append(f)

    def load_str(self, s: str) -> None:
        """Add the contents of a launch file, before `start`."""
        self.parent.roslaunch_strs.append(s)

    def start(self) -> None:
        """Start the launch, so that nodes can be launched; raise RLException if it cannot be started."""
        self.parent.start(auto_terminate=False)
        self.started = True

    def launch(self, node: Node) -> Process:
        """Start a node; return its process.

        Raises:
            RLException: the node cannot be started, or `start` was not called.
            ValueError: ``node`` is not a Node.
        """
        if not self.started or self.parent.runner is None:
            raise RLException("please start ROSLaunch first")
        if not isinstance(node, Node):
            raise ValueError("arg must be of type Node")
        process, started = self.parent.runner.launch_node(node)
        if not started:
            raise RLException(f"failed to launch {node.package}/{node.type}")
        return process

    def spin(self) -> None:
        """Wait until the launch has ended. Ctrl-C ends it."""
        self.parent.spin()

    def spin_once(self) -> bool:
        """Return whether anything is still running."""
        return self.parent.spin_once()

    def stop(self) -> None:
        """Stop all nodes."""
        self.parent.shutdown()
