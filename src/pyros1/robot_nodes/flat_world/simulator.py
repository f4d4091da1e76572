"""flat_world: simulates two-wheeled robots in a 2D world made from a map.

For each robot, it has the topics ``cmd_vel``, ``odom``, ``scan``, ``imu/data``, ``camera/image_raw``,
``camera/camera_info``, ``bumper``, ``joint_states`` and ``base_pose_ground_truth``; with several robots, they are in
the namespaces robot1, robot2 and so on. It publishes /clock and /tf, and has the service ``reset_positions``.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from time import monotonic
from typing import Any

from pyros1.ground.errors import Error, NodeError, NodeShutdownError
from pyros1.ground.timing import Time
from pyros1.msgs.rosgraph_msgs.msg import Clock
from pyros1.msgs.std_srvs.srv import Empty
from pyros1.node import Node
from pyros1.robot_nodes.flat_world.drive import Drive
from pyros1.robot_nodes.flat_world.robot import RobotTopics
from pyros1.robot_nodes.flat_world.sensors import Laser
from pyros1.robot_nodes.flat_world.walls import Walls
from pyros1.robot_nodes.flat_world.world import MAX_ROBOTS, STEPS_PER_SECOND, Settings, World, find_starts
from pyros1.robot_nodes.map_server.cells import OCCUPIED
from pyros1.robot_nodes.map_server.loading import load_map
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.tf import StaticTransformBroadcaster, TransformBroadcaster

_NS_PER_STEP = 1_000_000_000 // STEPS_PER_SECOND
_MAX_DELAY = 0.5
"""If the simulation is late by more seconds, it no longer tries to catch up."""
_REPORT_PERIOD = 30
_MAX_RADIUS_IN_CELLS = 100
"""Maximum radius of a robot in cells, since all cells near it are checked."""


@dataclass(frozen=True)
class Pace:
    """The speed of the simulation, and its rates.

    Attributes:
        speed: simulated seconds per second; 0 for as many as the machine can do.
        scan_steps, picture_steps: number of steps between scans, and between images.
        has_map_frame: whether to publish the transform from map to odom.
    """

    speed: float = 1.0
    scan_steps: int = 2
    picture_steps: int = 4
    has_map_frame: bool = True


class Simulator:
    """Simulates a world, and publishes what happens.

    Args:
        node: the node, which must use wall time.
        world: the world.
        pace: the simulation's speed and rates.
    """

    def __init__(self, node: Node, world: World, pace: Pace) -> None:
        self._node, self._world, self._pace = node, world, pace
        self._must_reset = False
        count = len(world.poses)
        namespaces = [""] if count == 1 else [f"robot{number + 1}/" for number in range(count)]
        self._clock = node.advertise("/clock", Clock, queue_size=10)
        self._robots = [RobotTopics(node, world, number, name) for number, name in enumerate(namespaces)]
        self._broadcaster = TransformBroadcaster(node)
        self._static_broadcaster = StaticTransformBroadcaster(node)
        stamp = self._now()
        self._static_broadcaster.send_transform(
            [each for robot in self._robots for each in robot.sensor_transforms(stamp)]
        )
        node.advertise_service("reset_positions", Empty, self._on_reset)

    def _on_reset(self, request: Any) -> Any:
        self._must_reset = True  # the reset is done between two steps
        return Empty._response_class()

    def _now(self) -> Time:
        return Time(*divmod(self._world.num_steps * _NS_PER_STEP, 1_000_000_000))

    def step(self) -> None:
        """Advance the world by one step, and publish the robots' measurements."""
        world, pace = self._world, self._pace
        if self._must_reset:
            self._must_reset = False
            world.reset()
        world.step()
        stamp = self._now()
        self._clock.publish(Clock(stamp))
        self._broadcaster.send_transform(
            [each for robot in self._robots for each in robot.transforms(stamp, pace.has_map_frame)]
        )
        for robot in self._robots:
            robot.publish_motion(stamp)
        if world.num_steps % pace.scan_steps == 0:
            self._publish_scans(stamp)
        if world.num_steps % pace.picture_steps == 0:
            for robot in self._robots:
                robot.publish_picture(stamp)

    def _publish_scans(self, stamp: Time) -> None:
        numbers = [number for number, robot in enumerate(self._robots) if robot.wants_scan]
        if numbers:
            for number, ranges in zip(numbers, self._world.scan(numbers), strict=True):
                self._robots[number].publish_scan(stamp, ranges, self._pace.scan_steps / STEPS_PER_SECOND)

    def run(self) -> None:
        """Simulate until the node shuts down."""
        with suppress(NodeError):  # raised if it shuts down during a step
            self._run()

    def _run(self) -> None:
        period = 1 / (self._pace.speed * STEPS_PER_SECOND) if self._pace.speed else 0.0
        due = monotonic()
        while self._node.ok():
            self.step()
            due += period
            delay = monotonic() - due
            if delay > _MAX_DELAY and period:
                self._node.log.warn(
                    "this machine is too slow for speed %g: simulated time falls behind",
                    self._pace.speed,
                    throttle=_REPORT_PERIOD,
                )
                due = monotonic()
            self._node.sleep(max(0.0, -delay))


