"""nodelet manager: a node with a nodelet manager's services, which does not load any nodelets.

Each nodelet runs in its own process, so a manager has nothing to do. It exists because launch files start one; callers
of its services get an error.
"""

from __future__ import annotations

from typing import Any

from pyros1.ground.terminal_text import one_line
from pyros1.msgs.nodelet.srv import NodeletList, NodeletListResponse, NodeletLoad, NodeletUnload
from pyros1.node import Node
from pyros1.robot_nodes.shared.program import run_node


class Manager:
    """Provides the services ``~load_nodelet``, ``~unload_nodelet`` and ``~list``.

    Args:
        node: the node that provides them.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        node.advertise_service("~load_nodelet", NodeletLoad, self._load)
        node.advertise_service("~unload_nodelet", NodeletUnload, lambda request: False)
        node.advertise_service("~list", NodeletList, lambda request: NodeletListResponse([]))

    def _load(self, request: Any) -> bool:
        self._node.log.error(
            "cannot load the nodelet %s of the class %s: this manager loads no compiled code. Start it by "
            "`pyros1 run nodelet nodelet load`, which runs the node of that name if there is one",
            one_line(request.name, 100),
            one_line(request.type, 100),
        )
        return False


def main(argv: list[str]) -> int:
    """Run a manager until it is shut down; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    return run_node(argv, "manager", Manager)
