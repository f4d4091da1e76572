"""ROSLaunchParent, which launches launch files."""

from __future__ import annotations

import logging
from typing import Any

from roslaunch.config import load_config_default
from roslaunch.core import RLException, printerrlog, printlog_bold
from roslaunch.launch import ROSLaunchRunner
from roslaunch.nodeprocess import DEFAULT_TIMEOUT_SIGINT, DEFAULT_TIMEOUT_SIGTERM, NUM_WORKERS
from roslaunch.pmon import ProcessMonitor, start_process_monitor
from roslaunch.server import ROSLaunchParentNode

__all__ = [
    "DEFAULT_TIMEOUT_SIGINT",
    "DEFAULT_TIMEOUT_SIGTERM",
    "NUM_WORKERS",
    "RLException",
    "ROSLaunchParent",
    "load_config_default",
    "printerrlog",
    "printlog_bold",
]


class ROSLaunchParent:
    """Launches launch files.

    Attributes:
        config, runner, pm: the ROSLaunchConfig, the ROSLaunchRunner and the ProcessMonitor; None until `start`.
        server: the launch's XML-RPC server, with its ``uri``.

    Args:
        run_id: the run id; see `rlutil.get_or_generate_uuid`.
        roslaunch_files: paths, or tuples of a path and a list of ``name:=value``.
        is_core: whether to run a core; another running master is then an error.
        port: port of a master started here.
        local_only: whether to skip nodes on other machines.
        process_listeners: objects with ``process_died``.
        verbose: whether to print a list of the files' contents.
        force_screen, force_log: whether to send all output to the screen, or to files.
        is_rostest, num_workers: accepted for compatibility.
        roslaunch_strs: contents of more files.
        timeout: maximum number of seconds that a master started here waits for a node to respond.
        master_logger_level: minimum level in the log of a master started here.
        show_summary: whether to print the SUMMARY block.
        force_required: whether to make every node required.
        sigint_timeout, sigterm_timeout: seconds between SIGINT, SIGTERM and SIGKILL.
    """

    def __init__(
        self,
        run_id: str | None,
        roslaunch_files: Any,
        is_core: bool = False,
        port: int | None = None,
        local_only: bool = False,
        process_listeners: Any = None,
        verbose: bool = False,
        force_screen: bool = False,
        force_log: bool = False,
        is_rostest: bool = False,
        roslaunch_strs: Any = None,
        num_workers: int = NUM_WORKERS,
        timeout: float | None = None,
        master_logger_level: Any = False,
        show_summary: bool = True,
        force_required: bool = False,
        sigint_timeout: float = DEFAULT_TIMEOUT_SIGINT,
        sigterm_timeout: float = DEFAULT_TIMEOUT_SIGTERM,
    ) -> None:
        if sigint_timeout <= 0:
            raise RLException(f"sigint_timeout must be a positive number, received {sigint_timeout}")
        if sigterm_timeout <= 0:
            raise RLException(f"sigterm_timeout must be a positive number, received {sigterm_timeout}")
        self.run_id = run_id
        self.roslaunch_files = roslaunch_files
        self.roslaunch_strs = roslaunch_strs
        self.is_core = is_core
        self.port = port
        self.local_only = local_only
        self.verbose = verbose
        self.process_listeners = process_listeners
        self.num_workers = num_workers
        self.timeout = timeout
        self.master_logger_level = master_logger_level
        self.sigint_timeout = sigint_timeout
        self.sigterm_timeout = sigterm_timeout
        self.config: Any = None
        self.runner: ROSLaunchRunner | None = None
        self.pm: ProcessMonitor | None = None
        self.server: ROSLaunchParentNode | None = None
        self.remote_runner: Any = None
        self.is_rostest = is_rostest
        self.show_summary = show_summary
        self.force_screen, self.force_log, self.force_required = force_screen, force_log, force_required
        self.logger = logging.getLogger("roslaunch.parent")
        self._options: dict[str, Any] = {
            "screen": False if force_log else True if force_screen else None,
            "port": port,
            "local": local_only,
            "required": force_required,
            "show_summary": show_summary,
        }

    def start(self, auto_terminate: bool = True) -> None:
        """Read the files and start everything.

        Args:
            auto_terminate: whether to shut down the launch when no process is left.

        Raises:
            RLException: something cannot be started.
        """
        if self.runner is not None:
            raise RLException("this launch was already started")
        self.config = load_config_default(
            self.roslaunch_files, self.port, roslaunch_strs=self.roslaunch_strs, verbose=self.verbose
        )
        self.pm = start_process_monitor()
        self.runner = ROSLaunchRunner(
            self.run_id or "",
            self.config,
            pmon=self.pm,
            is_core=self.is_core,
            timeout=self.timeout,
            master_logger_level=self.master_logger_level,
            sigint_timeout=self.sigint_timeout,
            sigterm_timeout=self.sigterm_timeout,
            options={**self._options, "run_id": self.run_id, "keep_running": not auto_terminate},
        )
        for listener in self.process_listeners or ():
            self.runner.add_process_listener(listener)
        self.runner.launch()
        self.server = ROSLaunchParentNode(self.config, self.pm, self.runner.server_uri or "")

    def spin_once(self) -> bool:
        """Return whether anything is still running."""
        return self.runner is not None and self.runner.spin_once()

    def spin(self) -> None:
        """Wait until the launch has ended. Ctrl-C ends it. Raises RLException if it was not started."""
        if self.runner is None:
            raise RLException("parent not started yet")
        self.runner.spin()
        self.shutdown()

    def shutdown(self) -> None:
        """Stop all processes that were started, and wait until they have exited."""
        if self.runner is not None:
            self.runner.stop()
        if self.pm is not None:
            self.pm.shutdown()
