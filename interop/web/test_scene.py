"""The scene in 3D: what is drawn, where it is, and what the mouse publishes."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from browsing import Browser, Web

from pyros1.msgs.geometry_msgs.msg import PoseStamped, TransformStamped
from pyros1.msgs.nav_msgs.msg import OccupancyGrid, Path
from pyros1.msgs.sensor_msgs.msg import LaserScan, PointCloud2, PointField
from pyros1.msgs.visualization_msgs.msg import Marker, MarkerArray
from pyros1.tf import StaticTransformBroadcaster
from pyros1.web.links import panel_link

SCENE = "document.querySelector('.scene')?.scene"
DISPLAYS = f"""Object.fromEntries([...{SCENE}.displays].map(
    ([topic, {{display}}]) => [topic, display.problem || display.status]))"""


def frame(parent: str, child: str, x: float, yaw: float = 0.0) -> TransformStamped:
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id = parent
    message.transform.translation.x = x
    message.transform.rotation.z, message.transform.rotation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return message


def shown(browser: Browser, link: str, **displays: str) -> None:
    """Open a scene, and wait until displays show these words."""
    topics = [f"/{name}" for name in displays]
    browser.open(panel_link(link, "scene", {"fixed": "map", "topics": topics}))
    for name, word in displays.items():
        browser.wait(f"{SCENE} && {DISPLAYS}['/{name}'] === arguments[0]", word)


def test_messages_are_where_their_frames_are(browser: Browser, web: Web, make_node: Callable[..., Any]) -> None:
    node = make_node("robot")
    StaticTransformBroadcaster(node).send_transform(
        [frame("map", "base", 2.0, math.pi / 2), frame("base", "laser", 1.0)]
    )
    scan = LaserScan(angle_increment=0.1, range_max=10.0, ranges=[1.0, 2.0, math.inf])
    points = np.array([[1, 2, 3], [4, 5, 6]], np.float32)
    fields = [PointField(name, 4 * index, 7, 1) for index, name in enumerate("xyz")]
    cloud = PointCloud2(height=1, width=2, fields=fields, point_step=12, row_step=24, data=points.tobytes())
    plan = Path(poses=[PoseStamped(), PoseStamped()])
    grid = OccupancyGrid(data=[0, 100, -1, 50])
    grid.info.width = grid.info.height = 2
    grid.info.resolution = 1.0
    markers = MarkerArray([Marker(ns="kinds", id=kind, type=kind) for kind in (1, 2, 3, 9)])
    for marker in markers.markers:
        marker.header.frame_id, marker.text = "base", "hello"
        marker.scale.x = marker.scale.y = marker.scale.z = marker.color.a = 1.0
    for name, message, place in [
        ("scan", scan, "laser"),
        ("cloud", cloud, "base"),
        ("plan", plan, "map"),
        ("grid", grid, "map"),
    ]:
        message.header.frame_id = place
        node.advertise(name, type(message), latch=True).publish(message)
    node.advertise("markers", MarkerArray, latch=True).publish(markers)
    words = {
        "scan": "2 points",
        "cloud": "2 points, colour: z",
        "plan": "2 poses",
        "grid": "2 \u00d7 2 cells",
        "markers": "4 markers",
    }
    shown(browser, web.link, **words)
    # the laser is 1 m ahead of the base, which looks along y
    place = browser.run(f"return {SCENE}.displays.get('/scan').display.object.position.toArray()")
    assert all(abs(one - other) < 1e-6 for one, other in zip(place, (2.0, 1.0, 0.0), strict=True))
    assert browser.run(f"return [...{SCENE}.frames.axes.keys()].sort()") == ["base", "laser", "map"]
    assert browser.run(f"return {SCENE}.stage.frames") > 0
    hidden = """const field = document.querySelector('.scene form.add input');
        const pen = new OffscreenCanvas(1, 1).getContext('2d');
        const { font, paddingLeft } = getComputedStyle(field);
        pen.font = font;
        return pen.measureText(field.placeholder).width + 2 * parseFloat(paddingLeft) - field.clientWidth;"""
    assert browser.run(hidden) <= 0, "pixels of the hint in the field for another robot"


def test_a_frame_that_is_not_connected_says_so(browser: Browser, web: Web, make_node: Callable[..., Any]) -> None:
    node = make_node("robot")
    StaticTransformBroadcaster(node).send_transform(frame("map", "base", 1.0))
    scan = LaserScan(angle_increment=0.1, range_max=10.0, ranges=[1.0])
    scan.header.frame_id = "elsewhere"
    node.advertise("scan", LaserScan, latch=True).publish(scan)
    shown(browser, web.link, scan="no transform to the frame elsewhere")
    browser.wait_for_text("no transform to the frame elsewhere")


def test_a_goal_is_dragged(browser: Browser, web: Web, make_node: Callable[..., Any]) -> None:
    node = make_node("robot")
    StaticTransformBroadcaster(node).send_transform(frame("map", "base", 1.0))
    goals: list[Any] = []
    node.subscribe("/move_base_simple/goal", PoseStamped, goals.append)
    browser.open(panel_link(web.link, "scene", {"fixed": "map"}))
    browser.wait(f"{SCENE} && {SCENE}.frames.axes.size === 2")
    browser.choose("select[aria-label=view]", "top")
    browser.click(".tools button", "Nav goal")
    drag = """
        const canvas = document.querySelector('.scene canvas'), box = canvas.getBoundingClientRect();
        const [button, pointers] = arguments;
        const at = (kind, x, y, pointerId) => canvas.dispatchEvent(new PointerEvent(kind, {
            bubbles: true, pointerId, button, pointerType: pointers[1] ? 'touch' : 'mouse',
            clientX: box.left + box.width * x, clientY: box.top + box.height * y}));
        canvas.setPointerCapture = canvas.releasePointerCapture = () => {};
        for (const id of pointers) at('pointerdown', 0.5, 0.5, id);
        at('pointermove', 0.5, 0.3, pointers[0]);
        for (const id of pointers) at('pointerup', 0.5, 0.3, id);
    """
    tool = "document.querySelector('.tools input[aria-label=\"topic of the tool\"]')"
    assert browser.run(f"return {tool}.value") == "/move_base_simple/goal"
    browser.run(drag, 2, [1])  # the right button moves the view
    browser.run(drag, 0, [1, 2])  # so do two fingers
    browser.click(".tools button", "Reset")
    browser.run(drag, 0, [1])
    browser.wait_for_text("to 1 subscriber")
    (goal,) = goals
    assert goal.header.frame_id == "map"
    assert abs(goal.pose.position.x) < 0.05  # the middle of the view from above, where x points up
    assert abs(goal.pose.position.y) < 0.05
    assert abs(goal.pose.orientation.z) < 0.02
    assert goal.header.stamp.to_sec() > 0
    others: list[Any] = []
    node.subscribe("/robot1/goal", PoseStamped, others.append)
    browser.click(".tools button", "Nav goal")
    browser.run("document.querySelector('.scene').dispatchEvent(new KeyboardEvent('keydown', {key: 'Escape'}))")
    assert browser.run(f"return {tool}.hidden")
    browser.click(".tools button", "Nav goal")
    browser.type(".tools input[aria-label='topic of the tool']", "robot1/goal")
    browser.run(drag, 0, [1])
    browser.wait_for_text("/robot1/goal: (")
    browser.wait_for_text("to 1 subscriber")
    assert (len(goals), len(others)) == (1, 1)
    assert "/robot1/goal" in browser.run("return localStorage['pyros1.layouts']")
