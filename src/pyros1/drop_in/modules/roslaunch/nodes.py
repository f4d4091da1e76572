"""Nodes, tests and parameters of a launch; stock has these classes in roslaunch.core."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pyros1.ground.names import canonicalize_name, ns_join

if TYPE_CHECKING:
    from roslaunch.core import Machine

TEST_TIME_LIMIT_DEFAULT = 60


class Param:
    """A parameter of a launch: full name and value."""

    def __init__(self, key: str, value: Any) -> None:
        self.key = canonicalize_name(key)
        self.value = value

    def __eq__(self, p: object) -> bool:
        return isinstance(p, Param) and (self.key, self.value) == (p.key, p.value)

    def __ne__(self, p: object) -> bool:
        return not self == p

    def __hash__(self) -> int:
        return hash(self.key)

    def __str__(self) -> str:
        return f"{self.key}={self.value}"

    __repr__ = __str__


class Node:
    """A node to launch; the arguments are as in a <node> tag.

    Attributes:
        all arguments; ``node_type`` is called ``type``.
        machine: the Machine that was assigned.
        process_name: name of the process; None until it has been started.
        source_plan: for a node in a launch file, pyros1's plan from which it was created.

    Raises:
        ValueError: a required argument is missing, or an argument is invalid.
    """

    __slots__ = [
        "args",
        "cwd",
        "env_args",
        "filename",
        "launch_prefix",
        "machine",
        "machine_name",
        "name",
        "namespace",
        "output",
        "package",
        "process_name",
        "remap_args",
        "required",
        "respawn",
        "respawn_delay",
        "source_plan",
        "type",
    ]

    def __init__(
        self,
        package: str,
        node_type: str,
        name: str | None = None,
        namespace: str = "/",
        machine_name: str | None = None,
        args: str = "",
        respawn: Any = False,
        respawn_delay: float = 0.0,
        remap_args: Any = None,
        env_args: Any = None,
        output: str | None = None,
        cwd: str | None = None,
        launch_prefix: str | None = None,
        required: Any = False,
        filename: str = "<unknown>",
    ) -> None:
        self.package = package
        self.type = node_type
        self.name = name or None
        self.namespace = canonicalize_name(ns_join("/", namespace or "/")).rstrip("/") + "/"
        self.machine_name = machine_name or None
        self.machine: Machine | None = None
        self.args = args or ""
        self.respawn = respawn
        self.respawn_delay = respawn_delay
        self.remap_args = remap_args or []
        self.env_args = env_args or []
        self.process_name: str | None = None
        self.output = output
        self.cwd = "ROS_HOME" if cwd == "ros_home" else cwd
        self.launch_prefix = launch_prefix or None
        self.required = required
        self.filename = filename
        self.source_plan: Any = None
        if "/" in (name or ""):
            raise ValueError("node name cannot contain a namespace")
        if output not in (None, "log", "screen"):
            raise ValueError(f"output must be one of 'log', 'screen', not [{output}]")
        if cwd not in (None, "ros_home", "ROS_HOME", "node"):
            raise ValueError(f"cwd must be one of 'ROS_HOME', 'node', not [{cwd}]")
        if not self.package:
            raise ValueError("package must be non-empty")
        if not self.type:
            raise ValueError("type must be non-empty")
        if respawn and required:
            raise ValueError("respawn and required cannot both be set to true")


class Test(Node):
    """A test in a launch; the arguments are as in a <test> tag."""

    __slots__ = ["retry", "test_name", "time_limit"]
    __test__ = False

    def __init__(
        self,
        test_name: str,
        package: str,
        node_type: str,
        name: str | None = None,
        namespace: str = "/",
        machine_name: str | None = None,
        args: str = "",
        remap_args: Any = None,
        env_args: Any = None,
        time_limit: float | None = None,
        cwd: str | None = None,
        launch_prefix: str | None = None,
        retry: int | None = None,
        filename: str = "<unknown>",
    ) -> None:
        super().__init__(
            package,
            node_type,
            name=name,
            namespace=namespace,
            machine_name=machine_name,
            args=args,
            remap_args=remap_args,
            env_args=env_args,
            output="log",
            cwd=cwd,
            launch_prefix=launch_prefix,
            filename=filename,
        )
        self.test_name = test_name
        self.retry = retry or 0
        self.time_limit = float(time_limit or TEST_TIME_LIMIT_DEFAULT)
        if self.time_limit <= 0:
            raise ValueError("'time-limit' must be a positive number")
