"""turtlesim_node through its topics and services, and what shows it in a terminal.

Feature: turtles on the web page and in the terminal
"""

from __future__ import annotations

import io
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from queue import Empty, Queue
from typing import Any

import pytest

import pyros1
from pyros1.finding.packages import OWN_PACKAGES
from pyros1.ground.errors import ServiceError
from pyros1.msgs import load_service
from pyros1.msgs.geometry_msgs.msg import Twist
from pyros1.msgs.rosgraph_msgs.msg import Log
from pyros1.msgs.sensor_msgs.msg import Image
from pyros1.msgs.turtlesim.msg import Color, Pose
from pyros1.node import Node
from pyros1.turtlesim.simulator import Simulator
from pyros1.turtlesim.teleop import Teleop
from pyros1.turtlesim.turtle import WORLD_SIZE
from pyros1.turtlesim.view import View, show

PATIENCE = 20.0
Make = Callable[..., Any]


class User:
    """A node that drives turtles."""

    def __init__(self, node: Node) -> None:
        self.node = node
        self.heard: dict[str, Queue[Any]] = {}

    def call(self, service: str, kind: str, *args: object) -> Any:
        self.node.wait_for_service(service, PATIENCE)
        cls = load_service(kind)
        return self.node.service(service, cls).call(cls._request_class(*args), PATIENCE)

    def until(self, topic: str, kind: type[Any], fits: Callable[[Any], object]) -> Any:
        """Return the first message of a topic that fits."""
        if topic not in self.heard:
            self.heard[topic] = Queue()
            self.node.subscribe(topic, kind, self.heard[topic].put)
        until, last = time.monotonic() + PATIENCE, None
        while time.monotonic() < until:
            last = self.heard[topic].get(timeout=PATIENCE)
            if fits(last):
                return last
        raise AssertionError(f"not seen on {topic}; the last was {last!r:.500}")


@pytest.fixture
def simulator(make_node: Make) -> Iterator[Node]:
    """A running turtlesim_node, whose background is dark."""
    make_node("setter").params["/turtlesim/background_r"] = 10
    node: Node = make_node("turtlesim", wall_time=True)
    running = threading.Thread(target=Simulator(node).run)
    running.start()
    yield node
    node.shutdown()
    running.join(PATIENCE)


@pytest.fixture
def user(make_node: Make) -> User:
    """Who drives them."""
    return User(make_node("user"))


def test_names_and_types_are_those_of_stock(simulator: Node, user: User) -> None:
    master = user.node.master
    topics = dict(master.get_published_topics(""))
    assert topics["/turtle1/pose"] == "turtlesim/Pose" and topics["/turtle1/color_sensor"] == "turtlesim/Color"
    _, subscribers, services = master.get_system_state()
    assert ["/turtle1/cmd_vel", ["/turtlesim"]] in subscribers
    names = {name for name, nodes in services if nodes == ["/turtlesim"] and "logger" not in name}
    assert names == {"/clear", "/reset", "/spawn", "/kill"} | {
        f"/turtle1/{name}" for name in ("set_pen", "teleport_absolute", "teleport_relative")
    }
    assert [user.node.params[f"/turtlesim/background_{part}"] for part in "rgb"] == [10, 86, 255]


def test_commands_and_walls(simulator: Node, user: User) -> None:
    begin = user.until("/turtle1/pose", Pose, lambda pose: True)
    assert (begin.x, begin.y, begin.theta) == (pytest.approx(WORLD_SIZE / 2, abs=1e-6), begin.x, 0.0)
    said: Queue[Any] = Queue()
    user.node.subscribe("/rosout", Log, lambda message: said.put(message.msg))
    publisher = user.node.advertise("/turtle1/cmd_vel", Twist)
    assert publisher.wait_for_subscribers(timeout=PATIENCE)
    twist = Twist()
    twist.linear.x = float("nan")
    heard = ""
    until = time.monotonic() + PATIENCE
    while "a command for [turtle1] is ignored: forward must be a number" not in heard:
        assert time.monotonic() < until
        publisher.publish(twist)  # again, until the link of the log is there, too
        with suppress(Empty):
            heard += said.get(timeout=0.1)
    twist.linear.x, twist.linear.y = 400.0, 300.0
    publisher.publish(twist)
    moving = user.until("/turtle1/pose", Pose, lambda pose: pose.linear_velocity)
    assert moving.linear_velocity == 500.0
    corner = user.until("/turtle1/pose", Pose, lambda pose: pose.x > 11 and pose.y > 11)
    assert (corner.x, corner.y) == pytest.approx((WORLD_SIZE, WORLD_SIZE), abs=1e-6)
    publisher.publish(Twist())
    user.until("/turtle1/pose", Pose, lambda pose: not pose.linear_velocity)
    while "Oh no! I hit the wall! (Clamping from [x=" not in heard:
        heard += said.get(timeout=PATIENCE)


