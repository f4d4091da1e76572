"""Launches nodes from a user's program, and supervises them in a thread (X93)."""

from __future__ import annotations

import atexit
import shlex
import threading
import time
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Future
from typing import Any, Protocol

from pyros1.ground.errors import LaunchError
from pyros1.ground.names import canonicalize_name, ns_join
from pyros1.launch.plan import ExitPolicy, NodePlan, Plan
from pyros1.launch.reading.convert import convert_bool
from pyros1.launch.reading.resources import Resources
from pyros1.launch.running.console import Console
from pyros1.launch.running.options import Options
from pyros1.launch.running.process import Process
from pyros1.launch.running.session import Session

_SIGKILL_MARGIN_S = 3.0


class Node:
    """A node to launch.

    Args:
        package: the node's ROS package.
        node_type: the name of its executable.
        name: the node's name; None for the executable's name.
        namespace: the node's namespace.
        machine_name: must be None or empty, since only nodes on this machine can be launched this way.
        args: the node's arguments as one string, as in a launch file.
        respawn: whether to restart the node whenever it exits; a bool, or the string true or false.
        respawn_delay: seconds to wait before restarting it.
        remap_args: remappings, as pairs of names.
        env_args: environment variables, as pairs of a name and a value.
        output: ``screen`` or ``log`` (default).
        cwd: ``ros_home`` (default), or ``node`` for the executable's folder.
        launch_prefix: a command that runs the node's command line, such as ``gdb --args``, as one string.
        required: whether to shut down the launch when the node exits.
        filename: name of the file that defines the node, for error messages.

    Raises:
        LaunchError: an argument is invalid.
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
            raise LaunchError(f"a node for machine [{machine_name}] must be in a launch file that declares the machine")
        if output not in (None, "log", "screen"):
            raise LaunchError(f"output must be one of 'log', 'screen', not [{output}]")
        if cwd not in (None, "", "ros_home", "ROS_HOME", "node"):
            raise LaunchError(f"cwd must be one of 'ros_home', 'node', not [{cwd}]")
        try:
            argument_words, prefix = shlex.split(args), shlex.split(launch_prefix or "")
        except ValueError as error:
            raise LaunchError(f"cannot split args or launch_prefix into arguments: {error}") from error
        self.plan = NodePlan(
            package,
            node_type,
            name or node_type.rpartition("/")[2].partition(".")[0],
            canonicalize_name(ns_join("/", namespace)).rstrip("/") + "/",
            args=argument_words,
            remappings=[(old, new) for old, new in remap_args or ()],
            env=dict(env_args or ()),
            prefix=prefix,
            cwd="node" if cwd == "node" else "ros_home",
            output="screen" if output == "screen" else "log",
            exit_policy=ExitPolicy(_to_bool(respawn, "respawn"), respawn_delay, _to_bool(required, "required")),
            file=filename,
        )


def _to_bool(value: bool | str, name: str) -> bool:
    return convert_bool(value, name) if isinstance(value, str) else bool(value)


class ProcessListener(Protocol):
    """A listener that is called when processes exit."""

    def process_died(self, process_name: str, exit_code: int | None) -> object:
        """Handle the exit of a process. Called in the launch's thread.

        Args:
            process_name: the process's label, such as ``name-2``.
            exit_code: the exit code; negative for a signal.
        """


class ProcessHandle:
    """A launched node.

    Attributes:
        name: the process's label, such as ``name-2``.
        spec: the description of the process; its ``exit_policy`` may be changed while it is running.
    """

    def __init__(self, process: Process, run: ScriptRun) -> None:
        self.name = process.spec.label
        self.spec = process.spec
        self._process = process
        self._run = run

    @property
    def exit_code(self) -> int | None:
        """The exit code: None while the node is running, negative for a signal."""
        return self._process.exit_code

    @property
    def pid(self) -> int:
        """The process id."""
        return self._process.pid

    @property
    def spawn_count(self) -> int:
        """The number of times that the node was started."""
        return self._process.spawn_count

    def is_alive(self) -> bool:
        """Return whether the node is running."""
        return self._process.alive

    def end(self, errors: list[str] | None = None) -> None:
        """Stop the node as if it had exited by itself, and wait until it has exited. It may be respawned.

        Args:
            errors: a list to which a message is added if the node does not exit.
        """
        if not self._run.end_process(self._process) and errors is not None:
            errors.append(f"{self.name} may still be running")

    def stop(self, errors: list[str] | None = None) -> None:
        """Stop the node, and wait until it has exited.

        Args:
            errors: a list to which a message is added if the node does not exit.
        """
        self._run.stop_process(self._process)
        if self._process.alive and errors is not None:
            errors.append(f"{self.name} may still be running")


class ScriptRun:
    """Runs a session in a separate thread; the session is shut down when the program exits.

    Args:
        plan: the plan to launch.
        options: the options of the launch.
        listeners: called when processes exit.
        resources: access to packages and the environment.
    """

    def __init__(
        self, plan: Plan, options: Options, listeners: Sequence[ProcessListener], resources: Resources
    ) -> None:
        self._options = options
        self._listeners = list(listeners)
        self._started: Future[None] = Future()
        self._pending_results: set[Future[Any]] = {self._started}
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._session = Session(
            plan, options, resources.packages, resources.environ, Console(title=False), self._on_started
        )
        self._session.supervisor.on_process_exit = self._notify_listeners
        self._thread = threading.Thread(target=self._run, name="launch", daemon=True)

    def start(self) -> None:
        """Start everything in the plan, and wait until everything has been started.

        Raises:
            LaunchError: something cannot be started. Processes that were already started have been stopped.
        """
        atexit.register(self.stop)
        self._thread.start()
        try:
            self._started.result()
        except BaseException:
            self.stop()
            raise

    def _run(self) -> None:
        failure: Exception = LaunchError("the launch is over")
        try:
            self._session.run()
        except Exception as error:  # noqa: BLE001 - waiting threads must continue after any error
            failure = error
        with self._lock:
            self._ended.set()
            for future in self._pending_results:
                if not future.done():
                    future.set_exception(failure)

    def _on_started(self) -> None:
        self._started.set_result(None)

    def _notify_listeners(self, process: Process) -> None:
        for listener in self._listeners:
            try:
                listener.process_died(process.spec.label, process.exit_code)
            except Exception as error:  # noqa: BLE001 - an error in user code must not affect the launch
                self._session.console.error(f"process_died of {listener!r} failed: {error!r}")

    def call(self, action: Callable[[], Any]) -> Any:
        """Call a function in the launch's thread; return its result, or raise its exception.

        Raises:
            LaunchError: the launch is over.
        """
        if threading.current_thread() is self._thread:
            return action()
        future: Future[Any] = Future()
        with self._lock:
            if self._ended.is_set():
                raise LaunchError("the launch is over")
            self._pending_results.add(future)

        def perform() -> None:
            try:
                future.set_result(action())
            except Exception as error:  # noqa: BLE001 - raised again in the waiting thread
                future.set_exception(error)

        self._session.supervisor.call_soon(perform)
        try:
            return future.result()
        finally:
            with self._lock:
                self._pending_results.discard(future)

    def launch(self, node: Node) -> ProcessHandle:
        """Start another node.

        Raises:
            LaunchError: the node cannot be started, or the launch is over.
        """
        return ProcessHandle(self.call(lambda: self._session.launch(node.plan)), self)

    def processes(self) -> list[ProcessHandle]:
        """Return the running processes."""
        return [ProcessHandle(process, self) for process in self._session.supervisor.active]

    def dead_processes(self) -> list[ProcessHandle]:
        """Return the processes that have exited and will not be respawned."""
        return [ProcessHandle(process, self) for process in self._session.supervisor.dead]

    @property
    def server_uri(self) -> str:
        """URI of the launch's XML-RPC server; empty if the server is not running."""
        server = self._session._server
        return server.uri if server is not None else ""

    def is_over(self) -> bool:
        """Return whether the launch is over."""
        return self._ended.is_set()

    def stop_process(self, process: Process) -> None:
        """Stop a process, and wait until it has exited."""
        self._end(process, self._session.supervisor.stop_node)

    def end_process(self, process: Process) -> bool:
        """Stop a process like `ProcessHandle.end`; return whether it has exited."""
        return self._end(process, self._session.supervisor.end_node)

    def _end(self, process: Process, end_in_thread: Callable[[Process], object]) -> bool:
        previous_count = process.spawn_count
        if not self._ended.is_set():
            try:
                self.call(lambda: end_in_thread(process))
            except LaunchError:
                self._ended.wait()  # the launch is being shut down
        if threading.current_thread() is self._thread:
            return True
        timeout = self._options.sigint_timeout + self._options.sigterm_timeout + _SIGKILL_MARGIN_S
        return process.wait(time.monotonic() + timeout) or process.spawn_count > previous_count

    def wait(self, timeout: float | None = None) -> bool:
        """Wait until the launch is over, at most `timeout` seconds; return whether it is over."""
        return self._ended.wait(timeout)

    def stop(self) -> None:
        """Stop the launch, and wait until all its processes have exited."""
        atexit.unregister(self.stop)
        if self._ended.is_set():
            return
        self._session.stop("stopped by the program")
        if threading.current_thread() is not self._thread:
            self._thread.join()
