"""Displays of the 3D scene as rviz has them: each draws its message, says what it shows, and has options."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from browsing import Browser, Web

from pyros1.msgs.geometry_msgs.msg import (
    AccelStamped,
    Point,
    Point32,
    PointStamped,
    PolygonStamped,
    Pose,
    PoseArray,
    PoseWithCovarianceStamped,
    TransformStamped,
    TwistStamped,
    WrenchStamped,
)
from pyros1.msgs.map_msgs.msg import OccupancyGridUpdate
from pyros1.msgs.nav_msgs.msg import GridCells, OccupancyGrid, Odometry
from pyros1.msgs.sensor_msgs.msg import (
    ChannelFloat32,
    CompressedImage,
    FluidPressure,
    Illuminance,
    Image,
    Imu,
    LaserScan,
    PointCloud,
    PointCloud2,
    PointField,
    Range,
    RelativeHumidity,
    Temperature,
)
from pyros1.msgs.visualization_msgs.msg import Marker, MarkerArray
from pyros1.tf import StaticTransformBroadcaster
from pyros1.web.links import panel_link

SCENE = "document.querySelector('.scene')?.scene"


def display(topic: str) -> str:
    return f"{SCENE}?.displays.get('{topic}')?.display"


def covered() -> PoseWithCovarianceStamped:
    message = PoseWithCovarianceStamped()
    covariance = [0.0] * 36
    covariance[0] = covariance[7] = covariance[35] = 0.1
    message.pose.covariance = covariance
    return message


def wrench() -> WrenchStamped:
    message = WrenchStamped()
    message.wrench.force.x, message.wrench.torque.z = 3.0, 0.5
    return message


def footprint() -> PolygonStamped:
    message = PolygonStamped()
    message.polygon.points = [Point32(1, 1, 0), Point32(1, -1, 0), Point32(-1, 0, 0)]
    return message


def older_cloud() -> PointCloud:
    return PointCloud(points=[Point32(1, 2, 3)] * 3, channels=[ChannelFloat32("intensity", [1.0, 2.0, 3.0])])


CASES: list[tuple[Any, str, int]] = [  # a message, what its display says, and how many things are drawn at least
    (AccelStamped(), "0.00 m/s\u00b2, 0.00 rad/s\u00b2", 0),
    (FluidPressure(fluid_pressure=101325.0), "101325 Pa", 1),
    (GridCells(cell_width=0.5, cell_height=0.5, cells=[Point(1, 2, 0)] * 7), "7 cells", 1),
    (Illuminance(illuminance=300.0), "300 lx", 1),
    (Imu(), "0.00 m/s\u00b2", 1),
    (Odometry(), "", 2),
    (PointStamped(point=Point(1, 2, 3)), "1.000, 2.000, 3.000", 1),
    (older_cloud(), "3 points, colour: intensity", 0),
    (footprint(), "3 corners", 0),
    (PoseArray(poses=[Pose(), Pose()]), "2 poses", 2),
    (covered(), "", 4),
    (Range(range=1.5, max_range=4.0, field_of_view=0.5), "1.50 m", 1),
    (Range(range=5.0, max_range=4.0, field_of_view=0.5), "nothing in range", 0),
    (RelativeHumidity(relative_humidity=0.4), "0.4", 1),
    (Temperature(temperature=21.5), "21.5 \u00b0C", 1),
    (TwistStamped(), "0.00 m/s, 0.00 rad/s", 0),
    (wrench(), "3.00 N, 0.50 N m", 5),
]


@pytest.fixture
def robot(make_node: Callable[..., Any]) -> Any:
    """A node; its robot has the frames map and base."""
    node = make_node("robot")
    link = TransformStamped(child_frame_id="base")
    link.header.frame_id, link.transform.translation.x, link.transform.rotation.w = "map", 2.0, 1.0
    StaticTransformBroadcaster(node).send_transform([link])
    return node


def test_messages_of_every_kind(browser: Browser, web: Web, robot: Any) -> None:
    topics = []
    for index, (message, _, _) in enumerate(CASES):
        message.header.frame_id = "base"
        topics.append(f"/t{index}")
        robot.advertise(topics[-1], type(message), latch=True).publish(message)
    browser.open(panel_link(web.link, "scene", {"fixed": "map", "topics": topics}))
    for topic, (message, said, things) in zip(topics, CASES, strict=True):
        browser.wait(f"{display(topic)}?.frame === 'base' && {display(topic)}.status === arguments[0]", said)
        count = f"let n = 0; {display(topic)}.object.traverse((each) => {{ n += each.isMesh ? 1 : 0; }}); return n"
        assert browser.run(count) >= things, type(message)
        assert browser.run(f"return {display(topic)}.object.visible")


def test_parts_of_a_map_change(browser: Browser, web: Web, robot: Any) -> None:
    grid = OccupancyGrid(data=[0] * 12)
    grid.info.width, grid.info.height, grid.info.resolution = 4, 3, 1.0
    grid.header.frame_id = "map"
    updates = robot.advertise("/map_updates", OccupancyGridUpdate)
    robot.advertise("/map", OccupancyGrid, latch=True).publish(grid)
    browser.open(panel_link(web.link, "scene", {"fixed": "map", "topics": ["/map"]}))
    browser.wait(f"{display('/map')}?.status === '4 \u00d7 3 cells'")
    assert updates.wait_for_subscribers(timeout=20)
    updates.publish(OccupancyGridUpdate(x=1, y=2, width=2, height=1, data=[100, -1]))
    pixels = f"[...new Uint8Array({display('/map')}.plane.texture.image.data.buffer)]"
    browser.wait(f"{pixels}[4 * 9] === 0")
    assert (
        browser.run(f"return {pixels}.slice(32, 48)")
        == [255, 255, 255, 255, 0, 0, 0, 255, 112, 137, 134, 255] + [255] * 4
    )
    browser.click("button[aria-label='options of /map']")
    browser.choose(".options select", "costmap")
    assert browser.run(f"return {pixels}.slice(36, 40)") == [255, 0, 255, 255]


def test_a_cloud_by_a_field_of_ones_choice(browser: Browser, web: Web, robot: Any) -> None:
    points = np.arange(20, dtype=np.float32)
    fields = [PointField(name, 4 * index, 7, 1) for index, name in enumerate(("x", "y", "z", "heat"))]
    cloud = PointCloud2(height=1, width=5, fields=fields, point_step=16, row_step=80, data=points.tobytes())
    cloud.header.frame_id = "map"
    robot.advertise("/cloud", PointCloud2, latch=True).publish(cloud)
    browser.open(panel_link(web.link, "scene", {"fixed": "map", "topics": ["/cloud"]}))
    browser.wait(f"{display('/cloud')}?.status === '5 points, colour: z'")
    browser.click("button[aria-label='options of /cloud']")
    choice = ".options select[data-mark='/cloud by']"
    browser.wait("document.querySelectorAll(`${arguments[0]} option`).length === 5", choice)
    browser.choose(choice, "heat")
    browser.wait(f"{display('/cloud')}.status === '5 points, colour: heat'")
    level = f"[...{display('/cloud')}.points.mesh.geometry.getAttribute('level').array.slice(0, 5)]"
    assert browser.run(f"return {level}") == [0, 63, 127, 191, 255]
    browser.driver.refresh()  # what was chosen is kept
    browser.wait(f"{display('/cloud')}?.status === '5 points, colour: heat'")


def test_pictures_over_the_scene(browser: Browser, web: Web, robot: Any) -> None:
    image = Image(width=2, height=1, encoding="rgb8", step=6, data=b"\xff\x00\x00\x00\xff\x00")
    robot.advertise("/camera", Image, latch=True).publish(image)
    robot.advertise("/broken", CompressedImage, latch=True).publish(CompressedImage(format="jpeg", data=b"no picture"))
    browser.open(panel_link(web.link, "scene", {"topics": ["/camera", "/broken"]}))
    browser.wait(f"{display('/camera')}?.status === '2 \u00d7 1'")
    colours = f"return [...{display('/camera')}.canvas.getContext('2d').getImageData(0, 0, 2, 1).data]"
    assert browser.run(colours) == [255, 0, 0, 255, 0, 255, 0, 255]
    browser.wait_for_text("the browser cannot show images of the format jpeg")
    browser.choose("select[aria-label='fixed frame']", "base")
    browser.wait(f"{SCENE}.lastFrames?.fixed === 'base'")
    assert not browser.run(f"return {SCENE}.displays.get('/camera').trouble")
    browser.click("button[aria-label='remove /camera']")
    assert browser.run("return document.querySelectorAll('.overlay').length") == 1


def test_namespaces_of_markers_are_hidden_and_locked_markers_go_with_their_frames(
    browser: Browser, web: Web, robot: Any
) -> None:
    markers = MarkerArray([Marker(ns=ns, type=Marker.CUBE, frame_locked=ns == "locked") for ns in ("free", "locked")])
    for marker in markers.markers:
        marker.header.frame_id = "base"
        marker.scale.x = marker.scale.y = marker.scale.z = marker.color.a = 1.0
    robot.advertise("/marks", MarkerArray, latch=True).publish(markers)
    browser.open(panel_link(web.link, "scene", {"fixed": "map", "topics": ["/marks"]}))
    browser.wait(f"{display('/marks')}?.status === '2 markers'")
    browser.click("button[aria-label='options of /marks']")
    browser.run("document.querySelector('.options input').click()")  # that of the first namespace
    facts = f"Object.fromEntries([...{display('/marks')}.markers.known.values()].map((each) => [each.userData.ns, each"
    assert browser.run(f"return {facts}.visible]))") == {"free": False, "locked": True}
    link = TransformStamped(child_frame_id="base")
    link.header.frame_id, link.transform.translation.x, link.transform.rotation.w = "map", 7.0, 1.0
    StaticTransformBroadcaster(robot).send_transform([link])
    browser.wait(f"{facts}.position.x])).locked === 7")
    assert browser.run(f"return {facts}.position.x]))") == {"free": 2, "locked": 7}


def test_views_and_a_frame_that_is_followed(browser: Browser, web: Web, robot: Any) -> None:
    browser.open(panel_link(web.link, "scene", {"fixed": "map"}))
    browser.wait(f"{SCENE}?.frames?.poses.size === 2")
    browser.choose("select[aria-label=view]", "flat")
    assert browser.run(f"return {SCENE}.stage.camera.isOrthographicCamera")
    browser.choose("select[aria-label='followed frame']", "base")
    target = f"{SCENE}.stage.controls.target.x"
    link = TransformStamped(child_frame_id="base")
    link.header.frame_id, link.transform.rotation.w = "map", 1.0
    for x in (4.0, 9.0):
        link.transform.translation.x = x
        StaticTransformBroadcaster(robot).send_transform([link])
        browser.wait(f"Math.abs({target} - {x}) < 1e-6")
    browser.driver.refresh()  # view and followed frame are kept
    browser.wait(f"{SCENE}?.stage?.camera.isOrthographicCamera && Math.abs({target} - 9) < 1e-6")


def test_one_walks_through_the_scene(browser: Browser, web: Web, robot: Any) -> None:
    browser.open(panel_link(web.link, "scene", {"fixed": "map"}))
    browser.wait(f"{SCENE}?.frames?.poses.size === 2")
    eye = f"const {{camera, controls}} = {SCENE}.stage; return [camera.position.toArray(), controls.target.toArray()]"
    before, _ = browser.run(eye)
    browser.choose("select[aria-label=view]", "walk")
    begun, middle = browser.run(eye)
    assert np.allclose([begun, middle], [before, [0, 0, 0]], atol=1e-3)  # where one was
    before = begun
    walk = f"""
        const {{canvas}} = {SCENE}.stage;
        canvas.setPointerCapture = canvas.releasePointerCapture = () => {{}};
        const fire = (kind, x, y, button) => canvas.dispatchEvent(new PointerEvent(kind, {{
            bubbles: true, pointerId: 1, button, clientX: 500 + x, clientY: 400 + y}}));
        for (const [kind, ...place] of arguments[0]) fire(kind, ...place);
        for (const key of arguments[1]) canvas.dispatchEvent(new KeyboardEvent('keydown', {{key, bubbles: true}}));
        canvas.dispatchEvent(new WheelEvent('wheel', {{deltaY: arguments[2], bubbles: true, cancelable: true}}));
    """
    browser.run(walk, [], "wws", -100)  # two steps ahead, and one back; one more by the wheel
    here, ahead = browser.run(eye)
    step = np.subtract(here, before)
    assert abs(np.linalg.norm(step) - 0.6) < 1e-6
    assert np.allclose(np.cross(step, before), 0, atol=1e-6)  # towards the middle, at which one looked
    browser.run(walk, [["pointerdown", 0, 0, 0], ["pointermove", 100, 0, 0], ["pointerup", 100, 0, 0]], "", 0)
    same, aside = browser.run(eye)
    assert np.allclose(same, here)
    way, turned = np.subtract(ahead, here), np.subtract(aside, here)
    angle = np.arctan2(turned[1], turned[0]) - np.arctan2(way[1], way[0])
    assert abs(angle + 0.5) < 1e-6  # to the right
    browser.run(walk, [["pointerdown", 0, 0, 2], ["pointermove", 100, 0, 2], ["pointerup", 100, 0, 2]], "", 0)
    there, _ = browser.run(eye)
    assert abs(np.linalg.norm(np.subtract(there, here)) - 1) < 1e-6
    browser.driver.refresh()  # it is kept
    browser.wait(f"{SCENE}?.stage?.name === 'walk'")
    assert np.allclose(browser.run(eye)[0], there, atol=0.01)


def test_one_stays_behind_a_frame_that_turns(browser: Browser, web: Web, robot: Any) -> None:
    browser.open(panel_link(web.link, "scene", {"fixed": "map", "target": "base"}))
    browser.wait(f"{SCENE}?.frames?.poses.size === 2")
    browser.choose("select[aria-label=view]", "third")
    link = TransformStamped(child_frame_id="base")
    link.header.frame_id, link.transform.rotation.z, link.transform.rotation.w = "map", 0.5**0.5, 0.5**0.5
    for x in (4.0, 9.0):
        link.transform.translation.x = x
        StaticTransformBroadcaster(robot).send_transform([link])
        place = f"{SCENE}.stage.camera.position"
        browser.wait(f"Math.abs({place}.x - {x}) < 1e-3 && Math.abs({place}.y + 5) < 1e-3")


def test_places_are_measured_and_published(browser: Browser, web: Web, robot: Any) -> None:
    box = Marker(type=Marker.CUBE)
    box.header.frame_id = "map"
    box.scale.x = box.scale.y = box.scale.z = 1.0
    box.pose.position.z, box.color.a = 0.5, 1.0
    robot.advertise("/box", Marker, latch=True).publish(box)
    points: list[Any] = []
    robot.subscribe("/clicked_point", PointStamped, points.append)
    browser.open(panel_link(web.link, "scene", {"fixed": "map", "topics": ["/box"]}))
    browser.wait(f"{display('/box')}?.status === '1 marker'")
    browser.choose("select[aria-label=view]", "flat")
    click = """
        const canvas = document.querySelector('.scene canvas'), box = canvas.getBoundingClientRect();
        const place = {bubbles: true, clientX: box.left + box.width / 2, clientY: box.top + box.height * arguments[0]};
        canvas.setPointerCapture = canvas.releasePointerCapture = () => {};
        canvas.dispatchEvent(new PointerEvent('pointerdown', place));
        const end = {...place, clientX: place.clientX + (arguments[1] || 0)};
        canvas.dispatchEvent(new PointerEvent('pointerup', end));
        canvas.dispatchEvent(new MouseEvent('click', end));
    """
    browser.wait(f"{SCENE}.stage.frames > 2")
    browser.click(".tools button", "Measure")
    browser.run(click, 0.5)
    browser.wait_for_text("1.000) \u2026")  # on the box
    browser.run(click, 0.25)
    browser.wait_for_text(", 0.000) 4.1")  # four metres ahead and one down, on the ground
    browser.click(".tools button", "Point")
    browser.run(click, 0.5, 100)  # the view is turned
    browser.run(click, 0.5)
    browser.wait_for_text("/clicked_point: (0.0")
    browser.wait_for_text("to 1 subscriber")
    (point,) = points
    assert (point.header.frame_id, round(point.point.z, 6)) == ("map", 1.0)


def test_a_link_may_say_anything(browser: Browser, web: Web, robot: Any) -> None:
    hostile = {
        "fixed": 5,
        "topics": {"a": 1},
        "robots": ["/<img src=x>", 7],
        "options": {"frames": {"size": "large", "names": 3}, "robot:/<img src=x>": 5},
        "hidden": 9,
        "view": {"name": "__proto__", "position": [1, 2, 3], "target": [0, 0, 0], "zoom": "x"},
        "target": {},
    }
    browser.open(panel_link(web.link, "scene", hostile))
    browser.wait(f"{SCENE}?.frames?.problem?.startsWith('no frame is connected to 5')")
    browser.wait_for_text("there is no parameter /<img src=x>")
    assert browser.run(f"return {SCENE}.frames.options.size") == 0.3


def test_older_messages_stay_as_long_as_one_wants(browser: Browser, web: Web, robot: Any) -> None:
    scans, steps = robot.advertise("/scan", LaserScan), robot.advertise("/odom", Odometry)
    options = {"/scan": {"decay": 3600}, "/odom": {"keep": 2}}
    settings = {"fixed": "map", "topics": ["/scan", "/odom"], "options": options}
    browser.open(panel_link(web.link, "scene", settings))
    assert scans.wait_for_subscribers(timeout=20.0) and steps.wait_for_subscribers(timeout=20.0)
    scan = LaserScan(angle_increment=0.1, range_max=9.0, ranges=[1.0, 2.0])
    step = Odometry()
    scan.header.frame_id = step.header.frame_id = "map"
    drawn = "{}?.object.children.length === arguments[0]"
    for count in (1, 2, 3):
        scans.publish(scan)
        browser.wait(drawn.format(display("/scan")), count)
    for place, count in ((0.0, 1), (0.15, 2), (0.3, 2)):
        step.pose.pose.position.x = place
        steps.publish(step)
        last = f"{display('/odom')}.lastPose?.[0].toFixed(2)"
        browser.wait(f"{drawn.format(display('/odom'))} && {last} === arguments[1]", count, f"{place:.2f}")
    step.pose.pose.position.x = 0.35  # nearer than the tolerance
    steps.publish(step)
    scans.publish(scan)
    browser.wait(drawn.format(display("/scan")), 4)
    assert browser.run(f"return {display('/odom')}.lastPose[0].toFixed(2)") == "0.30"
    browser.click("button[aria-label='options of /scan']")
    browser.type("input[data-mark='/scan decay']", "0")
    browser.wait(drawn.format(display("/scan")), 0)
