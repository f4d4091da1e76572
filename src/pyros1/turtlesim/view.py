"""turtle_view: displays the turtles of a turtlesim_node in the terminal."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable
from time import monotonic
from typing import Any, TextIO

from pyros1.graph import Graph
from pyros1.ground.errors import Error
from pyros1.ground.terminal_text import one_line
from pyros1.msgs.sensor_msgs.msg import Image
from pyros1.msgs.turtlesim.msg import Pose
from pyros1.node import Node
from pyros1.turtlesim.blocks import render_blocks
from pyros1.turtlesim.canvas import Canvas
from pyros1.turtlesim.finding import drawing_topic, find_simulators
from pyros1.turtlesim.turtle import PICTURE_SIZE
from pyros1.turtlesim.world import BACKGROUND

_FRAMES_PER_SECOND = 10.0
_REFRESH_PERIOD = 1.0
"""Seconds between checks for new turtles."""
_ENTER_SCREEN = "\x1b[?1049h\x1b[?25l\x1b[2J"
_LEAVE_SCREEN = "\x1b[?25h\x1b[?1049l"
_CURSOR_HOME = "\x1b[H"
_CLEAR_LINE, _CLEAR_SCREEN = "\x1b[K", "\x1b[J"


class View:
    """Renders the turtles that a turtlesim_node simulates.

    Args:
        node: this program's node.
        simulator: name of the turtlesim_node; empty for the first one found.
    """

    def __init__(self, node: Node, simulator: str = "") -> None:
        self._node = node
        self._requested_node = simulator and node.resolve(simulator)
        self._graph = Graph(node.master)
        self._displayed_node = ""  # the turtlesim_node whose turtles are displayed; empty for none
        self._poses: dict[str, Any] = {}
        self._subscribers: dict[str, Any] = {}  # topic -> subscriber
        self._pixels = self._blank_pixels = Canvas(BACKGROUND).pixels()
        self._refreshed_at = float("-inf")

    def lines(self, columns: int, rows: int) -> list[str]:
        """Return the lines to display now.

        Args:
            columns, rows: the available space in characters.
        """
        if monotonic() - self._refreshed_at >= _REFRESH_PERIOD:
            self._refresh()
            self._refreshed_at = monotonic()
        if not self._displayed_node:
            problem = f"{self._requested_node} is not running" if self._requested_node else "there are no turtles"
            return [f"{problem}; to start some: pyros1 run turtlesim turtlesim_node"[:columns]]
        turtles = {one_line(name): (pose.x, pose.y, pose.theta) for name, pose in self._poses.copy().items()}
        positions = ", ".join(f"{name} ({x:.2f}, {y:.2f})" for name, (x, y, _) in turtles.items())
        picture = render_blocks(self._pixels, PICTURE_SIZE, PICTURE_SIZE, turtles, columns, rows - 1)
        return [f"{one_line(self._displayed_node)}: {positions}"[:columns], *picture]

    def _refresh(self) -> None:
        try:
            simulators = find_simulators(self._graph.published_types(), self._graph.state().publishers)
        except Error:
            return  # the master is unreachable: continue with the known turtles
        node = self._requested_node or next(iter(simulators), "")
        turtles = simulators.get(node, {})
        topics: dict[str, tuple[Any, Callable[[Any], object]]] = {
            topic: (Pose, self._pose_callback(turtle)) for turtle, topic in turtles.items()
        }
        if turtles:
            topics[drawing_topic(node)] = (Image, self._on_drawing)
        for topic in self._subscribers.keys() - topics.keys():
            self._subscribers.pop(topic).unregister()
        for topic in topics.keys() - self._subscribers.keys():
            message_type, callback = topics[topic]
            self._subscribers[topic] = self._node.subscribe(topic, message_type, callback, queue_size=1)
        self._poses = {name: pose for name, pose in self._poses.copy().items() if name in turtles}
        if node != self._displayed_node:
            self._pixels = self._blank_pixels
        self._displayed_node = node if turtles else ""

    def _pose_callback(self, turtle: str) -> Callable[[Any], None]:
        def on_pose(pose: Any) -> None:
            self._poses[turtle] = pose

        return on_pose

    def _on_drawing(self, image: Any) -> None:
        if (image.encoding, image.width, image.height) == ("rgb8", PICTURE_SIZE, PICTURE_SIZE) and len(
            image.data
        ) == 3 * PICTURE_SIZE**2:
            self._pixels = image.data


def show(view: View, node: Node, out: TextIO) -> None:
    """Display a view in a terminal until the node shuts down, then restore the terminal's previous content."""
    out.write(_ENTER_SCREEN)
    try:
        rate = node.rate(_FRAMES_PER_SECOND)
        while node.ok():
            size = shutil.get_terminal_size()
            lines = f"{_CLEAR_LINE}\r\n".join(view.lines(size.columns, size.lines))
            out.write(f"{_CURSOR_HOME}{lines}{_CLEAR_LINE}{_CLEAR_SCREEN}")
            out.flush()
            rate.sleep()
    finally:
        out.write(_LEAVE_SCREEN)
        out.flush()


def main(argv: list[str]) -> int:
    """Run turtle_view; return its exit code.

    Args:
        argv: the command line, with the program's name; its optional argument is the name of a turtlesim_node.
    """
    with Node("turtle_view", argv=argv[1:], anonymous=True) as node:
        if not sys.stdout.isatty():
            node.log.fatal("turtle_view needs a terminal; to view turtles in a browser, use pyros1 web turtles")
            return 1
        show(View(node, *node.arguments.rest[:1]), node, sys.stdout)
    return 0
