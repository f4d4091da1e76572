"""A flat world with robots in it (no I/O). The same seed and commands always give the same result.

Arrays have a row for each robot.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pyros1.ground.errors import Error
from pyros1.robot_nodes.flat_world.camera import Camera, draw
from pyros1.robot_nodes.flat_world.drive import Drive, move
from pyros1.robot_nodes.flat_world.sensors import Imu, Laser, blur_ranges, cast_rays, read_imus
from pyros1.robot_nodes.flat_world.walls import Walls

Floats = NDArray[np.float64]
STEPS_PER_SECOND = 40
"""Steps per second of simulated time."""
DT = 1 / STEPS_PER_SECOND
MAX_ROBOTS = 50


@dataclass(frozen=True)
class Settings:
    """The robots of a world.

    Attributes:
        radius: the radius of the robots in m.
        command_timeout: seconds after which a robot stops without a new command.
        drive, laser, imu, camera: the robots' components.
    """

    radius: float = 0.2
    command_timeout: float = 0.5
    drive: Drive = field(default_factory=Drive)
    laser: Laser = field(default_factory=Laser)
    imu: Imu = field(default_factory=Imu)
    camera: Camera = field(default_factory=Camera)


class _Random(IntEnum):
    """The uses of random numbers. Each use has its own generator, so they do not affect each other."""

    SLIPS = 0
    BIASES = 1
    STARTS = 2
    WHEELS = 3
    LASER = 4
    IMU = 5


class _Command(NamedTuple):
    speed: float
    turn: float
    step: int


class World:
    """Robots between walls.

    Args:
        walls: the walls.
        starts: the robots' start poses: x and y in m, heading in radians; shape (n, 3).
        settings: the properties of the robots.
        seed: the seed for random numbers.

    Attributes:
        num_steps: the number of steps so far.
        poses: the robots' poses; shape (n, 3).
        odometry: their poses according to their wheels, relative to where they started; shape (n, 3).
        speeds: their true speeds (m/s) and turn rates (rad/s); shape (n, 2).
        wheel_speeds: the speeds and turn rates according to the wheels; shape (n, 2).
        wheel_angles: how far the left and right wheels have turned, in radians; shape (n, 2).
        bumped: which robots are blocked by walls or other robots; shape (n,).
        imus: the result of `sensors.read_imus`; shape (n, 4).
    """

    def __init__(self, walls: Walls, starts: Floats, settings: Settings, seed: int = 0) -> None:
        self.walls, self.settings = walls, settings
        self.num_steps = 0
        self._starts, self._seed = starts, seed
        count = len(starts)
        self._slips = settings.drive.draw_slips(count, self._random(_Random.SLIPS))
        self._biases = self._random(_Random.BIASES).standard_normal(count) * settings.imu.turn_bias
        self.reset()

    def reset(self) -> None:
        """Put the robots back to where they started. Simulated time continues."""
        count = len(self._starts)
        self._commands = [_Command(0.0, 0.0, 0)] * count
        self.poses = self._starts.copy()
        self.odometry = np.zeros((count, 3))
        self.speeds, self.wheel_speeds, self.wheel_angles = (np.zeros((count, 2)) for _ in range(3))
        self.bumped = np.zeros(count, np.bool_)
        self.imus = np.zeros((count, 4))

    def command(self, robot: int, speed: float, turn: float) -> None:
        """Command a robot's speed in m/s and turn rate in rad/s, which must be finite."""
        self._commands[robot] = _Command(speed, turn, self.num_steps)

    def step(self) -> None:
        """Advance the world by `DT` seconds."""
        drive = self.settings.drive
        self.num_steps += 1
        oldest = self.num_steps - 1 - self.settings.command_timeout * STEPS_PER_SECOND
        wanted = np.array([each[:2] if each.step > oldest else (0.0, 0.0) for each in self._commands])
        rolling = drive.speed_up(self.wheel_speeds, wanted, DT)
        ways = drive.to_wheels(rolling * DT)
        true_ways = drive.from_wheels(drive.slipped(ways, self._slips, self._random(_Random.WHEELS)))
        new_poses = move(self.poses, true_ways)
        self.bumped = self._find_collisions(new_poses)
        # A blocked robot can still turn, to get away.
        rolling[self.bumped, 0] = true_ways[self.bumped, 0] = 0
        new_poses[self.bumped, :2] = self.poses[self.bumped, :2]
        self.poses = new_poses
        ways = drive.to_wheels(rolling * DT)
        self.wheel_angles = self.wheel_angles + ways / drive.wheel_radius
        self.odometry = move(self.odometry, rolling * DT)
        before, self.speeds, self.wheel_speeds = self.speeds, true_ways / DT, rolling
        self.imus = read_imus(before, self.speeds, DT, self.settings.imu, self._biases, self._random(_Random.IMU))

    def _find_collisions(self, poses: Floats) -> NDArray[np.bool_]:
        """Return a mask of the robots: True for those that cannot move to the given poses."""
        old, radius = self.poses[:, :2], self.settings.radius
        held = self.walls.are_hit(poses[:, 0], poses[:, 1], radius)
        apart = _distances(old)
        while True:  # a blocked robot may be in the way of others
            places = np.where(held[:, None], old, poses[:, :2])
            between = _distances(places)
            # Robots that overlapped at the start may move apart.
            hitting = ((between < 2 * radius) & (between < apart)).any(axis=1)
            if not (hitting & ~held).any():
                return held
            held = held | hitting

    def scan(self, robots: Sequence[int]) -> NDArray[np.float32]:
        """Return the ranges that the lasers of one or more robots measure, in m; shape (len(robots), rays)."""
        laser = self.settings.laser
        found, _, _ = self._cast(robots, laser.angles, laser.x, laser.max_range)
        noise = np.stack([self._random(_Random.LASER, robot).standard_normal(laser.rays) for robot in robots])
        return blur_ranges(found, laser, noise)

    def picture(self, robot: int) -> NDArray[np.uint8]:
        """Return the image from a robot's camera, as RGB with shape (height, width, 3)."""
        camera = self.settings.camera
        found, faces_x, are_robots = self._cast([robot], camera.angles, camera.x, camera.max_range)
        return draw(camera, self.poses[robot], found[0], faces_x[0], are_robots[0])

    def _cast(
        self, robots: Sequence[int], angles: Floats, offset: float, max_range: float
    ) -> tuple[Floats, NDArray[np.bool_], NDArray[np.bool_]]:
        poses = self.poses[list(robots)]
        return cast_rays(self.walls, poses, angles, offset, max_range, self.poses[:, :2], self.settings.radius)

    def _random(self, purpose: _Random, *more: int) -> np.random.Generator:
        return np.random.default_rng((self._seed, purpose, self.num_steps, *more))


