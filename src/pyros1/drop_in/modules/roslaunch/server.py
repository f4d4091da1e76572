"""The XML-RPC server of a launch, which other programs can query (https://wiki.ros.org/roslaunch/Architecture)."""

from __future__ import annotations

from typing import Any

from pyros1.drop_in.module_attributes import module_getattr


class ROSLaunchParentNode:
    """The server of a launch, which runs with it.

    Args:
        rl_config: the ROSLaunchConfig.
        pm: the ProcessMonitor.
        uri: address of the server.

    Attributes:
        rl_config, pm, uri: the arguments.
    """

    def __init__(self, rl_config: Any, pm: Any, uri: str = "") -> None:
        self.rl_config = rl_config
        self.pm = pm
        self.uri = uri

    def add_process_listener(self, l: Any) -> None:  # noqa: E741
        """Call an object's ``process_died`` for each process that exits."""
        self.pm.add_process_listener(l)

    def start(self) -> None:
        """Do nothing: the server starts with the launch."""

    def shutdown(self, reason: str) -> None:
        """Do nothing: the server ends with the launch."""


__getattr__ = module_getattr(
    "roslaunch.server",
    ROSLaunchChildNode="`pyros1 launch` runs nodes on other machines itself",
)
