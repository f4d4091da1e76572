"""Starts nodes on other machines, through the user's ``ssh`` with its configuration, keys and agent (X91).

One connection per machine runs the program in `agent` there, and transfers the output and exit codes of nodes. If the
connection breaks, the agent stops the nodes: immediately if it is closed, after 30 seconds of silence if the network
fails. The launcher tries to reconnect after 1, 2, 4, ... 30 seconds, and then restarts nodes with ``respawn``; the
others can be started with `pyros1 node start`.

The other machine needs a ``python3``, and pyros1 or stock ROS to find nodes, but no launcher. It need not be able to
reach this launcher, but its nodes must be able to reach the master and the other nodes.
"""

from __future__ import annotations

import contextlib
import json
import math
import shlex
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from pyros1.ground.errors import LaunchError
from pyros1.launch.plan import MachinePlan, NodePlan
from pyros1.launch.reading.conditions import parse_seconds
from pyros1.launch.remote.process import RemoteProcess
from pyros1.launch.running.console import Console
from pyros1.launch.running.process import Process
from pyros1.launch.running.process_spec import ProcessSpec
from pyros1.launch.running.screen import Screen
from pyros1.launch.running.usage import UNKNOWN_USAGE, Usage
from pyros1.launch.running.watchdog import Watchdog

SSH_VARIABLE = "PYROS1_SSH"
"""Environment variable that contains a command to use instead of ``ssh``, for example ``ssh -F myconfig``."""

_SSH_OPTIONS = ["-T", "-o", "ServerAliveInterval=5", "-o", "ServerAliveCountMax=3"]
_LAUNCH_FOLDER = Path(__file__).parents[1]
_AGENT_FILE = _LAUNCH_FOLDER / "remote" / "agent.py"
# Reads the agent's code from the pipe and runs it, so that the agent need not be installed on the other machine.
# Tracebacks contain the file's path on this machine.
_BOOT_CODE = f"import sys; b = sys.stdin.buffer; exec(compile(b.read(int(b.readline())), {str(_AGENT_FILE)!a}, 'exec'))"
HEARTBEAT_INTERVAL = 5.0
"""Seconds between messages to the agent, which would otherwise consider the connection dead."""
_CONNECT_TIMEOUT = "10"
RECONNECT_DELAYS = (1.0, 30.0)
"""Initial and maximum number of seconds before an attempt to reconnect. The delay doubles with each attempt."""
USAGE_TIMEOUT = 1.0
"""Seconds to wait for the agent to report the CPU and memory usage."""
_USAGE_MAX_AGE = 0.2
_DEFAULT_LOADER = "/opt/ros/noetic/env.sh"
_ProcessFactory = Callable[[ProcessSpec, Callable[[Process], object], "Watchdog | None", "Screen | None"], Process]


def ssh_command(machine: MachinePlan, environ: Mapping[str, str]) -> list[str]:
    """Return the command that connects to a machine and runs the agent there.

    The settings of the ``<machine>`` tag take precedence over the user's ssh configuration. Without an ``env-loader``,
    the default one is used if it exists on the machine.
    """
    settings = dict(machine.settings)
    connect_timeout = math.ceil(_parse_timeout(settings))
    words = [*shlex.split(environ.get(SSH_VARIABLE) or "ssh"), *_SSH_OPTIONS, "-o", f"ConnectTimeout={connect_timeout}"]
    if settings.get("ssh-port"):
        words += ["-p", settings["ssh-port"]]
    if settings.get("user"):
        words += ["-l", settings["user"]]
    python = shlex.join(["python3", "-u", "-c", _BOOT_CODE])
    if settings.get("env-loader"):
        command = f"exec {shlex.quote(settings['env-loader'])} {python}"
    else:
        loader = _DEFAULT_LOADER
        command = f"if test -x {loader}; then exec {loader} {python}; else exec {python}; fi"
    return [*words, "--", machine.address, f"exec sh -c {shlex.quote(command)}"]


def _parse_timeout(settings: Mapping[str, str]) -> float:
    return parse_seconds(settings.get("timeout") or _CONNECT_TIMEOUT, "timeout")


