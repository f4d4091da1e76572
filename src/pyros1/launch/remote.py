"""Nodes on other machines, through the user's own ``ssh`` with its configuration, keys and agent (X91).

One connection per machine runs the program in `agent` there. What nodes say and how they end comes back through it,
and when it breaks, for whatever reason, the agent ends the nodes. No launcher need be installed there, and nothing
there has to reach this launcher; but nodes there have to reach the master, and each other, as always.
"""

from __future__ import annotations

import contextlib
import json
import shlex
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping
from importlib import resources
from typing import Any

from pyros1.errors import LaunchError
from pyros1.launch.conditions import parse_seconds
from pyros1.launch.console import Console
from pyros1.launch.plan import MachinePlan, NodePlan
from pyros1.launch.process import Process, ProcessSpec
from pyros1.launch.screen import Screen
from pyros1.launch.warden import Warden

SSH_VARIABLE = "PYROS1_SSH"
"""Environment variable with the command to use instead of ``ssh``, for example ``ssh -F myconfig``."""

_OPTIONS = ["-T", "-o", "ServerAliveInterval=5", "-o", "ServerAliveCountMax=3"]
# The agent's own text goes through the pipe, so that nothing has to be installed there: this runs that text, no other.
_BOOT = "import sys; b = sys.stdin.buffer; exec(compile(b.read(int(b.readline())), 'agent', 'exec'))"
_HEARTBEAT = 5.0
_CONNECT_TIMEOUT = "10"
_LOST = 255
_DEFAULT_LOADERS = "/opt/ros/noetic/env.sh"
_Factory = Callable[[ProcessSpec, Callable[[Process], object], "Warden | None", "Screen | None"], Process]


def ssh_words(machine: MachinePlan, environ: Mapping[str, str]) -> list[str]:
    """Return the command that connects to a machine and runs the agent there.

    The settings of the ``<machine>`` tag come before the user's configuration; what it does not say is left to that.
    Without an ``env-loader`` the usual one is used if the machine has it.
    """
    settings = dict(machine.settings)
    words = [*shlex.split(environ.get(SSH_VARIABLE) or "ssh"), *_OPTIONS]
    if settings.get("ssh-port"):
        words += ["-p", settings["ssh-port"]]
    if settings.get("user"):
        words += ["-l", settings["user"]]
    python = shlex.join(["python3", "-u", "-c", _BOOT])
    if settings.get("env-loader"):
        command = f"exec {shlex.quote(settings['env-loader'])} {python}"
    else:
        loader = _DEFAULT_LOADERS
        command = f"if test -x {loader}; then exec {loader} {python}; else exec {python}; fi"
    return [*words, "--", machine.address, f"exec sh -c {shlex.quote(command)}"]


