"""joint_state_publisher_gui: the node joint_state_publisher, and the page with its sliders in place of a window."""

from __future__ import annotations

import subprocess
import sys
import threading

from pyros1.ground.errors import Error
from pyros1.node import Node
from pyros1.urdf.joint_publisher import begin

_END = 5.0


def main(argv: list[str]) -> int:
    """Run the program; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    with Node("joint_state_publisher_gui", argv=argv[1:]) as node:
        try:
            publisher = begin(node)
        except Error as error:
            node.log.fatal("%s", error)
            return 1
        page = _open_page(node)
        try:
            publisher.run()
        finally:
            page.terminate()
            try:
                page.wait(_END)
            except subprocess.TimeoutExpired:
                page.kill()
    return 0


def _open_page(node: Node) -> subprocess.Popen[bytes]:
    """Open the panel on a page that is already served, or from a server that ends with this node."""
    words = ["web", "joints", f"__master:={node.master.uri}"]
    page = subprocess.Popen([sys.executable, "-m", "pyros1", *words], stdin=subprocess.DEVNULL)

    def watch() -> None:
        if page.wait() not in (0, -15):
            node.log.error("the page with sliders could not be opened (see above); the joints are published without it")

    threading.Thread(target=watch, name="waits for the page", daemon=True).start()
    return page