def make_simulator(node: Node) -> Simulator:
    """Create a simulator as described by a node's private parameters.

    Raises:
        Error: there is no map, or it does not have enough free space.
    """
    values = PrivateParameters.of(node)
    path = values.text("map", "")
    if not path:
        raise Error(f"set the parameter {node.name}/map to the YAML file of a map")
    loaded = load_map(path)
    x, y, yaw = loaded.origin
    if yaw:
        raise Error(f"{path}: the yaw of its origin must be 0")
    if loaded.resolution < Settings.radius / _MAX_RADIUS_IN_CELLS:
        raise Error(f"{path}: its resolution must be {Settings.radius / _MAX_RADIUS_IN_CELLS:g} m or more")
    walls = Walls(loaded.cells == OCCUPIED, loaded.resolution, (x, y))
    drive = Drive(slip=values.number("slip", Drive.slip, 0, 0.5), noise=values.number("noise", Drive.noise, 0, 0.1))
    laser = Laser(
        values.integer("rays", Laser.rays, 2, 10_000),
        values.number("range_max", Laser.max_range, 0.1, 1000),
        noise=values.number("range_noise", Laser.noise, 0, 1),
    )
    speed = values.number("speed", Pace.speed, 0, 1000)
    # The robot's commands may come in real time, from a person or a joystick, while simulated time is faster.
    timeout = values.number("cmd_vel_timeout", Settings.command_timeout, 0.1) * max(1.0, speed)
    settings = Settings(command_timeout=timeout, drive=drive, laser=laser)
    seed = values.integer("seed", 0, 0)
    first = (values.number("x", 0.0), values.number("y", 0.0), values.number("yaw", 0.0))
    starts = find_starts(walls, values.integer("robots", 1, 1, MAX_ROBOTS), settings.radius, first, seed)
    if tuple(starts[0]) != first:
        places = (*first[:2], *starts[0, :2])
        node.log.warn("the first robot has no room at x=%g, y=%g: it starts at x=%g, y=%g", *places)
    pace = Pace(
        speed,
        _steps(values.number("scan_rate", 20.0, 0.1, STEPS_PER_SECOND)),
        _steps(values.number("camera_rate", 10.0, 0.1, STEPS_PER_SECOND)),
        values.flag("localization", True),
    )
    node.log.info("Simulating %d robot(s) in %s", len(starts), path)
    return Simulator(node, World(walls, starts, settings, seed), pace)


def _steps(rate: float) -> int:
    return max(1, round(STEPS_PER_SECOND / rate))


def main(argv: list[str]) -> int:
    """Run flat_world; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    with Node("flat_world", argv=argv[1:], wall_time=True) as node:
        try:
            simulator = make_simulator(node)
        except NodeShutdownError:  # Ctrl-C came before the simulator was complete
            return 0
        except Error as error:
            node.log.fatal("%s", error)
            return 1
        simulator.run()
    return 0
