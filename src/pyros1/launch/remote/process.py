"""The launcher's representation of a process on another machine."""

from __future__ import annotations

import contextlib
import sys
import threading
import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pyros1.launch.plan import NodePlan
from pyros1.launch.running.process import Process
from pyros1.launch.running.usage import UNKNOWN_USAGE, Usage

if TYPE_CHECKING:
    from pyros1.launch.remote.over_ssh import Machine

_LOST_EXIT_CODE = 255
_SIGKILL = 9  # SIGKILL on the other machine; this machine may not have it
START_TIMEOUT = 10.0
"""Timeout in seconds for the other machine to confirm the start of a node."""


class RemoteProcess(Process):
    """A process on another machine."""

    def attach(self, machine: Machine, node: NodePlan, run_id: str) -> None:
        """Set the machine to run on, and the node to run there."""
        self._machine, self._node, self._run_id = machine, node, run_id
        self.machine = machine.plan.name
        self._start_reply: dict[str, Any] | None = None
        self._start_replied = threading.Event()
        self._on_started: Callable[[Process], object] = lambda process: None
        self._pid = 0
        self._is_running = False
        self._has_given_up = False  # whether the start was not confirmed in time

    @property
    def pid(self) -> int:
        """The process id on the other machine; 0 before the first start."""
        return self._pid

    @property
    def alive(self) -> bool:
        """Whether the process is running, as far as the launcher knows."""
        return self._is_running

    @property
    def is_gone(self) -> bool:
        """Whether the process has exited. The agent stops the other members of its process group."""
        return not self._is_running

    def start(self, on_started: Callable[[Process], object] = lambda process: None) -> None:
        """Start the process, for the first time or again.

        Args:
            on_started: called with this object when the process is running.

        Raises:
            OSError: the process cannot be started, or the machine cannot be reached.
        """
        if self._machine.is_lost:
            self.is_disconnected = True
            raise OSError(0, "the connection is lost", f"machine {self._machine.plan.name}")
        node = self._node
        env = {"ROS_MASTER_URI": self._machine.master_uri}
        if node.namespace.strip("/"):
            env["ROS_NAMESPACE"] = node.namespace.rstrip("/")
        self._start_reply = None
        self._has_given_up = False
        self._on_started = on_started
        self._start_replied.clear()
        self._ended = threading.Event()
        self._machine.send(
            {
                "do": "start",
                "label": self.spec.label,
                "package": node.package,
                "type": node.type,
                "prefix": node.prefix,
                "args": [*node.args, *(f"{old}:={new}" for old, new in node.remappings), f"__name:={node.name}"],
                "env": {**env, **node.env},
                "cwd": node.cwd,
                "run_id": self._run_id,
                "screen": self.spec.to_screen,
                "priority": self.spec.priority,
                "again": bool(self.spawn_count),
            }
        )
        self._start_replied.wait(START_TIMEOUT)
        reply = self._start_reply
        if reply is None:
            self.is_disconnected = self._machine.is_lost
            self._has_given_up = not self.is_disconnected
        if reply is None or reply.get("event") != "started":
            silence_reason = "no answer in time" if self._has_given_up else "the connection is lost"
            reason = reply.get("why") if reply else silence_reason
            raise OSError(0, str(reason), f"machine {self._machine.plan.name}")

    def handle_message(self, message: dict[str, Any]) -> None:
        """Handle a message from the agent about the process. Called in the thread that listens to the machine."""
        event = message.get("event")
        if event == "output":
            stream = sys.stderr if message.get("stream") == 2 else sys.stdout
            self._show(str(message.get("text", "")), stream)
        elif event == "ended":
            if self._is_running:
                self._handle_exit(int(message.get("code", 0)))
        elif self._has_given_up:
            if event == "started":  # too late: the start has already been reported as failed
                self._machine.send({"do": "signal", "label": self.spec.label, "number": _SIGKILL})
        else:
            self._pid = int(message.get("pid", 0))
            self._is_running = event == "started"
            if self._is_running:  # reported in this thread, so before any output and the exit
                self.exit_code = None
                self.spawn_count += 1
                self.started_at = time.monotonic()
                self._on_started(self)
            self._start_reply = message
            self._start_replied.set()

    def _show(self, text: str, stream: Any) -> None:
        if self.screen is not None:
            self.screen.write(self.spec.node, stream, text)
            return
        with contextlib.suppress(OSError, ValueError):
            stream.write(text)
            stream.flush()

    def on_connection_lost(self) -> None:
        """Handle the loss of the connection, after which the agent stops the process."""
        self.is_disconnected = True
        self._start_replied.set()
        if self._is_running:
            self._handle_exit(_LOST_EXIT_CODE)

    def _handle_exit(self, code: int) -> None:
        self.exit_code = code
        self._is_running = False
        self._ended.set()
        self.on_exit(self)

    def usage(self, local_usages: Mapping[int, Usage]) -> Usage:
        """Return the CPU and memory usage on the other machine."""
        return self._machine.usage(self.spec.label) if self._is_running else UNKNOWN_USAGE

    def signal(self, number: int) -> None:
        """Send a signal to the process group."""
        if self._is_running:
            self._machine.send({"do": "signal", "label": self.spec.label, "number": int(number)})