class Machine:
    """A connection to a machine.

    Args:
        plan: the machine, as declared in the launch file.
        environ: this process's environment.
        master_uri: ROS_MASTER_URI for the nodes on the machine.
        stop_timeouts: seconds that the agent waits after SIGINT and after SIGTERM when it stops the nodes because the
            connection is broken.
        console: prints lines for the user.
        on_reconnected: called with the machine's processes after a reconnection, in the thread of the connection.
    """

    def __init__(
        self,
        plan: MachinePlan,
        environ: Mapping[str, str],
        master_uri: str,
        stop_timeouts: tuple[float, float],
        console: Console,
        on_reconnected: Callable[[list[Process]], object] | None = None,
    ) -> None:
        self.plan = plan
        self.master_uri = master_uri
        self._environ = environ
        self._stop_timeouts = stop_timeouts
        self._console = console
        self._on_reconnected = on_reconnected
        self._ssh: subprocess.Popen[bytes] | None = None
        self._processes: dict[str, RemoteProcess] = {}
        self._changed = threading.Condition()
        self._is_ready = False
        self._is_lost = False
        self._usages: dict[str, Usage] = {}
        self._usages_at = -_USAGE_MAX_AGE
        self._usages_received = threading.Event()
        self._closed = threading.Event()
        self._threads: list[threading.Thread] = []

    def connect(self) -> None:
        """Start connecting, without waiting for the machine.

        Raises:
            LaunchError: ssh cannot be run.
        """
        self._console.line(f"remote[{self.plan.name}] connecting to {self.plan.address}")
        self._start_ssh()
        for target in (self._run, self._send_heartbeats):
            thread = threading.Thread(target=target, name=f"machine {self.plan.name}", daemon=True)
            thread.start()
            self._threads.append(thread)

    def _start_ssh(self) -> None:
        command = ssh_command(self.plan, self._environ)
        with self._changed:
            if self._closed.is_set():
                return
            try:
                # In a new session, so that Ctrl-C does not close the connection before the nodes have exited.
                self._ssh = subprocess.Popen(
                    command, env=self._environ, stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True
                )
            except OSError as error:
                raise LaunchError(f"cannot run {command[0]}: {error.strerror}") from error
        source = _AGENT_FILE.read_bytes()
        self._write(b"%d\n%s" % (len(source), source))
        usage = (_LAUNCH_FOLDER / "running" / "usage.py").read_text("utf-8")
        self.send({"do": "hello", "stop_timeouts": list(self._stop_timeouts), "usage": usage})

    def wait_ready(self) -> None:
        """Wait until nodes can be started on the machine.

        Raises:
            LaunchError: the connection failed, or was not ready within the machine's ``timeout``.
        """
        timeout = _parse_timeout(dict(self.plan.settings))
        with self._changed:
            self._changed.wait_for(lambda: self._is_ready or self._is_lost, timeout)
            if self._is_ready:
                return
            reason = "see the output of ssh" if self._is_lost else f"no answer within {timeout:g} s"
        self.close()
        raise LaunchError(
            f"cannot launch nodes on machine [{self.plan.name}] ({self.plan.address}): {reason}.\n"
            f"Try: {shlex.join(ssh_command(self.plan, self._environ)[:-1])} python3 --version"
        )

    def make_process_factory(self, node: NodePlan, run_id: str) -> _ProcessFactory:
        """Return a function that creates the process of a node on this machine, for `Supervisor.start`."""

        def make_process(
            spec: ProcessSpec, on_exit: Callable[[Process], object], watchdog: Watchdog | None, screen: Screen | None
        ) -> Process:
            process = RemoteProcess(spec, on_exit, screen=screen)
            process.attach(self, node, run_id)
            self._processes[spec.label] = process
            return process

        return make_process

    def send(self, message: dict[str, Any]) -> None:
        """Send a message to the agent. Errors are ignored, since the listening thread notices a dead connection."""
        self._write(json.dumps(message).encode() + b"\n")

    def _write(self, data: bytes) -> None:
        pipe = self._ssh.stdin if self._ssh is not None else None
        with self._changed, contextlib.suppress(OSError, ValueError):
            if pipe is not None:
                pipe.write(data)
                pipe.flush()

    def _run(self) -> None:
        """Listen until the connection is closed; reconnect if it has ever been ready."""
        was_ever_ready, delay = False, RECONNECT_DELAYS[0]
        while True:
            self._listen()
            with self._changed:
                was_ready, self._is_ready, self._is_lost = self._is_ready, False, True
                self._changed.notify_all()
            was_ever_ready = was_ever_ready or was_ready
            if self._closed.is_set() or not was_ever_ready:
                return
            if was_ready:
                delay = RECONNECT_DELAYS[0]
                self._report_lost()
            while True:
                self._reap_ssh()
                if self._closed.wait(delay):
                    return
                delay = min(2 * delay, RECONNECT_DELAYS[1])
                with contextlib.suppress(LaunchError):
                    self._start_ssh()
                    break

    def _report_lost(self) -> None:
        self._console.error(
            f"the connection to machine [{self.plan.name}] ({self.plan.address}) was lost, and the nodes on it "
            "were stopped. After reconnecting, nodes with respawn are started again; use pyros1 node start for others. "
            f"Check the network, and: ssh {self.plan.address}"
        )
        for process in list(self._processes.values()):
            process.on_connection_lost()

    def _reap_ssh(self) -> None:
        """Close the pipes to the ssh process, and kill it if it is still running."""
        with self._changed:
            if self._ssh is None:
                return
            for pipe in (self._ssh.stdin, self._ssh.stdout):
                if pipe is not None:
                    with contextlib.suppress(OSError):
                        pipe.close()
            self._ssh.kill()
            self._ssh.wait()
            self._ssh = None

    def _listen(self) -> None:
        pipe = self._ssh.stdout if self._ssh is not None else None
        for line in pipe or ():
            try:
                message = json.loads(line)
            except ValueError:  # output of a login script on the machine
                sys.stderr.write(line.decode("utf-8", "replace"))
                continue
            if isinstance(message, dict):
                self._handle_message(message)

    def _handle_message(self, message: dict[str, Any]) -> None:
        if message.get("event") == "ready":
            with self._changed:
                reconnected, self._is_ready, self._is_lost = self._is_lost, True, False
                self._changed.notify_all()
            if reconnected:
                self._console.line(f"remote[{self.plan.name}] connected to {self.plan.address} again")
                if self._on_reconnected is not None:
                    self._on_reconnected(list(self._processes.values()))
            return
        if message.get("event") == "usage":
            self._usages = {label: Usage(*numbers) for label, numbers in message["of"].items()}
            self._usages_received.set()
            return
        process = self._processes.get(message.get("label", ""))
        if process is not None:
            process.handle_message(message)

    def usage(self, label: str) -> Usage:
        """Return the CPU and memory usage of a process on the machine, which may be slightly outdated or unknown."""
        now = time.monotonic()
        if now - self._usages_at > _USAGE_MAX_AGE and not self._is_lost:
            self._usages_received.clear()
            self.send({"do": "usage"})
            if not self._usages_received.wait(USAGE_TIMEOUT):
                self._usages = {}
            self._usages_at = time.monotonic()
        return self._usages.get(label, UNKNOWN_USAGE)

    @property
    def is_lost(self) -> bool:
        """Whether the connection is currently broken."""
        return self._is_lost

    def _send_heartbeats(self) -> None:
        while not self._closed.wait(HEARTBEAT_INTERVAL):
            self.send({})

    def close(self) -> None:
        """Close the connection, which stops all processes that are still running on the machine."""
        self._closed.set()
        with self._changed:
            ssh = self._ssh
            if ssh is not None and ssh.stdin is not None:
                with contextlib.suppress(OSError):
                    ssh.stdin.close()
        if ssh is not None:
            try:
                ssh.wait(sum(self._stop_timeouts) + 5.0 if self._is_ready else 0.5)
            except subprocess.TimeoutExpired:
                ssh.kill()
                ssh.wait()
        for thread in self._threads:
            thread.join(5.0)
        self._reap_ssh()


def make_machine(
    plan: MachinePlan,
    environ: Mapping[str, str],
    master_uri: str,
    stop_timeouts: tuple[float, float],
    console: Console,
    on_reconnected: Callable[[list[Process]], object],
) -> Machine:
    """Return a machine to connect to; warn if its nodes cannot reach the master, or if its tag has a password."""
    if dict(plan.settings).get("password"):
        console.warning(
            f"the password of machine [{plan.name}] is not used, and anybody can read it in the launch file: use an "
            f"SSH key instead (ssh-keygen, then ssh-copy-id {plan.address})"
        )
    host = master_uri.partition("://")[2].partition(":")[0]
    if host == "localhost" or host.startswith("127."):
        console.warning(
            f"nodes on machine [{plan.name}] get the master URI {master_uri}, which refers to that machine, not to "
            "this one; set ROS_MASTER_URI to a name of this machine that can be resolved there"
        )
    return Machine(plan, environ, master_uri, stop_timeouts, console, on_reconnected)
