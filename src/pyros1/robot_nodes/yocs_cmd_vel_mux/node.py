"""cmd_vel_mux: passes the command with the highest priority on to ~output.

It replaces the nodelet yocs_cmd_vel_mux/CmdVelMuxNodelet (https://wiki.ros.org/yocs_cmd_vel_mux). It publishes the name
of the source that drives the robot on ~active, or "idle" if there is none.

When the source that drives the robot falls silent, a zero twist is published once; with stock, the robot must notice
this itself. Commands that are not finite are dropped.
"""

from __future__ import annotations

import threading
from functools import partial
from typing import Any

from pyros1.ground.errors import Error, NodeShutdownError
from pyros1.msgs.geometry_msgs.msg import Twist
from pyros1.msgs.std_msgs.msg import String
from pyros1.node import Node
from pyros1.reconfigure import Parameters, Server
from pyros1.robot_nodes.shared.node_clock import NodeClock, check_regularly
from pyros1.robot_nodes.shared.program import run_node
from pyros1.robot_nodes.shared.twists import TwistOutput, is_finite
from pyros1.robot_nodes.shared.user_files import read_regular_file
from pyros1.robot_nodes.yocs_cmd_vel_mux.config import Config, ConfigError, read_config
from pyros1.robot_nodes.yocs_cmd_vel_mux.selector import Selector

CHECK_PERIOD = 0.05
"""Seconds between checks of whether the robot must be stopped."""
_MAX_FILE_SIZE = 1 << 20


def load_config(file: str, text: str) -> Config:
    """Return the configuration from a string, or from a file if the string is empty.

    Raises:
        Error: the configuration cannot be used.
    """
    if text:
        return read_config(text, "yaml_cfg_data")
    if not file:
        raise ConfigError("the parameter yaml_cfg_file is not set, so nothing can drive the robot: set it to a file")
    try:
        text = read_regular_file(file, _MAX_FILE_SIZE).decode("utf-8")
    except (OSError, ValueError) as error:
        raise ConfigError(f"cannot read the file that yaml_cfg_file names: {error}") from error
    return read_config(text, file)


class CmdVelMux:
    """Subscribes to the topics of a configuration, which can be changed while the node is running.

    Args:
        node: the node.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._clock = NodeClock(node)
        self._lock = threading.RLock()
        self._selector = Selector(())
        self._subscribers: list[Any] = []
        self._output: TwistOutput | None = None
        self._has_ended = False
        self._announced = ""
        self._active = node.advertise("~active", String, queue_size=1, latch=True)
        self._announce()
        parameters = Parameters()
        parameters.add("yaml_cfg_file", "", "A file with the configuration", level=1)
        parameters.add("yaml_cfg_data", "", "The configuration itself, instead of the file", level=1)
        node.on_shutdown(self._end)
        self._server = Server(node, parameters, self._reconfigure)
        check_regularly(node, CHECK_PERIOD, self._check)

    def _end(self) -> None:
        with self._lock:
            self._has_ended = True
            if self._output is not None:
                self._output.end()

    def _reconfigure(self, values: Any, level: int) -> Any:
        try:
            config = load_config(values.yaml_cfg_file, values.yaml_cfg_data)
            for topic in (config.output, *(source.topic for source in config.sources)):
                self._node.resolve(f"~{topic}")  # check the names before replacing the current configuration
            self._apply(config)
        except NodeShutdownError:
            raise
        except Error as error:
            self._node.log.error("%s", error)
        return values

    def _apply(self, config: Config) -> None:
        """Replace the configuration; the robot is stopped first.

        The lock is not held while waiting for the master, so that the robot is stopped in time even if it is slow.
        """
        selector = Selector(config.sources)
        with self._lock:
            old_output, old_subscribers = self._output, self._subscribers
            self._output, self._subscribers, self._selector = None, [], selector
            self._announce()
        if old_output is not None:
            old_output.close()
        for subscriber in old_subscribers:
            subscriber.unregister()
        output = TwistOutput(self._node, f"~{config.output}", ends_with_node=False)
        with self._lock:
            self._output = output
            if self._has_ended:
                output.end()
        for index, source in enumerate(config.sources):
            command = partial(self._command, selector, index)
            self._subscribers.append(self._node.subscribe(f"~{source.topic}", Twist, command, queue_size=1))

    def _command(self, selector: Selector, index: int, twist: Any) -> None:
        if not is_finite(twist):
            self._node.log.error("dropped a command, since it is not finite", throttle=10)
            return
        with self._lock:
            if selector is not self._selector or self._output is None:
                return  # received before the configuration was replaced
            if selector.command(index, self._clock.seconds()):
                self._announce()
                self._output.publish(twist)

    def _check(self) -> None:
        with self._lock:
            if self._output is not None and self._selector.must_stop(self._clock.seconds()):
                self._output.stop()
                self._announce()

    def _announce(self) -> None:
        """Publish the name of the source that drives the robot if it has changed."""
        active = self._selector.active
        if active != self._announced:
            self._announced = active
            self._active.publish(active)


def main(argv: list[str]) -> int:
    """Run cmd_vel_mux; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    return run_node(argv, "cmd_vel_mux", CmdVelMux)
