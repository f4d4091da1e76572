"""teleop_twist_keyboard: publishes velocities on cmd_vel as keys are pressed, and stops the robot when it ends."""

from __future__ import annotations

import contextlib
import signal
import sys
import threading
from time import monotonic
from typing import Any

from pyros1.ground.errors import Error, NodeShutdownError
from pyros1.ground.interrupts import TERMINATION_SIGNALS
from pyros1.ground.keys import KeyReader
from pyros1.msgs.geometry_msgs.msg import Twist, TwistStamped
from pyros1.node import Node
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.robot_nodes.teleop_twist_keyboard.driver import STOPPED, Driver, Velocity

HELP_TEXT = """
Drive with the keyboard: this publishes velocities.
---------------------------
Move and turn:             Move sideways, with shift:
   u    i    o                U    I    O
   j    k    l                J    K    L
   m    ,    .                M    <    >

t : up      b : down       any other key : stop

q/z : raise/lower both speeds by 10%
w/x : raise/lower the linear speed by 10%
e/c : raise/lower the angular speed by 10%

Ctrl-C to quit
"""
_POLL_PERIOD = 0.2
"""Seconds between checks of whether the node has shut down."""
_WAITING_PERIOD = 2.5
"""Seconds between reminders that nobody subscribes."""
_HELP_PERIOD = 15
"""The keys are shown again after this many changes of the speeds."""


class Teleop:
    """Drives a robot as keys are pressed.

    Args:
        node: the node, with the parameters ``~speed``, ``~turn``, ``~speed_limit``, ``~turn_limit``, ``~repeat_rate``
            (per second; 0: velocities are published only when keys are pressed), ``~key_timeout`` (seconds after the
            last key until the robot stops; 0: it does not), ``~stamped`` and ``~frame_id``.
    """

    def __init__(self, node: Node) -> None:
        parameters = PrivateParameters.of(node)
        self._node = node
        self._driver = Driver(
            parameters.number("speed", 0.5),
            parameters.number("turn", 1.0),
            parameters.number("speed_limit", 1000.0),
            parameters.number("turn_limit", 1000.0),
        )
        self._key_timeout = parameters.number("key_timeout", 0.0, 0.0)
        self._is_stamped = parameters.flag("stamped", False)
        self._frame = parameters.text("frame_id", "")
        self._lock = threading.Lock()  # ensures that nothing is published after the velocity that stops the robot
        self._ended = False
        self._num_changes = 0
        self._last_key_at = monotonic()
        self._publisher = node.advertise("cmd_vel", TwistStamped if self._is_stamped else Twist, queue_size=1)
        node.on_shutdown(self.stop, early=True)
        if rate := parameters.number("repeat_rate", 0.0, 0.0, 1000.0):
            node.timer(1.0 / rate, lambda event: self.publish())

    @property
    def topic(self) -> str:
        """The full name of the topic."""
        return self._node.resolve("cmd_vel")

    def wait_for_subscribers(self, timeout: float) -> bool:
        """Wait until there is a subscriber; return whether there is one.

        Args:
            timeout: maximum number of seconds to wait.
        """
        return self._publisher.wait_for_subscribers(timeout=timeout)

    def press(self, key: str) -> list[str]:
        """Handle a key and publish the velocity; return the lines to show."""
        self._last_key_at = monotonic()
        with self._lock:
            lines = self._driver.press(key)
        self.publish()
        if lines:
            self._num_changes += 1
            if self._num_changes % _HELP_PERIOD == 0:
                lines.append(HELP_TEXT)
        return lines

    def describe(self) -> str:
        """Return a line with the speeds."""
        return self._driver.describe()

    def check_timeout(self) -> float:
        """Stop the robot if no key was pressed for ``~key_timeout``; return the seconds until the next check is due."""
        if not self._key_timeout or self._driver.direction == STOPPED:
            return _POLL_PERIOD
        remaining = self._last_key_at + self._key_timeout - monotonic()
        if remaining > 0.0:
            return min(remaining, _POLL_PERIOD)
        self.press("")
        return _POLL_PERIOD

    def publish(self) -> None:
        """Publish the velocity."""
        with self._lock:
            if not self._ended:
                self._publish(self._driver.velocity)

    def stop(self) -> None:
        """Stop the robot, and publish nothing afterwards."""
        with self._lock:
            if not self._ended:
                self._ended = True
                self._publish(STOPPED)

    def _publish(self, velocity: Velocity) -> None:
        message: Any = TwistStamped() if self._is_stamped else Twist()
        twist = message
        if self._is_stamped:
            message.header.stamp, message.header.frame_id = self._node.now(), self._frame
            twist = message.twist
        twist.linear.x, twist.linear.y, twist.linear.z, twist.angular.z = velocity
        self._publisher.publish(message)


def main(argv: list[str]) -> int:
    """Run the node until it is shut down or its terminal is closed; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    with Node("teleop_twist_keyboard", argv=argv[1:]) as node:  # at the end, its shutdown stops the robot
        try:
            with KeyReader() as keys, _Interrupts() as interrupts:
                _drive(node, Teleop(node), keys, interrupts)
        except NodeShutdownError:  # the node was shut down before it was complete
            return 0
        except Error as error:
            node.log.fatal("%s", error)
            return 1
    return 0


def _drive(node: Node, teleop: Teleop, keys: KeyReader, interrupts: _Interrupts) -> None:
    next_reminder = monotonic() + _WAITING_PERIOD
    while node.ok() and not interrupts.arrived and not teleop.wait_for_subscribers(_POLL_PERIOD):
        if monotonic() >= next_reminder:
            next_reminder += _WAITING_PERIOD
            _show(f"Waiting for subscriber to connect to {teleop.topic}")
    if interrupts.arrived or not node.ok():
        return
    teleop.publish()
    _show(HELP_TEXT, teleop.describe())
    while node.ok() and not interrupts.arrived and (pressed := keys.read(teleop.check_timeout())) is not None:
        for key in pressed:
            _show(*teleop.press(key))


class _Interrupts:
    """A context manager that records termination signals instead of handling them.

    The node's own handler would stop the robot in the middle of `Teleop.publish`, which would then publish another
    velocity after the one that stops the robot. Closing the terminal sends SIGHUP, which must stop the robot, too.
    """

    def __init__(self) -> None:
        self.arrived = False
        self._previous: dict[int, Any] = {}

    def __enter__(self) -> _Interrupts:
        for number in TERMINATION_SIGNALS:
            with contextlib.suppress(ValueError):  # raised outside the main thread
                self._previous[number] = signal.signal(number, self._note)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._previous.items():
            signal.signal(number, handler)

    def _note(self, *_: object) -> None:
        self.arrived = True


def _show(*lines: str) -> None:
    for line in lines:
        sys.stdout.write(f"{line}\n")
    sys.stdout.flush()