class Machine:
    """A connection to a machine.

    Args:
        plan: the machine.
        environ: this process's environment.
        master_uri: what nodes there find in ROS_MASTER_URI.
        stages: seconds that nodes there have after SIGINT and after SIGTERM when the connection breaks.
        console: where lines for the user go.
    """

    def __init__(
        self,
        plan: MachinePlan,
        environ: Mapping[str, str],
        master_uri: str,
        stages: tuple[float, float],
        console: Console,
    ) -> None:
        self.plan = plan
        self.master_uri = master_uri
        self._environ = environ
        self._stages = stages
        self._console = console
        self._ssh: subprocess.Popen[bytes] | None = None
        self._processes: dict[str, RemoteProcess] = {}
        self._changed = threading.Condition()
        self._ready = False
        self._lost = False
        self._closed = threading.Event()
        self._threads: list[threading.Thread] = []

    def connect(self) -> None:
        """Begin to connect.

        Raises:
            LaunchError: there is no ssh.
        """
        words = ssh_words(self.plan, self._environ)
        self._console.line(f"remote[{self.plan.name}] connecting to {self.plan.address}")
        try:
            # In a session of its own no Ctrl-C of the user ends the connection before the nodes have ended.
            self._ssh = subprocess.Popen(
                words, env=self._environ, stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True
            )
        except OSError as error:
            raise LaunchError(f"cannot run {words[0]}: {error.strerror}") from error
        source = (resources.files("pyros1.launch") / "agent.py").read_bytes()
        self._write(b"%d\n%s" % (len(source), source))
        self.send({"do": "hello", "stages": list(self._stages)})
        for target in (self._listen, self._beat):
            thread = threading.Thread(target=target, name=f"machine {self.plan.name}", daemon=True)
            thread.start()
            self._threads.append(thread)

    def wait_ready(self) -> None:
        """Wait until nodes can be started there.

        Raises:
            LaunchError: that was not so within the machine's ``timeout``.
        """
        timeout = parse_seconds(dict(self.plan.settings).get("timeout") or _CONNECT_TIMEOUT, "timeout")
        with self._changed:
            self._changed.wait_for(lambda: self._ready or self._lost, timeout)
            if self._ready:
                return
            why = "see what ssh says" if self._lost else f"no answer within {timeout:g} s"
        self.close()
        raise LaunchError(
            f"cannot launch nodes on machine [{self.plan.name}] ({self.plan.address}): {why}.\n"
            f"Try: {shlex.join(ssh_words(self.plan, self._environ)[:-1])} python3 --version"
        )

    def process(self, node: NodePlan, run_id: str) -> _Factory:
        """Return what makes the process of a node there."""

        def make(
            spec: ProcessSpec, on_exit: Callable[[Process], object], warden: Warden | None, screen: Screen | None
        ) -> Process:
            process = RemoteProcess(spec, on_exit, screen=screen)
            process.attach(self, node, run_id)
            self._processes[spec.label] = process
            return process

        return make

    def send(self, message: dict[str, Any]) -> None:
        """Tell the agent something; a dead connection is noticed by who listens."""
        self._write(json.dumps(message).encode() + b"\n")

    def _write(self, data: bytes) -> None:
        pipe = self._ssh.stdin if self._ssh is not None else None
        with self._changed, contextlib.suppress(OSError, ValueError):
            if pipe is not None:
                pipe.write(data)
                pipe.flush()

    def _listen(self) -> None:
        pipe = self._ssh.stdout if self._ssh is not None else None
        for line in pipe or ():
            try:
                message = json.loads(line)
            except ValueError:  # what a login script of the machine says
                sys.stderr.write(line.decode("utf-8", "replace"))
                continue
            if isinstance(message, dict):
                self._heard(message)
        with self._changed:
            self._lost = True
            self._changed.notify_all()
        for process in list(self._processes.values()):
            process.lost()

    def _heard(self, message: dict[str, Any]) -> None:
        if message.get("event") == "ready":
            with self._changed:
                self._ready = True
                self._changed.notify_all()
            return
        process = self._processes.get(message.get("label", ""))
        if process is not None:
            process.heard(message)

    def _beat(self) -> None:
        while not self._closed.wait(_HEARTBEAT):
            self.send({})

    def close(self) -> None:
        """End the connection, and with it whatever still runs there."""
        self._closed.set()
        if self._ssh is None:
            return
        with self._changed, contextlib.suppress(OSError):
            if self._ssh.stdin is not None:
                self._ssh.stdin.close()
        try:
            self._ssh.wait(sum(self._stages) + 5.0 if self._ready else 0.5)
        except subprocess.TimeoutExpired:
            self._ssh.kill()
            self._ssh.wait()
        for thread in self._threads:
            thread.join(5.0)
        if self._ssh.stdout is not None:
            self._ssh.stdout.close()


class RemoteProcess(Process):
    """A process on another machine."""

    def attach(self, machine: Machine, node: NodePlan, run_id: str) -> None:
        """Say where it is to run, and what."""
        self._machine, self._node, self._run_id = machine, node, run_id
        self.machine = machine.plan.name
        self._answer: dict[str, Any] | None = None
        self._answered = threading.Event()
        self._pid = 0
        self._running = False

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

    def start(self) -> None:
        """Start it, or start it again.

        Raises:
            OSError: it cannot be started, or the machine cannot be reached.
        """
        node = self._node
        env = {"ROS_MASTER_URI": self._machine.master_uri}
        if node.namespace.strip("/"):
            env["ROS_NAMESPACE"] = node.namespace.rstrip("/")
        self._answer = None
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
        self._answered.wait(10.0)
        answer = self._answer
        if answer is None or answer.get("event") != "started":
            why = answer.get("why") if answer else "the connection is lost"
            raise OSError(0, str(why), f"machine {self._machine.plan.name}")
        self.exit_code = None
        self.spawn_count += 1
        self.started = time.monotonic()

    def heard(self, message: dict[str, Any]) -> None:
        """Take what the agent says about it; called by the thread that listens to the machine."""
        event = message.get("event")
        if event == "output":
            stream = sys.stderr if message.get("stream") == 2 else sys.stdout
            self._show(str(message.get("text", "")), stream)
        elif event == "ended":
            self._over(int(message.get("code", 0)))
        else:
            self._pid = int(message.get("pid", 0))
            self._running = event == "started"
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
        self._answered.set()
        if self._running:
            self._over(_LOST)

    def _over(self, code: int) -> None:
        self.exit_code = code
        self._running = False
        self._ended.set()
        self.on_exit(self)

    def signal(self, number: int) -> None:
        """Send a signal to the process and all that it started in its group."""
        if self._running:
            self._machine.send({"do": "signal", "label": self.spec.label, "number": int(number)})


def make_machine(
    plan: MachinePlan, environ: Mapping[str, str], master_uri: str, stages: tuple[float, float], console: Console
) -> Machine:
    """Return a machine to connect to, with a warning if nodes there cannot reach the master."""
    host = master_uri.partition("://")[2].partition(":")[0]
    if host == "localhost" or host.startswith("127."):
        console.warning(
            f"nodes on machine [{plan.name}] are told that the master is at {master_uri}, which there is that machine; "
            "set ROS_MASTER_URI to a name that it knows"
        )
    return Machine(plan, environ, master_uri, stages, console)
