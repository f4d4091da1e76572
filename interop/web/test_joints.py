"""The panel of joints: its sliders move the robot."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from browsing import Browser, Web
from harness import until

import pyros1.bag
from pyros1.ground.timing import Time
from pyros1.msgs.sensor_msgs.msg import JointState
from pyros1.node import Node
from pyros1.tf import Buffer, TransformListener
from pyros1.urdf import joint_publisher
from pyros1.urdf.kinematics import Kinematics
from pyros1.urdf.reading import read_robot
from pyros1.urdf.state_publisher import RobotStatePublisher, Settings

PACKAGES = Path(pyros1.__file__).parent / "packages"
ROBOT = (PACKAGES / "two_wheeler" / "urdf" / "two_wheeler.urdf").read_text()
PATIENCE = 40.0
Make = Callable[..., Any]
ROW = "document.querySelector('[data-joint=\"{}\"]')"
SLIDE = "const slider = arguments[0].querySelector('input[type=range]'); slider.value = arguments[1];"
SLIDE += "slider.dispatchEvent(new Event('input', {bubbles: true}));"


@pytest.fixture
def robot(make_node: Make) -> Iterator[Buffer]:
    """The example with its nodes; its frames as another node hears them."""
    node: Node = make_node("joint_state_publisher")
    node.params["/robot_description"] = ROBOT
    RobotStatePublisher(make_node("robot_state_publisher"), Kinematics(read_robot(ROBOT)), Settings())
    running = threading.Thread(target=joint_publisher.make_publisher(node).run)
    running.start()
    buffer = Buffer()
    TransformListener(make_node("ear"), buffer)
    yield buffer
    node.shutdown()
    running.join(PATIENCE)


def height(buffer: Buffer, frame: str) -> float:
    return float(buffer.lookup_transform("base_footprint", frame).transform.translation.z)


def test_a_slider_moves_the_robot(browser: Browser, web: Web, robot: Buffer) -> None:
    """Feature: joint_state_publisher_gui: sliders on the page move the robot's frames -- `pyros1 launch
    two_wheeler display.launch`
    """
    assert robot.can_transform("base_footprint", "lift", timeout=PATIENCE)
    low = height(robot, "lift")
    browser.open(web.page("joints"))
    browser.wait("document.querySelector('[data-panel=scene]')")  # the tab begins with both
    browser.wait(f"{ROW.format('lift_joint')} && !{ROW.format('lift_joint')}.querySelector('input').disabled")
    row = browser.run(f"return {ROW.format('lift_joint')}")
    browser.run(SLIDE, row, 0.2)
    until(lambda: abs(height(robot, "lift") - low - 0.2) < 1e-6, "the lift is 0.2 m higher")
    follower = f"{ROW.format('right_finger_joint')}.querySelector('.joints-number').value"
    browser.run(SLIDE, browser.run(f"return {ROW.format('left_finger_joint')}"), 0.03)
    browser.wait(f"{follower} === '0.03'")
    browser.click(".tools button", "Centre")
    browser.wait(f"{follower} === '0'")
    browser.type("[data-joint=arm_joint] .joints-number", "5")  # cut at the limit
    browser.wait(f"{ROW.format('arm_joint')}.querySelector('.joints-number').value === '1'")
    browser.click(".tools button", "rad")
    browser.wait(f"{ROW.format('arm_joint')}.querySelector('.joints-number').value === '57.3'")
    browser.click(".tools button", "Randomize")
    browser.wait(f"{follower} !== '0'")
    browser.type("[aria-label='find joints']", "finger")
    assert browser.run("return [...document.querySelectorAll('.joints-row')].filter((row) => !row.hidden).length") == 2


def test_publishing_from_the_page_until_a_driver_comes(browser: Browser, web: Web, make_node: Make) -> None:
    browser.open(web.page("joints"))
    browser.wait_for_text("No robot here")
    node = make_node("user")
    node.params["/robot_description"] = ROBOT
    came: list[Any] = []
    node.subscribe("/joint_states", JointState, came.append)
    browser.wait_for_text("No node publishes /joint_states")
    browser.click(".joints-hint button", "Publish from here")
    browser.wait(f"!{ROW.format('pan_joint')}.querySelector('input').disabled")
    browser.run(SLIDE, browser.run(f"return {ROW.format('pan_joint')}"), 1.3)
    browser.wait(f"{ROW.format('pan_joint')}.querySelector('.joints-number').value.startsWith('1.3')")
    until(lambda: came and 1.3 in came[-1].position, "the joint is published where the slider is")
    make_node("driver").advertise("/joint_states", JointState)
    browser.wait_for_text("View only: /driver does not accept positions from here.")
    browser.wait(f"{ROW.format('pan_joint')}.querySelector('input').disabled")


def test_a_slider_is_where_the_robot_says_also_if_it_says_so_at_once(
    browser: Browser, web: Web, make_node: Make
) -> None:
    driver = make_node("driver")
    driver.params["/robot_description"] = ROBOT
    states = driver.advertise("/joint_states", JointState, latch=True)
    states.publish(JointState(name=["lift_joint"], position=[0.0]))
    asked: list[float] = []

    def moves_half_the_way(message: Any) -> None:
        asked.extend(message.position)
        states.publish(JointState(name=["lift_joint"], position=[message.position[0] / 2]))

    driver.subscribe("/driver/sliders", JointState, moves_half_the_way)
    browser.open(web.page("joints"))
    browser.wait(f"{ROW.format('lift_joint')}?.querySelector('input').disabled === false")
    browser.run(SLIDE, browser.run(f"return {ROW.format('lift_joint')}"), 0.2)
    until(lambda: asked == [0.2], "the driver is asked")
    browser.wait(f"{ROW.format('lift_joint')}.querySelector('.joints-number').value === '0.1'")


STOCK = Path("/usr/lib/joint_state_publisher/joint_state_publisher")


@pytest.mark.skipif(not STOCK.exists(), reason="joint-state-publisher is not installed; run interop/setup")
def test_stocks_joint_state_publisher_is_moved_by_its_source_list(
    browser: Browser, web: Web, environ: dict[str, str], make_node: Make
) -> None:
    params = make_node("user").params
    params["/robot_description"] = ROBOT
    params["/joint_state_publisher/source_list"] = ["wanted"]
    process = subprocess.Popen(["/usr/bin/python3", STOCK], env={**os.environ, **environ}, stderr=subprocess.DEVNULL)
    try:
        browser.open(web.page("joints"))
        browser.wait(f"{ROW.format('lift_joint')}?.querySelector('input').disabled === false")
        browser.run(SLIDE, browser.run(f"return {ROW.format('left_finger_joint')}"), 0.03)
        browser.wait(f"{ROW.format('right_finger_joint')}.querySelector('.joints-number').value === '0.03'")
    finally:
        process.terminate()
        process.wait(PATIENCE)


def test_on_a_phone_and_in_the_dark(browser: Browser, start_web: Callable[..., Web], robot: Buffer) -> None:
    browser.resize(390, 800)
    browser.open(start_web("--read-only").page("joints"))
    browser.wait(f"{ROW.format('tilt_joint')}?.querySelector('input').disabled")
    assert browser.run("return document.documentElement.scrollWidth") <= 390


def test_the_node_joint_state_publisher_gui_opens_the_panel(
    browser: Browser, environ: dict[str, str], make_node: Make
) -> None:
    make_node("user").params["/robot_description"] = ROBOT
    script = PACKAGES / "joint_state_publisher_gui" / "scripts" / "joint_state_publisher_gui"
    process = subprocess.Popen(
        [sys.executable, script],
        env={**os.environ, **environ, "BROWSER": "true"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    try:
        assert process.stdout is not None
        link = re.search(
            r"http://localhost:\d+/\?token=\S+#joints", next(line for line in process.stdout if "#" in line)
        )
        assert link
        browser.open(link[0])
        browser.wait(f"{ROW.format('lift_joint')}?.querySelector('input').disabled === false")
        browser.driver.get("about:blank")
    finally:
        process.terminate()
        rest, _ = process.communicate(timeout=20)
    assert "Traceback" not in rest, rest


def test_joints_of_a_recording(
    browser: Browser, web: Web, make_node: Make, start_program: Callable[..., Any], tmp_path: Path
) -> None:
    with pyros1.bag.open(tmp_path / "joints.bag", "w") as bag:
        for step in range(50):
            stamp = Time(1_700_000_000, step * 10_000_000)
            state = JointState(name=["lift_joint", "arm_joint"], position=[0.125, 0.5])
            state.header.stamp = stamp
            bag.write("/joint_states", state, stamp)
    make_node("robot").params["/robot_description"] = ROBOT
    start_program("bag", "play", "--loop", "--quiet", str(tmp_path / "joints.bag"))
    browser.open(web.page("joints"))
    for joint, value in (("lift_joint", "0.125"), ("arm_joint", "0.5")):
        browser.wait(f"{ROW.format(joint)}?.querySelector('.joints-number').value === arguments[0]", value)
    browser.wait_for_text("View only")