def _distances(places: Floats) -> Floats:
    """Return the distances between all pairs of robots; a robot's distance from itself is infinite."""
    between = places[:, None] - places[None]
    distances = np.hypot(between[:, :, 0], between[:, :, 1])
    np.fill_diagonal(distances, np.inf)
    return distances


def find_starts(walls: Walls, count: int, radius: float, first: tuple[float, float, float], seed: int = 0) -> Floats:
    """Return start poses for robots, with shape (count, 3). All but the first are random.

    Args:
        walls: the walls.
        count: number of robots.
        radius: their radius in m.
        first: the first robot's x and y in m, and heading in radians; if there is a wall, its pose is random, too.
        seed: the seed for random numbers.

    Raises:
        Error: the map does not have enough free places.
    """
    random = np.random.default_rng((seed, _Random.STARTS))
    starts = [] if walls.are_hit(np.array([first[0]]), np.array([first[1]]), radius)[0] else [first]
    for x, y in random.permutation(walls.free_places(radius)):
        if len(starts) >= count:
            break
        if all(np.hypot(x - other[0], y - other[1]) > 2.5 * radius for other in starts):
            starts.append((x, y, random.uniform(-np.pi, np.pi)))
    if len(starts) < count:
        raise Error(f"the map has free places for {len(starts)} robots, not for {count}")
    return np.array(starts)
