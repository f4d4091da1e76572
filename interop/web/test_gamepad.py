"""The panel of gamepads: it drives a robot by teleop_twist_joy, and stops it when nobody drives it any more."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from browsing import Browser, Web
from harness import until

from pyros1.msgs.geometry_msgs.msg import Twist
from pyros1.msgs.sensor_msgs.msg import Joy
from pyros1.node import Node
from pyros1.robot_nodes.teleop_twist_joy.node import TeleopNode

Make = Callable[..., Any]
# An Xbox gamepad at rest. Tests change it as a person would.
FAKE = """
window.pad = {
  id: 'Xbox 360 Controller (STANDARD GAMEPAD Vendor: 045e Product: 028e)', index: 0, connected: true,
  mapping: 'standard', timestamp: 0, axes: [0, 0, 0, 0],
  buttons: Array.from({length: 17}, () => ({pressed: false, touched: false, value: 0})),
};
window.isUsed = true;
navigator.getGamepads = () => [window.pad, null, null, null];
document.hasFocus = () => window.isUsed;
"""
XBOX = {"enable_button": 2, "axis_linear": 1, "axis_angular": 0, "scale_linear": 0.7, "scale_angular": 0.4}
# The stick moves a little, since one that only was pushed while the page was busy does not count.
FORWARD = "pad.axes[1] = pad.axes[1] === -1 ? -0.995 : -1; pad.buttons[2] = {pressed: true, touched: true, value: 1};"


@pytest.fixture
def speeds(make_node: Make) -> list[float]:
    """The forward speeds that teleop_twist_joy commands, with the settings of its xbox.config.yaml."""
    node: Node = make_node("teleop_twist_joy")
    for name, value in XBOX.items():
        node.params[f"~{name}"] = value
    TeleopNode(node)
    commanded: list[float] = []
    make_node("base").subscribe("/cmd_vel", Twist, lambda twist: commanded.append(twist.linear.x))
    return commanded


@pytest.fixture
def page(browser: Browser, web: Web, speeds: list[float]) -> Iterator[Browser]:
    """A page whose gamepad is published."""
    open_with_gamepad(browser, web)
    browser.click(".tools button", "Publish")
    browser.wait("/\\/joy: \\d+ sent; 1 subscriber/.test(document.body.innerText)")
    yield browser


def drive(page: Browser, speeds: list[float]) -> None:
    """Press the enable button, and push the stick until the robot drives."""

    def drives() -> bool:
        page.run(FORWARD)
        return bool(speeds) and speeds[-1] > 0.6

    until(drives, "the robot drives")


def open_with_gamepad(browser: Browser, web: Web) -> None:
    script = browser.driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": FAKE})
    browser.open(web.page("gamepad"))
    browser.wait_for_text("Xbox 360 Controller")
    browser.driver.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", script)


def test_a_gamepad_drives_a_robot(page: Browser, speeds: list[float], make_node: Make, tmp_path: Path) -> None:
    """Feature: a gamepad of the browser drives the robot, in the order of joy_node -- `pyros1 web gamepad`"""
    heard: list[Any] = []
    make_node("ear").subscribe("/joy", Joy, heard.append)
    drive(page, speeds)
    page.run(
        "pad.axes[0] = 0.5; pad.buttons[6] = {pressed: true, touched: true, value: 0.75}; pad.buttons[15].value = 1;"
    )
    until(lambda: heard and heard[-1].axes[2] < 0, "the trigger is pressed")
    axes = [-0.474, 1.0, -0.474, 0.0, 0.0, 0.0, -1.0, 0.0]
    assert list(heard[-1].axes) == pytest.approx(axes, abs=0.01)
    assert list(heard[-1].buttons) == [0, 0, 1] + [0] * 8 and heard[-1].header.frame_id == "gamepad"
    page.wait("document.querySelector('[data-axis=\"1\"] .gamepad-value').textContent > '0.95'")
    page.wait("document.querySelector('[data-button=\"2\"]').matches('.pressed')")
    file = tmp_path / "gamepad.png"
    page.picture(file)
    assert file.stat().st_size > 20_000
    page.resize(390, 800)
    assert page.run("return document.documentElement.scrollWidth") <= 390
    page.click(".tools button", "Stop")
    until(lambda: speeds[-1] == 0.0, "the robot stops")
    assert list(heard[-1].axes) == [0.0] * 8


@pytest.mark.parametrize(
    ("leave", "said"),
    [
        ("window.pad = null;", "the gamepad is gone"),
        ("window.isUsed = false;", "this window is not in use"),
        ("window.requestAnimationFrame = () => 0; window.isUsed = false; window.dispatchEvent(new Event('blur'));", ""),
        ("location.href = 'about:blank';", ""),
        ("const begin = performance.now(); while (performance.now() - begin < 3000);", ""),
    ],
    ids=["unplugged", "unused", "hidden", "closed", "frozen"],
)
def test_a_robot_without_a_driver_stops(page: Browser, speeds: list[float], leave: str, said: str) -> None:
    drive(page, speeds)
    before = len(speeds)
    page.run(f"setTimeout(() => {{ {leave} }});")
    until(lambda: 0.0 in speeds[before:], "the robot stops")
    assert not any(speeds[speeds.index(0.0, before) :])
    if said:
        page.wait_for_text(said)


def test_it_goes_on_when_the_gamepad_is_back_but_not_after_a_lost_connection(
    page: Browser, speeds: list[float], web: Web
) -> None:
    drive(page, speeds)
    page.run("window.kept = window.pad; window.pad = null;")
    until(lambda: speeds[-1] == 0.0, "the robot stops")
    page.run("window.pad = window.kept;")
    page.wait("document.querySelector('[data-axis=\"1\"] .gamepad-value').textContent === '0.00'")
    drive(page, speeds)
    page.run("window.isUsed = false;")
    until(lambda: speeds[-1] == 0.0, "the robot stops")
    page.run("window.isUsed = true;")
    page.wait("document.querySelector('[data-axis=\"1\"] .gamepad-value').textContent === '0.00'")
    drive(page, speeds)
    web.process.terminate()
    until(lambda: speeds[-1] == 0.0, "the robot stops")
    page.wait_for_text("the connection was lost, so publishing has stopped")
    page.driver.get("about:blank")
    page.complaints()  # the browser's own, of the connection


def test_those_who_only_look_do_not_drive(browser: Browser, start_web: Callable[..., Web]) -> None:
    open_with_gamepad(browser, start_web("--read-only"))
    browser.wait(
        "[...document.querySelectorAll('.tools button')].find((each) => each.textContent === 'Publish').disabled"
    )


def test_without_a_gamepad_the_panel_says_what_to_do(browser: Browser, web: Web) -> None:
    browser.open(web.page("gamepad"))
    browser.wait_for_text("No gamepad yet")
    browser.wait_for_text("pyros1 run teleop_twist_joy teleop_node")


def test_where_the_browser_gives_no_gamepads_the_panel_says_why(browser: Browser, web: Web) -> None:
    hidden = {"source": "delete Navigator.prototype.getGamepads;"}
    script = browser.driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", hidden)
    browser.open(web.page("gamepad"))
    browser.wait_for_text("only pages at localhost or https addresses")
    browser.driver.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", script)
