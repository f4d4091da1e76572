"""The contents of a launch."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterable
from typing import Any

from pyros1.launch.reading.cli_arguments import parse_arguments
from pyros1.launch.reading.report import summary
from pyros1.launch.running.core import CORE_PARAMS
from roslaunch.core import Machine, Master, Node, Param, RLException, Test, is_machine_local, local_machine
from roslaunch.plans import to_plan
from roslaunch.xmlloader import XmlLoader

DEFAULT_MASTER_PORT = 11311

__all__ = [
    "DEFAULT_MASTER_PORT",
    "Master",
    "RLException",
    "ROSLaunchConfig",
    "calculate_env_loader",
    "get_roscore_filename",
    "is_machine_local",
    "load_config_default",
    "load_roscore",
    "local_machine",
    "namespaces_of",
]


def namespaces_of(name: str) -> list[str]:
    """Return the namespaces that contain a name, beginning with ``/``."""
    if name is None:
        raise ValueError("name")
    if not isinstance(name, str):
        raise TypeError("name")
    words = [word for word in name.split("/") if word][:-1]
    return ["/", *("/" + "/".join(words[: count + 1]) for count in range(len(words)))]


def calculate_env_loader(env: Any = None) -> str:
    """Return the path of the default script that sets up ROS on other machines."""
    distro = (os.environ if env is None else env).get("ROS_DISTRO", "noetic")
    return f"/opt/ros/{distro}/env.sh"


def get_roscore_filename() -> str:
    """Return the path of the core's launch file, which may not exist."""
    return os.path.join(os.environ.get("ROS_ETC_DIR", "/etc/ros"), "roscore.xml")


def load_roscore(loader: Any, config: ROSLaunchConfig, verbose: bool = True) -> None:
    """Read a core's nodes and parameters from its launch file, if it exists."""
    if os.path.exists(get_roscore_filename()):
        loader.load(get_roscore_filename(), config, core=True, verbose=verbose)


