"""Interactive markers in 3D: what the mouse does, and what the marker's server hears.

The server is a program for the package interactive_markers; it runs on stock's, if that is installed, and on ours. What
it hears of rviz 1.14 was observed, and is what these tests expect: the order of the events, frames, stamps of 0, and
where the mouse's place is told.
"""

from __future__ import annotations

import os
import queue
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from browsing import Browser, Web

from pyros1.finding.python_modules import DROP_IN_START
from pyros1.msgs.geometry_msgs.msg import TransformStamped
from pyros1.msgs.visualization_msgs.msg import InteractiveMarkerFeedback
from pyros1.tf import StaticTransformBroadcaster
from pyros1.web.links import panel_link

POSE_UPDATE, MENU_SELECT, BUTTON_CLICK, MOUSE_DOWN, MOUSE_UP = range(1, 6)
SET = "document.querySelector('.scene')?.scene?.displays.get('/controls/update')?.display"
READY = f"{SET}?.known?.size === 5 && [...{SET}.known.values()].every((each) => each.placed)"
SERVER = """
import rospy
from interactive_markers.interactive_marker_server import InteractiveMarkerServer
from interactive_markers.menu_handler import MenuHandler
from visualization_msgs.msg import InteractiveMarker, InteractiveMarkerControl, Marker

rospy.init_node("controls")
server, menu = InteractiveMarkerServer("controls"), MenuHandler()

def box():
    marker = Marker(type=Marker.CUBE)
    marker.scale.x = marker.scale.y = marker.scale.z = 0.4
    marker.color.a = marker.pose.orientation.w = 1.0
    return marker

def add(name, x, mode, axis="x", boxed=True, stamped=False):
    made = InteractiveMarker(name=name, description=name, scale=1.0)
    made.header.frame_id = "base"
    if stamped:
        made.header.stamp = rospy.Time(1)
    made.pose.position.x, made.pose.orientation.w = x, 1.0
    control = InteractiveMarkerControl(name="control", interaction_mode=mode, always_visible=True)
    control.orientation.w = 1.0
    setattr(control.orientation, axis, 1.0)
    control.markers = [box()] if boxed else []
    made.controls.append(control)
    server.insert(made, lambda feedback: server.applyChanges())

def toggled(feedback):
    menu.setCheckState(feedback.menu_entry_id, MenuHandler.CHECKED)
    menu.reApply(server)
    server.applyChanges()

add("axis", 0.0, InteractiveMarkerControl.MOVE_AXIS, "z")
add("plane", 1.0, InteractiveMarkerControl.MOVE_PLANE, "y", stamped=True)
add("ring", 2.0, InteractiveMarkerControl.ROTATE_AXIS, "y", boxed=False)
add("button", 3.0, InteractiveMarkerControl.BUTTON)
add("menu", 4.0, InteractiveMarkerControl.MENU)
sub = menu.insert("more <b>")
menu.setCheckState(menu.insert("fast", parent=sub, callback=toggled), MenuHandler.UNCHECKED)
menu.apply(server, "menu")
server.applyChanges()
rospy.spin()
"""
HELPERS = """
const scene = document.querySelector('.scene').scene, {stage} = scene, canvas = stage.canvas;
canvas.setPointerCapture = () => {};
const set = scene.displays.get('/controls/update').display;
const marker = (name) => [...set.known.values()].find((each) => each.facts.name === name);
const at = (kind, [x, y], button = 0) => canvas.dispatchEvent(new PointerEvent(kind, {
    bubbles: true, cancelable: true, pointerId: 1, button, buttons: 1, clientX: x, clientY: y}));
const seen = (point) => { // where a point of the scene is on the screen
    const box = canvas.getBoundingClientRect();
    const {x, y} = stage.controls.target.clone().set(...point).project(stage.camera);
    return [box.left + (x + 1) / 2 * box.width, box.top + (1 - y) / 2 * box.height];
};
const grip = (name, offset = [0, 0, 0]) => {
    stage.scene.updateMatrixWorld(true);
    const {x, y, z} = marker(name).inner.getWorldPosition(stage.controls.target.clone());
    return seen([x + offset[0], y + offset[1], z + offset[2]]);
};
"""


