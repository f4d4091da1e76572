"""What one selects in the 3D scene says whose it is; and how hard joints work."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from browsing import Browser, Web

from pyros1.msgs.geometry_msgs.msg import TransformStamped
from pyros1.msgs.sensor_msgs.msg import JointState, PointCloud2, PointField
from pyros1.msgs.visualization_msgs.msg import Marker
from pyros1.tf import StaticTransformBroadcaster
from pyros1.web.links import panel_link

SCENE = "document.querySelector('.scene')?.scene"
MOUSE = f"""
    const {{stage}} = {SCENE}, {{canvas}} = stage, box = canvas.getBoundingClientRect();
    canvas.setPointerCapture = canvas.releasePointerCapture = () => {{}};
    const fire = (kind, [x, y]) => canvas.dispatchEvent(new PointerEvent(kind, {{
        bubbles: true, pointerId: 1, button: 0, clientX: x, clientY: y, shiftKey: arguments[2]}}));
    const at = (place, more) => {{
        const {{x, y}} = stage.controls.target.clone().set(...place).project(stage.camera);
        return [box.left + (x + 1) / 2 * box.width + more, box.top + (1 - y) / 2 * box.height + more];
    }};
    const [from, to] = [at(arguments[0], -arguments[1]), at(arguments[0], arguments[1])];
    fire('pointerdown', from); fire('pointermove', to); fire('pointerup', to);
    return [...document.querySelectorAll('.selection section')].map((each) =>
        [each.querySelector('h4').textContent, ...[...each.querySelectorAll('dd')].map((value) => value.textContent)]);
"""
URDF = """<robot name="arm"><link name="base"/><link name="upper"/><link name="lower"/>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
<limit effort="20" velocity="1"/></joint>
<joint name="slider" type="prismatic"><parent link="upper"/><child link="lower"/><axis xyz="0 0 1"/></joint></robot>"""


def display(key: str) -> str:
    return f"{SCENE}?.displays.get('{key}')?.display"


def frame(parent: str, child: str, x: float) -> TransformStamped:
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id, message.transform.translation.x, message.transform.rotation.w = parent, x, 1.0
    return message


@pytest.fixture
def robot(make_node: Callable[..., Any]) -> Any:
    """A robot with the frames map, base, upper and lower, 3 m from each other."""
    node = make_node("robot")
    StaticTransformBroadcaster(node).send_transform(
        [frame("map", "base", 3.0), frame("base", "upper", 3.0), frame("upper", "lower", 3.0)]
    )
    return node


def test_things_and_points_say_what_they_are(browser: Browser, web: Web, robot: Any) -> None:
    box = Marker(type=Marker.CUBE, ns="<b>", id=7)
    box.header.frame_id = "base"
    box.scale.x = box.scale.y = box.scale.z = box.color.a = 1.0
    points = np.array([[np.nan] * 4, [0, 3, 0, 0.125], [0, -3, 0, 8.5], [0.05, -3, 0, 1.5]], np.float32)
    fields = [PointField(name, 4 * index, 7, 1) for index, name in enumerate(("x", "y", "z", "heat"))]
    cloud = PointCloud2(height=1, width=4, fields=fields, point_step=16, row_step=64, data=points.tobytes())
    cloud.header.frame_id = "base"
    robot.advertise("/box", Marker, latch=True).publish(box)
    robot.advertise("/cloud", PointCloud2, latch=True).publish(cloud)
    settings = {"fixed": "map", "robots": [], "topics": ["/box", "/cloud"], "options": {"/cloud": {"by": "heat"}}}
    browser.open(panel_link(web.link, "scene", settings))
    for topic, word in [("/box", "1 marker"), ("/cloud", "3 points, colour: heat")]:
        browser.wait(f"{display(topic)}?.status === arguments[0]", word)
    browser.choose("select[aria-label=view]", "flat")
    browser.click(".tools button", "Select")
    browser.wait(f"{display('/cloud')}.pointData?.values")  # the numbers themselves have come
    (thing,) = browser.run(MOUSE, [3.4, 0.4, 0.5], 0, False)  # one click, beside the axes of the frame
    assert thing == ["/box", "Marker", "<b>", "7", "CUBE", "base", "3, 0, 0", "0, 0, 0"]
    (point,) = browser.run(MOUSE, [3, 3, 0], 0, False)
    assert point == ["/cloud", "PointCloud2", "base", "1", "0, 3, 0", "0.125"]
    cube, several = browser.run(MOUSE, [3.4, 0.4, 0.5], 0, False) + browser.run(MOUSE, [3, -3, 0], 20, True)[1:]
    assert cube == thing
    assert several[3:] == ["2", "0, -3, 0", "8.5", "3", "0.05, -3, 0", "1.5"]
    assert browser.run(f"return {SCENE}.toolbox.tool.marks.children.map((each) => each.type)") == [
        "BoxHelper",
        "Points",
    ]
    assert browser.run(MOUSE, [3, -1.5, 0], 0, False) == []
    browser.click(".tools button", "Select")
    assert not browser.run("return document.querySelector('.selection')")
    browser.wait(f"!{display('/cloud')}.pointData")  # nothing more is sent than is drawn


def test_efforts_of_joints(browser: Browser, web: Web, robot: Any) -> None:
    robot.master.set_param("/robot_description", URDF)
    states = robot.advertise("/joint_states", JointState, latch=True)
    states.publish(JointState(name=["shoulder", "slider", "odd"], effort=[-10.0, 5.0, 1.0]))
    browser.open(panel_link(web.link, "scene", {"fixed": "map", "robots": [], "topics": ["/joint_states"]}))
    shown = display("/joint_states")
    browser.wait(f"{shown}?.status === '3 joints; shoulder has 50% of its limit' && {shown}.shapes.size === 2")
    assert browser.run(f"return {shown}.problem") == "not in the robot's description: odd"
    tip = f"""const {{group, inner}} = {shown}.shapes.get(arguments[0]), place = {SCENE}.stage.controls.target.clone();
        {shown}.object.updateMatrixWorld(true);
        const cone = inner.children[0].children[1];
        return [group.visible, ...cone.localToWorld(place.set(...arguments[1])).sub(group.position).toArray()]"""
    # The arc lies around y; its tip is a quarter before where it begins, and points against the right hand's sense.
    visible, *place = browser.run(tip, "shoulder", [0, 0, 0])
    _, *ahead = browser.run(tip, "shoulder", [0, 1, 0])
    way = np.cross(place, np.subtract(ahead, place))
    assert visible
    assert abs(np.linalg.norm(place) - 0.15) < 1e-6  # half of the size
    assert way[1] < -0.01
    assert abs(way[0]) + abs(way[2]) < 1e-6
    states.publish(JointState(name=["shoulder", "slider"], effort=[0.0, -8.0]))
    browser.wait(f"{shown}.status === '2 joints' && !{shown}.problem")
    assert browser.run(tip, "shoulder", [0, 0, 0])[0] is False
    _, *down = browser.run(tip, "slider", [1, 0, 0])
    assert down[2] < -0.2
    robot.master.delete_param("/robot_description")
    browser.wait(f"{shown}.problem === 'there is no parameter /robot_description'")