class ROSLaunchConfig:
    """The contents of a launch, which a program may change before it launches them.

    Attributes:
        nodes, nodes_core, tests: the nodes, the core's nodes and the tests to start.
        params: Param by full name.
        clear_params: namespaces of parameters that are deleted before parameters are set.
        machines: Machine by name.
        executables: commands to run in addition to the nodes; pyros1 does not launch contents that have any.
        master: the Master.
        roslaunch_files: paths of the files that were read.
        resolved_node_names: full names of all nodes.
        config_errors: error messages.
        actions: pyros1's plans of rosparam dumps and deletes.
    """

    def __init__(self) -> None:
        self.logger = logging.getLogger("roslaunch")
        self.master = Master()
        self.nodes_core: list[Node] = []
        self.nodes: list[Node] = []
        self.tests: list[Test] = []
        self.params: dict[str, Param] = {}
        self.clear_params: list[str] = []
        self.executables: list[Any] = []
        self.machines: dict[str, Machine] = {"": local_machine()}
        self.roslaunch_files: list[str] = []
        self.resolved_node_names: list[str] = []
        self.config_errors: list[str] = []
        self.actions: list[Any] = []

    def add_roslaunch_file(self, f: str) -> None:
        """Add a file to ``roslaunch_files``."""
        self.roslaunch_files.append(f)

    def add_config_error(self, msg: str) -> None:
        """Add an error message to ``config_errors``."""
        self.config_errors.append(msg)

    def set_master(self, m: Master) -> None:
        """Set the master."""
        self.master = m

    def has_remote_nodes(self) -> bool:
        """Return whether any nodes run on other machines; valid after `assign_machines`."""
        return any(node.machine is not None and not is_machine_local(node.machine) for node in self.nodes)

    def assign_machines(self) -> None:
        """Assign machines to all nodes and tests; raise RLException if a machine is unknown."""
        for node in [*self.nodes_core, *self.nodes, *self.tests]:
            name = node.machine_name or ""
            if name not in self.machines:
                raise RLException(f"ERROR: unknown machine [{name}]")
            node.machine = self.machines[name]

    def summary(self, local: bool = False) -> str:
        """Return the contents as text; without machines if ``local`` is true."""
        return summary(to_plan(self), machines=[] if local else [name for name in self.machines if name])

    def add_executable(self, exe: Any) -> None:
        """Add a command; the contents can then no longer be launched. Raise ValueError if ``exe`` is None."""
        if not exe:
            raise ValueError("exe is None")
        self.executables.append(exe)

    def add_clear_param(self, param: str) -> None:
        """Add a namespace of parameters that is deleted before parameters are set."""
        self.clear_params.append(param)

    def add_param(self, p: Param, filename: str | None = None, verbose: bool = True) -> None:
        """Add a parameter; if one of its namespaces already has a value, an error is added to ``config_errors``."""
        for name in namespaces_of(p.key)[1:]:
            if name in self.params:
                self.add_config_error(f"parameter [{p.key}] conflicts with parent parameter [{name}]")
        self.params[p.key] = p
        if verbose:
            print(f"Added parameter [{p.key}]")

    def add_machine(self, m: Machine, verbose: bool = True) -> bool:
        """Add a machine; return False if it was already added.

        Raises:
            RLException: another machine has the same name.
        """
        existing_machine = self.machines.get(m.name)
        if existing_machine is not None:
            if existing_machine != m:
                raise RLException(f"Machine [{m.name}] already added and does not match duplicate entry")
            return False
        self.machines[m.name] = m
        if verbose:
            print(f"Added machine [{m.name}]")
        return True

    def add_test(self, test: Test, verbose: bool = True) -> None:
        """Add a test."""
        self.tests.append(test)

    def add_node(self, node: Node, core: bool = False, verbose: bool = True) -> None:
        """Add a node to the launch or to the core.

        Raises:
            RLException: another node has the same name.
        """
        name = node.namespace + node.name if node.name else ""
        if name in self.resolved_node_names:
            raise RLException(
                f"roslaunch file contains multiple nodes named [{name}].\nPlease check all <node> 'name' attributes to "
                "make sure they are unique.\nAlso check that $(anon id) use different ids."
            )
        if name:
            self.resolved_node_names.append(name)
        (self.nodes_core if core else self.nodes).append(node)
        if verbose:
            print(f"Added {'core ' * core}node of type [{node.package}/{node.type}] in namespace [{node.namespace}]")


def load_config_default(
    roslaunch_files: Iterable[Any],
    port: int | None,
    roslaunch_strs: Iterable[str] | None = None,
    loader: Any = None,
    verbose: bool = False,
    assign_machines: bool = True,
    ignore_unset_args: bool = False,
) -> ROSLaunchConfig:
    """Read launch files.

    Args:
        roslaunch_files: paths, or tuples of a path and a list of ``name:=value``.
        port: the master's port; None for the port in ROS_MASTER_URI.
        roslaunch_strs: contents of more files.
        loader: an XmlLoader; None for a new one.
        verbose: whether to print a list of the files' contents.
        assign_machines: whether to assign machines to the nodes.
        ignore_unset_args: whether to read as much of the files as possible if required arguments have no values.

    Raises:
        RLException: a file cannot be used.
    """
    config = ROSLaunchConfig()
    if port:
        config.master.uri = f"http://{config.master.get_host()}:{port}/"
    for name, value in CORE_PARAMS.items():
        config.add_param(Param(name, value), verbose=False)
    loader = loader or XmlLoader()  # the core's other nodes are read when the core starts
    for file in roslaunch_files:
        path, words = (file, None) if isinstance(file, str) else file
        if words is not None:
            parse_arguments(words)
        try:
            loader.load(path, config, argv=words, verbose=verbose)
        except RLException as error:
            if not (ignore_unset_args and "requires the" in str(error)):
                raise RLException(str(error)) from error
            config.add_config_error(str(error))
    for text in roslaunch_strs or ():
        loader.load_string(text, config, core=False, verbose=verbose)
    if config.config_errors and not ignore_unset_args:
        raise RLException("\n".join(config.config_errors))
    if assign_machines:
        config.assign_machines()
    return config
