"""The plan of a launch: everything that its launch files specify, fully resolved. The files are not read again."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

from pyros1.ground.names import ns_join
from pyros1.launch.reading.conditions import DEFAULT_TIMEOUT, Condition
from pyros1.launch.reading.on_death import OnDeath


@dataclass
class ExitPolicy:
    """The launcher's reaction to the exit of a node.

    Attributes:
        respawn: whether the node is started again.
        respawn_delay: seconds to wait before the node is started again.
        required: whether the whole launch is shut down.
    """

    respawn: bool = False
    respawn_delay: float = 0.0
    required: bool = False


@dataclass
class NodePlan:
    """A node to start.

    Attributes:
        package: ROS package that contains the executable.
        type: the executable's name.
        name: base name.
        namespace: ``/`` or ``/a/b/``, with a slash at the end.
        args: arguments, already split into words.
        remappings: ``(from, to)`` pairs in order.
        env: environment variables to set for the node.
        prefix: words to put before the executable.
        cwd: ``ros_home`` or ``node`` (the executable's folder).
        output: ``log`` or ``screen``.
        exit_policy: whether to restart the node, or to shut down the launch, when the node exits.
        machine: name of a declared machine; None for this machine.
        file: path of the launch file that defines the node.
        line: the line in that file; 0 if unknown.
        wait_for: conditions to wait for before the node starts.
        wait_timeout: seconds to wait for these conditions; 0 for no limit.
        on_death: the action to take when the node has exited; None for no action.
        priority: the real-time priority, 1 to 99; 0 for none.
        args_text, prefix_text: ``args`` and ``prefix`` as written in the file, after substitution.
    """

    package: str
    type: str
    name: str
    namespace: str = "/"
    args: list[str] = field(default_factory=list)
    remappings: list[tuple[str, str]] = field(default_factory=list)
    env: dict[str, str] = field(default_factory=dict)
    prefix: list[str] = field(default_factory=list)
    cwd: Literal["ros_home", "node"] = "ros_home"
    output: Literal["log", "screen"] = "log"
    exit_policy: ExitPolicy = field(default_factory=ExitPolicy)
    machine: str | None = None
    file: str = ""
    line: int = 0
    wait_for: list[Condition] = field(default_factory=list)
    wait_timeout: float = DEFAULT_TIMEOUT
    on_death: OnDeath | None = None
    priority: int = 0
    args_text: str = field(default="", compare=False)
    prefix_text: str = field(default="", compare=False)

    @property
    def full_name(self) -> str:
        """The name with its namespace, ``/a/b/name``."""
        return ns_join(self.namespace, self.name)

    @property
    def on_death_plan(self) -> NodePlan | None:
        """The program that ``on-death`` runs, as a node; None if it publishes a message, or there is no ``on-death``.

        The program gets the namespace, remappings and environment of this node.
        """
        if self.on_death is None or self.on_death.kind != "run":
            return None
        package, program, *args = self.on_death.words
        return NodePlan(
            package=package,
            type=program,
            name=f"{self.name}_on_death",
            namespace=self.namespace,
            args=args,
            remappings=self.remappings,
            env=self.env,
            file=self.file,
            line=self.line,
        )


@dataclass
class TestPlan(NodePlan):
    """A ``<test>``: a node that performs a test. The test ends when the node exits.

    Attributes:
        test_name: name of the test, and of its results.
        time_limit: seconds after which the test fails.
        retry: maximum number of retries after a failure.
    """

    __test__ = False  # not a test for pytest

    test_name: str = ""
    time_limit: float = 60.0
    retry: int = 0


@dataclass(frozen=True)
class MachinePlan:
    """A declared machine.

    Attributes:
        name: the name that nodes use for it.
        address: host name or IP address.
        settings: ``(name, value)`` of the other attributes, as written.
    """

    name: str
    address: str
    settings: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class IncludePlan:
    """An ``<include>``.

    Attributes:
        file: the file that contains the tag.
        line: the line in that file.
        included: the file that the tag includes.
    """

    file: str
    line: int
    included: str


@dataclass(frozen=True)
class ParamFileAction:
    """A ``rosparam`` dump or delete, executed before parameters are set.

    Attributes:
        command: ``dump`` or ``delete``.
        name: full name of the parameter or namespace to dump or delete.
        path: the file to write for dump; empty for delete.
    """

    command: Literal["dump", "delete"]
    name: str
    path: str = ""


@dataclass
class ArgPlan:
    """An ``<arg>`` of a top-level file, for ``--ros-args``.

    Attributes:
        name: the argument's name.
        default: the argument's default; None if there is none.
        doc: the ``doc`` attribute; None if the tag does not have it.
    """

    name: str
    default: str | None
    doc: str | None


@dataclass
class Plan:
    """Everything that the launch files specify, in the order of the files.

    Attributes:
        nodes: the nodes to start, in order.
        tests: the tests; only `pyros1 test` runs them.
        params: full name -> value; setting a name again changes its value, but not its position.
        clear_params: namespaces whose parameters are deleted first.
        actions: rosparam dumps and deletes.
        machines: declared machines, by name.
        files: the files that were read, in order.
        includes: the ``<include>`` tags, in order.
        args: name -> argument declared in a top-level file, in order.
        warnings: warnings to print.
    """

    nodes: list[NodePlan] = field(default_factory=list)
    tests: list[TestPlan] = field(default_factory=list)
    params: dict[str, Any] = field(default_factory=dict)
    clear_params: list[str] = field(default_factory=list)
    actions: list[ParamFileAction] = field(default_factory=list)
    machines: dict[str, MachinePlan] = field(default_factory=dict)
    files: list[str] = field(default_factory=list)
    includes: list[IncludePlan] = field(default_factory=list)
    args: dict[str, ArgPlan] = field(default_factory=dict)
    warnings: list[str] = field(default_factory=list)

    def find_node(self, name: str) -> NodePlan | None:
        """Return the node or test with this name. A name without a leading slash is treated as global."""
        wanted_name = "/" + name.strip("/")
        return next((node for node in [*self.nodes, *self.tests] if node.full_name == wanted_name), None)
