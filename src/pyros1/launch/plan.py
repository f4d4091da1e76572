"""What a set of launch files asks for, fully resolved: nothing in here needs the files again."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

from pyros1.launch.reading.conditions import DEFAULT_TIMEOUT, Condition
from pyros1.names import ns_join


@dataclass
class NodePlan:
    """A node to start.

    Attributes:
        package: ROS package that holds the executable.
        type: the executable's name.
        name: base name.
        namespace: ``/`` or ``/a/b/``, with a slash at the end.
        args: extra arguments, already split.
        remappings: ``(from, to)`` pairs in order.
        env: environment variables to set.
        prefix: words in front of the executable.
        cwd: ``ros_home`` or ``node`` (the executable's folder).
        output: ``log`` or ``screen``.
        respawn: start it again whenever it exits.
        respawn_delay: seconds to wait before that.
        required: the whole launch ends when it exits.
        machine: name of a declared machine, None for this one.
        file: the launch file that defines it.
        line: line there.
        wait_for: what has to exist before it starts.
        wait_timeout: seconds until that is given up, 0 for never.
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
    respawn: bool = False
    respawn_delay: float = 0.0
    required: bool = False
    machine: str | None = None
    file: str = ""
    line: int = 0
    wait_for: list[Condition] = field(default_factory=list)
    wait_timeout: float = DEFAULT_TIMEOUT

    @property
    def full_name(self) -> str:
        """The name with its namespace, ``/a/b/name``."""
        return ns_join(self.namespace, self.name)


@dataclass
class TestPlan(NodePlan):
    """A ``<test>``: a node whose end is the end of the test.

    Attributes:
        test_name: name of the test, and of its results.
        time_limit: seconds until it has failed.
        retry: how often it may be tried again.
    """

    __test__ = False  # not one of pytest's

    test_name: str = ""
    time_limit: float = 60.0
    retry: int = 0


@dataclass(frozen=True)
class MachinePlan:
    """A declared machine.

    Attributes:
        name: how nodes refer to it.
        address: host name or address.
        settings: the other attributes as written.
    """

    name: str
    address: str
    settings: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class IncludePlan:
    """An ``<include>``.

    Attributes:
        file: the file it stands in.
        line: line there.
        included: the file that it names.
    """

    file: str
    line: int
    included: str


@dataclass(frozen=True)
class ParamFileAction:
    """A ``rosparam`` dump or delete, done before parameters are set.

    Attributes:
        command: what to do.
        name: full name of the parameter or namespace.
        path: file to dump to, empty for delete.
    """

    command: Literal["dump", "delete"]
    name: str
    path: str = ""


@dataclass
class ArgPlan:
    """An ``<arg>`` of a top-level file, for ``--ros-args``.

    Attributes:
        name: its name.
        default: its default, None if it is required.
        doc: the ``doc`` attribute, None without one.
    """

    name: str
    default: str | None
    doc: str | None


@dataclass
class Plan:
    """Everything that was asked for, in the order of the files.

    Attributes:
        nodes: nodes, in order.
        tests: ``<test>`` nodes; launching ignores them.
        params: full name to value; setting a name again moves it to its new value, not its place.
        clear_params: namespaces to delete first.
        actions: rosparam dumps and deletes.
        machines: by name.
        files: the files that were read, in order.
        includes: which file included which, in order.
        args: arguments declared in the top-level files, in order.
        warnings: for a person to read.
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
        """Return the node or test of that name; a name without a leading slash is taken as global."""
        wanted = "/" + name.strip("/")
        return next((node for node in [*self.nodes, *self.tests] if node.full_name == wanted), None)
