"""rosmsg, rossrv and rosmsg-proto against ours, on the definitions of this machine: no master is needed (L86-L89).

Feature: msg and srv print what rosmsg and rossrv print
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from harness import our_tools, stock_tools, write_tool

TYPES = [
    "std_msgs/String", "actionlib_msgs/GoalStatus", "geometry_msgs/TwistStamped", "sensor_msgs/Image",
    "sensor_msgs/JointState", "nav_msgs/Odometry", "nav_msgs/GetMapResult", "nav_msgs/GetMapAction",
    "trajectory_msgs/JointTrajectory", "visualization_msgs/MarkerArray", "sensor_msgs/RegionOfInterest",
    "geometry_msgs/PoseWithCovariance", "std_msgs/Empty", "dynamic_reconfigure/Config",
    "diagnostic_msgs/DiagnosticArray", "sensor_msgs/BatteryState", "nav_msgs/OccupancyGrid", "tf2_msgs/TFMessage",
    "stereo_msgs/DisparityImage",
]  # fmt: skip
SERVICES = [
    "std_srvs/SetBool",
    "std_srvs/Empty",
    "nav_msgs/GetPlan",
    "nav_msgs/SetMap",
    "dynamic_reconfigure/Reconfigure",
]

COMMANDS = [
    *(f"rosmsg show {name}" for name in TYPES),
    *(f"rosmsg-proto msg {name}" for name in TYPES),
    *(f"rossrv show {name}" for name in SERVICES),
    *(f"rosmsg-proto srv {name}" for name in SERVICES),
    "rosmsg",
    "rosmsg bogus",
    "rossrv",
    "rossrv bogus",
    "rosmsg info String",
    "rosmsg show Header",
    "rosmsg show -r geometry_msgs/Twist",
    "rosmsg show -r Twist",
    "rosmsg show std_msgs/String.msg",
    "rosmsg show geometry_msgs::Twist",
    "rosmsg show a.b",
    "rosmsg show nopkg/X",
    "rosmsg show std_msgs/Nope",
    "rosmsg show Nope",
    "rosmsg show -b /nope.bag std_msgs/String",
    "rosmsg md5 std_msgs/String",
    "rosmsg md5 String",
    "rosmsg md5 Nope",
    "rosmsg md5 std_msgs/Nope",
    "rosmsg package std_msgs",
    "rosmsg package -s geometry_msgs",
    "rosmsg package std_srvs",
    "rosmsg package nope",
    "rossrv show SetBool",
    "rossrv show -r Trigger",
    "rossrv show nope/X",
    "rossrv md5 std_srvs/SetBool",
    "rossrv md5 SetBool",
    "rossrv package std_srvs",
    "rossrv package -s std_srvs",
    "rosmsg-proto msg -e sensor_msgs/JointState",
    "rosmsg-proto msg -x stamp,frame_id,x geometry_msgs/PoseStamped",
    "rosmsg-proto msg -p xx sensor_msgs/JointState",
    "rosmsg-proto msg -H sensor_msgs/JointState",
    "rosmsg-proto msg -f 0 sensor_msgs/JointState",
    "rosmsg-proto msg -f 1 nav_msgs/Path",
    "rosmsg-proto msg String",
    "rosmsg-proto msg nope/X",
    "rosmsg-proto msg -s nope/X",
    "rosmsg-proto msg",
]


def ask(program: Path, words: list[str], stdin: str = "") -> tuple[int, str, str]:
    environ = {name: value for name, value in os.environ.items() if name != "ROS_PACKAGE_PATH"}
    environ["ROS_PACKAGE_PATH"] = "/usr/share"
    tools = stock_tools() if program.parent == Path("/usr/bin") else our_tools()
    return tools.ask([str(program), *words], environ, stdin=stdin)


@pytest.fixture(scope="module")
def tools(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("tools")
    for name in ("rosmsg", "rossrv", "rosmsg-proto"):
        write_tool(folder, name)
    return folder


def both(tools: Path, command: str, stdin: str = "") -> tuple[tuple[int, str, str], tuple[int, str, str]]:
    program, *words = command.split()
    with ThreadPoolExecutor(2) as pool:
        stock = pool.submit(ask, Path("/usr/bin") / program, words, stdin)
        ours = pool.submit(ask, tools / program, words, stdin)
    return stock.result(), ours.result()


@pytest.mark.parametrize("command", COMMANDS)
def test_output_and_exit_code(tools: Path, command: str) -> None:
    """Standard output and exit code are stock's; error texts are shorter and say what may have been meant."""
    stock, ours = both(tools, command)
    assert ours[:2] == stock[:2]
    assert bool(ours[2]) == bool(stock[2])


@pytest.mark.parametrize("command", ["rosmsg show", "rosmsg md5", "rossrv show"])
def test_the_type_may_come_through_a_pipe(tools: Path, command: str) -> None:
    name = "std_srvs/Trigger\n" if "srv" in command else "geometry_msgs/Point\n"
    stock, ours = both(tools, command, name)
    assert ours[:2] == stock[:2] and ours[0] == 0


def test_lists_hold_all_that_stock_lists(tools: Path) -> None:
    """Ours also knows the definitions that come with pyros1."""
    for command in ("rosmsg list", "rossrv list"):
        stock, ours = both(tools, command)
        assert set(stock[1].split()) <= set(ours[1].split()) and ours[1].split() == sorted(ours[1].split())
    for command in ("rosmsg packages -s", "rossrv packages"):
        stock, ours = both(tools, command)
        assert set(stock[1].split()) <= set(ours[1].split())
