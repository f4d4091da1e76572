"""A process on another machine, as its launcher sees it."""

from __future__ import annotations

import contextlib
import signal
import sys
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any, Protocol

from pyros1.launch.plan import MachinePlan, NodePlan
from pyros1.launch.running.process import Process
from pyros1.launch.running.usage import UNKNOWN, Usage

_LOST = 255
ANSWER_TIME = 10.0
"""Seconds in which the other machine has to say that a node was started."""


class Machine(Protocol):
    """What a process needs of the connection to its machine; see `over_ssh.Machine`."""

    plan: MachinePlan
    master_uri: str

    @property
    def lost(self) -> bool: ...
    def send(self, message: dict[str, Any]) -> None: ...
    def usage(self, label: str) -> Usage: ...


class RemoteProcess(Process):
    """A process on another machine."""

    def attach(self, machine: Machine, node: NodePlan, run_id: str) -> None:
        """Say where it is to run, and what."""
        self._machine, self._node, self._run_id = machine, node, run_id
        self.machine = machine.plan.name
        self._answer: dict[str, Any] | None = None
        self._answered = threading.Event()
        self._announce: Callable[[Process], object] = lambda process: None
        self._pid = 0
        self._running = False
        self._given_up = False  # its start was not answered in time

    @property
    def pid(self) -> int:
        """Process id over there, 0 before the first start."""
        return self._pid

    @property
    def alive(self) -> bool:
        """Whether it runs, as far as is known here."""
        return self._running

    @property
    def gone(self) -> bool:
        """Whether it does not run; the agent sees to what it leaves behind."""
        return not self._running

    def start(self, announce: Callable[[Process], object] = lambda process: None) -> None:
        """Start it, or start it again.

        Args:
            announce: called with it when it runs.

        Raises:
            OSError: it cannot be started, or the machine cannot be reached.
        """
        if self._machine.lost:
            self.stranded = True
            raise OSError(0, "the connection is lost", f"machine {self._machine.plan.name}")
        node = self._node
        env = {"ROS_MASTER_URI": self._machine.master_uri}
        if node.namespace.strip("/"):
            env["ROS_NAMESPACE"] = node.namespace.rstrip("/")
        self._answer = None
        self._given_up = False
        self._announce = announce
        self._answered.clear()
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
                "again": bool(self.spawn_count),
            }
        )
        self._answered.wait(ANSWER_TIME)
        answer = self._answer
        if answer is None:
            self.stranded = self._machine.lost
            self._given_up = not self.stranded
        if answer is None or answer.get("event") != "started":
            silent = "there was no answer in time" if self._given_up else "the connection is lost"
            why = answer.get("why") if answer else silent
            raise OSError(0, str(why), f"machine {self._machine.plan.name}")

    def heard(self, message: dict[str, Any]) -> None:
        """Take what the agent says about it; called by the thread that listens to the machine."""
        event = message.get("event")
        if event == "output":
            stream = sys.stderr if message.get("stream") == 2 else sys.stdout
            self._show(str(message.get("text", "")), stream)
        elif event == "ended":
            if self._running:
                self._over(int(message.get("code", 0)))
        elif self._given_up:
            if event == "started":  # too late: nobody here knows of it any more
                self._machine.send({"do": "signal", "label": self.spec.label, "number": int(signal.SIGKILL)})
        else:
            self._pid = int(message.get("pid", 0))
            self._running = event == "started"
            if self._running:  # in this thread: what it says, and its end, come behind
                self.exit_code = None
                self.spawn_count += 1
                self.started = time.monotonic()
                self._announce(self)
            self._answer = message
            self._answered.set()

    def _show(self, text: str, stream: Any) -> None:
        if self.screen is not None:
            self.screen.write(self.spec.node, stream, text)
            return
        with contextlib.suppress(OSError, ValueError):
            stream.write(text)
            stream.flush()

    def lost(self) -> None:
        """The connection has broken: over there it is being ended."""
        self.stranded = True
        self._answered.set()
        if self._running:
            self._over(_LOST)

    def _over(self, code: int) -> None:
        self.exit_code = code
        self._running = False
        self._ended.set()
        self.on_exit(self)

    def usage(self, here: Mapping[int, Usage]) -> Usage:
        """What it uses over there."""
        return self._machine.usage(self.spec.label) if self._running else UNKNOWN

    def signal(self, number: int) -> None:
        """Send a signal to the process and all that it started in its group."""
        if self._running:
            self._machine.send({"do": "signal", "label": self.spec.label, "number": int(number)})
