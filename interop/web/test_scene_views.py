"""From where one looks at the 3D scene, and what of it is kept."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from browsing import Browser, Web

from pyros1.msgs.geometry_msgs.msg import TransformStamped
from pyros1.tf import StaticTransformBroadcaster
from pyros1.web.links import panel_link

SCENE = "document.querySelector('.scene')?.scene"
EYE = f"""
    const {{camera, controls}} = {SCENE}.stage;
    const up = camera.up.clone().set(0, 1, 0).applyQuaternion(camera.quaternion);
    const way = controls.target.clone().sub(camera.position).normalize();
    return [camera.position.toArray(), way.toArray(), up.toArray()];
"""
DRAG = f"""
    const {{canvas}} = {SCENE}.stage;
    canvas.setPointerCapture = canvas.releasePointerCapture = () => {{}};
    const fire = (kind, x) => canvas.dispatchEvent(new PointerEvent(kind, {{
        bubbles: true, pointerId: 1, button: 0, clientX: 500 + x, clientY: 400}}));
    fire('pointerdown', 0); fire('pointermove', arguments[0]); fire('pointerup', arguments[0]);
"""
KEPT = "JSON.parse(localStorage.getItem('pyros1.layouts')).scene.settings"


ROBOT = "<robot name='box'><link name='base'><visual><geometry><box size='1 1 1'/></geometry></visual></link></robot>"


@pytest.fixture
def move(make_node: Callable[..., Any]) -> Callable[..., None]:
    """Return a function that puts the frame base somewhere in the frame map, and turns it by quarters around z."""
    node = make_node("robot")
    node.params["/robot_description"] = ROBOT

    def put(x: float, quarters: int = 0) -> None:
        link = TransformStamped(child_frame_id="base")
        link.header.frame_id, link.transform.translation.x = "map", x
        link.transform.rotation.z, link.transform.rotation.w = (
            np.sin(quarters * np.pi / 4),
            np.cos(quarters * np.pi / 4),
        )
        StaticTransformBroadcaster(node).send_transform([link])

    put(2.0)
    return put


def seen(browser: Browser, eye: list[float], way: list[float], up: list[float]) -> bool:
    return np.allclose(browser.run(EYE), [eye, way, up], atol=1e-3)


def test_one_sits_in_a_frame_and_looks_along_its_axes(browser: Browser, web: Web, move: Callable[..., None]) -> None:
    browser.open(panel_link(web.link, "scene", {"fixed": "map", "target": "base"}))
    browser.wait(f"{SCENE}?.frames?.poses.size === 2")
    browser.choose("select[aria-label=view]", "frame")
    assert seen(browser, [2, 0, 0], [1, 0, 0], [0, 0, 1])
    browser.choose("select[aria-label=axis]", "z")  # as a camera looks: what is on its right has a larger x
    assert seen(browser, [2, 0, 0], [0, 0, 1], [0, -1, 0])
    move(5.0, quarters=1)
    browser.wait(f"Math.abs({SCENE}.stage.camera.position.x - 5) < 1e-3")
    assert seen(browser, [5, 0, 0], [0, 0, 1], [1, 0, 0])
    browser.choose("select[aria-label=axis]", "-y")
    assert seen(browser, [5, 0, 0], [1, 0, 0], [0, 0, 1])
    browser.run(DRAG, 100)
    assert browser.run("return document.querySelector('select[aria-label=axis]').selectedOptions[0].text") == "turned"
    aside = [np.cos(0.5), -np.sin(0.5), 0]
    assert seen(browser, [5, 0, 0], aside, [0, 0, 1])
    browser.driver.refresh()  # it is kept as a place in the frame, wherever that is now
    browser.wait(f"Math.abs(({SCENE}?.stage?.camera.position.x ?? 0) - 5) < 1e-3")
    assert seen(browser, [5, 0, 0], aside, [0, 0, 1])
    browser.choose("select[aria-label='followed frame']", "")  # that is the fixed frame
    assert seen(browser, [0, 0, 0], [aside[1], -aside[0], 0], [0, 0, 1])
    browser.click(".tools button", "Reset")
    assert seen(browser, [0, 0, 0], [1, 0, 0], [0, 0, 1])


def test_the_view_turns_around_what_is_up_and_only_then_is_kept(
    browser: Browser, web: Web, move: Callable[..., None]
) -> None:
    browser.open(panel_link(web.link, "scene", {"fixed": "map"}))
    browser.wait(f"{SCENE}?.frames?.poses.size === 2")
    browser.click(".display input")  # frames are not shown
    assert browser.run(f"return [{KEPT}.hidden, {KEPT}.view]") == [["frames"], None]
    browser.choose("select[aria-label=view]", "top")
    assert browser.run(f"return {KEPT}.view") == {"name": "top"}
    _, way, up = browser.run(EYE)
    assert np.allclose([way, up], [[0, 0, -1], [1, 0, 0]], atol=1e-3)
    browser.choose("select[aria-label=view]", "orbit")
    (before, *_) = browser.run(EYE)
    browser.run(DRAG, 0)  # a click turns nothing
    assert browser.run(f"return {KEPT}.view") == {"name": "orbit"}
    browser.run(DRAG, 100)
    (after, *_) = browser.run(EYE)
    assert abs(after[2] - before[2]) < 1e-6 < abs(after[0] - before[0])
    assert np.allclose(browser.run(f"return {KEPT}.view.position"), after, atol=1e-3)


def test_a_robot_alone_stays_in_the_picture_until_the_view_is_turned(
    browser: Browser, web: Web, move: Callable[..., None]
) -> None:
    robot = f"{SCENE}?.displays.get('robot:/robot_description')?.display"
    there = f"Math.abs(({robot}?.links.get('base')?.group.position.x ?? -1) - "
    shown = f"{SCENE}.stage.shows({robot}.object)"
    browser.open(panel_link(web.link, "scene", {"fixed": "map", "hidden": ["frames"]}))
    browser.wait(f"{there} 2) < 1e-3 && {shown}")
    move(500.0)
    browser.wait(f"{there} 500) < 1e-3 && {shown}")
    browser.run(DRAG, 100)
    move(20.0)
    browser.wait(f"{there} 20) < 1e-3")
    assert not browser.run(f"return {shown}")
    browser.click(".tools button", "Reset")
    browser.wait(shown)
