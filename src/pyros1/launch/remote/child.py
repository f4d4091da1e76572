"""The remote end for a stock launcher: ``roslaunch -c NAME -u URI --run_id ID`` (L151-L153, X91).

A stock parent starts this child through ssh, waits for its registration, sends it the nodes as a launch file, and later
tells it to shut down. The child reports each line of output and each exit of a process to the parent. pyros1's launcher
does not use this module; see `over_ssh`.
"""

from __future__ import annotations

import contextlib
import os
import queue
import stat
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, TextIO

from pyros1.ground.errors import Error, LaunchError
from pyros1.launch.plan import NodePlan, Plan
from pyros1.launch.reading.loader import STDIN_NAME, load_plan
from pyros1.launch.reading.resources import Resources
from pyros1.launch.running.api import LaunchServer, Response
from pyros1.launch.running.console import Console
from pyros1.launch.running.logs import open_run_log, run_log
from pyros1.launch.running.options import Options
from pyros1.launch.running.process import Process
from pyros1.launch.running.starting import RunInfo, Starter
from pyros1.launch.running.supervisor import Supervisor
from pyros1.net.allowlist import make_allowlist
from pyros1.net.hosts import addresses_from_environment, master_uri
from pyros1.net.master_client import MasterClient, unpack_reply
from pyros1.net.xmlrpc_client import XmlRpcClient

_INFO_LEVEL, _ERROR_LEVEL = 2, 8
_TIMEOUT = 5.0
_END_TIMEOUT = 10.0
_ALL_ENDED = "all processes on machine have died"


class Parent:
    """The launcher that started this launcher.

    A thread reports events to the parent, in order. If the parent does not respond, reporting stops.

    Args:
        name: name under which the child registers with the parent.
        uri: the parent's URI.

    Raises:
        ProtocolError: the URI is malformed.
    """

    def __init__(self, name: str, uri: str) -> None:
        self._name = name
        self._client = XmlRpcClient(uri, timeout=_TIMEOUT)
        self._calls: queue.SimpleQueue[tuple[Any, ...] | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._report_events, name="roslaunch parent", daemon=True)

    def register(self, uri: str) -> None:
        """Register the child's URI with the parent.

        Raises:
            Error: the parent cannot be reached, or refuses the child.
        """
        unpack_reply(self._client.call("register", self._name, uri), f"the parent at {self._client.uri}")
        self._thread.start()

    def log(self, level: int, text: str) -> None:
        """Make the parent print a line."""
        self._calls.put(("log", self._name, level, text))

    def report_exit(self, process: Process) -> None:
        """Report that a process has exited."""
        self._calls.put(("process_died", process.spec.label, process.exit_code or 0))

    def flush(self) -> None:
        """Wait until everything has been reported. Later events are not reported."""
        if self._thread.is_alive():
            self._calls.put(None)
            self._thread.join(_END_TIMEOUT)

    def close(self) -> None:
        """Close the connection."""
        self.flush()
        self._client.close()

    def _report_events(self) -> None:
        while call := self._calls.get():
            try:
                self._client.call(*call)
            except Error:
                return


class _ParentConsole(Console):
    """A console that prints lines on the parent's screen."""

    def __init__(self, parent: Parent) -> None:
        super().__init__()
        self._parent = parent
        self._file: TextIO | None = None

    def log_to(self, log: TextIO | None) -> None:
        self._file = log

    def _write(self, stream: TextIO, text: str, style: str) -> None:
        self._parent.log(_ERROR_LEVEL if stream is self._err else _INFO_LEVEL, text)
        if self._file is not None:
            self._file.write(text + "\n")
            self._file.flush()


class _ChildServer(LaunchServer):
    """Serves the launcher's public API, and the methods that only the parent calls."""

    def __init__(self, child: Child, supervisor: Supervisor, environ: Mapping[str, str]) -> None:
        self._child = child
        address = addresses_from_environment(environ, {})
        super().__init__(
            supervisor, address, f"part {child.name} of another launch", allowlist=make_allowlist(address.allowed)
        )

    def dispatch(self, method: str, params: Sequence[Any]) -> Response:
        if method == "launch":
            return self._child.launch(str(params[0]) if params else "")
        if method == "shutdown":
            return self._child.shutdown()
        return super().dispatch(method, params)


