"""The 3D panel's frames: without tf, typed, with names that can be read; and its room on a phone."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from browsing import Browser, Web

from pyros1.msgs.geometry_msgs.msg import TransformStamped
from pyros1.msgs.sensor_msgs.msg import LaserScan, PointCloud2, PointField
from pyros1.msgs.std_msgs.msg import String
from pyros1.tf import StaticTransformBroadcaster
from pyros1.web.links import panel_link

SCENE = "document.querySelector('.scene')?.scene"
FIXED = "document.querySelector('select[aria-label=\"fixed frame\"]')"
WORD = f"{SCENE}?.displays.get('/scan')?.display.status"


def scan(place: str) -> LaserScan:
    """Three ranges."""
    message = LaserScan(angle_increment=0.1, range_max=10.0, ranges=[1.0, 2.0, 3.0])
    message.header.frame_id = place
    return message


def frame(parent: str, child: str, x: float) -> TransformStamped:
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id = parent
    message.transform.translation.x, message.transform.rotation.w = x, 1.0
    return message


def test_messages_without_tf_are_shown_in_their_frame(
    browser: Browser, web: Web, make_node: Callable[..., Any]
) -> None:
    node = make_node("robot")
    node.advertise("scan", LaserScan, latch=True).publish(scan("laser"))
    browser.open(panel_link(web.link, "scene", {"topics": ["/scan"]}))
    browser.wait(f"{WORD} === '3 points'")
    assert browser.run(f"return {FIXED}.selectedOptions[0].textContent") == "laser (there is no tf)"
    browser.choose("select[aria-label='fixed frame']", "\n")  # another one
    browser.type("[aria-label='name of the fixed frame']", "map")
    browser.wait_for_text("no transform from map to laser: choose another fixed frame, or publish a transform")
    assert browser.run(f"return [...{FIXED}.options].map((each) => each.value)") == ["", "laser", "map", "\n"]
    StaticTransformBroadcaster(node).send_transform(frame("map", "laser", 1.0))
    browser.wait("document.querySelector('.panel .note').hidden")
    browser.choose("select[aria-label='fixed frame']", "")
    browser.wait(f"{FIXED}.selectedOptions[0].textContent === 'the root (map)'")
    browser.wait(f"{WORD} === '3 points'")


URDF = """<robot name="arm"><link name="base"/><link name="arm"/><joint name="shoulder" type="fixed">
    <parent link="base"/><child link="arm"/></joint></robot>"""


def test_a_fixed_frame_without_connection_names_the_trees_that_there_are(
    browser: Browser, web: Web, make_node: Callable[..., Any]
) -> None:
    node = make_node("robot")
    node.params["/robot_description"] = URDF
    pairs = [("world", "table"), ("table", "lamp"), ("base", "arm")]
    StaticTransformBroadcaster(node).send_transform([frame(*pair, 1.0) for pair in pairs])
    robot, tf = (f"{SCENE}?.displays.get('{key}')?.display" for key in ("robot:/robot_description", "frames"))
    trees = "there are the trees world (3 frames), base (2 frames): choose one of these roots as fixed frame"
    browser.open(panel_link(web.link, "scene", {"fixed": "world"}))
    browser.wait(f"{robot}?.problem === arguments[0]", f"no transform from world to base, arm, drawn with joints at 0: "
        f"2 frames are not connected to world; {trees}")  # fmt: skip
    browser.wait_for_text("2 frames are not connected to world; there are the trees world (3 frames), base (2 frames)")
    assert browser.run(f"return [{tf}.status, {tf}.problem]") == ["3 frames", ""]
    browser.open(panel_link(web.link, "scene", {"fixed": "nowhere"}))
    browser.wait(f"{tf}?.problem === arguments[0]", f"no frame is connected to nowhere; {trees}")
    browser.open(
        panel_link(web.link, "scene", {"fixed": ""})
    )  # without a choice, what the robot stands on stands still
    browser.wait(f"{SCENE}?.fixedFrame() === 'base' && {robot}?.problem === ''")


def test_names_of_frames_do_not_cover_each_other(browser: Browser, web: Web, make_node: Callable[..., Any]) -> None:
    frames = [frame("map", f"link_{number}", number / 1000) for number in range(8)]
    StaticTransformBroadcaster(make_node("robot")).send_transform([*frames, frame("map", "far_away", 3.0)])
    browser.open(web.page("scene"))
    names = f"[...{SCENE}.frames.axes].filter(([, axes]) => axes.children[1].visible).map(([name]) => name)"
    browser.wait(f"{SCENE}?.frames?.axes.size === 10 && {names}.length === 2 && {names}.includes('far_away')")
    browser.wait(f"{SCENE}.list && !{SCENE}.stage.due")
    browser.run(f"{SCENE}.displays.get('frames').display.set({{names: false}}); {SCENE}.stage.render()")
    assert browser.run(f"return {names}") == []


def test_fit_shows_all_points(browser: Browser, web: Web, make_node: Callable[..., Any]) -> None:
    node = make_node("robot")
    points = np.array([[40, 0, 0], [40, 30, 5], [np.nan, 0, 0]], np.float32)
    fields = [PointField(name, 4 * index, 7, 1) for index, name in enumerate("xyz")]
    cloud = PointCloud2(height=1, width=3, fields=fields, point_step=12, row_step=36, data=points.tobytes())
    cloud.header.frame_id = "map"
    node.advertise("cloud", PointCloud2, latch=True).publish(cloud)
    browser.open(panel_link(web.link, "scene", {"topics": ["/cloud"], "options": {"/cloud": {"most": 1000}}}))
    object_ = f"{SCENE}?.displays.get('/cloud')?.display.object"
    browser.wait(f"{SCENE}?.displays.get('/cloud')?.display.status?.startsWith('2 points')")
    assert not browser.run(f"return {SCENE}.stage.shows({object_})")
    browser.click(".tools button", "Fit")
    browser.wait(f"{SCENE}.stage.shows({object_})")


def test_a_cloud_of_which_some_is_drawn_says_so(browser: Browser, web: Web, make_node: Callable[..., Any]) -> None:
    node = make_node("robot")
    fields = [PointField(name, 4 * index, 7, 1) for index, name in enumerate("xyz")]
    data = np.random.default_rng(1).random((5000, 3), np.float32).tobytes()
    cloud = PointCloud2(height=1, width=5000, fields=fields, point_step=12, row_step=60000, data=data)
    cloud.header.frame_id = "map"
    publisher = node.advertise("cloud", PointCloud2)
    node.timer(0.1, lambda _: publisher.publish(cloud))
    browser.open(panel_link(web.link, "scene", {"topics": ["/cloud"], "options": {"/cloud": {"most": 1000}}}))
    shown = f"{SCENE}?.displays.get('/cloud')?.display.status"
    browser.wait(f"/^1000 points \\(one of 5\\), \\d+\\.\\d a second, colour: z$/.test({shown})")


def test_the_scene_has_room_on_a_phone(browser: Browser, web: Web, make_node: Callable[..., Any]) -> None:
    node = make_node("robot")
    for number in range(12):
        node.advertise(f"scan{number}", LaserScan, latch=True).publish(scan("laser"))
    browser.resize(390, 844)
    browser.open(panel_link(web.link, "scene", {"topics": [f"/scan{number}" for number in range(12)]}))
    browser.wait("document.querySelector('.scene .view')?.clientHeight > 844 / 2")
    hidden = "[...document.querySelectorAll(arguments[0])].every((each) => !each.checkVisibility())"
    assert browser.run(f"return {hidden}", ".scene .display, .tools .more button")
    browser.click(".fold-tools")
    browser.click(".fold-displays")
    assert not browser.run(f"return {hidden}", ".scene .display")
    assert not browser.run(f"return {hidden}", ".tools .more button")


def test_long_names_of_frames_leave_room_for_the_buttons(
    browser: Browser, web: Web, make_node: Callable[..., Any]
) -> None:
    StaticTransformBroadcaster(make_node("robot")).send_transform([frame("map", "f" * 150, 1.0)])
    browser.open(panel_link(web.link, "scene", {}))
    browser.wait(f"{FIXED}?.options.length > 2")
    wide = f"const box = {FIXED}.getBoundingClientRect(); return [box.width, box.right, innerWidth]"
    for width in (500, 700, 780, 1280):
        browser.resize(width, 800)
        size, right, room = browser.run(wide)
        assert size < 221 and right <= room, width


def test_topics_of_which_there_is_no_display(browser: Browser, web: Web, make_node: Callable[..., Any]) -> None:
    make_node("robot").advertise("words", String, latch=True).publish(String("a"))
    browser.open(panel_link(web.link, "scene", {"topics": ["/words", "/nothing"]}))
    words = f"['/words', '/nothing'].map((key) => {SCENE}?.displays?.get(key)?.display.status).join('; ')"
    browser.wait(f"{words} === 'there is no display of std_msgs/String; no node publishes it yet'")


def test_a_file_hides_links_and_frames_and_says_what_is_behind(
    browser: Browser, web: Web, make_node: Callable[..., Any]
) -> None:
    node = make_node("robot")
    node.params["/robot_description"] = URDF
    StaticTransformBroadcaster(node).send_transform([frame("base", "arm", 1.0)])
    options = {"frames": {"concealed": ["arm"]}, "robot:/robot_description": {"concealed": ["base"]}}
    browser.open(panel_link(web.link, "scene", {"options": options, "background": "#0102ff"}))
    robot, tf = (f"{SCENE}.displays.get('{key}').display" for key in ("robot:/robot_description", "frames"))
    browser.wait(f"{SCENE}?.displays?.get('frames')?.display.axes.size === 2 && {robot}?.links.size === 2")
    browser.wait(f"{SCENE}.list && !{SCENE}.stage.due")
    shown = "[...arguments[0]].filter(([, one]) => (one.group || one).visible).map(([name]) => name)"
    for known, expected in ((f"{tf}.axes", ["base"]), (f"{robot}.links", ["arm"])):
        assert browser.run(f"return {shown.replace('arguments[0]', known)}") == expected
    pixel = f"const {{stage}} = {SCENE}; stage.render(); const gl = stage.renderer.getContext();"
    pixel += "const found = new Uint8Array(4);"
    pixel += "gl.readPixels(2, gl.drawingBufferHeight - 2, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, found);"
    pixel += "return [...found]"
    assert browser.run(pixel)[:3] == [1, 2, 255]
