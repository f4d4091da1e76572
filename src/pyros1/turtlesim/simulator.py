"""turtlesim_node: simulates turtles, which other nodes drive (https://wiki.ros.org/turtlesim).

It has no window: `pyros1 web turtles` and turtle_view display what it publishes.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from contextlib import ExitStack, contextmanager, suppress
from time import monotonic
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import Error, NodeError, ServiceRefusal
from pyros1.ground.terminal_text import one_line
from pyros1.msgs.geometry_msgs.msg import Twist
from pyros1.msgs.sensor_msgs.msg import Image
from pyros1.msgs.std_srvs.srv import Empty
from pyros1.msgs.turtlesim.msg import Color, Pose
from pyros1.msgs.turtlesim.srv import Kill, SetPen, Spawn, TeleportAbsolute, TeleportRelative
from pyros1.node import Node
from pyros1.turtlesim.canvas import Colour
from pyros1.turtlesim.turtle import PICTURE_SIZE, STEP_PERIOD, WORLD_SIZE, Pen
from pyros1.turtlesim.world import BACKGROUND, StepResult, TurtleError, World

if TYPE_CHECKING:
    from collections.abc import Iterator

DRAWING_TOPIC = "~drawing"
"""Topic with the turtles' drawing; stock turtlesim has no such topic, since its window displays the drawing."""
_DRAWING_PERIOD = 0.1
"""Minimum number of seconds between two publications of the drawing."""
_COLOUR_PARAM_SUFFIXES = ("r", "g", "b")


