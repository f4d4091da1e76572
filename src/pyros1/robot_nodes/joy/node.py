"""joy_node: publishes the state of a joystick on joy (https://wiki.ros.org/joy).

When the joystick is unplugged, and when the node ends, it publishes a message with all axes and buttons 0, so that the
robot does not keep driving. Force feedback is not supported.
"""

from __future__ import annotations

import os
import select
import threading
from math import inf
from time import monotonic

from pyros1.diagnostics import Status, Updater
from pyros1.ground.errors import Error
from pyros1.ground.terminal_text import one_line
from pyros1.msgs.sensor_msgs.msg import Joy
from pyros1.node import Node
from pyros1.robot_nodes.joy.device import Device, joysticks
from pyros1.robot_nodes.joy.events import BUTTON, FULL_SCALE, EventReader
from pyros1.robot_nodes.joy.joystick import MAX_DEADZONE, Joystick, Settings
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.robot_nodes.shared.program import run_node

RETRY_PERIOD = 1.0
"""Seconds between attempts to open the device."""
_MAX_RATE = 1000.0
_MAX_INTERVAL = 10.0
_OK, _ERROR = 0, 2


def read_settings(values: PrivateParameters) -> Settings:
    """Read the settings from a node's parameters."""
    deadzone = values.number("deadzone", 0.05, 0.0, FULL_SCALE)
    if deadzone >= 1:  # old launch files give it in the units of events
        deadzone /= FULL_SCALE
    return Settings(
        deadzone=min(deadzone, MAX_DEADZONE),
        autorepeat_rate=values.number("autorepeat_rate", 0.0, 0.0, _MAX_RATE),
        coalesce_interval=values.number("coalesce_interval", 0.001, 0.0, _MAX_INTERVAL),
        use_initial_axes=values.flag("default_trig_val", False),
        sticky_buttons=values.flag("sticky_buttons", False),
    )


class JoyNode:
    """Reads a joystick in a thread, and reopens it whenever it is plugged in.

    Args:
        node: the node that publishes.
    """

    def __init__(self, node: Node) -> None:
        values = PrivateParameters.of(node)
        self._node = node
        self._path = self._frame_id = values.text("dev", "/dev/input/js0")
        self._name = values.text("dev_name", "")
        self._settings = read_settings(values)
        self._joystick = Joystick(self._settings)
        self._publisher = node.advertise("joy", Joy, queue_size=1)
        self._device: Device | None = None
        self._problem = ""
        self._is_name_reported = False
        self._events = self._messages = 0
        self._counted_at = monotonic()
        self._wake_reader, self._wake_writer = os.pipe()
        self._diagnostics = Updater(node, "none")
        self._diagnostics.add("Joystick Driver Status", self._diagnose)
        self._thread = threading.Thread(target=self._run, name="joystick", daemon=True)
        self._thread.start()
        node.on_shutdown(self._end)  # called at once if the node is already shutting down

    def _end(self) -> None:
        os.close(self._wake_writer)  # wakes the thread
        self._thread.join()
        os.close(self._wake_reader)

    def _run(self) -> None:
        while True:
            device = self._open()
            try:
                is_ending = self._wait(None, RETRY_PERIOD) if device is None else self._follow(device)
            except (OSError, Error) as error:
                is_ending = False
                self._report(f"lost the joystick {self._frame_id} ({_reason(error)})")
            self._device = None
            if device is not None:
                device.close()
                self._joystick.close(monotonic())
                self._publish_if_due()
                # Wait, so that a device that fails immediately does not keep the processor busy.
                is_ending = is_ending or self._wait(None, RETRY_PERIOD)
            if is_ending:
                return

    def _open(self) -> Device | None:
        path = self._find_path()
        try:
            device = Device(path)
        except (OSError, ValueError) as error:  # a path with a null byte is a ValueError
            hint = "; add the user to the group input" if isinstance(error, PermissionError) else ""
            self._report(f"cannot open the joystick {path} ({_reason(error)}{hint})")
            return None
        self._device, self._frame_id = device, path
        self._joystick.open(device.axes, device.buttons, monotonic())
        return device

    def _find_path(self) -> str:
        """Return the path of the joystick named by ~dev_name, or ~dev if there is none."""
        if not self._name:
            return self._path
        found = list(joysticks())
        path = next((path for path, name in found if name == self._name), None)
        if path is None and not self._is_name_reported:
            self._is_name_reported = True
            names = ", ".join(one_line(repr(name), 100) for _, name in found[:20]) or "none"
            self._node.log.warn("no joystick is called %r (there are: %s): using %s", self._name, names, self._path)
        return path or self._path

    def _follow(self, device: Device) -> bool:
        """Read a device and publish until it fails (then raise) or the node ends (then return True)."""
        reader = EventReader()
        is_silent = True
        while True:
            due = self._joystick.due()
            if self._wait(device, inf if due is None else due - monotonic()):
                return True
            now = monotonic()
            events = reader.feed(device.read())
            if events and is_silent:
                is_silent, self._problem = False, ""
                self._node.log.info("opened the joystick %s", one_line(f"{device.path} {device.name}".strip(), 200))
            for event in events:
                self._joystick.handle(event, now)
                self._events += 1
                if event.kind == BUTTON and not event.initial:
                    self._publish_if_due()  # each press and release is a separate message
            self._publish_if_due()

    def _wait(self, device: Device | None, seconds: float) -> bool:
        """Wait until a device has data or the time has passed; return whether the node is ending."""
        files = [self._wake_reader] if device is None else [self._wake_reader, device.fileno()]
        ready, _, _ = select.select(files, [], [], None if seconds == inf else max(0.0, seconds))
        return self._wake_reader in ready

    def _publish_if_due(self) -> None:
        now, due = monotonic(), self._joystick.due()
        if due is None or due > now:
            return
        message = Joy(axes=self._joystick.axes, buttons=self._joystick.buttons)
        message.header.stamp = self._node.now()
        message.header.frame_id = self._frame_id
        self._publisher.publish(message)
        self._joystick.published(now)
        self._messages += 1

    def _report(self, problem: str) -> None:
        """Log the first problem since the joystick last worked."""
        if not self._problem:
            self._node.log.error("%s; trying again every second", problem)
        self._problem = problem

    def _diagnose(self, status: Status) -> None:
        now, device = monotonic(), self._device
        elapsed, self._counted_at = max(now - self._counted_at, 1e-3), now
        events, self._events = self._events, 0
        messages, self._messages = self._messages, 0
        status.summary(*((_OK, "OK") if device is not None else (_ERROR, "Joystick not open.")))
        status.add("topic", self._node.resolve("joy"))
        status.add("device", self._frame_id)
        status.add("device name", device.name if device is not None else self._name)
        status.add("dead zone", self._settings.deadzone)
        status.add("autorepeat rate (Hz)", self._settings.autorepeat_rate)
        status.add("coalesce interval (s)", self._settings.coalesce_interval)
        status.add("recent joystick event rate (Hz)", round(events / elapsed, 2))
        status.add("recent publication rate (Hz)", round(messages / elapsed, 2))
        status.add("subscribers", self._publisher.num_connections)
        if self._problem:
            status.add("problem", self._problem)


def _reason(error: Exception) -> str:
    return one_line(getattr(error, "strerror", None) or error, 200)


def main(argv: list[str]) -> int:
    """Run joy_node; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    return run_node(argv, "joy_node", JoyNode)
