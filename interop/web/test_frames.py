"""The tree of coordinate frames."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from browsing import Browser, Web

from pyros1.ground.timing import Time
from pyros1.msgs.geometry_msgs.msg import TransformStamped
from pyros1.msgs.tf2_msgs.msg import TFMessage
from pyros1.node import Node
from pyros1.tf import StaticTransformBroadcaster, TransformBroadcaster
from pyros1.web.links import layout_link


def test_the_tree(
    browser: Browser, web: Web, start_program: Callable[..., Any], make_node: Callable[..., Node]
) -> None:
    browser.open(web.page("frames"))
    browser.wait_for_text("No frames yet")
    start_program("run", "tf2_ros", "static_transform_publisher", "1", "2", "0", "0", "0", "1.5707963", "map", "odom")
    sender = make_node("sender")
    broadcaster = TransformBroadcaster(sender)
    link = TransformStamped(child_frame_id="base_link")
    link.header.frame_id, link.transform.translation.z, link.transform.rotation.w = "odom", 0.5, 1.0

    def send(_: object) -> None:
        link.header.stamp = sender.now()
        broadcaster.send_transform(link)

    sender.timer(0.05, send)
    rows = "[...document.querySelectorAll('.frames tbody tr')].map((each) => each.innerText.split(/[\\s▾▸]+/))"
    names = f"{rows}.map((row) => row.find((word) => /[a-z]/.test(word))).join()"
    browser.wait(f"{names} === 'map,odom,base_link'")
    browser.wait(f"{rows}[1].includes('static') && {rows}[2].includes('Hz')")
    with browser.pressed(".frames tr", "base_link"):
        age = f"{rows}[2].join()"
        browser.wait(f"{age} !== arguments[0]", browser.run(f"return {age}"))  # the row goes on
    browser.wait("/translation\\s+0\\s+0\\s+0.5\\s+m/.test(document.querySelector('.detail').innerText)")
    browser.click(".frames tr", "odom")
    browser.wait("/translation\\s+1\\s+2\\s+0\\s+m/.test(document.querySelector('.detail').innerText)")
    press = "document.activeElement.dispatchEvent(new KeyboardEvent('keydown', {key: arguments[0], bubbles: true}))"
    browser.run("document.querySelectorAll('.frames tbody tr')[1].focus()")
    for key in ("ArrowDown", "Enter"):
        browser.run(press, key)
    browser.wait("document.querySelector('.detail').innerText.includes('odom → base_link')")
    browser.click(".fold")
    browser.wait(f"{rows}.length === 1")


def test_a_phone_shows_all_frames_above_another_panel(
    browser: Browser, web: Web, make_node: Callable[..., Node]
) -> None:
    links = [TransformStamped(child_frame_id=f"link{number}") for number in range(16)]
    for link in links:
        link.header.frame_id, link.transform.rotation.w = "map", 1.0
    StaticTransformBroadcaster(make_node("sender")).send_transform(links)
    browser.resize(390, 844)
    parts = [{"panel": "frames"}, {"panel": "console"}]
    browser.open(layout_link(web.link, "two", {"split": "column", "sizes": [1, 1], "parts": parts}))
    browser.wait("document.querySelectorAll('.frames tbody tr').length === 17")
    high, seen = browser.run(
        "const { scrollHeight, clientHeight } = document.querySelector('.frames'); return [scrollHeight, clientHeight]"
    )
    assert high == seen > 480


def test_transforms_of_a_recording(browser: Browser, web: Web, make_node: Callable[..., Node]) -> None:
    publisher = make_node("player").advertise("/tf", TFMessage)
    link = TransformStamped(child_frame_id="base_link")
    link.header.frame_id, link.header.stamp, link.transform.rotation.w = "odom", Time(1_400_000_000, 0), 1.0
    browser.open(web.page("frames"))
    browser.wait_for_text("No frames yet")
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(TFMessage([link]))
    browser.wait_for_text("pyros1 bag play --clock")
    browser.wait("document.querySelector('.frames tbody')?.innerText.includes('years')")
    assert not browser.run("return document.querySelectorAll('.frames td.wrong').length")
