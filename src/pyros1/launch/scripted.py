"""What a user's program launches, and the thread that looks after it (X93)."""

from __future__ import annotations

import atexit
import shlex
import threading
import time
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Future
from typing import Any, Protocol

from pyros1.errors import LaunchError
from pyros1.launch.plan import NodePlan, Plan
from pyros1.launch.reading.convert import convert_bool
from pyros1.launch.reading.resources import Resources
from pyros1.launch.running.console import Console
from pyros1.launch.running.options import Options
from pyros1.launch.running.process import Process
from pyros1.launch.running.session import Session
from pyros1.names import canonicalize_name, ns_join

_LAST_MOMENTS_S = 3.0


class Node:
    """A node to launch.

    Args:
        package: its ROS package.
        node_type: its executable.
        name: its name, None for that of the executable.
        namespace: its namespace.
        machine_name: only nodes of this machine can be launched so: None or empty.
        args: its arguments in one string, as in a launch file.
        respawn: start it again whenever it ends; as a string: true or false.
        respawn_delay: seconds before that.
        remap_args: pairs of names.
        env_args: pairs of a variable and its value.
        output: ``screen`` or ``log``, which it is without.
        cwd: ``ros_home``, which it is without, or ``node`` for the executable's folder.
        launch_prefix: words before the command line in one string.
        required: everything ends when it ends.
        filename: where it was read, for messages.

    Raises:
        LaunchError: these arguments make no node.
    """

    def __init__(
        self,
        package: str,
        node_type: str,
        name: str | None = None,
        namespace: str = "/",
        machine_name: str | None = None,
        args: str = "",
        respawn: bool | str = False,
        respawn_delay: float = 0.0,
        remap_args: Iterable[tuple[str, str]] | None = None,
        env_args: Iterable[tuple[str, str]] | None = None,
        output: str | None = None,
        cwd: str | None = None,
        launch_prefix: str | None = None,
        required: bool | str = False,
        filename: str = "<unknown>",
    ) -> None:
        if not package or not node_type:
            raise LaunchError("package and node_type must be non-empty")
        if machine_name:
            raise LaunchError(f"a node for machine [{machine_name}] has to be in a launch file that declares it")
        if output not in (None, "log", "screen"):
            raise LaunchError(f"output must be one of 'log', 'screen', not [{output}]")
        if cwd not in (None, "", "ros_home", "ROS_HOME", "node"):
            raise LaunchError(f"cwd must be one of 'ros_home', 'node', not [{cwd}]")
        try:
            words, prefix = shlex.split(args), shlex.split(launch_prefix or "")
        except ValueError as error:
            raise LaunchError(f"the quotes of args or launch_prefix do not match: {error}") from error
        self.plan = NodePlan(
            package,
            node_type,
            name or node_type.rpartition("/")[2].partition(".")[0],
            canonicalize_name(ns_join("/", namespace)).rstrip("/") + "/",
            args=words,
            remappings=[(old, new) for old, new in remap_args or ()],
            env=dict(env_args or ()),
            prefix=prefix,
            cwd="node" if cwd == "node" else "ros_home",
            output="screen" if output == "screen" else "log",
            respawn=_flag(respawn, "respawn"),
            respawn_delay=respawn_delay,
            required=_flag(required, "required"),
            file=filename,
        )


def _flag(value: bool | str, what: str) -> bool:
    return convert_bool(value, what) if isinstance(value, str) else bool(value)


class ProcessListener(Protocol):
    """Hears of processes that end."""

    def process_died(self, process_name: str, exit_code: int | None) -> object:
        """Take note that a process has ended; called on the launch's thread.

        Args:
            process_name: its label, ``name-2``.
            exit_code: negative for a signal.
        """


