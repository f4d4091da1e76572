"""What a file of rviz shows in the 3D scene."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from browsing import Browser, Web

from pyros1.msgs.geometry_msgs.msg import PoseStamped, TransformStamped
from pyros1.msgs.nav_msgs.msg import Path as Way
from pyros1.msgs.sensor_msgs.msg import LaserScan
from pyros1.tf import StaticTransformBroadcaster

SCENE = "document.querySelector('.scene')?.scene"
FILE = """
Visualization Manager:
  Displays:
    - {Class: rviz/Grid, Enabled: true, Name: Grid, Cell Size: 0.5, Plane Cell Count: 12, Color: 0; 128; 255}
    - {Class: rviz/LaserScan, Enabled: true, Name: Scan, Topic: /scan, Style: Points, Size (Pixels): 6,
       Color Transformer: FlatColor, Color: 255; 0; 0, Alpha: 1}
    - {Class: rviz/Path, Enabled: true, Name: Plan, Topic: /plan, Color: 0; 160; 0}
    - {Class: rviz/Path, Enabled: false, Name: Other plan, Topic: /other_plan, Color: 0; 0; 255}
  Global Options: {Fixed Frame: map}
  Views:
    Current: {Class: rviz/Orbit, Distance: 6, Pitch: 0.785, Yaw: 3.14159, Target Frame: <Fixed Frame>,
              Focal Point: {X: 1, Y: 0, Z: 0}}
"""


def display(key: str) -> str:
    return f"{SCENE}?.displays.get('{key}')?.display"


def line_colour(key: str) -> str:
    """Return JavaScript for red, green, blue and opacity of a display's first line."""
    return f"""((found) => {{
        {display(key)}?.object.traverse((each) => {{ found ||= each.geometry?.getAttribute('colour'); }});
        return found && [...found.array.slice(0, 4)];
    }})()"""


def steps(*places: float) -> Way:
    message = Way(poses=[PoseStamped() for _ in places])
    message.header.frame_id = "map"
    for pose, place in zip(message.poses, places, strict=True):
        pose.pose.position.x, pose.pose.position.y, pose.pose.orientation.w = place, place / 2, 1.0
    return message


@pytest.fixture
def robot(make_node: Callable[..., Any]) -> Any:
    """A node; it has sent a scan and two paths."""
    node = make_node("robot")
    link = TransformStamped(child_frame_id="laser")
    link.header.frame_id, link.transform.translation.x, link.transform.rotation.w = "map", 1.0, 1.0
    StaticTransformBroadcaster(node).send_transform([link])
    scan = LaserScan(angle_min=-1.5, angle_max=1.5, angle_increment=0.1, range_max=9.0, ranges=[1.5] * 31)
    scan.header.frame_id = "laser"
    node.advertise("/scan", LaserScan, latch=True).publish(scan)
    node.advertise("/plan", Way, latch=True).publish(steps(0.0, 1.0, 2.0))
    node.advertise("/other_plan", Way, latch=True).publish(steps(0.0, 3.0))
    return node


def test_displays_colours_and_view(browser: Browser, start_web: Callable[..., Web], robot: Any, tmp_path: Path) -> None:
    file = tmp_path / "robot.rviz"
    file.write_text(FILE)
    browser.open(start_web("rviz", "-d", str(file)).link)
    browser.wait(f"{display('/scan')}?.status === '31 points' && {display('/plan')}?.status === '3 poses'")
    assert browser.run(f"return {SCENE}.fixed.frame") == "map"
    shown = f"return [...{SCENE}.displays].map(([key, {{display}}]) => [key, display.object.visible])"
    assert dict(browser.run(shown)) == {
        "frames": False,
        "grid": True,
        "/scan": True,
        "/plan": True,
        "/other_plan": False,
    }
    assert browser.run(f"return {line_colour('/plan')}") == [0, 160, 0, 255]
    points = f"const {{mode, size, tint}} = {display('/scan')}.points.uniforms;"
    assert browser.run(f"{points} return [mode.value, size.value, ...tint.value.toArray()]") == [3, 6, 1, 0, 0]
    assert browser.run(f"return {SCENE}.stage.grid.status") == "6 m"
    place = browser.run(f"return {SCENE}.stage.place")
    assert place["name"] == "orbit" and place["target"] == [1, 0, 0]
    assert place["position"] == pytest.approx([1 - 6 * 0.7072, 0, 6 * 0.7068], abs=0.01)


