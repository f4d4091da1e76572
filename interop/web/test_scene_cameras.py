"""Cameras in the 3D scene: the scene over their pictures, and their depths as points."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from browsing import Browser, Web

from pyros1.msgs.geometry_msgs.msg import TransformStamped
from pyros1.msgs.sensor_msgs.msg import CameraInfo, Image
from pyros1.msgs.visualization_msgs.msg import Marker
from pyros1.tf import StaticTransformBroadcaster
from pyros1.web.links import panel_link

SCENE = "document.querySelector('.scene')?.scene"
WIDTH, HEIGHT, FOCAL = 64, 48, 60.0
CAMERA, DEPTH = "camera:/cam/rgb", "depth:/cam/depth"
PIXEL = f"""
    const {{stage}} = {SCENE}, hole = document.querySelector('.hole').getBoundingClientRect();
    const all = stage.canvas.getBoundingClientRect(), gl = stage.renderer.getContext();
    stage.render();
    const scale = hole.width / {WIDTH}, pixel = new Uint8Array(4);
    const [x, y] = [0, 1].map((index) => (arguments[index] + 0.5) * scale);
    gl.readPixels(hole.left - all.left + x, all.bottom - hole.top - y, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    return [...pixel].slice(0, 3);
"""


def display(key: str) -> str:
    return f"{SCENE}?.displays.get('{key}')?.display"


@pytest.fixture
def camera(make_node: Callable[..., Any]) -> Any:
    """A robot whose camera is 1 m above the map, looks along x, and sees a red picture and depths of 2 m."""
    node = make_node("camera")
    link = TransformStamped(child_frame_id="optical")
    link.header.frame_id, link.transform.translation.z = "map", 1.0
    turn = link.transform.rotation
    turn.x, turn.y, turn.z, turn.w = -0.5, 0.5, -0.5, 0.5
    StaticTransformBroadcaster(node).send_transform([link])
    middle = WIDTH / 2 - 0.5, HEIGHT / 2 - 0.5
    info = CameraInfo(width=WIDTH, height=HEIGHT)
    info.P = [FOCAL, 0, middle[0], 0, 0, FOCAL, middle[1], 0, 0, 0, 1, 0]
    red = Image(width=WIDTH, height=HEIGHT, encoding="rgb8", step=3 * WIDTH, data=b"\xff\0\0" * (WIDTH * HEIGHT))
    depths = np.full((HEIGHT, WIDTH), 2000, np.uint16)
    depths[0] = 0
    depth = Image(width=WIDTH, height=HEIGHT, encoding="16UC1", step=2 * WIDTH, data=depths.tobytes())
    for topic, message in [("/cam/camera_info", info), ("/cam/rgb", red), ("/cam/depth", depth)]:
        message.header.frame_id = "optical"
        node.advertise(topic, type(message), latch=True).publish(message)
    return node


def test_the_scene_is_drawn_over_the_picture_where_things_are(browser: Browser, web: Web, camera: Any) -> None:
    box = Marker(type=Marker.CUBE)  # 2 m ahead, half a metre to the left: 15 pixels from the middle of the picture
    box.header.frame_id = "map"
    box.pose.position.x, box.pose.position.y, box.pose.position.z = 2.1, 0.5, 1.0
    box.scale.x = box.scale.y = box.scale.z = 0.2
    box.color.g = box.color.a = 1.0
    camera.advertise("/box", Marker, latch=True).publish(box)
    frames = {"names": False, "axes": False, "lines": False}
    options = {"frames": frames, CAMERA: {"alpha": 0}}
    settings = {"fixed": "map", "robots": [], "topics": [CAMERA, "/box"], "options": options}
    browser.open(panel_link(web.link, "scene", settings))
    browser.wait(f"{display(CAMERA)}?.status === '64 \u00d7 48, from optical' && !{display(CAMERA)}.problem")
    browser.wait(f"{display('/box')}?.status === '1 marker'")
    for place in [(16, 23), (14, 21), (18, 26)]:
        red, green, blue = browser.run(PIXEL, *place)
        assert green > 80 > max(red, blue), place
    for place in [(31, 5), (12, 19), (21, 28), (47, 20), (5, 5)]:
        assert browser.run(PIXEL, *place) == [255, 0, 0], place
    browser.click(f"button[aria-label='options of {CAMERA}']")
    browser.run("document.querySelector('.options input[type=checkbox]').click()")  # no picture behind
    assert browser.run(PIXEL, 31, 5) != [255, 0, 0]
    browser.click(f"button[aria-label='remove {CAMERA}']")
    assert browser.run(f"return document.querySelectorAll('.hole').length + {SCENE}.stage.after.length") == 0


def test_depths_are_points_in_the_colours_of_a_picture(browser: Browser, web: Web, camera: Any) -> None:
    browser.open(panel_link(web.link, "scene", {"fixed": "map", "robots": []}))
    browser.click("button.add", "/cam/depth DepthCloud")
    count = WIDTH * (HEIGHT - 1)
    browser.wait(f"{display(DEPTH)}?.status === '{count} points, colour: z'")
    browser.click(f"button[aria-label='options of {DEPTH}']")
    browser.choose(".options select", "/cam/rgb")
    browser.wait(f"{display(DEPTH)}.status === '{count} points, colour: rgb'")
    corner = f"""const {{points, object}} = {display(DEPTH)}, cloud = points.mesh.geometry;
        object.updateMatrixWorld(true);
        const place = {SCENE}.stage.controls.target.clone().fromArray(cloud.getAttribute('position').array);
        place.applyMatrix4(points.object.matrixWorld);
        return [...place.toArray(), ...cloud.getAttribute('bgr').array.slice(0, 3)]"""
    x, y, z, *bgr = browser.run(corner)
    assert bgr == [0, 0, 255]
    # The first pixel of the second row: 2 m ahead, to the left and above.
    expected = (2.0, 2 * (WIDTH / 2 - 0.5) / FOCAL, 1 + 2 * (HEIGHT / 2 - 1.5) / FOCAL)
    assert all(abs(one - other) < 1e-5 for one, other in zip((x, y, z), expected, strict=True))
    browser.driver.refresh()  # what was added and chosen is kept
    browser.wait(f"{display(DEPTH)}?.status === '{count} points, colour: rgb'")


def test_a_camera_without_a_camera_info(browser: Browser, web: Web, make_node: Callable[..., Any]) -> None:
    image = Image(width=2, height=1, encoding="rgb8", step=6, data=bytes(6))
    make_node("camera").advertise("/cam/depth", Image, latch=True).publish(image)
    browser.open(panel_link(web.link, "scene", {"robots": [], "topics": ["camera:/cam/depth", DEPTH, "camera:/none"]}))
    browser.wait(f"{display('camera:/cam/depth')}?.problem === 'no CameraInfo has been received on /cam/camera_info'")
    browser.wait(f"{SCENE}.displays.get('{DEPTH}').trouble === 'no CameraInfo has been received on /cam/camera_info'")
    assert browser.run(f"return {display('camera:/none')}.status") == "no node publishes it yet"
