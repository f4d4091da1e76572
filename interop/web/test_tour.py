"""The tour of the page: the tutorial's simulator in every view, as pictures.

To make the pictures anew: ``PYROS1_PICTURES=.github/pictures python -m pytest interop/web/test_tour.py``
"""

from __future__ import annotations

import io
import math
import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browsing import Browser, Web
from PIL import Image

import pyros1.bag
from pyros1.ground.timing import Time
from pyros1.guide.documents import pages, steps
from pyros1.msgs import load_message
from pyros1.msgs.geometry_msgs.msg import PoseStamped, TransformStamped
from pyros1.msgs.nav_msgs.msg import OccupancyGrid
from pyros1.msgs.nav_msgs.msg import Path as Plan
from pyros1.msgs.sensor_msgs.msg import JointState, LaserScan
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.tf import StaticTransformBroadcaster
from pyros1.urdf.kinematics import Kinematics
from pyros1.urdf.reading import read_robot
from pyros1.urdf.state_publisher import RobotStatePublisher, Settings
from pyros1.web.links import panel_link

CURVES = "document.querySelector('.plot')?.plot?.curves"
GRAPH = "document.querySelector('.graph')?.graph"
SCENE = "document.querySelector('.scene')?.scene"
ROOT = Path(__file__).parents[2]
SHIPPED = Path(pyros1.__file__).parent / "web" / "page" / "pictures"
GUIDE = {file for step in steps() for file in re.findall(r"pictures/(\w+)\.webp", step.text)}
"""Pictures that the guide shows in the browser, too, so they are in the wheel."""
ROBOT = Path(pyros1.__file__).parent / "packages" / "two_wheeler" / "urdf" / "two_wheeler.urdf"


