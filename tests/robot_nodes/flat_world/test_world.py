from __future__ import annotations

from math import hypot, pi

import numpy as np
import pytest

from pyros1.ground.errors import Error
from pyros1.robot_nodes.flat_world.drive import Drive
from pyros1.robot_nodes.flat_world.sensors import Laser
from pyros1.robot_nodes.flat_world.walls import Walls
from pyros1.robot_nodes.flat_world.world import DT, STEPS_PER_SECOND, Settings, World, find_starts

EXACT = Settings(drive=Drive(slip=0.0, noise=0.0), laser=Laser(rays=8, noise=0.0))
ROOM = Walls(np.zeros((100, 100), np.bool_), 0.1)
"""10 m x 10 m."""


def make_world(*starts: tuple[float, float, float], settings: Settings = EXACT, seed: int = 0) -> World:
    return World(ROOM, np.array(starts), settings, seed)


def drive(world: World, seconds: float, *commands: tuple[float, float]) -> None:
    for _ in range(round(seconds * STEPS_PER_SECOND)):
        for robot, command in enumerate(commands):
            world.command(robot, *command)
        world.step()


def test_a_circle_is_one() -> None:
    world = make_world((5, 3, 0))
    drive(world, 2.0, (0.5, 0.5))
    centres = []
    for _ in range(3):
        drive(world, 1.0, (0.5, 0.5))
        x, y, heading = world.poses[0]
        centres.append([x - np.sin(heading), y + np.cos(heading)])
    assert np.ptp(centres, axis=0) == pytest.approx([0, 0], abs=1e-9)
    assert world.speeds[0] == pytest.approx([0.5, 0.5])
    assert world.imus[0] == pytest.approx([0.5, 0.0, 0.25, 9.81], abs=0.3)


def test_wheels_and_odometry_without_slip_are_the_truth() -> None:
    world = make_world((5, 3, pi / 2))
    drive(world, 3.0, (0.4, -0.3))
    x, y, heading = world.odometry[0]
    assert world.poses[0] == pytest.approx([5 - y, 3 + x, pi / 2 + heading])
    left, right = world.wheel_angles[0] * EXACT.drive.wheel_radius
    assert (right - left) / EXACT.drive.separation == pytest.approx(heading)


def test_odometry_drifts_with_slip() -> None:
    world = make_world((2, 5, 0), settings=Settings(drive=Drive(slip=0.05, noise=0.0)))
    drive(world, 4.0, (0.5, 0.0))
    assert world.odometry[0, 0] == pytest.approx(0.5 * 4 - 0.5**2 / 2 / 2, abs=0.02)
    way = hypot(*(world.poses[0, :2] - [2, 5]))
    assert 0.9 * world.odometry[0, 0] <= way < world.odometry[0, 0]
    assert world.poses[0, 2] != 0 == world.odometry[0, 2]


def test_a_robot_stops_when_its_commands_cease() -> None:
    world = make_world((5, 5, 0))
    drive(world, 1.0, (0.5, 0.0))
    for _ in range(round(EXACT.command_timeout * STEPS_PER_SECOND) - 1):
        world.step()
    assert world.wheel_speeds[0, 0] == 0.5
    for _ in range(round(0.5 / EXACT.drive.acceleration / DT) + 1):
        world.step()
    assert world.wheel_speeds[0].tolist() == [0, 0]


@pytest.mark.slow
@pytest.mark.parametrize("heading", [0.0, 0.7, 2.0, -2.4])
def test_walls_stop_robots_which_can_leave_again(heading: float) -> None:
    world = make_world((5, 5, heading))
    drive(world, 12.0, (1.0, 0.0))
    x, y, _ = world.poses[0]
    gap = min(x, y, 10 - x, 10 - y)
    assert EXACT.radius <= gap < EXACT.radius + 0.01
    for _ in range(3):  # it goes on trying, until it touches
        drive(world, 0.1, (1.0, 0.0))
    assert world.speeds[0, 0] < 0.2
    drive(world, 0.5, (-0.5, 0.0))
    assert not world.bumped[0] and world.speeds[0, 0] == pytest.approx(-0.5)
    assert world.wheel_speeds[0, 0] == pytest.approx(-0.5)


def test_bumping_is_noticed_and_odometry_stops() -> None:
    world = make_world((9.5, 5, 0))
    bumps = 0
    for _ in range(80):
        drive(world, DT, (1.0, 0.0))
        bumps += int(world.bumped[0])
    assert bumps > 10
    assert world.odometry[0, 0] == pytest.approx(0.3, abs=0.01)
    drive(world, 1.0, (0.0, 1.0))
    assert world.speeds[0, 1] == pytest.approx(1.0)