def test_services(simulator: Node, user: User) -> None:
    assert user.call("/spawn", "turtlesim/Spawn", 2.0, 3.0, 1.5, "").name == "turtle2"
    pose = user.until("/turtle2/pose", Pose, lambda pose: True)
    assert (pose.x, pose.y, pose.theta) == (2.0, 3.0, 1.5)
    with pytest.raises(ServiceError, match=r"A turtle named \[turtle2\] already exists"):
        user.call("/spawn", "turtlesim/Spawn", 2.0, 3.0, 1.5, "turtle2")
    with pytest.raises(ServiceError, match="is not a legal ROS name"):
        user.call("/spawn", "turtlesim/Spawn", 2.0, 3.0, 1.5, "no name")
    user.call("/turtle2/set_pen", "turtlesim/SetPen", 1, 2, 3, 0, 0)
    user.call("/turtle2/teleport_absolute", "turtlesim/TeleportAbsolute", 8.0, 3.0, 0.0)
    assert user.until("/turtle2/color_sensor", Color, lambda colour: colour.b == 3).r == 1
    user.call("/turtle2/teleport_relative", "turtlesim/TeleportRelative", 1.0, 0.5)
    pose = user.until("/turtle2/pose", Pose, lambda pose: pose.theta == 0.5)
    assert (pose.x, pose.y) == pytest.approx((8.877583, 3.479426), abs=1e-5)
    with pytest.raises(ServiceError, match="theta must be a number"):
        user.call("/turtle2/teleport_absolute", "turtlesim/TeleportAbsolute", 8.0, 3.0, float("nan"))
    user.call("/kill", "turtlesim/Kill", "turtle2")
    with pytest.raises(ServiceError, match="which does not exist"):
        user.call("/kill", "turtlesim/Kill", "turtle2")
    assert "/turtle2/pose" not in dict(user.node.master.get_published_topics(""))
    user.call("/kill", "turtlesim/Kill", "turtle1")
    user.call("/reset", "std_srvs/Empty")
    user.until("/turtle1/pose", Pose, lambda pose: pose.theta == 0)


def test_the_drawing_and_its_background(simulator: Node, user: User) -> None:
    first = user.until("/turtlesim/drawing", Image, lambda image: True)
    assert (first.encoding, first.width, first.height, first.step) == ("rgb8", 500, 500, 1500)
    assert first.data == bytes([10, 86, 255]) * 500**2
    user.call("/turtle1/teleport_relative", "turtlesim/TeleportRelative", 3.0, 0.0)
    user.until("/turtlesim/drawing", Image, lambda image: image.data.count(bytes([179, 184, 255])) > 300)
    user.node.params["/turtlesim/background_r"] = 77
    user.node.params["/turtlesim/background_g"] = "green"
    user.call("/clear", "std_srvs/Empty")
    user.until("/turtlesim/drawing", Image, lambda image: image.data == bytes([77, 86, 255]) * 500**2)


def test_keys(simulator: Node, make_node: Make, user: User) -> None:
    teleop = Teleop(make_node("teleop_turtle", argv=["_scale_angular:=1.5"]))
    twists: Queue[Any] = Queue()
    user.node.subscribe("/turtle1/cmd_vel", Twist, twists.put).wait_for_publishers(1, PATIENCE)
    for key, wanted in {"up": (2, 0), "down": (-2, 0), "left": (0, 1.5), "right": (0, -1.5), "f": (0, 0)}.items():
        assert teleop.handle_key(key)
        twist = twists.get(timeout=PATIENCE)
        assert (twist.linear.x, twist.angular.z) == wanted, key
    assert teleop.wait_for_pose(PATIENCE)
    for key, theta in {"D": 3.141593, "r": 1.570796, "b": -0.785398, "G": 0.0}.items():
        assert teleop.handle_key(key)
        user.until("/turtle1/pose", Pose, lambda pose, theta=theta: abs(abs(pose.theta) - abs(theta)) < 1e-5)
    assert teleop.handle_key("x") and not teleop.handle_key("q")


def test_draw_square_begins_anew_and_walks(simulator: Node, user: User, environ: dict[str, str]) -> None:
    user.call("/turtle1/teleport_absolute", "turtlesim/TeleportAbsolute", 1.0, 1.0, 2.0)
    env = {**os.environ, **environ, "PYTHONPATH": str(Path(pyros1.__file__).parents[1])}
    script = Path(OWN_PACKAGES) / "turtlesim" / "scripts" / "draw_square"
    process = subprocess.Popen([sys.executable, script], env=env, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        assert "New goal [7.544445 5.544445, 0.000000]" in process.stdout.readline()
        walking = user.until("/turtle1/pose", Pose, lambda pose: pose.linear_velocity)
        assert (walking.linear_velocity, walking.theta) == (1.0, 0.0)
    finally:
        process.terminate()
        assert process.wait(PATIENCE) == 0
        process.stdout.close()


class Screen(io.StringIO):
    """A terminal that is looked at."""

    def __init__(self, shown: Callable[[str], None]) -> None:
        super().__init__()
        self._shown = shown

    def flush(self) -> None:
        self._shown(self.getvalue())


def test_the_view_in_a_terminal(simulator: Node, make_node: Make, user: User) -> None:
    user.call("/turtle1/teleport_absolute", "turtlesim/TeleportAbsolute", 8.0, 3.0, 1.57)
    node = make_node("turtle_view")

    def look(text: str) -> None:
        if "turtle1 (8.00, 3.00)" in text and "179;184;255" in text and "↑" in text:
            threading.Thread(target=node.shutdown).start()

    screen = Screen(look)
    give_up = threading.Timer(PATIENCE, node.shutdown)
    give_up.start()
    show(View(node), node, screen)
    give_up.cancel()
    text = screen.getvalue()
    assert "/turtlesim: turtle1 (8.00, 3.00)" in text and text.endswith("\x1b[?25h\x1b[?1049l")
    assert View(make_node("other"), "nobody").lines(80, 24) == [
        "/nobody is not running; to start some: pyros1 run turtlesim turtlesim_node"
    ]
