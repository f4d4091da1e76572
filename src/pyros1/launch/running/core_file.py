"""Reads the nodes and parameters of a core, which a user's ``roscore.xml`` may change (X94)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pyros1.launch.plan import NodePlan
from pyros1.launch.reading.resources import PackageFinder
from pyros1.launch.running.core import CORE_PARAMS, ROSDISTRO, ROSVERSION

_STOCK_ROSOUT = ("rosout", "rosout")


@dataclass(frozen=True)
class CoreFile:
    """The nodes and parameters to start together with a master.

    Attributes:
        starts_rosout: whether to start pyros1's rosout node.
        params: the parameters by name.
        nodes: the other nodes, in order.
    """

    starts_rosout: bool = True
    params: Mapping[str, Any] = field(default_factory=lambda: dict(CORE_PARAMS))
    nodes: tuple[NodePlan, ...] = ()


def read_core_file(environ: Mapping[str, str], packages: PackageFinder) -> CoreFile:
    """Return the content of ``$ROS_ETC_DIR/roscore.xml``, or the default if the file does not exist.

    Stock's rosout node is replaced with pyros1's.

    Args:
        environ: environment variables.
        packages: finds packages.

    Raises:
        LaunchError: the file cannot be used.
    """
    folder = environ.get("ROS_ETC_DIR")
    if not folder or not (path := Path(folder, "roscore.xml")).is_file():
        return CoreFile()
    from pyros1.launch.reading.loader import load_plan  # noqa: PLC0415 - few users have such a file
    from pyros1.launch.reading.resources import Resources  # noqa: PLC0415
    from pyros1.launch.reading.system_resources import run_command  # noqa: PLC0415

    def run(words: list[str]) -> str:
        if words[0] == "rosversion":  # used in the default file; stock ROS may not be installed
            return ROSDISTRO if "-d" in words else ROSVERSION
        return run_command(words)

    plan = load_plan([str(path)], {}, Resources(packages, environ, run_command=run))
    other_nodes = tuple(node for node in plan.nodes if (node.package, node.type) != _STOCK_ROSOUT)
    return CoreFile(len(other_nodes) < len(plan.nodes), plan.params, other_nodes)
