"""The remote end of `over_ssh`: starts nodes on another machine, and stops them when the connection is closed.

This file is sent to the machine and run by its ``python3`` (3.7 or newer). To find nodes, it needs pyros1, or stock
ROS's ``rosrun``, and nothing else. It reads messages from standard input and writes messages to standard output, each a
line of JSON.
"""

from __future__ import annotations

import contextlib
import json
import os
import queue
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from importlib import import_module
from typing import IO, Any

HEARTBEAT_TIMEOUT = 30.0
"""Seconds without a message from the launcher after which the connection is considered dead."""


class Agent:
    """Starts, watches and stops the nodes of one launch."""

    def __init__(self) -> None:
        self._nodes: dict[str, subprocess.Popen[bytes]] = {}
        self._lock = threading.Lock()
        self._lines: queue.Queue[bytes] = queue.Queue()
        self._find = make_finder()
        self._usage_namespace: dict[str, Any] = {"__name__": "usage"}  # for the code of the launcher's module ``usage``

    def send(self, **message: Any) -> None:
        """Send a message to the launcher. Errors are ignored: when its heartbeats stop, the nodes are stopped."""
        with self._lock, contextlib.suppress(OSError, ValueError):
            sys.stdout.write(json.dumps(message) + "\n")
            sys.stdout.flush()

    def run(self) -> None:
        """Serve the launcher until the connection is closed or dead, then stop the remaining nodes."""
        threading.Thread(target=self._read_messages, daemon=True).start()
        self.send(event="ready", pid=os.getpid())
        stop_timeouts = [15.0, 2.0]
        while True:
            try:
                line = self._lines.get(timeout=HEARTBEAT_TIMEOUT)
            except queue.Empty:
                break
            if not line:
                break
            message = json.loads(line)
            command = message.get("do")
            if command == "hello":
                stop_timeouts = message["stop_timeouts"]
                exec(message["usage"], self._usage_namespace)
            elif command == "usage":
                self._send_usage()
            elif command == "start":
                self._start(message)
            elif command == "signal":
                self._signal(message["label"], message["number"])
        self._stop_nodes(stop_timeouts)

    def _read_messages(self) -> None:
        for line in sys.stdin.buffer:
            self._lines.put(line)
        self._lines.put(b"")

    def _send_usage(self) -> None:
        usages = self._usage_namespace["group_usages"]()
        nodes = list(self._nodes.items())
        self.send(event="usage", of={label: usages[node.pid] for label, node in nodes if node.pid in usages})

    def _start(self, message: dict[str, Any]) -> None:
        label = message["label"]
        try:
            node = self._spawn(label, message)
        except (OSError, RuntimeError) as error:
            self.send(event="failed", label=label, why=str(error))
        except Exception as error:  # noqa: BLE001 - any version of pyros1 may raise other errors about a package
            self.send(event="failed", label=label, why=f"{type(error).__name__}: {error}")
        else:
            self.send(event="started", label=label, pid=node.pid)
            if message.get("priority"):
                self._set_priority(label, node.pid, message["priority"])
            threading.Thread(target=self._watch, args=(label, node), daemon=True).start()

    def _spawn(self, label: str, message: dict[str, Any]) -> subprocess.Popen[bytes]:
        words = self._find(message["package"], message["type"])
        home = os.environ.get("ROS_HOME") or os.path.join(os.path.expanduser("~"), ".ros")
        log_folder = os.path.join(os.environ.get("ROS_LOG_DIR") or os.path.join(home, "log"), message["run_id"])
        os.makedirs(log_folder, exist_ok=True)
        log_base = os.path.join(log_folder, label.replace("/", "-"))
        env = dict(os.environ)
        env.pop("ROS_NAMESPACE", None)
        env.update(message["env"])
        command = message["prefix"] + words + message["args"] + [f"__log:={log_base}.log"]
        options: dict[str, Any] = {"env": env, "cwd": os.path.dirname(words[-1]) if message["cwd"] == "node" else home}
        if message["screen"]:
            options.update(stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        else:
            mode = "ab" if message["again"] else "wb"
            options.update(stdout=open(f"{log_base}-stdout.log", mode), stderr=open(f"{log_base}-stderr.log", mode))  # noqa: SIM115
        try:
            node = subprocess.Popen(command, stdin=subprocess.DEVNULL, start_new_session=True, **options)
        finally:
            if not message["screen"]:
                options["stdout"].close()
                options["stderr"].close()
        self._nodes[label] = node
        return node

    def _set_priority(self, label: str, pid: int, priority: int) -> None:
        try:
            for thread in os.listdir(f"/proc/{pid}/task"):
                os.sched_setscheduler(int(thread), os.SCHED_FIFO, os.sched_param(priority))
        except (FileNotFoundError, ProcessLookupError):  # the process has exited
            pass
        except (OSError, AttributeError) as error:
            text = f"[{label}] cannot get real-time priority {priority}: {error}\n"
            self.send(event="output", label=label, stream=2, text=text)

    def _forward_output(self, label: str, number: int, pipe: IO[bytes]) -> None:
        with pipe:
            for line in pipe:
                self.send(event="output", label=label, stream=number, text=line.decode("utf-8", "replace"))

    def _watch(self, label: str, node: subprocess.Popen[bytes]) -> None:
        readers = [
            threading.Thread(target=self._forward_output, args=(label, number, pipe), daemon=True)
            for number, pipe in ((1, node.stdout), (2, node.stderr))
            if pipe is not None
        ]
        for reader in readers:
            reader.start()
        code = node.wait()
        for reader in readers:
            reader.join(1.0)  # send the remaining output first, unless a child process keeps the pipe open
        self.send(event="ended", label=label, code=code)

    def _signal(self, label: str, number: int) -> None:
        node = self._nodes.get(label)
        if node is not None:
            with contextlib.suppress(OSError):
                os.killpg(node.pid, number)

    def _stop_nodes(self, stop_timeouts: list[float]) -> None:
        signals = (signal.SIGINT, signal.SIGTERM, signal.SIGKILL)
        for number, seconds in zip(signals, (*stop_timeouts, 2.0)):  # noqa: B905 - Python 3.7
            for label in self._running_nodes():
                self._signal(label, number)
            deadline = time.monotonic() + seconds
            while self._running_nodes() and time.monotonic() < deadline:
                time.sleep(0.05)

    def _running_nodes(self) -> list[str]:
        return [label for label, node in self._nodes.items() if group_exists(node.pid)]


_MODULE_NAMES = (
    ("pyros1.finding.packages", "pyros1.launch.running.command_line"),
    ("pyros1.msgs.packages", "pyros1.launch.command_line"),
)
"""Names of pyros1's modules that find packages and create command lines, now and in version 0.1.0."""


def group_exists(pid: int) -> bool:
    """Return whether a process group still has members."""
    try:
        os.killpg(pid, 0)
    except OSError:
        return False
    return True


def make_finder() -> Callable[[str, str], list[str]]:
    """Return a function that finds a node with pyros1, or else with stock ROS, and returns the node's command line."""
    for packages_name, command_line_name in _MODULE_NAMES:
        try:
            packages_module, command_line_module = import_module(packages_name), import_module(command_line_name)
        except ImportError:
            continue
        packages = packages_module.PackageIndex(os.environ)
        return lambda package, executable_name: command_line_module.executable_words(
            command_line_module.locate(package, executable_name, packages)
        )
    return _find_with_rosrun


def _find_with_rosrun(package: str, executable_name: str) -> list[str]:
    try:
        result = subprocess.run(
            ["rosrun", "--prefix", "echo", package, executable_name], capture_output=True, check=False
        )
    except FileNotFoundError:
        raise RuntimeError(
            "neither pyros1 nor stock ROS was found with the machine's python3 and PATH; install pyros1 for that "
            "python3, or set up ROS in the machine's env-loader"
        ) from None
    path = result.stdout.decode().strip()
    if result.returncode or not path:
        raise RuntimeError(result.stderr.decode().strip() or f"no [{executable_name}] in package [{package}]")
    return [path]


if __name__ == "__main__":
    # Closing the connection also causes a hang-up signal, but the agent handles only the end of the input.
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    Agent().run()
