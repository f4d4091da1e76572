"""Launches single nodes or launch files from a user's program.

    launch = ROSLaunch()
    launch.start()
    process = launch.launch(Node("minimal_nodes", "minimal_publisher"))
    ...
    process.stop()
    launch.stop()

A launch runs in a separate thread; only that thread starts and stops processes. Names and arguments are the same
as in roslaunch's API.
"""

from __future__ import annotations

import os
import time
import uuid
from collections.abc import Iterable, Sequence

from pyros1.ground.errors import LaunchError, MasterUnreachableError, ParameterNotSetError
from pyros1.launch.plan import Plan
from pyros1.launch.reading.cli_arguments import find_launch_files, parse_arguments
from pyros1.launch.reading.loader import load_plan
from pyros1.launch.reading.report import list_contents
from pyros1.launch.reading.system_resources import make_resources
from pyros1.launch.running.check import check_machines
from pyros1.launch.running.console import Console
from pyros1.launch.running.logs import make_run_folder
from pyros1.launch.running.options import Options
from pyros1.launch.script_run import Node, ProcessHandle, ProcessListener, ScriptRun
from pyros1.net.hosts import master_uri
from pyros1.net.master_client import MasterClient

__all__ = [
    "Node",
    "ProcessHandle",
    "ProcessListener",
    "ROSLaunch",
    "ROSLaunchParent",
    "configure_logging",
    "get_or_generate_uuid",
    "resolve_launch_arguments",
]
_WAIT_STEP = 0.2
LaunchFile = str | tuple[str, Sequence[str]]
"""A path, or a path and its ``name:=value`` arguments."""


class ROSLaunchParent:
    """Launches launch files.

    Args:
        run_id: the run id of the running master, or a new run id; see `get_or_generate_uuid`.
        roslaunch_files: paths, or tuples of a path and a list of ``name:=value`` arguments.
        is_core: whether to run a core; if so, it is an error if a master is already running.
        port: port for a master started by this launch.
        local_only: whether to skip nodes on other machines.
        process_listeners: called when processes exit.
        verbose: whether to print everything that was read.
        force_screen: whether to send all output to the screen.
        force_log: whether to send all output to log files.
        is_rostest: accepted for compatibility, without effect. ``pyros1 test`` runs tests.
        roslaunch_strs: contents of launch files.
        num_workers: accepted for compatibility, without effect.
        timeout: maximum number of seconds that a master started by this launch waits for a node to respond.
        master_logger_level: minimum level in the log of a master started by this launch.
        show_summary: whether to print the SUMMARY block.
        force_required: whether to make every node required.
        sigint_timeout: seconds between SIGINT and SIGTERM when stopping nodes.
        sigterm_timeout: seconds between SIGTERM and SIGKILL.
    """

    def __init__(
        self,
        run_id: str | None,
        roslaunch_files: Iterable[LaunchFile],
        is_core: bool = False,
        port: int | None = None,
        local_only: bool = False,
        process_listeners: Sequence[ProcessListener] | None = None,
        verbose: bool = False,
        force_screen: bool = False,
        force_log: bool = False,
        is_rostest: bool = False,
        roslaunch_strs: Iterable[str] | None = None,
        num_workers: int = 3,
        timeout: float | None = None,
        master_logger_level: str = "",
        show_summary: bool = True,
        force_required: bool = False,
        sigint_timeout: float = 15.0,
        sigterm_timeout: float = 2.0,
    ) -> None:
        self._files = [(file, ()) if isinstance(file, str) else file for file in roslaunch_files]
        self._texts = list(roslaunch_strs or ())
        self._listeners = list(process_listeners or ())
        self._verbose = verbose
        self._options = Options(
            core=is_core,
            port=port,
            run_id=run_id,
            screen=False if force_log else True if force_screen else None,
            required=force_required,
            local=local_only,
            show_summary=show_summary,
            sigint_timeout=sigint_timeout,
            sigterm_timeout=sigterm_timeout,
            notify_timeout=timeout,
            master_log_level=master_logger_level.lower() or "info",
        )
        self._run: ScriptRun | None = None

    def start(self, auto_terminate: bool = True) -> None:
        """Read the files and start everything.

        Args:
            auto_terminate: whether to shut down the launch when no process is left.

        Raises:
            LaunchError: something cannot be started. Processes that were already started have been stopped.
        """
        if self._run is not None:
            raise LaunchError("this launch was already started")
        self._options.keep_running = not auto_terminate
        plan = self._load()
        if self._verbose:
            Console().line(list_contents(plan))
        self._run = ScriptRun(plan, self._options, self._listeners, make_resources())
        self._run.start()

    def _load(self) -> Plan:
        plan = Plan()
        resources = make_resources()
        for file, words in self._files:
            load_plan([file], parse_arguments(list(words)), resources, plan=plan)
        for text in self._texts:
            resources.read_stdin = lambda text=text: text  # type: ignore[misc]
            load_plan(["-"], {}, resources, plan=plan)
        check_machines(plan)
        return plan

    def launch(self, node: Node) -> ProcessHandle:
        """Start one more node.

        Raises:
            LaunchError: the node cannot be started.
        """
        if self._run is None:
            raise LaunchError("the launch has not been started")
        return self._run.launch(node)

    def spin_once(self) -> None:
        """Do nothing: the launch's thread supervises the processes."""

    def spin(self) -> None:
        """Wait until the launch is over. Ctrl-C shuts it down."""
        if self._run is None:
            raise LaunchError("the launch has not been started")
        try:
            while not self._run.wait(_WAIT_STEP):  # in steps, since some systems handle signals only between waits
                pass
        except KeyboardInterrupt:
            self.shutdown()

    def shutdown(self) -> None:
        """Stop all processes that were started, and wait until they have exited. No effect if the launch is over."""
        if self._run is not None:
            self._run.stop()


