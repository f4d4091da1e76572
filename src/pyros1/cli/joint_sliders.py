"""joint_state_publisher_gui: the node joint_state_publisher, with its sliders on a web page instead of in a window."""

from __future__ import annotations

import subprocess
import sys
import threading

from pyros1.ground.errors import Error
from pyros1.node import Node
from pyros1.urdf.joint_publisher import make_publisher

_EXIT_TIMEOUT = 5.0


def main(argv: list[str]) -> int:
    """Publish joint states until the node is shut down. Return the exit code.

    Args:
        argv: the command line, including the program's name.
    """
    with Node("joint_state_publisher_gui", argv=argv[1:]) as node:
        try:
            publisher = make_publisher(node)
        except Error as error:
            node.log.fatal("%s", error)
            return 1
        page_process = _open_page(node)
        try:
            publisher.run()
        finally:
            page_process.terminate()
            try:
                page_process.wait(_EXIT_TIMEOUT)
            except subprocess.TimeoutExpired:
                page_process.kill()
    return 0


def _open_page(node: Node) -> subprocess.Popen[bytes]:
    """Open the panel with the sliders on the page of a running web server, or of a new one that exits with this node.

    Returns:
        The process of ``pyros1 web``.
    """
    args = ["web", "joints", f"__master:={node.master.uri}"]
    page_process = subprocess.Popen([sys.executable, "-m", "pyros1", *args], stdin=subprocess.DEVNULL)

    def report_failure() -> None:
        if page_process.wait() not in (0, -15):
            node.log.error(
                "the page with the sliders could not be opened (see above); joint states are published anyway"
            )

    threading.Thread(target=report_failure, name="watch the page", daemon=True).start()
    return page_process
