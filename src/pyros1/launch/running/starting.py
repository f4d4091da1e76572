"""Starts the nodes of a plan, on this machine and on others, as soon as their ``wait-for`` conditions are met."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from pyros1.ground.errors import LaunchError
from pyros1.launch.plan import ExitPolicy, MachinePlan, NodePlan, Plan, TestPlan
from pyros1.launch.reading.resources import PackageFinder
from pyros1.launch.running.command_line import (
    check_prefix,
    check_script,
    locate,
    node_environment,
    node_words,
    own_python_environment,
)
from pyros1.launch.running.console import Console
from pyros1.launch.running.logs import ros_home
from pyros1.launch.running.options import Options
from pyros1.launch.running.process import Process
from pyros1.launch.running.process_spec import ProcessSpec
from pyros1.launch.running.supervisor import Supervisor
from pyros1.net.hosts import is_local

if TYPE_CHECKING:
    from pyros1.launch.remote.over_ssh import Machine
    from pyros1.launch.running.readiness import ConditionWatcher

# Modules that only some launches need are imported where they are used, since imports delay the first node's start.


def _location(node: NodePlan) -> str:
    place = f"{node.file}:{node.line}" if node.line else node.file
    return f"\n  at {place}" if place else ""


@dataclass
class RunInfo:
    """Data shared by all nodes of one launch.

    Attributes:
        master_uri: the master's URI.
        run_id: the master's run id.
        folder: folder of the log files.
        log: path of the launcher's own log file.
        counter: number in the label of the most recently started process.
    """

    master_uri: str
    run_id: str
    folder: Path
    log: Path
    counter: int = 0


@dataclass
class Starter:
    """Starts nodes.

    Args:
        plan: the plan whose nodes are started.
        options: the options of the launch.
        packages: finds executables.
        environ: this process's environment.
        console: prints lines for the user.
        supervisor: supervises the processes.
        run: data shared by all nodes.
    """

    plan: Plan
    options: Options
    packages: PackageFinder
    environ: Mapping[str, str]
    console: Console
    supervisor: Supervisor
    run: RunInfo
    _machines: dict[str, Machine] = field(default_factory=dict)
    _condition_watcher: ConditionWatcher | None = None

    @contextlib.contextmanager
    def environment_copied(self) -> Iterator[None]:
        """Use a copy of the environment while nodes are started, since os.environ decodes values on each access."""
        original, self.environ = self.environ, dict(self.environ)
        try:
            yield
        finally:
            self.environ = original

    def connect(self) -> None:
        """Connect to all machines that have nodes, before any node is started.

        Raises:
            LaunchError: a machine cannot be used.
        """
        machines: dict[str, MachinePlan] = {}
        for node in self.plan.nodes:
            machine = self._remote_machine(node)
            if machine is not None:
                machines[machine.name] = machine
        if not machines:
            return
        from pyros1.launch.remote.over_ssh import make_machine  # noqa: PLC0415

        for machine in machines.values():
            stop_timeouts = (self.options.sigint_timeout, self.options.sigterm_timeout)
            connection = make_machine(
                machine, self.environ, self.run.master_uri, stop_timeouts, self.console, self._on_reconnected
            )
            self._machines[machine.name] = connection
        for connection in self._machines.values():
            connection.connect()
        for connection in self._machines.values():
            connection.wait_ready()

    def _on_reconnected(self, processes: list[Process]) -> None:
        self.supervisor.call_soon(lambda: self.supervisor.resume(processes))

    def start(self, node: NodePlan) -> None:
        """Start a node, now or when its ``wait-for`` conditions are met. Errors are printed on the console."""
        self.run.counter += 1
        label = f"{node.full_name.lstrip('/')}-{self.run.counter}"
        if not node.wait_for:
            self._start(node, label)
            return
        if self._condition_watcher is None:
            from pyros1.launch.running.readiness import ConditionWatcher  # noqa: PLC0415

            self._condition_watcher = ConditionWatcher(self.run.master_uri, self.supervisor.call_soon)
        self.supervisor.num_expected += 1
        conditions = ", ".join(map(str, node.wait_for))
        self.console.line(f"[{label}] waiting for {conditions}")
        self._condition_watcher.add(
            node.wait_for,
            node.wait_timeout,
            lambda: self._on_conditions_met(node, label),
            lambda missing: self._on_wait_timeout(node, label, missing),
        )

    def start_test(self, test: TestPlan) -> None:
        """Start a test; the launch is shut down when the test exits.

        Raises:
            LaunchError: the test cannot be started.
        """
        self.run.counter += 1
        spec = self.make_spec(test, f"{test.full_name.lstrip('/')}-{self.run.counter}")
        spec.ends_launch = True
        if not self.supervisor.start(spec):
            raise LaunchError(f"test [{test.test_name}] cannot be started")

    def start_one(self, node: NodePlan) -> Process:
        """Start a node on this machine immediately.

        Raises:
            LaunchError: the node cannot be started.
        """
        if self.is_remote(node):
            raise LaunchError(f"node [{node.full_name}] runs on another machine: put it into a launch file")
        self.run.counter += 1
        label = f"{node.full_name.lstrip('/')}-{self.run.counter}"
        spec = self.make_spec(node, label)
        spec.on_death_spec = self._on_death_spec(node, spec)
        if not self.supervisor.start(spec):
            raise LaunchError(f"node [{node.full_name}] cannot be started")
        return self.supervisor.find(label)

    def _on_conditions_met(self, node: NodePlan, label: str) -> None:
        self.supervisor.num_expected -= 1
        self._start(node, label)

    def _on_wait_timeout(self, node: NodePlan, label: str, missing: str) -> None:
        self.supervisor.num_expected -= 1
        self.console.error(
            f"[{label}] is not started: {missing} did not appear within {node.wait_timeout:g} s "
            f"(wait-for at {node.file}:{node.line})"
        )
        if self._exit_policy(node).required:
            self.supervisor.required_failed = True
            self.supervisor.stop(f"required node {node.full_name} could not be started")

    def _start(self, node: NodePlan, label: str) -> None:
        machine = self._remote_machine(node)
        try:
            spec = self.make_spec(node, label) if machine is None else self._remote_spec(node, label)
            spec.on_death_spec = self._on_death_spec(node, spec)
        except LaunchError as error:
            hint = ""
            if machine is None:
                from pyros1.launch.running.check import similar_executable_hint  # noqa: PLC0415

                hint = similar_executable_hint(node, self.packages)
            self.console.error(
                f"cannot launch node of type [{node.package}/{node.type}]: {error}{hint}{_location(node)}"
            )
            return
        if machine is None:
            self.supervisor.start(spec)
        else:
            self.supervisor.start(spec, self._machines[machine.name].make_process_factory(node, self.run.run_id))

    def make_spec(self, node: NodePlan, label: str) -> ProcessSpec:
        """Return the description of a node's process on this machine.

        Raises:
            LaunchError: the executable does not exist or cannot be started, or the folder where nodes run (ROS_HOME)
                cannot be created.
        """
        executable = locate(node.package, node.type, self.packages)
        check_prefix(node, self.environ)
        check_script(node, executable, self.environ)
        home = ros_home(self.environ)
        try:
            home.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise LaunchError(
                f"cannot create the folder {home}, where nodes run: {error.strerror}; set ROS_HOME to another folder"
            ) from error
        # The logging of stock ROS sets this in roslaunch's own environment, which nodes inherit.
        environ = {**self.environ, "ROS_LOG_FILENAME": str(self.run.log)}
        log_base = self.run.folder / label.replace("/", "-")
        return ProcessSpec(
            label=label,
            node=node.full_name,
            words=[*node_words(node, executable, self.environ), f"__log:={log_base}.log"],
            env=node_environment(node, executable, environ, self.run.master_uri),
            cwd=str(executable.parent) if node.cwd == "node" else str(home),
            log_base=str(log_base),
            to_screen=self._outputs_to_screen(node),
            exit_policy=self._exit_policy(node),
            package=node.package,
            priority=node.priority,
        )

    def _remote_spec(self, node: NodePlan, label: str) -> ProcessSpec:
        remaps = [f"{old}:={new}" for old, new in node.remappings]
        return ProcessSpec(
            label=label,
            node=node.full_name,
            words=[*node.prefix, f"{node.package}/{node.type}", *node.args, *remaps, f"__name:={node.name}"],
            env={},
            cwd="",
            to_screen=self._outputs_to_screen(node),
            exit_policy=self._exit_policy(node),
            package=node.package,
            priority=node.priority,
        )

    def _on_death_spec(self, node: NodePlan, spec: ProcessSpec) -> ProcessSpec | None:
        """Return the process to start on this machine when a node exits; None if there is none.

        Raises:
            LaunchError: the process could not be started later, when the node exits.
        """
        if node.on_death is None:
            return None
        label = f"{spec.label}-on-death"
        if node.on_death_plan is not None:
            try:
                on_death_spec = self.make_spec(node.on_death_plan, label)
            except LaunchError as error:
                raise LaunchError(f"on-death '{node.on_death}': {error}") from error
        else:
            from pyros1.launch.running.check import check_on_death  # noqa: PLC0415

            check_on_death(node)
            log_base = self.run.folder / label.replace("/", "-")
            on_death_spec = ProcessSpec(
                label=label,
                node=f"{node.full_name}_on_death",
                words=[sys.executable, "-m", "pyros1", "topic", "pub", "-1", *node.on_death.words],
                env={**self.environ, "ROS_MASTER_URI": self.run.master_uri, **own_python_environment(self.environ)},
                cwd=str(self.run.folder),
                log_base=str(log_base),
                to_screen=False,
            )
        on_death_spec.exit_policy, on_death_spec.ends_launch = ExitPolicy(), spec.exit_policy.required
        return on_death_spec

    def _exit_policy(self, node: NodePlan) -> ExitPolicy:
        return replace(node.exit_policy, required=node.exit_policy.required or self.options.required)

    def _outputs_to_screen(self, node: NodePlan) -> bool:
        return node.output == "screen" if self.options.screen is None else self.options.screen

    def is_remote(self, node: NodePlan) -> bool:
        """Return whether a node runs on another machine."""
        return self._remote_machine(node) is not None

    def _remote_machine(self, node: NodePlan) -> MachinePlan | None:
        machine = self.plan.machines.get(node.machine or "")
        return machine if machine is not None and not is_local(machine.address) else None

    def cancel_waiting(self) -> None:
        """Drop the nodes that are still waiting to be started. Call this before stopping processes."""
        if self._condition_watcher is not None:
            self._condition_watcher.close()
            self._condition_watcher = None

    def close(self) -> None:
        """Disconnect from the other machines. Call this when all processes have exited."""
        for machine in self._machines.values():
            machine.close()
        self._machines.clear()