@pytest.fixture(params=["ours", "stock"])
def server(request: pytest.FixtureRequest, environ: dict[str, str], tmp_path: Path) -> Iterator[None]:
    """A server of interactive markers in a program of its own."""
    file = tmp_path / "server.py"
    file.write_text(SERVER)
    if request.param == "stock":
        python, more = "/usr/bin/python3", {}
        probe = [python, "-c", "import interactive_markers"]
        if not Path(python).exists() or subprocess.run(probe, check=False, capture_output=True).returncode:
            pytest.skip("stock's interactive_markers is not installed")
    else:
        python, more = sys.executable, {"PYTHONPATH": DROP_IN_START}
    process = subprocess.Popen(
        [python, str(file)], env={**os.environ, **environ, **more}, stdout=subprocess.DEVNULL, stdin=subprocess.DEVNULL
    )
    yield
    process.terminate()
    process.wait(15)


class Ear:
    """What the server hears."""

    def __init__(self, node: Any) -> None:
        self._came: queue.SimpleQueue[InteractiveMarkerFeedback] = queue.SimpleQueue()
        self.subscriber = node.subscribe("/controls/feedback", InteractiveMarkerFeedback, self._came.put)

    def next(self) -> InteractiveMarkerFeedback:
        return self._came.get(timeout=20)

    def until_released(self) -> list[InteractiveMarkerFeedback]:
        events = [self.next()]
        while events[-1].event_type != MOUSE_UP:
            events.append(self.next())
        return events


@pytest.fixture
def heard(make_node: Callable[..., Any]) -> Ear:
    """An ear beside the server's. The frame base is 10 m before map."""
    node = make_node("ear")
    link = TransformStamped(child_frame_id="base")
    link.header.frame_id, link.transform.translation.x, link.transform.rotation.w = "map", 10.0, 1.0
    StaticTransformBroadcaster(node).send_transform([link])
    return Ear(node)


@pytest.fixture
def page(server: None, heard: Ear, browser: Browser, web: Web) -> Browser:
    """A page that shows all five markers from above."""
    browser.open(panel_link(web.link, "scene", {"fixed": "map", "topics": ["/controls/update"]}))
    browser.wait(READY)
    browser.run(HELPERS + "stage.place = {name: 'flat', position: [12, 0, 50], target: [12, 0, 0], zoom: 1};")
    assert heard.subscriber.wait_for_publishers(timeout=20)
    browser.run(
        "robot.stream('system', {}, {data: ({edges}) => { window.heard = edges.some(([topic, , to]) =>"
        " topic === '/controls/feedback' && to === '/controls'); }})"
    )
    browser.wait("window.heard")  # the server, too: it would miss the first event else
    return browser


def drag(page: Browser, name: str, start: str, way: str) -> None:
    page.run(
        f"""{HELPERS}
        const [x, y] = grip({name!r}, {start}), [across, down] = {way};
        at('pointerdown', [x, y]);
        for (let step = 1; step <= 5; step += 1) at('pointermove', [x + across * step / 5, y + down * step / 5]);
        at('pointerup', [x + across, y + down]);"""
    )


def test_dragging_along_an_axis(page: Browser, heard: Ear) -> None:
    drag(page, "axis", "[0, 0, 0.2]", "[60, 60]")  # the flat view: x is up on the screen, y left
    events = heard.until_released()
    assert [each.event_type for each in events[:2]] == [POSE_UPDATE, MOUSE_DOWN]
    assert [each.event_type for each in events[-2:]] == [POSE_UPDATE, MOUSE_UP]
    assert {each.event_type for each in events[2:-2]} <= {POSE_UPDATE}
    for each in events:
        assert (each.marker_name, each.control_name, each.header.frame_id) == ("axis", "control", "base")
        assert each.client_id
        assert each.header.stamp.to_sec() == 0
    assert events[0].mouse_point_valid
    assert abs(events[0].pose.position.x) < 1e-6
    last = events[-1].pose.position
    assert last.y < -0.5  # along y only, however the mouse went
    assert abs(last.x) < 1e-6
    assert abs(last.z) < 1e-6
    page.wait(f"Math.abs([...{SET}.known.values()][0].inner.position.y - arguments[0]) < 1e-6", last.y)


