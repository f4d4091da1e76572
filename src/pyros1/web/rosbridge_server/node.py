"""The programs of rosbridge_server: rosbridge_websocket, and stubs for rosbridge_tcp and rosbridge_udp, unsupported."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from functools import partial

from pyros1.ground.errors import Error, NodeShutdownError
from pyros1.node import Node
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.web.rosbridge_server.server import BridgeServer
from pyros1.web.rosbridge_server.settings import options_in, read_settings


def main(argv: list[str]) -> int:
    """Run rosbridge_websocket until it is shut down; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    with Node("rosbridge_websocket", argv=argv[1:]) as node:
        try:
            values = node.params.get("~", {})
            options = options_in(node.arguments.rest)
            parameters = PrivateParameters(
                {**(values if isinstance(values, Mapping) else {}), **options},
                partial(node.log.error, "%s"),
                node.name,
            )
            BridgeServer(node, read_settings(parameters)).run()
        except NodeShutdownError:  # Ctrl-C while the server was starting
            return 0
        except Error as error:
            node.log.fatal("%s", error)
            return 1
    return 0


def unsupported(argv: list[str]) -> int:
    """Say what to use instead of rosbridge_tcp or rosbridge_udp; return the exit code."""
    name = os.path.basename(argv[0]).removesuffix(".py")
    sys.stderr.write(
        f"ERROR: {name}: only rosbridge over WebSockets is supported: "
        "use the node rosbridge_websocket, with a client such as roslibpy or roslibjs\n"
    )
    return 1