class ROSLaunch:
    """Launches single nodes, and starts a master if none is running."""

    def __init__(self) -> None:
        self.parent = ROSLaunchParent(None, [], show_summary=False)

    def start(self) -> None:
        """Start the launch, so that nodes can be added to it.

        Raises:
            LaunchError: the launch cannot be started.
        """
        self.parent.start(auto_terminate=False)

    def launch(self, node: Node) -> ProcessHandle:
        """Start a node.

        Raises:
            LaunchError: the node cannot be started.
        """
        return self.parent.launch(node)

    def load(self, file: LaunchFile) -> None:
        """Add a launch file. Call this before `start`."""
        self.parent._files.append((file, ()) if isinstance(file, str) else file)

    def stop(self) -> None:
        """Stop all nodes."""
        self.parent.shutdown()

    def spin(self) -> None:
        """Wait until Ctrl-C is pressed or a required node has exited."""
        self.parent.spin()

    def spin_once(self) -> None:
        """Do nothing: the launch's thread supervises the processes."""
        self.parent.spin_once()


def get_or_generate_uuid(options_runid: str | None, options_wait_for_master: bool) -> str:
    """Return the run id of the running master, or a new run id.

    Args:
        options_runid: a run id specified by the user, which is returned unless it is empty.
        options_wait_for_master: whether to wait until a master is running.
    """
    if options_runid:
        return options_runid
    master = MasterClient("/roslaunch", master_uri(os.environ, {}))
    try:
        while True:
            try:
                return str(master.get_param("/run_id"))
            except ParameterNotSetError:
                break
            except MasterUnreachableError:
                if not options_wait_for_master:
                    break
                time.sleep(_WAIT_STEP)
    finally:
        master.close()
    return str(uuid.uuid1())


def configure_logging(run_id: str) -> str:
    """Create the log folder of a run, and the link ``latest`` to it.

    Args:
        run_id: the run id, see `get_or_generate_uuid`.

    Returns:
        The folder's path.

    Raises:
        LaunchError: the folder cannot be created, or the id is not a valid folder name.
    """
    try:
        return str(make_run_folder(os.environ, run_id))
    except OSError as error:
        raise LaunchError(f"cannot create the log folder: {error.strerror}: {error.filename}") from error


def resolve_launch_arguments(args: Iterable[str]) -> list[str]:
    """Return the paths specified on a command line as ``pkg file`` or ``file...``.

    Args:
        args: the command-line arguments; those with ``:=`` are ignored.

    Raises:
        LaunchError: a file does not exist.
    """
    return find_launch_files([word for word in args if ":=" not in word], make_resources())
