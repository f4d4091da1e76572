"""Runs a plan: starts everything, supervises it, and shuts it down (X78-X90).

The order is fixed: server, SUMMARY, master (if none is running and this is its machine), /run_id, rosout, rosparam
dumps and deletes, parameters in one call, nodes. Everything is stopped in the opposite order.
"""

from __future__ import annotations

import os
import sys
import time
import uuid
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TextIO

from pyros1.ground.atomic_file import write_atomically
from pyros1.ground.errors import (
    DeadlineError,
    Error,
    LaunchError,
    MasterError,
    MasterUnreachableError,
    ParameterNotSetError,
    SerializationError,
    UnknownHostError,
)
from pyros1.launch.plan import NodePlan, Plan, TestPlan
from pyros1.launch.preload.preloader import Preloader
from pyros1.launch.reading.report import summary
from pyros1.launch.reading.resources import PackageFinder
from pyros1.launch.running.api import LaunchServer
from pyros1.launch.running.check import unsendable_params
from pyros1.launch.running.console import Console
from pyros1.launch.running.core import ROSVERSION, Core, write_pid_file
from pyros1.launch.running.core_file import CoreFile, read_core_file
from pyros1.launch.running.core_journal import CoreJournal, set_aside_journal
from pyros1.launch.running.logs import open_run_log, ros_home, run_log
from pyros1.launch.running.options import Options
from pyros1.launch.running.process import Process
from pyros1.launch.running.screen import Screen
from pyros1.launch.running.starting import RunInfo, Starter
from pyros1.launch.running.supervisor import Supervisor
from pyros1.net.allowlist import make_allowlist
from pyros1.net.hosts import (
    DEFAULT_MASTER_URI,
    WILDCARD_ADDRESSES,
    LocalAddress,
    addresses_from_environment,
    is_local,
    make_uri,
    master_uri,
    parse_uri,
)
from pyros1.net.master_client import MasterClient

_CALLER = "/roslaunch"
_POLL_PERIOD = 0.2
PING_TIMEOUT = 5.0
_TIME_LIMIT = "time limit"


@dataclass
class TestAttempt:
    """A test to run; the launch is shut down when the test exits.

    Attributes:
        test: the test, which is started after all nodes.
        time_limit: time limit of the test in seconds.
        timed_out: whether the time limit was exceeded; set at the end of the launch.
    """

    test: TestPlan
    time_limit: float
    timed_out: bool = False


