"""The node flat_world.

Feature: a simulated robot -- drive, laser, odometry, IMU, camera and bumper in a flat world, made from a map
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable
from math import atan2, inf, nan
from pathlib import Path
from queue import Queue
from typing import Any

import numpy as np
import pytest

from pyros1.ground.errors import Error
from pyros1.msgs.geometry_msgs.msg import Twist
from pyros1.msgs.rosgraph_msgs.msg import Clock
from pyros1.msgs.tf2_msgs.msg import TFMessage
from pyros1.node import Node
from pyros1.robot_nodes.flat_world import simulator
from pyros1.robot_nodes.flat_world.drive import Drive
from pyros1.robot_nodes.flat_world.sensors import Imu, Laser
from pyros1.robot_nodes.flat_world.simulator import Pace, Simulator, make_simulator
from pyros1.robot_nodes.flat_world.walls import Walls
from pyros1.robot_nodes.flat_world.world import Settings, World
from pyros1.tf import Buffer

from ..logs import wait_for_line

PATIENCE = 20.0
SETTINGS = Settings(drive=Drive(slip=0.04), laser=Laser(rays=4, noise=0.0), imu=Imu(0.0, 0.0, 0.0))
YAML = "image: room.pgm\nresolution: 0.5\norigin: [{}, 0, {}]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"


@pytest.fixture
def room(tmp_path: Path) -> Path:
    """A map of a room of 5 m x 5 m."""
    (tmp_path / "room.pgm").write_bytes(b"P5 10 10 255 " + b"\xff" * 100)
    (tmp_path / "room.yaml").write_text(YAML.format(0, 0))
    return tmp_path / "room.yaml"


def make_world(*starts: tuple[float, float, float]) -> World:
    return World(Walls(np.zeros((10, 10), np.bool_), 0.5), np.array(starts), SETTINGS)


Subscribe = Callable[[str, str], "Queue[Any]"]


@pytest.fixture
def subscribe(make_node: Any) -> Subscribe:
    """Return a function that subscribes to a topic, and returns its messages."""
    user = make_node("user")

    def start(topic: str, type_name: str) -> Queue[Any]:
        messages: Queue[Any] = Queue()
        user.subscribe(topic, type_name, messages.put)
        return messages

    return start


def step_until(simulated: Simulator, messages: Queue[Any]) -> Any:
    """Make steps until there is a message."""
    for _ in range(10_000):
        simulated.step()
        try:
            return messages.get(timeout=0.002)
        except Exception:  # noqa: BLE001 - there is none yet
            continue
    raise AssertionError("no message came")


def test_what_one_robot_says(make_node: Any, subscribe: Subscribe) -> None:
    simulated = Simulator(make_node("flat_world", wall_time=True), make_world((2, 1, 0)), Pace())
    scans = subscribe("/scan", "sensor_msgs/LaserScan")
    scan = step_until(simulated, scans)
    assert scan.ranges == pytest.approx((2.1, 1.0, 2.9, 4.0), abs=1e-5)
    assert scan.angle_min + 3 * scan.angle_increment == pytest.approx(scan.angle_max)
    assert (scan.header.frame_id, scan.range_max) == ("laser", 10.0)
    assert scan.scan_time == pytest.approx(0.05)
    assert scan.header.stamp.to_sec() * 20 % 1 == pytest.approx(0)
    odometry = step_until(simulated, subscribe("/odom", "nav_msgs/Odometry"))
    assert (odometry.header.frame_id, odometry.child_frame_id) == ("odom", "base_footprint")
    assert odometry.pose.pose.position.x == 0
    truth = step_until(simulated, subscribe("/base_pose_ground_truth", "nav_msgs/Odometry"))
    assert (truth.header.frame_id, truth.pose.pose.position.x) == ("map", 2)
    imu = step_until(simulated, subscribe("/imu/data", "sensor_msgs/Imu"))
    assert (imu.header.frame_id, imu.linear_acceleration.z) == ("imu", 9.81)
    image = step_until(simulated, subscribe("/camera/image_raw", "sensor_msgs/Image"))
    assert (image.width, image.height, image.encoding, len(image.data)) == (160, 120, "rgb8", 160 * 120 * 3)
    assert image.step == 160 * 3
    info = step_until(simulated, subscribe("/camera/camera_info", "sensor_msgs/CameraInfo"))
    assert (info.width, info.header.frame_id) == (160, image.header.frame_id)
    assert info.K[0] == info.P[5] == pytest.approx(138.564)
    joints = step_until(simulated, subscribe("/joint_states", "sensor_msgs/JointState"))
    assert joints.name == ["left_wheel_joint", "right_wheel_joint"]
    assert step_until(simulated, subscribe("/bumper", "std_msgs/Bool")).data is False
    clock = step_until(simulated, subscribe("/clock", "rosgraph_msgs/Clock"))
    assert clock.clock > joints.header.stamp


def test_it_drives_as_commanded_and_its_frames_agree_with_the_truth(make_node: Any, subscribe: Subscribe) -> None:
    world = make_world((1, 1, 0.5))
    simulated = Simulator(make_node("flat_world", wall_time=True), world, Pace())
    driver = make_node("driver").advertise("cmd_vel", Twist)
    assert driver.wait_for_subscribers(timeout=PATIENCE)
    frames, fixed = subscribe("/tf", "tf2_msgs/TFMessage"), subscribe("/tf_static", "tf2_msgs/TFMessage")
    bumps = subscribe("/bumper", "std_msgs/Bool")
    command = Twist()
    command.linear.x, command.angular.z = 0.5, 0.1
    while world.odometry[0, 0] < 1.0:
        driver.publish(command)
        simulated.step()
    assert world.wheel_speeds[0] == pytest.approx([0.5, 0.1])
    buffer = Buffer()
    for transform in fixed.get(timeout=PATIENCE).transforms:
        buffer.set_transform_static(transform)
    received: TFMessage = frames.get(timeout=PATIENCE)
    while not frames.empty() or received.transforms[0].header.stamp.to_sec() * 40 < world.num_steps - 0.5:
        received = frames.get(timeout=PATIENCE)
    for transform in received.transforms:
        buffer.set_transform(transform)
    found = buffer.lookup_transform("map", "base_footprint", received.transforms[0].header.stamp).transform
    heading = 2 * atan2(found.rotation.z, found.rotation.w)
    assert [found.translation.x, found.translation.y, heading] == pytest.approx(world.poses[0].tolist())
    assert world.poses[0, :2] != pytest.approx(world.odometry[0, :2] + 1, abs=0.01)
    lens = buffer.lookup_transform("base_footprint", "camera_optical", received.transforms[0].header.stamp).transform
    assert (lens.translation.z, lens.rotation.w) == (0.5, pytest.approx(0.5))
    while bumps.empty() or not bumps.get().data:
        driver.publish(command)
        simulated.step()
    assert world.speeds[0, 0] < 0.25, "the wall holds it, though it may turn and slide along it"


@pytest.mark.parametrize(("speed", "turn"), [(nan, 0.0), (0.0, inf)])
def test_commands_that_are_not_numbers(
    make_node: Any, capfd: pytest.CaptureFixture[str], speed: float, turn: float
) -> None:
    world = make_world((1, 1, 0))
    simulated = Simulator(make_node("flat_world", wall_time=True), world, Pace())
    driver = make_node("driver").advertise("cmd_vel", Twist)
    assert driver.wait_for_subscribers(timeout=PATIENCE)
    command = Twist()
    command.linear.x, command.angular.z = speed, turn
    driver.publish(command)
    wait_for_line(capfd, "a command is ignored, since it is not a number: ")
    command.linear.x, command.angular.z = 0.1, 0.0
    while world.speeds[0, 0] < 0.05:
        driver.publish(command)
        simulated.step()
    assert np.isfinite(world.poses).all()


def test_several_robots_have_namespaces(make_node: Any, subscribe: Subscribe) -> None:
    world = make_world((1, 1, 0), (4, 4, 0))
    simulated = Simulator(make_node("flat_world", wall_time=True, namespace="/sim"), world, Pace(has_map_frame=False))
    scan = step_until(simulated, subscribe("/sim/robot2/scan", "sensor_msgs/LaserScan"))
    assert scan.header.frame_id == "robot2/laser" and scan.ranges[2] == pytest.approx(0.9)
    frames = step_until(simulated, subscribe("/tf", "tf2_msgs/TFMessage")).transforms
    names = [(each.header.frame_id, each.child_frame_id) for each in frames]
    assert names == [("robot1/odom", "robot1/base_footprint"), ("robot2/odom", "robot2/base_footprint")]
    driver = make_node("driver").advertise("/sim/robot2/cmd_vel", Twist)
    assert driver.wait_for_subscribers(timeout=PATIENCE)
    command = Twist()
    command.linear.x = -0.5
    while world.speeds[1, 0] > -0.2:
        driver.publish(command)
        simulated.step()
    assert world.speeds[0, 0] == 0


def test_nothing_is_computed_that_nobody_wants(make_node: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    world = make_world((1, 1, 0))
    simulated = Simulator(make_node("flat_world", wall_time=True), world, Pace())
    for name in ("scan", "picture"):
        monkeypatch.setattr(world, name, lambda robots, name=name: pytest.fail(name))
    for _ in range(8):
        simulated.step()


def test_reset_positions(make_node: Any) -> None:
    world = make_world((1, 1, 0))
    simulated = Simulator(make_node("flat_world", wall_time=True), world, Pace())
    world.command(0, 0.5, 0.0)
    for _ in range(8):
        simulated.step()
    assert world.poses[0, 0] > 1
    make_node("user").service("reset_positions", "std_srvs/Empty")()
    simulated.step()
    assert world.poses[0, 0] == 1 and world.num_steps == 9


@pytest.mark.parametrize(
    ("values", "problem"),
    [
        ({}, "set the parameter /flat_world/map to the YAML file of a map"),
        ({"map": "nowhere.yaml"}, "nowhere.yaml: cannot be read"),
        ({"map": "room.yaml", "robots": 50}, "the map has free places for"),
        ({"map": "fine.yaml"}, "fine.yaml: its resolution must be 0.002 m or more"),
        ({"map": "turned.yaml"}, "turned.yaml: the yaw of its origin must be 0"),
    ],
)
def test_worlds_that_cannot_be(
    room: Path, make_node: Any, monkeypatch: pytest.MonkeyPatch, values: dict[str, Any], problem: str
) -> None:
    monkeypatch.chdir(room.parent)
    (room.parent / "turned.yaml").write_text(YAML.format(0, 1.5))
    (room.parent / "fine.yaml").write_text(YAML.format(0, 0).replace("0.5", "1e-300"))
    node = make_node("flat_world")
    for name, value in values.items():
        node.params[f"~{name}"] = value
    with pytest.raises(Error, match=problem):
        make_simulator(node)


def test_parameters(room: Path, make_node: Any, subscribe: Subscribe) -> None:
    node: Node = make_node("flat_world", wall_time=True)
    wanted = {"x": 1.5, "y": 2, "yaw": 3.0, "rays": 10, "range_max": 1.0, "scan_rate": 10, "range_noise": 0.0}
    for name, value in {"map": str(room), "speed": "fast", "seed": -1, "localization": False, **wanted}.items():
        node.params[f"~{name}"] = value
    simulated = make_simulator(node)
    scan = step_until(simulated, subscribe("/scan", "sensor_msgs/LaserScan"))
    assert (len(scan.ranges), scan.range_max, scan.scan_time) == (10, 1.0, pytest.approx(0.1))
    assert set(scan.ranges) == {inf}  # all walls are farther than that, and there is no noise
    truth = step_until(simulated, subscribe("/base_pose_ground_truth", "nav_msgs/Odometry")).pose.pose
    assert (truth.position.x, truth.position.y) == (1.5, 2.0)
    assert len(step_until(simulated, subscribe("/tf", "tf2_msgs/TFMessage")).transforms) == 1


def test_a_start_in_a_wall_is_reported(room: Path, make_node: Any, capfd: pytest.CaptureFixture[str]) -> None:
    node: Node = make_node("flat_world", wall_time=True)
    node.params["~map"], node.params["~x"], node.params["~y"] = str(room), 100, 2
    make_simulator(node)
    wait_for_line(capfd, "the first robot has no room at x=100, y=2: it starts at x=")


@pytest.mark.parametrize(("speed", "seconds"), [(20, 1.0), (0, 1.0)])
def test_the_program(
    room: Path,
    environ: dict[str, str],
    monkeypatch: pytest.MonkeyPatch,
    make_node: Any,
    speed: float,
    seconds: float,
) -> None:
    """Simulated time goes as fast as wanted, and Ctrl-C ends it."""
    for name, value in environ.items():
        monkeypatch.setenv(name, value)
    user = make_node("user")
    reached = threading.Event()

    def on_clock(clock: Any) -> None:
        if clock.clock.to_sec() > seconds and not reached.is_set():
            reached.set()
            os.kill(os.getpid(), signal.SIGINT)

    user.subscribe("/clock", Clock, on_clock)
    assert simulator.main(["flat_world", f"_map:={room}", f"_speed:={speed}"]) == 0
    assert reached.is_set()


def test_the_program_without_a_map(
    environ: dict[str, str], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    for name, value in environ.items():
        monkeypatch.setenv(name, value)
    assert simulator.main(["flat_world"]) == 1
    assert "set the parameter /flat_world/map" in capfd.readouterr().err


def test_an_interrupt_during_the_start_is_no_error(
    environ: dict[str, str], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], room: Path
) -> None:
    for name, value in environ.items():
        monkeypatch.setenv(name, value)
    advertise = Node.advertise

    def advertise_too_late(node: Node, *args: Any, **options: Any) -> Any:
        node.shutdown()
        return advertise(node, *args, **options)

    monkeypatch.setattr(Node, "advertise", advertise_too_late)
    assert simulator.main(["flat_world", f"_map:={room}", "_x:=2.25", "_y:=1.75"]) == 0
    assert capfd.readouterr().err == ""