class ProcessHandle:
    """A node that was launched.

    Attributes:
        name: its label, ``name-2``.
    """

    def __init__(self, process: Process, run: ScriptRun) -> None:
        self.name = process.spec.label
        self._process = process
        self._run = run

    @property
    def exit_code(self) -> int | None:
        """None while it runs, negative for a signal."""
        return self._process.exit_code

    @property
    def pid(self) -> int:
        """Its process id."""
        return self._process.pid

    def is_alive(self) -> bool:
        """Whether it runs."""
        return self._process.alive

    def stop(self, errors: list[str] | None = None) -> None:
        """End it, and wait until it has ended.

        Args:
            errors: gets a text if it does not.
        """
        self._run.stop_process(self._process)
        if self._process.alive and errors is not None:
            errors.append(f"{self.name} may still be running")


class ScriptRun:
    """A session in a thread of its own; when the program ends, so does the session.

    Args:
        plan: what to start.
        options: how.
        listeners: hear of processes that end.
        resources: finds executables, and has the environment.
    """

    def __init__(
        self, plan: Plan, options: Options, listeners: Sequence[ProcessListener], resources: Resources
    ) -> None:
        self._options = options
        self._listeners = list(listeners)
        self._started: Future[None] = Future()
        self._waiting: set[Future[Any]] = {self._started}
        self._lock = threading.Lock()
        self._over = threading.Event()
        self._session = Session(
            plan, options, resources.packages, resources.environ, Console(title=options.show_title), self._has_started
        )
        self._session.supervisor.on_death = self._tell_listeners
        self._thread = threading.Thread(target=self._work, name="launch", daemon=True)

    def start(self) -> None:
        """Start everything.

        Raises:
            LaunchError: something cannot be started; what had been has ended.
        """
        atexit.register(self.stop)
        self._thread.start()
        try:
            self._started.result()
        except BaseException:
            self.stop()
            raise

    def _work(self) -> None:
        failure: Exception = LaunchError("the launch is over")
        try:
            self._session.run()
        except Exception as error:  # noqa: BLE001 - whatever it is, nobody must wait for ever
            failure = error
        with self._lock:
            self._over.set()
            for future in self._waiting:
                if not future.done():
                    future.set_exception(failure)

    def _has_started(self) -> None:
        self._started.set_result(None)

    def _tell_listeners(self, process: Process) -> None:
        for listener in self._listeners:
            try:
                listener.process_died(process.spec.label, process.exit_code)
            except Exception as error:  # noqa: BLE001 - a user's code must not end the launch
                self._session.console.error(f"process_died of {listener!r} failed: {error!r}")

    def do(self, action: Callable[[], Any]) -> Any:
        """Let the launch's thread do something and return what it returns; raises LaunchError when all is over."""
        if threading.current_thread() is self._thread:
            return action()
        future: Future[Any] = Future()
        with self._lock:
            if self._over.is_set():
                raise LaunchError("the launch is over")
            self._waiting.add(future)

        def perform() -> None:
            try:
                future.set_result(action())
            except Exception as error:  # noqa: BLE001 - raised again where it is waited for
                future.set_exception(error)

        self._session.supervisor.do(perform)
        try:
            return future.result()
        finally:
            with self._lock:
                self._waiting.discard(future)

    def launch(self, node: Node) -> ProcessHandle:
        """Start one more node."""
        return ProcessHandle(self.do(lambda: self._session.launch(node.plan)), self)

    def stop_process(self, process: Process) -> None:
        """End a process, and wait until it has."""
        if not self._over.is_set():
            try:
                self.do(lambda: self._session.supervisor.stop_node(process))
            except LaunchError:
                self._over.wait()  # everything ends
        if threading.current_thread() is not self._thread:
            seconds = self._options.sigint_timeout + self._options.sigterm_timeout + _LAST_MOMENTS_S
            process.wait(time.monotonic() + seconds)

    def wait(self, timeout: float | None = None) -> bool:
        """Wait for the end; return whether it has come."""
        return self._over.wait(timeout)

    def stop(self) -> None:
        """End everything, and wait until all has ended."""
        atexit.unregister(self.stop)
        if self._over.is_set():
            return
        self._session.stop("stopped by the program")
        if threading.current_thread() is not self._thread:
            self._thread.join()