@dataclass
class Session:
    """A launch: runs a plan from its start to its end.

    Args:
        plan: the nodes, parameters and so on.
        options: the options of the launch.
        packages: finds executables.
        environ: this process's environment.
        console: prints lines for the user.
        on_started: called when everything has been started.

    Attributes:
        exit_code: 1 if a required node failed, otherwise 0; set at the end of the launch.
    """

    plan: Plan
    options: Options
    packages: PackageFinder
    environ: Mapping[str, str]
    console: Console
    on_started: Callable[[], object] | None = None
    exit_code: int = 0
    _core: Core | None = None
    _has_started_all = False  # whether everything in the plan has been started
    _core_file: CoreFile = field(default_factory=CoreFile)
    _core_journal: CoreJournal | None = None
    _server: LaunchServer | None = None
    _starter: Starter | None = None
    _log: TextIO | None = None
    _is_stopped: bool = False  # not an Event, since a signal handler must not acquire locks

    def __post_init__(self) -> None:
        self._address: LocalAddress = addresses_from_environment(self.environ, {})
        self._allowlist = make_allowlist(self._address.allowed)
        self._uri = self._master_uri()
        self._master = MasterClient(_CALLER, self._uri)
        self._screen = Screen(sys.stdout, sys.stderr) if self.options.prefix else None
        self._supervisor = Supervisor(
            self.console,
            sigint_timeout=self.options.sigint_timeout,
            sigterm_timeout=self.options.sigterm_timeout,
            keep_running=self.options.core or self.options.keep_running,
            guarded=True,
            screen=self._screen,
            preloader=Preloader(self.environ) if self.options.preload else None,
        )

    def _master_uri(self) -> str:
        port = self.options.port
        # The default URI names localhost, but a master that is bound to one address cannot be reached there.
        if port is None and not self.environ.get("ROS_MASTER_URI") and self._address.bind not in WILDCARD_ADDRESSES:
            port = parse_uri(DEFAULT_MASTER_URI)[1]
        if port is not None:
            return make_uri(self._address.advertised, port)
        return master_uri(self.environ, {})

    @property
    def supervisor(self) -> Supervisor:
        """The supervisor of the processes."""
        return self._supervisor

    def launch(self, node: NodePlan) -> Process:
        """Start another node on this machine during `run`. Must be called in the thread of `run`.

        Raises:
            LaunchError: the node cannot be started.
        """
        if self._starter is None:
            raise LaunchError("cannot start a node: the launch is not running")
        return self._starter.start_one(node)

    def stop(self, reason: str = "") -> None:
        """Make `run` stop everything and return. May be called in any thread or signal handler."""
        self._is_stopped = True
        self._supervisor.stop(reason)

    def stop_waiting(self) -> None:
        """Stop waiting for nodes to exit. May be called in any thread or signal handler."""
        self._supervisor.stop_waiting()

    def run(self, attempt: TestAttempt | None = None) -> None:
        """Start everything, supervise it, and return when everything has exited.

        Args:
            attempt: one run of a test. The launch is shut down when the test exits.

        Raises:
            LaunchError: the launch cannot be started. Processes that were already started are stopped.
        """
        for text in self._address.warnings:
            self.console.warning(text)
        try:
            is_master_running = self._find_master()
            if not is_master_running:
                self._core_file = read_core_file(self.environ, self.packages)
            if self.options.journal:
                self._core_journal = CoreJournal(self.environ, parse_uri(self._uri)[1], self.console)
            run_id, folder = self._prepare(is_master_running)
            self._start(is_master_running, run_id, folder)
            if not is_master_running and self._core_journal is None:
                set_aside_journal(self.environ, parse_uri(self._uri)[1], self.console)
            if attempt is not None and self._starter is not None:
                self._starter.start_test(attempt.test)
                self._supervisor.stop_after(attempt.time_limit, _TIME_LIMIT)
            if self.on_started is not None:
                self.on_started()
            self._has_started_all = True
            reason = self._supervisor.run()
            if attempt is not None:
                attempt.timed_out = reason == _TIME_LIMIT
            if self._supervisor.required_failed:
                self.exit_code = 1
            if reason.startswith("all processes"):
                self.console.bold(reason if self._supervisor.dead else "No processes to monitor")
        finally:
            self._shut_down()

    # Before anything runs ------------------------------------------------------------------------------------------

    def _find_master(self) -> bool:
        """Return whether a master is running; wait until one is running if the options say so."""
        is_waiting = False
        while True:
            try:
                self._master.ping(PING_TIMEOUT)
            except MasterUnreachableError as error:
                unknown_host_error = error.__cause__ if isinstance(error.__cause__, UnknownHostError) else None
                if not self.options.wait:
                    if isinstance(error.__cause__, DeadlineError):
                        raise LaunchError(
                            f"the ROS master at [{self._uri}] does not answer within {PING_TIMEOUT:g} s: "
                            "is it suspended (resume it with kill -CONT PID), or is the network losing packets?"
                        ) from error
                    break
                if not is_waiting:
                    is_waiting = True
                    self.console.line("roscore/master is not yet running, will wait for it to start")
                time.sleep(_POLL_PERIOD)
                if self._is_stopped:
                    raise LaunchError("interrupted while waiting for the master") from None
                continue
            if self.options.core:
                raise LaunchError(
                    f"roscore cannot run as another roscore/master is already running. \n"
                    f"Please kill other roscore/master processes before relaunching.\nThe ROS_MASTER_URI is {self._uri}"
                )
            if self.options.wait:
                self.console.line("master has started, initiating launch")
            return True
        host, _ = parse_uri(self._uri)
        if self.options.core:
            self._warn_about_uri()
        elif self.options.port is None and unknown_host_error is not None:
            raise LaunchError(
                f"unable to contact ROS master at [{self._uri}]: {unknown_host_error}. Use the master's IP address in "
                f"ROS_MASTER_URI, or add a line 'ADDRESS {unknown_host_error.host}' to /etc/hosts."
            )
        elif self.options.port is None and not is_local(host):
            raise LaunchError(
                f"unable to contact ROS master at [{self._uri}]: it is on another machine, so it is not started "
                f"here. Start it there, or change ROS_MASTER_URI."
            )
        return False

    def _warn_about_uri(self) -> None:
        """Warn if nodes that use ROS_MASTER_URI would not find this core (L19)."""
        configured_uri = self.environ.get("ROS_MASTER_URI")
        if not configured_uri:
            return
        try:
            host, port = parse_uri(configured_uri)
        except Error as error:
            self.console.warning(f"ROS_MASTER_URI is not usable: {error}")
            return
        if not is_local(host):
            self.console.warning(f"ROS_MASTER_URI [{configured_uri}] host is not set to this machine")
        elif port != parse_uri(self._uri)[1]:
            self.console.warning(
                f"ROS_MASTER_URI port [{port}] does not match this roscore [{parse_uri(self._uri)[1]}]"
            )

    def _prepare(self, is_master_running: bool) -> tuple[str, Path]:
        run_id = self.options.run_id
        if is_master_running:
            try:
                master_run_id = str(self._master.get_param("/run_id"))
            except ParameterNotSetError:
                master_run_id = ""
            if run_id and master_run_id and run_id != master_run_id:
                raise LaunchError(
                    f"run_id on parameter server does not match declared run_id: {master_run_id} vs {run_id}"
                )
            run_id = run_id or master_run_id
        elif self._core_journal is not None:
            run_id = run_id or self._core_journal.previous_run_id
        run_id = run_id or str(uuid.uuid1())
        folder, self._log = open_run_log(self.environ, run_id)
        self.console.line(f"... logging to {self._log.name}")
        self.console.log_to(self._log)
        return run_id, folder

    # Starting ------------------------------------------------------------------------------------------------------

    def _start(self, is_master_running: bool, run_id: str, folder: Path) -> None:
        self.console.set_title(self.options.title)
        self._server = LaunchServer(self._supervisor, self._address, self.options.title, allowlist=self._allowlist)
        self.console.bold(f"started roslaunch server {self._server.uri}")
        if self.options.core:
            self.console.line(f"ros_comm version {ROSVERSION.strip()}")
        run = RunInfo(self._uri, run_id, folder, run_log(folder))
        self._starter = Starter(
            self.plan, self.options, self.packages, self.environ, self.console, self._supervisor, run
        )
        if not self.options.local:
            self._starter.connect()
        if self.options.show_summary:
            self.console.line(summary(self.plan, {} if is_master_running else dict(self._core_file.params)))
        for text in self.plan.warnings:
            self.console.warning(text)
        if not is_master_running:
            self._start_master(folder)
        self.console.bold(f"ROS_MASTER_URI={self._uri}")
        self.console.set_title(f"{self.options.title} {self._uri}")
        self._set_run_id(run_id, is_master_running)
        if self._core is not None:
            self._start_core_nodes(self._core, self._starter)
        self._execute_param_actions()
        self._set_params()
        with self._starter.environment_copied():
            for node in self.plan.nodes:
                if self._is_stopped:
                    return
                if not (self.options.local and self._starter.is_remote(node)):
                    self._starter.start(node)
        if self._core is not None:
            self._core.await_rosout()

    def _start_core_nodes(self, core: Core, starter: Starter) -> None:
        """Start rosout and the other nodes of the core."""
        if self._core_file.starts_rosout:
            core.start_rosout(self.console.line)
            if not self.plan.nodes:
                core.await_rosout()
            starter.run.counter = 1
            self.console.bold(f"process[rosout-1]: started with pid [{os.getpid()}]")
            self.console.line("started core service [/rosout]")
        for node in self._core_file.nodes:
            starter.start(node)
            self.console.line(f"started core service [{node.full_name}]")

    def _start_master(self, folder: Path) -> None:
        self.console.line("auto-starting new master")
        port = parse_uri(self._uri)[1]
        self._core = Core(
            port=port,
            address=self._address,
            uri=self._uri,
            log_folder=folder,
            environ=self.environ,
            on_shutdown=self.stop,
            notify_timeout=self.options.notify_timeout,
            log_level=self.options.master_log_level,
            core_journal=self._core_journal,
            allowlist=self._allowlist,
        )
        try:
            self._core.start_master()
        except LaunchError:
            self._core = None
            if self._core_journal is not None:
                self._core_journal.release()
            raise
        try:
            self._master.ping()
        except MasterUnreachableError:
            raise LaunchError(
                f"the master just started cannot be reached at {self._uri}: [{parse_uri(self._uri)[0]}] is not "
                f"a name of this machine, or cannot be resolved here.\n"
                "Check ROS_HOSTNAME, ROS_IP and ROS_MASTER_URI."
            ) from None
        self.console.bold(f"process[master]: started with pid [{os.getpid()}]")
        # The core is a process of this launch, which therefore continues when no node is left (X89).
        self._supervisor.keep_running = True
        write_pid_file(self.environ, port, ros_home(self.environ))

    def _set_run_id(self, run_id: str, is_master_running: bool) -> None:
        if is_master_running and self._master.has_param("/run_id"):
            return
        self.console.bold(f"setting /run_id to {run_id}")
        self._master.set_param("/run_id", run_id)

    def _execute_param_actions(self) -> None:
        for action in self.plan.actions:
            try:
                if action.command == "delete":
                    self._master.delete_param(action.name)
                else:
                    from pyros1.values import dump_yaml  # noqa: PLC0415 - rarely used

                    write_atomically(action.path, dump_yaml(self._master.get_param(action.name)))
            except ParameterNotSetError as error:
                self.console.error(str(error))
            except OSError as error:
                raise LaunchError(f"cannot dump {action.name} to {action.path}: {error.strerror}") from error

    def _set_params(self) -> None:
        """Delete and set all parameters, with one call each, before any node is started."""
        namespaces = [name for name in self.plan.clear_params if name != "/"]
        if namespaces:
            self._master.multicall([("deleteParam", (name.rstrip("/"),)) for name in namespaces])
        params: dict[str, Any] = {**(self._core_file.params if self._core is not None else {}), **self.plan.params}
        if self._server is not None:
            params[self._server.param_name()] = self._server.uri
        try:
            replies = self._master.multicall([("setParam", (name, value)) for name, value in params.items()])
        except SerializationError as error:
            raise next(unsendable_params(params), error) from error
        for name, reply in zip(params, replies, strict=True):
            if isinstance(reply, Error):
                raise LaunchError(f"cannot set parameter {name}: {reply}") from reply

    # Stopping ------------------------------------------------------------------------------------------------------

    def _shut_down(self) -> None:
        was_started = self._server is not None
        if self._starter is not None:
            self._starter.cancel_waiting()
        self._supervisor.shut_down()
        if self._screen is not None:
            self._screen.close()
        if self._starter is not None:
            self._starter.close()
            self._starter = None
        if self._server is not None:
            self._delete_server_param()
            self._server.close()
            self._server = None
        self._master.close()
        had_processes = self._core is not None or self._supervisor.dead
        if self._core is not None:
            if self._core_file.starts_rosout:
                self.console.line("[rosout-1] killing on exit")
            self._core.stop_rosout()
            self.console.line("[master] killing on exit")
            is_restored = self._core_journal is not None and self._core_journal.previous is not None
            self._core.stop_master(keep_journal=is_restored and not self._has_started_all)
            self._core = None
        if was_started:
            self.console.line("shutting down processing monitor...")
            self.console.line("... shutting down processing monitor complete")
            if had_processes:
                self.console.bold("done")
        self.console.log_to(None)
        if self._log is not None:
            self._log.close()
            self._log = None

    def _delete_server_param(self) -> None:
        if self._core is not None or self._server is None:
            return  # the parameter is lost with this launch's own master
        try:
            self._master.delete_param(self._server.param_name())
        except MasterError:
            pass
        except ParameterNotSetError:
            pass