def test_robots_never_overlap_walls_or_each_other() -> None:
    occupied = np.random.default_rng(3).random((60, 60)) < 0.01
    walls = Walls(occupied, 0.1)
    settings = Settings()
    starts = find_starts(walls, 8, settings.radius, (-1, -1, 0), 3)
    world = World(walls, starts, settings, 3)
    random = np.random.default_rng(4)
    bumps = 0
    for step in range(400):
        if step % 20 == 0:
            commands = random.uniform(-1, 1, (8, 2)) * [1.5, 2]
        for robot, (speed, turn) in enumerate(commands):
            world.command(robot, speed, turn)
        world.step()
        bumps += int(world.bumped.sum())
        x, y = world.poses[:, 0], world.poses[:, 1]
        assert not walls.are_hit(x, y, settings.radius).any()
        apart = np.hypot(x[:, None] - x, y[:, None] - y) + np.eye(8)
        assert apart.min() >= 2 * settings.radius
    assert bumps > 100


def test_robots_push_against_each_other() -> None:
    world = make_world((4, 5, 0), (6, 5, pi))
    drive(world, 5.0, (0.5, 0.0), (0.5, 0.0))
    assert 0 <= world.poses[1, 0] - world.poses[0, 0] - 2 * EXACT.radius < 0.01
    assert world.scan([0])[0, 4] == pytest.approx(EXACT.radius - EXACT.laser.x, abs=0.011)
    drive(world, 1.0, (-0.5, 0.0), (0.0, 0.0))
    assert world.speeds[0, 0] == pytest.approx(-0.5)


def test_robots_that_start_too_close_can_part() -> None:
    world = make_world((5, 5, 0), (5.1, 5, 0))
    drive(world, 2.0, (-0.5, 0.0), (0.5, 0.0))
    assert world.poses[1, 0] - world.poses[0, 0] > 1.5


def run(seed: int, scanned: list[int]) -> tuple[list[float], list[float]]:
    world = World(ROOM, np.array([(2.0, 2.0, 0.0), (7.0, 7.0, 1.0)]), Settings(), seed)
    for _ in range(20):
        drive(world, DT, (0.3, 0.2), (0.2, -0.1))
        scans = world.scan(scanned)
    return [*world.poses.ravel(), *world.imus.ravel(), *world.odometry.ravel()], scans[-1].tolist()


def test_the_seed_decides_and_not_who_looks() -> None:
    first = run(1, [0, 1])
    assert run(1, [0, 1]) == first == run(1, [1])
    other = run(2, [1])
    assert other[0] != first[0] and other[1] != first[1]


def test_pictures_show_what_is_ahead() -> None:
    world = make_world((5, 5, 0), (6, 5, 0))
    camera = EXACT.camera
    assert world.picture(0).shape == (camera.height, camera.width, 3)
    assert not np.array_equal(world.picture(0), world.picture(1))


def test_reset() -> None:
    world = make_world((5, 5, 0))
    drive(world, 1.0, (0.5, 0.1))
    steps = world.num_steps
    world.reset()
    assert (world.num_steps, world.poses.tolist(), world.odometry.tolist()) == (steps, [[5, 5, 0]], [[0, 0, 0]])
    world.step()
    assert world.speeds.tolist() == [[0, 0]]


def test_starts() -> None:
    wanted = (3.0, 4.0, 1.0)
    starts = find_starts(ROOM, 10, 0.2, wanted, 5)
    assert tuple(starts[0]) == wanted and starts.shape == (10, 3)
    x, y, _ = starts.T
    assert not ROOM.are_hit(x, y, 0.2).any()
    assert (np.hypot(x[:, None] - x, y[:, None] - y) + np.eye(10)).min() > 0.5
    assert np.array_equal(find_starts(ROOM, 10, 0.2, wanted, 5), starts)
    assert not np.array_equal(find_starts(ROOM, 10, 0.2, wanted, 6), starts)
    assert tuple(find_starts(ROOM, 1, 0.2, (0.1, 0.1, 0), 5)[0]) != (0.1, 0.1, 0)


def test_too_little_room() -> None:
    with pytest.raises(Error, match="free places for 0 robots, not for 1"):
        find_starts(Walls(np.ones((5, 5), np.bool_), 0.1), 1, 0.2, (0.2, 0.2, 0))
    with pytest.raises(Error, match=r"free places for \d robots, not for 50"):
        find_starts(Walls(np.zeros((20, 20), np.bool_), 0.1), 50, 0.2, (1, 1, 0))
