"""rosout: collects the log messages, unless `pyros1 core` or a launch already does.

Stock's node would replace the one that is running, which would then be restarted and replace it, and so on.
"""

from __future__ import annotations

import contextlib
import os
import sys
import threading
from collections.abc import Callable, Mapping

from pyros1.graph import Graph
from pyros1.ground.errors import Error
from pyros1.ground.names import parse_arguments
from pyros1.net.hosts import master_uri
from pyros1.net.master_client import MasterClient
from pyros1.node import Node
from pyros1.node.log.rosout import RosoutAggregator
from pyros1.node.log.sink import default_log_file

NAME = "/rosout"
_TIMEOUT = 3.0
"""Seconds to wait for responses from the master and from a /rosout that may be running."""


def is_running(uri: str) -> bool:
    """Return whether a node named /rosout responds.

    Args:
        uri: the master's URI.
    """
    client = MasterClient(NAME, uri, timeout=_TIMEOUT)
    try:
        graph = Graph(client)
        node_uri = graph.node_uri(NAME)
        if node_uri is None:
            return False
        api = graph.node_api(node_uri, _TIMEOUT)
        try:
            api.ping()
        finally:
            api.close()
    except Error:
        return False
    finally:
        client.close()
    return True


def start(node: Node, environ: Mapping[str, str]) -> RosoutAggregator:
    """Publish log messages on /rosout_agg, and write them to ``rosout.log`` in the folder of the node's own log."""
    folder = os.path.dirname(default_log_file(node.name, environ, node.arguments.special))
    return RosoutAggregator(node, os.path.join(folder, "rosout.log"))


def _wait() -> None:
    threading.Event().wait()


def main(argv: list[str], wait: Callable[[], object] = _wait) -> int:
    """Run the node until it is shut down; return its exit code.

    Args:
        argv: the command line, with the program's name.
        wait: waits until the process is interrupted; called if another node collects the messages.
    """
    special = parse_arguments(argv[1:]).special
    if is_running(master_uri(os.environ, special)):
        sys.stdout.write("the node /rosout is running already: this process leaves the log messages to it\n")
        sys.stdout.flush()
        with contextlib.suppress(KeyboardInterrupt):
            wait()
        return 0
    args = argv[1:]
    if "__log" not in special:  # keep the node's own log out of rosout.log
        folder = os.path.dirname(default_log_file(NAME, os.environ, special))
        args = [*args, f"__log:={os.path.join(folder, 'rosout-1.log')}"]
    with Node("rosout", argv=args, rosout=False) as node:
        aggregator = start(node, os.environ)
        node.spin()
        del aggregator
    return 0
