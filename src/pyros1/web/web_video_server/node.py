"""web_video_server: serves images and videos of image topics to browsers."""

from __future__ import annotations

import threading

from pyros1.ground.errors import Error
from pyros1.net.allowlist import make_allowlist
from pyros1.net.hosts import addresses_from_environment
from pyros1.node import Node
from pyros1.observe.image_files import import_pillow
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.robot_nodes.shared.program import run_node
from pyros1.web.web_video_server.requests import STREAM_TYPES
from pyros1.web.web_video_server.server import VideoServer, describe
from pyros1.web.web_video_server.video_options import VIDEO_TYPES
from pyros1.web.web_video_server.videos import import_av

_POLL_PERIOD = 0.2
"""Seconds between checks of whether the server should stop."""


class ListenError(Error):
    """The server cannot listen on its port."""


def start(node: Node) -> VideoServer:
    """Serve images until the node shuts down.

    The parameters are ``~port`` (8080), ``~address`` (0.0.0.0), ``~default_stream_type`` (mjpeg), ``~publish_rate``
    (repetitions per second; if it is not positive, images are sent only when they arrive) and ``~verbose`` (true).

    Raises:
        ListenError: the port is not available.
        Error: Pillow is not installed.
    """
    import_pillow()
    parameters = PrivateParameters.of(node)
    address = parameters.text("address", "0.0.0.0")
    port = parameters.integer("port", 8080, 0, 65535)
    default_type = parameters.text("default_stream_type", "mjpeg")
    if default_type not in STREAM_TYPES:
        expected = f"one of {', '.join(STREAM_TYPES)}"
        default_type = parameters.report_invalid("default_stream_type", default_type, expected, "mjpeg")
    if default_type in VIDEO_TYPES:
        try:
            import_av(default_type)
        except Error as error:
            node.log.error("%s", error)
            default_type = "mjpeg"
    try:
        server = VideoServer(
            node,
            address,
            port,
            default_type,
            parameters.number("publish_rate", -1.0, maximum=1000.0),
            parameters.flag("verbose", True),
            make_allowlist(addresses_from_environment(node.environ, node.arguments.special).allowed),
        )
    except OSError as error:
        hint = "the parameters ~address and ~port say where to listen"
        raise ListenError(f"cannot listen on {address}:{port}: {describe(error)}; {hint}") from None
    thread = threading.Thread(target=server.serve_forever, args=(_POLL_PERIOD,), name="web_video_server", daemon=True)
    thread.start()
    node.on_shutdown(server.stop)
    node.log.info("waiting for connections on %s:%d", address, server.port)
    return server


def main(argv: list[str]) -> int:
    """Run the node until it is shut down; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    return run_node(argv, "web_video_server", start)
