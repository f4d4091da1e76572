"""Questions about the nodes of launch files."""

from __future__ import annotations

import sys
from typing import Any

from roslaunch.config import load_config_default
from roslaunch.core import RLException


class NodeParamsException(Exception):
    """There is no such node."""


def get_node_list(config: Any) -> list[str]:
    """Return the full names of all nodes and tests of a ROSLaunchConfig."""
    return [node.namespace + node.name for node in [*config.nodes, *config.tests]]


def print_node_list(roslaunch_files: Any) -> None:
    """Print the full names of all nodes of launch files."""
    print("\n".join(get_node_list(_load(roslaunch_files))))


def print_node_filename(node_name: str, roslaunch_files: Any) -> None:
    """Print the file that defines a node; raises SystemExit if there is none."""
    config = _load(roslaunch_files)
    wanted = "/" + node_name.strip("/")
    found = [node.filename for node in [*config.nodes, *config.tests] if node.namespace + node.name == wanted]
    if not found:
        names = "Run \n\troslaunch --nodes <files>\nto see list of node names."
        print(f"ERROR: cannot find node named [{node_name}]. {names}", file=sys.stderr)
        sys.exit(1)
    print(found[0])


def _load(files: Any) -> Any:
    try:
        return load_config_default(files, None, verbose=False, assign_machines=False)
    except RLException as error:
        print(str(error), file=sys.stderr)
        sys.exit(1)


def __getattr__(name: str) -> Any:
    if name in ("get_node_args", "print_node_args", "create_local_process_args"):
        raise AttributeError(f"pyros1 has no roslaunch.node_args.{name}: see `pyros1 launch --args`")
    raise AttributeError(f"module 'roslaunch.node_args' has no attribute {name!r}")
