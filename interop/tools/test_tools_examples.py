"""The examples of `pyros1 pkg create --example`, run as their users do: each in each face, and what it does is seen."""

from __future__ import annotations

import importlib.util
import math
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy
import pytest
from harness import SOURCE, until

from pyros1.guide.catalogue import APIS, CATALOGUE
from pyros1.msgs.actionlib_msgs.msg import GoalStatus
from pyros1.msgs.geometry_msgs.msg import Twist, Vector3
from pyros1.reconfigure import Client
from pyros1.testing import Program
from pyros1.tf import Buffer, TransformListener

Start = Callable[..., Any]
pytestmark = pytest.mark.ours_only


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a package for each face, which has all examples of that face."""
    folder = tmp_path_factory.mktemp("workspace")
    for face in APIS:
        words = [word for each in CATALOGUE if face in each.apis for word in ("--example", each.name)]
        command = [sys.executable, "-m", "pyros1", "pkg", "create", f"in_{face}", "--face", face, *words]
        environ = {**os.environ, "PYTHONPATH": str(SOURCE)}
        made = subprocess.run(
            command, cwd=folder, env=environ, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60,
            check=False,
        )  # fmt: skip
        assert (made.returncode, made.stderr) == (0, "")
    return folder


@pytest.fixture
def shell(workspace: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Programs are found as in a shell in the folder, with this Python."""
    ours = SOURCE / "pyros1" / "packages"  # before those of a stock ROS on this machine
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"{workspace}:{ours}")
    monkeypatch.setenv("PYTHONPATH", str(SOURCE))
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}:{os.environ['PATH']}")
    monkeypatch.chdir(workspace)


@pytest.fixture(params=APIS)
def package(request: pytest.FixtureRequest, shell: None) -> str:
    """The package of a face."""
    return f"in_{request.param}"


@pytest.fixture
def run(shell: None, ros_run: Start) -> Iterator[Start]:
    """`pyros1 run`; Ctrl-C ends each program without a traceback, or it has ended without one."""
    yield from quiet(ros_run)


@pytest.fixture
def launch(shell: None, ros_launch: Start) -> Iterator[Start]:
    """`pyros1 launch`, likewise."""
    yield from quiet(ros_launch)


def quiet(start: Start) -> Iterator[Start]:
    """Give what starts programs; afterwards end them, and look at what they printed."""
    programs: list[Program] = []

    def begin(*words: object, **options: Any) -> Program:
        programs.append(start(*words, **options))
        return programs[-1]

    yield begin
    for program in programs:
        program.stop()
        assert "Traceback" not in program.output, program.output