@pytest.fixture
def take(browser: Browser, tmp_path: Path) -> Callable[[str], None]:
    """Return a function that takes a picture of the page, and looks whether anything is in it."""
    folder = Path(os.environ.get("PYROS1_PICTURES") or tmp_path)
    folder.mkdir(parents=True, exist_ok=True)

    def take(name: str) -> None:
        file = folder / f"{name}.png"
        browser.resize(1280, 720)
        browser.run("return new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        browser.picture(file)
        picture = Image.open(io.BytesIO(file.read_bytes())).convert("RGB")
        assert picture.size == (1280, 720)
        colours = picture.getcolors(1280 * 720) or []
        assert len(colours) > 50, f"{name}: only {len(colours)} colours"
        assert max(count for count, _ in colours) < 0.98 * 1280 * 720, f"{name} is empty"
        picture.save(file, optimize=True)
        if name in GUIDE:
            place = SHIPPED if "PYROS1_PICTURES" in os.environ else folder
            picture.save(place / f"{name}.webp", quality=70, method=6)

    return take


def test_the_simulator_in_all_views(
    browser: Browser,
    web: Web,
    take: Callable[[str], None],
    start_program: Callable[..., Any],
    make_node: Callable[..., Any],
) -> None:
    start_program("launch", "minimal_nodes", "minimal_simulator.launch")
    browser.open(panel_link(web.link, "plot", {"curves": ["/velocity/data", "/force_cmd/data"]}))
    browser.wait(f"{CURVES}?.length === 2 && {CURVES}.every((each) => each.points.size)")
    node = make_node("commander")
    publisher = node.advertise("vel_cmd", Float64)
    assert publisher.wait_for_subscribers(timeout=20)
    for goal in (1.0, 0.0):
        publisher.publish(Float64(goal))
        node.log.info("the commanded velocity is %s", goal)
        browser.wait("Math.abs(document.querySelector('.chip .value').textContent - arguments[0]) < 0.01", goal)
    take("plot")
    browser.open(web.page("graph"))
    browser.wait(
        f"{GRAPH}?.model?.edges.length === 6 && {GRAPH}.model.edges.every((edge) => edge.links[0].hz !== null)"
    )
    take("graph")
    browser.open(web.page("console"))
    browser.wait_for_text("the commanded velocity is 1.0")
    take("console")
    browser.click("#bar button", "Layouts")
    browser.click(".layouts .title", "Tutorial")
    browser.wait(f"{CURVES}?.some((each) => each.points.size) && document.querySelectorAll('.panel').length === 4")
    publisher.publish(Float64(1.0))
    browser.wait("Math.abs(document.querySelector('.chip .value').textContent - 1) < 0.01")
    take("tutorial")


def test_a_recorded_run(
    browser: Browser, start_web: Callable[..., Web], take: Callable[[str], None], tmp_path: Path
) -> None:
    number, text = load_message("std_msgs/Float64"), load_message("std_msgs/String")
    with pyros1.bag.open(tmp_path / "run.bag", "w") as bag:
        for index in range(3000):
            seconds = index / 100
            stamp = Time(1_700_000_000 + index // 100, index % 100 * 10_000_000)
            goal = float(int(seconds / 6) % 2)
            bag.write("/velocity", number(goal + (1 - 2 * goal) * math.exp(-(seconds % 6))), stamp)
            if index % 10 == 0:
                bag.write("/force_cmd", number((2 * goal - 1) * math.exp(-(seconds % 6))), stamp)
            if index % 600 == 0:
                bag.write("/event", text(f"the commanded velocity is {goal}"), stamp)
    web = start_web("--bags", str(tmp_path))
    browser.open(web.page("bag"))
    browser.click(".files .entry.file", "run.bag")
    browser.wait("document.querySelectorAll('.timeline .row').length === 3")
    browser.click(".timeline .name", "/event")
    browser.wait_for_text("the commanded velocity is 0.0")
    take("bag")


def frame(parent: str, child: str) -> TransformStamped:
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id = parent
    message.transform.rotation.w = 1.0
    return message


def room() -> tuple[OccupancyGrid, LaserScan, Plan]:
    """A map of a room, a scan of its walls, and a way through it."""
    cells = np.full((140, 180), -1, np.int8)
    cells[10:130, 10:170] = 0
    cells[[10, 129], 10:170] = cells[10:130, 10] = cells[10:130, 169] = 100
    grid = OccupancyGrid(data=cells.ravel().tolist())
    grid.info.width, grid.info.height, grid.info.resolution = 180, 140, 0.025
    grid.info.origin.position.x, grid.info.origin.position.y = -2.25, -1.75
    grid.info.origin.orientation.w = 1.0
    angles = np.linspace(-math.pi, math.pi, 720)
    walls = np.minimum(2 / np.maximum(np.abs(np.cos(angles)), 0.01), 1.5 / np.maximum(np.abs(np.sin(angles)), 0.01))
    scan = LaserScan(angle_min=-math.pi, angle_increment=math.tau / 719, range_max=20.0, ranges=walls.tolist())
    plan = Plan()
    for step in range(60):
        pose = PoseStamped()
        pose.pose.position.x, pose.pose.position.y = step / 35, math.sin(step / 12) / 2
        plan.poses.append(pose)
    for message in (grid, scan, plan):
        message.header.frame_id = "map"
    return grid, scan, plan


def test_a_robot_in_space(
    browser: Browser, web: Web, take: Callable[[str], None], make_node: Callable[..., Any]
) -> None:
    node = make_node("robot")
    model = read_robot(ROBOT.read_text())
    node.params["/robot_description"] = ROBOT.read_text()
    RobotStatePublisher(make_node("robot_state_publisher"), Kinematics(model), Settings())
    pose = {"lift_joint": 0.1, "arm_joint": 0.5, "wrist_joint": -0.6, "left_finger_joint": 0.01}
    names = re.findall(r'<joint name="(\w+)" type="(?!fixed)', ROBOT.read_text())
    state = JointState(name=names, position=[pose.get(name, 0.0) for name in names])
    joints = node.advertise("joint_states", JointState)

    def move(_: object) -> None:
        state.header.stamp = node.now()
        joints.publish(state)

    node.timer(0.1, move)
    StaticTransformBroadcaster(node).send_transform(frame("map", "base_footprint"))
    for name, message in zip(("map", "scan", "plan"), room(), strict=True):
        node.advertise(name, type(message), latch=True).publish(message)
    view = {"name": "orbit", "position": [2.6, -1.9, 1.9], "target": [0.3, 0, 0.1], "zoom": 1}
    settings = {"fixed": "map", "topics": ["/map", "/scan", "/plan"], "hidden": ["frames"], "view": view}
    browser.open(panel_link(web.link, "scene", settings))
    browser.wait(f"{SCENE} && [...{SCENE}.displays.values()].filter((each) => each.display.status).length >= 4")
    browser.wait(f"{SCENE}.displays.get('robot:/robot_description')?.display.problem === ''")
    take("scene")
    browser.open(web.page("joints"))
    browser.wait(f"{SCENE}?.displays.get('robot:/robot_description')?.display.problem === ''")
    browser.wait("document.querySelectorAll('[data-joint]').length >= 7")
    take("joints")


def test_readme_and_guide_show_the_pictures() -> None:
    texts = [(ROOT / "README.md").read_text(encoding="utf-8"), *(page.text for page in pages().values())]
    shown = {name for text in texts for name in re.findall(r"[(/]\.github/pictures/(\w+)\.png\)", text)}
    there = {each.stem for each in (ROOT / ".github" / "pictures").glob("*.png")}
    assert shown == there == {"tutorial", "graph", "plot", "console", "bag", "scene", "joints"}