def test_a_file_is_opened_in_the_page(
    browser: Browser, start_web: Callable[..., Web], robot: Any, tmp_path: Path
) -> None:
    file = tmp_path / "robot.rviz"
    file.write_text(FILE.replace("rviz/Grid", "my/Thing"))
    browser.open(start_web("rviz").link)
    browser.wait(f"{SCENE}?.displays.size === 3")  # frames, grid, robot
    choice = browser.driver.find_element("css selector", ".panel input[type=file]")
    choice.send_keys(str(file))
    browser.wait(f"{display('/scan')}?.status === '31 points' && {display('/plan')}?.status === '3 poses'")
    assert browser.run(f"return {SCENE}.fixed.frame") == "map"
    said = "return document.querySelector('.scene .view > .word').textContent"
    assert browser.run(said) == "Thing 'Grid': unsupported display my/Thing"
    file.write_text("- [")
    browser.driver.find_element("css selector", ".panel input[type=file]").send_keys(str(file))
    browser.wait("document.querySelector('.scene .view > .word').textContent.startsWith('robot.rviz is not YAML')")
    assert browser.run(f"return {SCENE}.fixed.frame") == "map"  # what was there is there


def test_colours_of_ones_choice(browser: Browser, start_web: Callable[..., Web], robot: Any) -> None:
    browser.open(start_web("rviz").link)
    browser.click("button.add", "/plan")
    browser.wait(f"{display('/plan')}?.status === '3 poses'")
    browser.click("button[aria-label='options of /plan']")
    browser.type("input[type=color]", "#123456")
    changed = f"{line_colour('/plan')}?.join() === '18,52,86,255'"
    browser.wait(changed)
    browser.click("button[aria-label='options of Grid']")
    browser.type("input[data-mark='grid count']", "4")
    browser.wait(f"{SCENE}.stage.grid.status === '4 m'")
    browser.driver.refresh()  # it is kept
    browser.wait(f"{changed} && {SCENE}.stage.grid.status === '4 m'")


@pytest.mark.parametrize(
    ("current", "name", "way", "up"),
    [
        ("{Class: rviz/TopDownOrtho, X: 1, Y: 0, Scale: 50, Angle: 0}", "flat", [0, 0, -1], [0, 1, 0]),
        ("{Class: rviz/TopDownOrtho, X: 1, Y: 0, Scale: 50, Angle: -1.5708}", "flat", [0, 0, -1], [1, 0, 0]),
        ("{Class: rviz/FPS, Position: {X: 0, Y: 0, Z: 1}, Yaw: 1.5708, Pitch: 0}", "walk", [0, 1, 0], [0, 0, 1]),
        ("{Class: rviz/ThirdPersonFollower, Yaw: 3.14159, Target Frame: laser}", "third", [1, 0, 0], [0, 0, 1]),
    ],
)  # fmt: skip
def test_views(
    browser: Browser,
    start_web: Callable[..., Web],
    robot: Any,
    tmp_path: Path,
    current: str,
    name: str,
    way: list[int],
    up: list[int],
) -> None:
    file = tmp_path / "view.rviz"
    file.write_text(f"Visualization Manager: {{Global Options: {{Fixed Frame: map}}, Views: {{Current: {current}}}}}")
    browser.open(start_web("rviz", str(file)).link)
    browser.wait(f"{SCENE}?.displays.get('frames')?.display.status === '2 frames'")
    looks = f"""
        const {{camera, controls}} = {SCENE}.stage;
        const up = camera.up.clone().set(0, 1, 0).applyQuaternion(camera.quaternion);
        return [controls.target.clone().sub(camera.position).normalize().toArray(), up.toArray()];
    """
    for seen, wanted in zip(browser.run(looks), (way, up), strict=True):
        assert seen == pytest.approx(wanted, abs=0.01)
    place = browser.run(f"return {SCENE}.stage.place")
    assert place["name"] == name
    if name == "third":  # it goes along with the frame, which is at x = 1
        browser.wait(f"Math.abs({SCENE}.stage.controls.target.x - 1) < 0.01")
