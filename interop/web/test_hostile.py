"""What no robot should send: the page goes on drawing, and nothing of it reaches the browser's console."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from browsing import Browser, Web

from pyros1.msgs.geometry_msgs.msg import Point, Point32, PolygonStamped, PoseStamped, WrenchStamped
from pyros1.msgs.nav_msgs.msg import OccupancyGrid, Path
from pyros1.msgs.rosgraph_msgs.msg import Log
from pyros1.msgs.std_msgs.msg import Float64, String
from pyros1.msgs.visualization_msgs.msg import Marker, MarkerArray
from pyros1.web.links import panel_link

Make = Callable[..., Any]
NAN, INF, HUGE = float("nan"), float("inf"), 1e308


def placed(message: Any) -> Any:
    message.header.frame_id = "map"
    return message


def absurd_marker(kind: int) -> Marker:
    marker = placed(Marker(id=kind, type=kind, text="W" * 300, mesh_resource="javascript:alert(1).stl"))
    odd = bool(kind % 2)
    marker.scale.x = marker.scale.y = marker.scale.z = HUGE if odd else 1e6
    marker.pose.position.x, marker.color.a = NAN if odd else -1e6, 1.0
    marker.points = [Point(0, 0, 0), Point(HUGE, NAN, -INF) if odd else Point(1e6, -1e6, 0), Point(1, 1, 1)]
    return marker


def test_numbers_that_nothing_can_draw(browser: Browser, web: Web, make_node: Make) -> None:
    node = make_node("robot")
    path = placed(Path(poses=[PoseStamped(), PoseStamped(), PoseStamped()]))
    path.poses[0].pose.position.x, path.poses[1].pose.position.y = NAN, HUGE
    polygon = placed(PolygonStamped())
    polygon.polygon.points = [Point32(1, 2, 3), Point32(0, 3e38, 0), Point32(0, 0, INF)]
    wrench = placed(WrenchStamped())
    wrench.wrench.force.x, wrench.wrench.torque.y = HUGE, 1e300
    grid = placed(OccupancyGrid(data=[100] * 20_000))
    grid.info.width, grid.info.height, grid.info.resolution = 20_000, 1, 0.05
    messages = {"path": path, "polygon": polygon, "wrench": wrench, "map": grid, "nothing": MarkerArray()}
    messages["markers"] = MarkerArray(markers=[absurd_marker(kind) for kind in range(14)])
    for name, message in messages.items():
        node.advertise(f"/{name}", type(message), latch=True).publish(message)
    browser.open(panel_link(web.link, "scene", {"topics": [f"/{name}" for name in messages], "fixed": "map"}))
    for words in ("2 of 3 omitted: not finite", "1 corner", "numbers are not finite", "one of 3 across"):
        browser.wait("document.querySelector('.panel')?.textContent.includes(arguments[0])", words)
    # Half of them have numbers that are none, and an arrow has three points.
    browser.wait("document.querySelector('.scene').scene.displays.get('/markers')?.display.status === '5 markers'")
    drawn = browser.run("return document.querySelector('.scene').scene.stage.frames")
    browser.run("document.querySelector('.scene').scene.stage.draw()")
    browser.wait("document.querySelector('.scene').scene.stage.frames > arguments[0]", drawn)
    refused = [text for text in browser.complaints() if "package_file" not in text]
    assert not refused, refused


def test_values_between_which_an_axis_has_no_steps(browser: Browser, web: Web, make_node: Make) -> None:
    publisher = make_node("robot").advertise("/value", Float64)
    browser.open(panel_link(web.link, "plot", {"curves": ["/value/data"], "period": 2}))
    assert publisher.wait_for_subscribers(timeout=20)
    for one, other in ((1e17, 1e17 + 16), (HUGE, -HUGE), (5e-324, 0.0)):
        for number in range(6):
            publisher.publish(Float64((one, other)[number % 2]))
        browser.wait(
            "document.querySelector('.plot').plot.lines[0]?.points.lastValue() === arguments[0]", other, seconds=40
        )


def test_a_log_of_endless_lines(browser: Browser, web: Web, make_node: Make) -> None:
    node = make_node("robot")
    publisher = node.advertise("/rosout", Log)
    browser.open(web.page("console"))
    assert publisher.wait_for_subscribers(timeout=20)
    for number in range(200):
        publisher.publish(Log(level=8, name="/robot", msg="x\x1b[31m\u202e" * 20_000, line=number))
    publisher.publish(Log(level=16, name="/robot", msg="the last one"))
    browser.wait_for_text("the last one", seconds=40)
    longest = "Math.max(...[...document.querySelectorAll('.entry .text')].map(({textContent}) => textContent.length))"
    assert 100 < browser.run(f"return {longest}") <= 1000


def test_types_and_names_that_are_words_of_javascript(browser: Browser, web: Web, make_node: Make) -> None:
    node = make_node("constructor")
    for name in ("toString", "__proto__", "constructor"):
        node.advertise(f"/{name}", String, latch=True)
    node.advertise("/valueOf", String, latch=True).publish(String("hello"))
    node.params["/hasOwnProperty"] = {"constructor": 1, "__proto__": {"x": 2}}
    for panel, words in (("scene", "TF"), ("graph", ""), ("topics", "valueOf"), ("params", "hasOwnProperty")):
        browser.open(web.page(panel))
        browser.wait("document.querySelector('.panel .body')?.childElementCount > 0")
        browser.wait_for_text(words)
    browser.open(web.page("scene"))
    browser.wait("document.querySelector('.scene')?.scene?.types['/toString'] === 'std_msgs/String'")
    assert "native code" not in browser.run("return document.documentElement.outerHTML")