def stock(*words: str) -> str:
    """Run a tool of stock; return what it prints."""
    done = subprocess.run(words, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=30, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_publisher_and_subscriber(package: str, run: Start, ros_listen: Start) -> None:
    numbers = ros_listen("numbers", "std_msgs/Float64")
    run(package, "publisher.py", "_rate:=50")
    assert all(-1.0 <= message.data <= 1.0 for message in numbers.wait(5))
    subscriber = run(package, "subscriber.py")
    subscriber.wait_for(r"\[INFO\] .*: -?[01]\.\d+, the mean of 3 numbers is -?[01]\.\d+")
    assert "data: " in stock("rostopic", "echo", "-n", "1", "/numbers")


def test_service(package: str, run: Start, ros_master: Any) -> None:
    run(package, "divide_server.py")
    client = run(package, "divide_client.py", "7", "2")
    client.wait_for(r"^7 / 2 = 3\.5$")
    assert client.wait() == 0
    refused = run(package, "divide_client.py", "1", "0")
    refused.wait_for("no answer: .*the divisor is 0")
    assert refused.wait() == 1
    assert stock("rosservice", "type", "/divide").strip() == f"{package}/Divide"


def test_timer(package: str, run: Start, ros_listen: Start) -> None:
    lamp = ros_listen("lamp", "std_msgs/Bool")
    blinker = run(package, "blinker.py", "_period:=0.05", "_duration:=4.0")
    first, second, third = lamp.wait(3)
    assert first.data != second.data != third.data
    blinker.wait_for("blinked long enough")
    assert blinker.wait() == 0 and lamp.messages[-1].data is False


def test_parameters(package: str, launch: Start, ros_node: Start, ros_listen: Start) -> None:
    limited = ros_listen("cmd_vel_limited", "geometry_msgs/Twist")
    launched = launch(package, "speed_limiter.launch")
    launched.wait_for("mower has the wheels: left, right")
    node = ros_node("driver")
    fast = node.advertise("cmd_vel", "geometry_msgs/Twist", latch=True)
    fast.publish(Twist(linear=Vector3(x=2.0)))
    assert limited.next().linear.x == 0.5 and node.params["/speed_limiter/wheel_count"] == 2
    node.params["/speed_limiter/limits/linear"] = 0.2

    def slower() -> bool:
        fast.publish(Twist(linear=Vector3(x=-2.0)))
        return bool(limited.next().linear.x == -0.2)

    until(slower, "the new limit")


def test_launch(package: str, launch: Start, ros_node: Start, ros_listen: Start) -> None:
    words = ros_listen("/r2/words", "std_msgs/String")
    launched = launch(package, "robot.launch", "robot:=r2", "rate:=20")
    assert words.next().data == "hello from /r2/talker"
    launched.wait_for("heard: hello from /r2/talker")
    assert ros_node("looking").params["/robot_name"] == "r2"
    nodes = stock("rosnode", "list").split()
    assert {"/r2/talker", "/r2/listener"} <= {*nodes}


def test_action(package: str, run: Start, ros_listen: Start) -> None:
    run(package, "count_server.py")
    client = run(package, "count_client.py", "3")
    client.wait_for("^counted 3$")
    assert client.wait() == 0 and "now 2\n" in client.output
    stopped = run(package, "count_client.py", "500", "--patience", "0.5")
    stopped.wait_for(r"^that takes too long\n(now \d+\n)*not done: .*PREEMPTED")
    refused = run(package, "count_client.py", "--", "-1")
    refused.wait_for("not done: .*ABORTED.* not be negative")
    assert (stopped.wait(), refused.wait()) == (1, 1)
    statuses = ros_listen("count/status", "actionlib_msgs/GoalStatusArray")
    interrupted = run(package, "count_client.py", "400")
    interrupted.wait_for("^now 3")
    running = statuses.first(lambda message: any(each.status == GoalStatus.ACTIVE for each in message.status_list))
    goal = next(each.goal_id.id for each in running.status_list if each.status == GoalStatus.ACTIVE)
    interrupted.stop()
    ended = (goal, GoalStatus.PREEMPTED)
    statuses.first(lambda message: ended in [(each.goal_id.id, each.status) for each in message.status_list])
    assert stock("rostopic", "type", "/count/goal").strip() == f"{package}/CountActionGoal"


def test_reconfigure(package: str, run: Start, ros_listen: Start, ros_node: Start) -> None:
    output = ros_listen("output", "std_msgs/Float64")
    oscillator = run(package, "oscillator.py")
    oscillator.wait_for("amplitude 1.0, frequency 0.5 Hz")
    Client(ros_node("tuner"), "oscillator").update({"amplitude": 2.5, "shape": 1})
    assert output.first(lambda message: abs(message.data) == 2.5)
    oscillator.wait_for("amplitude 2.5")


def test_tf(package: str, run: Start, ros_master: Any) -> None:
    listener = run(package, "tf_listener.py", "world", "laser")
    listener.wait_for("no position yet: ")
    run(package, "tf_broadcaster.py")
    place = listener.wait_for(r"laser is at x = (\S+), y = (\S+), z = 0\.30 m")
    assert math.hypot(float(place[1]), float(place[2])) == pytest.approx(math.hypot(2.0, 0.2), abs=0.02)


def test_urdf(package: str, launch: Start, ros_node: Start) -> None:
    launch(package, "arm.launch")
    buffer = Buffer()
    with TransformListener(ros_node("looking"), buffer):
        found = buffer.lookup_transform("upper_arm", "right_link", timeout=20.0).transform.translation
        assert -0.05 <= found.y <= -0.02 and found.z == 0.5
        start = buffer.lookup_transform("base_link", "upper_arm").transform.rotation.y
        until(lambda: buffer.lookup_transform("base_link", "upper_arm").transform.rotation.y != start, "a movement")


def test_image(package: str, run: Start, ros_listen: Start) -> None:
    edges = ros_listen("edges", "sensor_msgs/Image")
    run(package, "edges.py")
    run(package, "picture_source.py")
    image = edges.next()
    assert (image.width, image.height, image.encoding, image.header.frame_id) == (320, 240, "mono8", "camera")
    bright = numpy.frombuffer(image.data, numpy.uint8).reshape(240, 320) > 100
    assert 200 < bright.sum() < 1000  # the outline of a square of 60 pixels
    assert bright[85:155].any() and not bright[:80].any()


def test_cloud(package: str, run: Start, ros_listen: Start) -> None:
    filtered = ros_listen("filtered", "sensor_msgs/PointCloud2")
    run(package, "cloud_filter.py", "_cube:=0.2")
    run(package, "cloud_source.py")
    cloud = filtered.next()
    points = numpy.frombuffer(cloud.data, "<f4").reshape(-1, 3)
    assert 10 < cloud.width == len(points) < 200 and cloud.header.frame_id == "camera"
    assert (points[:, 2] > 0.05).all() and (abs(points[:, :2]) < 0.31).all()  # the ball, without the floor


def test_bag(package: str, run: Start, tmp_path: Path) -> None:
    bag = str(tmp_path / "drive.bag")
    assert run(package, "write_bag.py", bag).wait() == 0
    assert re.search(r"^messages: +1200$", stock("rosbag", "info", bag), re.M)
    if importlib.util.find_spec("pandas") is None:
        pytest.skip("pandas is not installed")
    analysis = run(package, "analyse_bag.py", bag)
    analysis.wait_for(r"^driven: 19\.1\d m\nstood still: [45]\d% of the time\nmean speed, every 10 s: 0\.\d\d, ")
    other = run(package, "analyse_bag.py", bag, "/odo")
    other.wait_for("/odo")
    assert (analysis.wait(), other.wait()) == (0, 1)
    (tmp_path / "pandas.py").write_text("raise ImportError")
    lacking = run(package, "analyse_bag.py", bag, environ={"PYTHONPATH": f"{tmp_path}:{SOURCE}"})
    lacking.wait_for("^this needs pandas: pip install pandas$")
    assert lacking.wait() == 1


def test_asyncio(run: Start, ros_listen: Start, ros_node: Start) -> None:
    average = ros_listen("average", "std_msgs/Float64")
    averager = run("in_node", "averager.py")
    node = ros_node("counter")
    numbers = node.advertise("numbers", "std_msgs/Float64", latch=True)
    numbers.publish(data=1.0)
    assert average.first().data == 1.0
    numbers.publish(data=4.0)
    assert average.first(lambda message: message.data == 2.5)
    node.service("reset", "std_srvs/Empty")()
    numbers.publish(data=7.0)
    assert average.first(lambda message: message.data == 7.0)
    assert averager.stop() == 0


def test_test(package: str, workspace: Path, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", f"{package}/tests"]
    asked = subprocess.run(
        command, cwd=workspace, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    assert asked.returncode == 0 and "3 passed" in asked.stdout, asked.stdout
    command = [sys.executable, "-m", "pyros1", "test", package, "doubler.test"]
    asked = subprocess.run(
        command, cwd=workspace, env={**os.environ, "ROS_HOME": str(tmp_path)}, stdin=subprocess.DEVNULL,
        capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    assert (
        asked.returncode == 0 and f"[{package}.rosunit-check_doubler/test_a_number_is_doubled][passed]" in asked.stdout
    )