def test_dragging_on_a_plane_of_a_marker_with_a_stamp(page: Browser, heard: Ear) -> None:
    drag(page, "plane", "[0, 0, 0.2]", "[30, -30]")
    last = heard.until_released()[-1]
    assert last.header.frame_id == "map"  # as rviz: in the fixed frame, for it does not go with its own
    assert last.pose.position.x > 11.1
    assert last.pose.position.y < -0.1
    assert abs(last.pose.position.z) < 1e-6


def test_turning_a_ring(page: Browser, heard: Ear) -> None:
    page.run(
        f"""{HELPERS}
        const [from, to] = [grip('ring', [0.56, 0, 0]), grip('ring', [0, 0.56, 0])];
        at('pointerdown', from); at('pointermove', to); at('pointerup', to);"""
    )
    turn = heard.until_released()[-1].pose.orientation
    assert abs(turn.z) == pytest.approx(0.5**0.5, abs=0.02)
    assert turn.z * turn.w > 0  # from x to y


def test_a_second_finger_leaves_the_first_its_marker(page: Browser, heard: Ear) -> None:
    page.run(
        f"""{HELPERS}
        const finger = (kind, pointerId, [x, y]) => canvas.dispatchEvent(new PointerEvent(kind, {{
            bubbles: true, cancelable: true, pointerId, button: 0, buttons: 1, clientX: x, clientY: y}}));
        const [first, second] = [grip('axis', [0, 0, 0.2]), grip('plane', [0, 0, 0.2])];
        finger('pointerdown', 1, first);
        finger('pointerdown', 2, second);
        finger('pointermove', 2, [second[0] + 60, second[1]]);
        finger('pointerup', 2, second);
        finger('pointerup', 1, first);"""
    )
    events = heard.until_released()
    assert {each.marker_name for each in events} == {"axis"}
    assert abs(events[-1].pose.position.y) < 1e-6
    time.sleep(0.7)  # a marker that is held tells its place every 0.5 s; none is held now
    assert page.run(f"return {SET}.known.size") == 5


def test_a_button(page: Browser, heard: Ear) -> None:
    drag(page, "button", "[0, 0, 0.2]", "[0, 0]")
    assert [each.event_type for each in heard.until_released()] == [
        POSE_UPDATE,
        MOUSE_DOWN,
        BUTTON_CLICK,
        POSE_UPDATE,
        MOUSE_UP,
    ]


def test_a_menu(page: Browser, heard: Ear) -> None:
    press = f"{HELPERS} const place = grip('menu', [0, 0, 0.2]); at('pointerdown', place); at('pointerup', place);"
    page.run(press)
    page.wait("document.querySelector('.scene-menu')?.innerText.includes('more <b>')")
    page.click(".scene-menu button", "[ ] fast")
    chosen = heard.next()
    assert (chosen.event_type, chosen.marker_name, chosen.menu_entry_id) == (MENU_SELECT, "menu", 2)
    page.wait(f"[...{SET}.known.values()].some((each) => each.facts.menu.some((entry) => entry.title === '[x] fast'))")
    page.run(press)
    page.wait("document.querySelector('.scene-menu')?.innerText.includes('[x] fast')")


def test_a_server_that_is_read_only_says_so(
    server: None, heard: Ear, browser: Browser, start_web: Callable[..., Web]
) -> None:
    link = start_web("--read-only").link
    browser.open(panel_link(link, "scene", {"fixed": "map", "topics": ["/controls/update"]}))
    browser.wait(READY)
    browser.run(HELPERS + "stage.place = {name: 'flat', position: [12, 0, 50], target: [12, 0, 0], zoom: 1};")
    drag(browser, "button", "[0, 0, 0.2]", "[0, 0]")
    browser.wait_for_text("read-only")
