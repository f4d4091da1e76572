"""ROSLaunchRunner, which runs the contents of a launch."""

from __future__ import annotations

from typing import Any

from pyros1.drop_in.module_attributes import module_getattr
from pyros1.launch.reading.system_resources import make_resources
from pyros1.launch.running.check import check_machines
from pyros1.launch.running.options import Options
from pyros1.launch.script_run import ScriptRun
from pyros1.launch.scripting import Node as ScriptNode
from roslaunch.core import (
    PHASE_RUN,
    PHASE_SETUP,
    PHASE_TEARDOWN,
    TEST_TIME_LIMIT_DEFAULT,
    Node,
    RLException,
    is_machine_local,
    printlog,
    rl_errors,
)
from roslaunch.nodeprocess import DEFAULT_TIMEOUT_SIGINT, DEFAULT_TIMEOUT_SIGTERM, NUM_WORKERS
from roslaunch.plans import to_node_plan, to_plan
from roslaunch.pmon import Process, ProcessListener, ProcessMonitor

__all__ = [
    "DEFAULT_TIMEOUT_SIGINT",
    "DEFAULT_TIMEOUT_SIGTERM",
    "NUM_WORKERS",
    "PHASE_RUN",
    "PHASE_SETUP",
    "PHASE_TEARDOWN",
    "TEST_TIME_LIMIT_DEFAULT",
    "Node",
    "ProcessListener",
    "RLException",
    "ROSLaunchListener",
    "ROSLaunchRunner",
    "is_machine_local",
    "printlog",
]


class ROSLaunchListener:
    """A listener that is notified when processes exit."""

    def process_died(self, process_name: str, exit_code: int | None) -> None:
        """Handle the exit of a process; see `ProcessListener`."""


class ROSLaunchRunner:
    """Runs the contents of a launch.

    Args:
        run_id: the run id.
        config: a ROSLaunchConfig.
        server_uri: not used, since a launch has its own server. The attribute with this name is that server's address.
        pmon: a ProcessMonitor that lists and stops the processes; None for a new one.
        is_core: whether to run a core.
        remote_runner, is_child, is_rostest, num_workers: not used.
        timeout: maximum number of seconds that a master started here waits for a node to respond.
        master_logger_level: minimum level in the log of a master started here.
        sigint_timeout, sigterm_timeout: seconds between SIGINT, SIGTERM and SIGKILL.
        options: additional launch options, which only pyros1 has; None for the defaults.

    Raises:
        RLException: there is no run id.
    """

    def __init__(
        self,
        run_id: str,
        config: Any,
        server_uri: str | None = None,
        pmon: Any = None,
        is_core: bool = False,
        remote_runner: Any = None,
        is_child: bool = False,
        is_rostest: bool = False,
        num_workers: int = NUM_WORKERS,
        timeout: float | None = None,
        master_logger_level: Any = False,
        sigint_timeout: float = DEFAULT_TIMEOUT_SIGINT,
        sigterm_timeout: float = DEFAULT_TIMEOUT_SIGTERM,
        options: dict[str, Any] | None = None,
    ) -> None:
        if run_id is None:
            raise RLException("run_id is None")
        self.run_id = run_id
        self.config = config
        self.server_uri = server_uri
        self.pm = pmon or ProcessMonitor()
        self.is_core = is_core
        self.options = Options(
            core=is_core,
            run_id=run_id,
            sigint_timeout=sigint_timeout,
            sigterm_timeout=sigterm_timeout,
            notify_timeout=timeout,
            master_log_level=(master_logger_level or "info").lower(),
        )
        for name, value in ({"show_summary": False} if options is None else options).items():
            setattr(self.options, name, value)
        self._run: ScriptRun | None = None

    def add_process_listener(self, l: Any) -> None:  # noqa: E741
        """Call an object's ``process_died`` for each process that exits."""
        self.pm.add_process_listener(l)

    @rl_errors
    def launch(self) -> tuple[list[str], list[str]]:
        """Start everything.

        Returns:
            The names of the processes that were started, and an empty list, since a failure raises an exception.

        Raises:
            RLException: something cannot be started; processes that were already started have been stopped.
        """
        plan = to_plan(self.config)
        check_machines(plan)
        self._run = ScriptRun(plan, self.options, [self.pm], make_resources())
        self.pm.runs.append(self._run)
        self._run.start()
        self.server_uri = self._run.server_uri
        return [f"Process<{handle.name}>" for handle in self._run.processes()], []

    @rl_errors
    def launch_node(self, node: Node, core: bool = False) -> tuple[Process, bool]:
        """Start one more node.

        Returns:
            The node's process, and whether it was started.

        Raises:
            RLException: the node cannot be started, or the launch was not started.
        """
        if self._run is None:
            raise RLException("the launch has not been started")
        script_node = ScriptNode(node.package, node.type)
        script_node.plan = to_node_plan(node)
        handle = self._run.launch(script_node)
        node.process_name = handle.name
        return self.pm.process_for(handle), True

    def is_node_running(self, node: Node) -> bool:
        """Return whether a node's process is running."""
        names = ((node.namespace + (node.name or "")).lstrip("/"), node.process_name)
        return any(name in names or name.rpartition("-")[0] in names for name in self.pm.get_active_names())

    def spin_once(self) -> bool:
        """Return whether anything is still running."""
        return self._run is not None and not self._run.is_over()

    def spin(self) -> None:
        """Wait until the launch has ended. Ctrl-C ends it."""
        if self._run is None:
            return
        try:
            while not self._run.wait(0.2):
                pass
        except KeyboardInterrupt:
            self.stop()

    def stop(self) -> None:
        """Stop all processes, and wait until they have exited."""
        if self._run is not None:
            self._run.stop()

    def run_test(self, test: Any) -> None:
        """Raise RLException: `pyros1 test` runs tests."""
        raise RLException("pyros1 has no ROSLaunchRunner.run_test: `pyros1 test` runs tests")


__getattr__ = module_getattr(
    "roslaunch.launch",
    ROSRemoteRunnerIF="`pyros1 launch` runs nodes on other machines itself",
    RLTestTimeoutException="`pyros1 test` runs tests",
    validate_master_launch="ROSLaunchRunner.launch checks the master",
)
