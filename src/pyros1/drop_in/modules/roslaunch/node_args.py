"""Lists the nodes in launch files, and their command lines."""

from __future__ import annotations

import sys
from typing import Any

from pyros1.drop_in.module_attributes import module_getattr
from pyros1.launch.reading.report import node_arg_words
from pyros1.launch.reading.system_resources import make_resources
from pyros1.launch.running.command_line import locate, node_words
from roslaunch.config import load_config_default
from roslaunch.core import RLException, rl_errors
from roslaunch.plans import to_node_plan


class NodeParamsException(Exception):
    """The requested node does not exist."""


def get_node_list(config: Any) -> list[str]:
    """Return the full names of all nodes and tests of a ROSLaunchConfig."""
    return [node.namespace + node.name for node in [*config.nodes, *config.tests]]


def print_node_list(roslaunch_files: Any) -> None:
    """Print the full names of all nodes of launch files."""
    print("\n".join(get_node_list(_load(roslaunch_files))))


def print_node_filename(node_name: str, roslaunch_files: Any) -> None:
    """Print the file that defines a node; exit with code 1 if there is no such node."""
    config = _load(roslaunch_files)
    full_name = "/" + node_name.strip("/")
    filenames = [node.filename for node in [*config.nodes, *config.tests] if node.namespace + node.name == full_name]
    if not filenames:
        hint = "Run \n\troslaunch --nodes <files>\nto see list of node names."
        print(f"ERROR: cannot find node named [{node_name}]. {hint}", file=sys.stderr)
        sys.exit(1)
    print(filenames[0])


@rl_errors
def get_node_args(node_name: str, roslaunch_files: Any) -> list[str]:
    """Return the words of a node's environment and command line.

    Raises:
        RLException: there is no such node, or a file cannot be read.
    """
    config = load_config_default(roslaunch_files, None, verbose=False, assign_machines=False)
    full_name = "/" + node_name.strip("/")
    for node in [*config.nodes, *config.tests]:
        if f"{node.namespace}{node.name}" == full_name:
            plan, resources = to_node_plan(node), make_resources()
            executable = locate(plan.package, plan.type, resources.packages)
            return node_arg_words(plan, node_words(plan, executable, resources.environ), resources.environ)
    names = "\n".join(f" * {name}" for name in get_node_list(config))
    files = ", ".join(map(str, roslaunch_files))
    raise RLException(f"ERROR: Cannot find node named [{node_name}] in [{files}].\nNode names are:\n{names}")


def print_node_args(node_name: str, roslaunch_files: Any) -> None:
    """Print a node's environment and command line; exit with code 1 if there is no such node."""
    try:
        print(" ".join(get_node_args(node_name, roslaunch_files)))
    except RLException as error:
        print(str(error), file=sys.stderr)
        sys.exit(1)


def _load(files: Any) -> Any:
    try:
        return load_config_default(files, None, verbose=False, assign_machines=False)
    except RLException as error:
        print(str(error), file=sys.stderr)
        sys.exit(1)


__getattr__ = module_getattr(
    "roslaunch.node_args",
    create_local_process_args="see `pyros1 launch --args`",
)