class Simulator:
    """Simulates a world, which initially contains turtle1, and provides its topics and services.

    Args:
        node: the node that has the topics and services.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._world = World()
        self._lock = threading.Lock()  # guards the world; never held while waiting
        # Held while turtles are added or removed, which may take a long time, since it includes calls to the master.
        self._population_lock = threading.Lock()
        self._interfaces: dict[str, _TurtleInterface] = {}
        self._drawn_version, self._drawn_at = -1, float("-inf")
        for name, value in zip(_COLOUR_PARAM_SUFFIXES, BACKGROUND, strict=True):
            if f"~background_{name}" not in node.params:
                node.params[f"~background_{name}"] = value
        self._drawing_publisher = node.advertise(DRAWING_TOPIC, Image, queue_size=1, latch=True)
        node.log.info("Starting turtlesim with node name %s", node.name)
        self._clear()
        self._spawn("", WORLD_SIZE / 2, WORLD_SIZE / 2, 0.0)
        node.advertise_service("clear", Empty, self._on_clear)
        node.advertise_service("reset", Empty, self._on_reset)
        node.advertise_service("spawn", Spawn, self._on_spawn)
        node.advertise_service("kill", Kill, self._on_kill)

    # Services ---------------------------------------------------------------------------------------------------------

    def _on_clear(self, request: Any) -> Any:
        self._node.log.info("Clearing turtlesim.")
        self._clear()
        return Empty._response_class()

    def _on_reset(self, request: Any) -> Any:
        self._node.log.info("Resetting turtlesim.")
        with _report_errors(self._node), self._population_lock:
            with self._lock:
                self._world.reset()
            for name in [name for name in self._interfaces if name != "turtle1"]:
                self._interfaces.pop(name).close()
            if "turtle1" not in self._interfaces:
                self._interfaces["turtle1"] = _TurtleInterface(self._node, "turtle1", self._world, self._lock)
        self._clear()
        return Empty._response_class()

    def _on_spawn(self, request: Any) -> Any:
        with _report_errors(self._node):
            return self._spawn(request.name, request.x, request.y, request.theta)

    def _on_kill(self, request: Any) -> Any:
        with _report_errors(self._node), self._population_lock:
            with self._lock:
                self._world.kill(request.name)
            if interface := self._interfaces.pop(request.name, None):
                interface.close()
        return Kill._response_class()

    def _spawn(self, name: str, x: float, y: float, theta: float) -> str:
        with self._population_lock:
            with self._lock:
                name = self._world.spawn(name, x, y, theta)
            try:
                self._interfaces[name] = _TurtleInterface(self._node, name, self._world, self._lock)
            except BaseException:
                with self._lock:
                    self._world.kill(name)
                raise
        self._node.log.info("Spawning turtle [%s] at x=[%f], y=[%f], theta=[%f]", name, x, y, theta)
        return name

    def _clear(self) -> None:
        background = self._read_background()
        with self._lock:
            self._world.canvas.clear(background)

    def _read_background(self) -> Colour:
        red, green, blue = (
            self._colour_param(name, default) for name, default in zip(_COLOUR_PARAM_SUFFIXES, BACKGROUND, strict=True)
        )
        return red, green, blue

    def _colour_param(self, name: str, default: int) -> int:
        value = self._node.params.get(f"~background_{name}", default)
        if type(value) is int and 0 <= value <= 255:
            return value
        value_text = one_line(repr(value), 100)
        self._node.log.error("the parameter ~background_%s must be a number from 0 to 255, not %s", name, value_text)
        return default

    # Steps ------------------------------------------------------------------------------------------------------------

    def step(self) -> None:
        """Move all turtles by one step, and publish their new states and the drawing."""
        with self._lock:
            results = self._world.step(monotonic())
        for result in results:
            interface = self._interfaces.get(result.name)
            if interface is not None:  # otherwise, the turtle is being spawned or killed
                interface.publish(result)
        self._publish_drawing()

    def _publish_drawing(self) -> None:
        with self._lock:
            version, now = self._world.canvas.version, monotonic()
            if version == self._drawn_version or now - self._drawn_at < _DRAWING_PERIOD:
                return
            pixels = self._world.canvas.pixels()
        self._drawn_version, self._drawn_at = version, now
        message = Image(height=PICTURE_SIZE, width=PICTURE_SIZE, encoding="rgb8", step=3 * PICTURE_SIZE, data=pixels)
        message.header.stamp = self._node.now()
        self._drawing_publisher.publish(message)

    def run(self) -> None:
        """Simulate until the node shuts down."""
        rate = self._node.rate(1 / STEP_PERIOD)
        while self._node.ok():
            self.step()
            rate.sleep()


class _TurtleInterface:
    """One turtle's topics and services.

    Raises:
        Error: the turtle's name cannot be part of a topic's name, or another node uses one of the topics or services
            with another type.
    """

    def __init__(self, node: Node, name: str, world: World, lock: threading.Lock) -> None:
        self._node = node
        self._name = name
        self._world = world
        self._lock = lock
        base = node.resolve(name)
        with ExitStack() as cleanup:
            self._pose_publisher = node.advertise(f"{base}/pose", Pose, queue_size=1)
            cleanup.callback(self._pose_publisher.unregister)
            self._colour_publisher = node.advertise(f"{base}/color_sensor", Color, queue_size=1)
            cleanup.callback(self._colour_publisher.unregister)
            command_subscriber = node.subscribe(f"{base}/cmd_vel", Twist, self._on_command, queue_size=1)
            cleanup.callback(command_subscriber.unregister)
            services: tuple[tuple[str, Any, Callable[[Any], None]], ...] = (
                ("set_pen", SetPen, self._set_pen),
                ("teleport_absolute", TeleportAbsolute, self._teleport_absolute),
                ("teleport_relative", TeleportRelative, self._teleport_relative),
            )
            for service, service_type, apply_request in services:
                cleanup.callback(
                    node.advertise_service(
                        f"{base}/{service}", service_type, self._make_handler(service_type, apply_request)
                    ).shutdown
                )
            self._cleanup = cleanup.pop_all()

    def close(self) -> None:
        """Remove the turtle's topics and services."""
        self._cleanup.close()

    def publish(self, result: StepResult) -> None:
        """Publish the result of a step, and log a warning if the turtle has hit a wall."""
        turtle = result.turtle
        if result.requested is not None:
            # In stock's message, y is measured downwards, as in stock's window.
            x, y = result.requested.x, WORLD_SIZE - result.requested.y
            self._node.log.warn("Oh no! I hit the wall! (Clamping from [x=%f, y=%f])", x, y)
        with suppress(NodeError):  # the turtle is being killed
            self._pose_publisher.publish(Pose(turtle.x, turtle.y, turtle.theta, turtle.speed, turtle.turning))
            self._colour_publisher.publish(Color(*result.colour))

    def _make_handler(self, service_type: Any, apply_request: Callable[[Any], None]) -> Callable[[Any], Any]:
        def handle(request: Any) -> Any:
            with _report_errors(self._node), self._lock:
                apply_request(request)
            return service_type._response_class()

        return handle

    def _set_pen(self, request: Any) -> None:
        pen = Pen(request.r, request.g, request.b, max(request.width, 1), bool(request.off))
        self._world.set_pen(self._name, pen)

    def _teleport_absolute(self, request: Any) -> None:
        self._world.teleport_absolute(self._name, request.x, request.y, request.theta)

    def _teleport_relative(self, request: Any) -> None:
        self._world.teleport_relative(self._name, request.linear, request.angular)

    def _on_command(self, message: Any) -> None:
        try:
            with self._lock:
                speeds = message.linear.x, message.linear.y, message.angular.z
                self._world.command(self._name, *speeds, monotonic())
        except TurtleError as error:
            self._node.log.warn("a command for [%s] is ignored: %s", self._name, error, throttle=1)


@contextmanager
def _report_errors(node: Node) -> Iterator[None]:
    """Log errors that occur in the context, and report them to the service's caller."""
    try:
        yield
    except Error as error:
        message = one_line(str(error), 1000)
        node.log.error("%s", message)
        raise ServiceRefusal(message) from None


def main(argv: list[str]) -> int:
    """Run turtlesim_node; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    with Node("turtlesim", argv=argv[1:], wall_time=True) as node:  # wall time, even if time is simulated
        Simulator(node).run()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv))