class Child:
    """Runs the parent's nodes until the launch is shut down or the parent is gone.

    Args:
        name: name under which the child registers with the parent.
        parent_uri: the parent's URI.
        run_id: name of the log folder.
        options: timeouts for stopping nodes, and the destination of their output.
        resources: access to packages and the environment.

    Raises:
        Error: the parent's URI is malformed, or log files cannot be written.
    """

    def __init__(self, name: str, parent_uri: str, run_id: str, options: Options, resources: Resources) -> None:
        environ = resources.environ
        self.name = name
        self._resources = resources
        self._options = options
        folder, self._log = open_run_log(environ, run_id)
        self._local_console = Console()
        self._local_console.line(f"... logging to {self._log.name}")
        try:
            self._parent = Parent(name, parent_uri)
        except Error:
            self._log.close()
            raise
        self._console = _ParentConsole(self._parent)
        self._console.log_to(self._log)
        self._run = RunInfo(master_uri(environ, {}), run_id, folder, run_log(folder))
        self._supervisor = Supervisor(
            self._console,
            sigint_timeout=options.sigint_timeout,
            sigterm_timeout=options.sigterm_timeout,
            guarded=True,
        )
        self._supervisor.on_process_exit = self._parent.report_exit
        self._supervisor.num_expected = 1  # a placeholder for the parent's nodes, which have not been received yet
        self._server: LaunchServer | None = None
        self._shut_down_event = threading.Event()

    def stop(self, reason: str = "") -> None:
        """Make `run` stop everything and return. May be called in any thread or signal handler."""
        self._supervisor.stop(reason)

    def stop_waiting(self) -> None:
        """Stop waiting for nodes to exit. May be called in any thread or signal handler."""
        self._supervisor.stop_waiting()

    def run(self) -> None:
        """Register, serve requests, and return when everything has been stopped.

        Raises:
            Error: the parent cannot be reached.
        """
        self._server = server = _ChildServer(self, self._supervisor, self._resources.environ)
        self._local_console.line(f"started roslaunch server {server.uri}")
        try:
            self._parent.register(server.uri)
            reason = self._supervisor.run()
            if reason.startswith(_ALL_ENDED):
                self._console.line(reason)
        finally:
            self._supervisor.shut_down()
            self._update_uri_param(delete=True)
            self._parent.close()
            self._shut_down_event.set()
            server.close()
            self._log.close()

    def _update_uri_param(self, *, delete: bool = False) -> None:
        """Set or delete the parameter with this launcher's URI, through which `pyros1 node status` finds the nodes."""
        server = self._server
        if server is None:
            return
        master = MasterClient("/roslaunch", self._run.master_uri, timeout=_TIMEOUT)
        with contextlib.suppress(Error):
            if delete:
                master.delete_param(server.param_name())
            else:
                master.set_param(server.param_name(), server.uri)
        master.close()

    def launch(self, xml: str) -> Response:
        """Start the nodes in a launch file. Called by the parent.

        Args:
            xml: content of the file.

        Returns:
            The API's response, with the processes that were started, and the names of the nodes that were not.
        """
        try:
            plan = load_plan([STDIN_NAME], {}, replace(self._resources, read_stdin=lambda: xml))
        except Error as error:
            return [-1, f"ERROR: {error}", [[], []]]
        started = threading.Event()
        results: list[list[str]] = [[], []]

        def start() -> None:
            self._start(plan, results)
            self._supervisor.num_expected = 0
            started.set()

        self._supervisor.call_soon(start)
        while not started.wait(0.1):
            if self._shut_down_event.is_set():
                return [0, "ERROR: this launcher is shutting down", [[], []]]
        return [1, "launched", results]

    def _start(self, plan: Plan, results: list[list[str]]) -> None:
        self._update_uri_param()
        self._console.line("launching nodes...")
        self._console.line(f"ROS_MASTER_URI={self._run.master_uri}")
        environ, packages = self._resources.environ, self._resources.packages
        starter = Starter(plan, self._options, packages, environ, self._console, self._supervisor, self._run)
        for node in plan.nodes:
            label = self._start_node(starter, node)
            if label:
                results[0].append(f"Process<{label}>")
            else:
                results[1].append(node.name)
        self._console.line("... done launching nodes")

    def _start_node(self, starter: Starter, node: NodePlan) -> str:
        self._run.counter += 1
        label = f"{node.full_name.lstrip('/')}-{self._run.counter}"
        try:
            spec = starter.make_spec(node, label)
        except LaunchError as error:
            self._console.error(f"cannot launch node of type [{node.package}/{node.type}]: {error}")
            return ""
        spec.errors_to_file = not spec.to_screen
        return label if self._supervisor.start(spec) else ""

    def shutdown(self) -> Response:
        """Stop everything, and return when everything has stopped. Called by the parent."""
        self.stop()
        self._shut_down_event.wait(self._options.sigint_timeout + self._options.sigterm_timeout + _END_TIMEOUT)
        return [1, "success", 1]


def stop_when_stdin_closes(stop: Callable[[str], None]) -> None:
    """Call ``stop`` when standard input is closed, which may be the only sign that the ssh connection was closed.

    Standard input is replaced with an empty one, so that no node reads from the connection.
    """
    if not (stat.S_ISFIFO(os.fstat(0).st_mode) or stat.S_ISSOCK(os.fstat(0).st_mode)):
        return
    connection, null_device = os.dup(0), os.open(os.devnull, os.O_RDONLY)
    os.dup2(null_device, 0)
    os.close(null_device)

    def watch() -> None:
        with contextlib.suppress(OSError):
            while os.read(connection, 4096):
                pass
        stop("the connection to the parent was closed")

    threading.Thread(target=watch, name="connection to the parent", daemon=True).start()
