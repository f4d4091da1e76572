"""The panel of turtles: it shows where they are and what they draw."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from browsing import Browser, Web

from pyros1.msgs import load_service
from pyros1.node import Node

PATIENCE = 40.0
COLOUR = """
const canvas = document.querySelector('.turtles canvas'), scale = canvas.width / 500;
const [x, y] = [arguments[0] * 45, 499 - arguments[1] * 45].map((each) => Math.round(each * scale));
return [...canvas.getContext('2d').getImageData(x, y, 1, 1).data].slice(0, 3).join(' ');
"""
HERE = f"(() => {{ {COLOUR} }})(...arguments)"


def call(node: Node, service: str, kind: str, *args: object) -> None:
    node.wait_for_service(service, PATIENCE)
    cls = load_service(kind)
    node.service(service, cls).call(cls._request_class(*args), PATIENCE)


def test_turtles_draw_on_the_page(
    browser: Browser,
    web: Web,
    start_program: Callable[..., Any],
    make_node: Callable[..., Node],
    tmp_path: Path,
) -> None:
    """Feature: turtles on the web page and in the terminal -- `pyros1 web turtles`, `pyros1 run turtlesim
    turtle_view`
    """
    browser.open(web.page(""))
    tabs = "[...document.querySelectorAll('.tab')].map((tab) => tab.textContent)"
    browser.wait(f"{tabs}.includes('Plot') && !{tabs}.includes('Turtles')")  # most robots have none
    browser.open(web.page("turtles"))
    browser.wait(f"{tabs}.includes('Turtles')")
    browser.wait_for_text("No turtles here")
    start_program("run", "turtlesim", "turtlesim_node")
    user = make_node("user")
    call(user, "/spawn", "turtlesim/Spawn", 2.0, 3.0, 0.0, "painter")
    browser.wait_for_text("painter  x 2.00  y 3.00")
    assert browser.wait(HERE, 5.0, 9.0) == "69 86 255"
    call(user, "/painter/set_pen", "turtlesim/SetPen", 255, 200, 0, 12, 0)
    for x, y, theta in [(9.0, 3.0, 1.57), (9.0, 9.0, 3.14), (2.0, 9.0, -1.57), (2.0, 6.0, 2.2)]:
        call(user, "/painter/teleport_absolute", "turtlesim/TeleportAbsolute", x, y, theta)
    browser.wait(f"{HERE} === '255 200 0'", 5.0, 9.0)
    browser.wait_for_text("painter  x 2.00  y 6.00  θ 2.20")
    # The turtles are on top of the drawing: stock's and this one's shells are not blue.
    browser.wait(f"{HERE} !== '69 86 255'", 5.544, 5.3)
    file = tmp_path / "turtles.png"
    browser.picture(file)
    assert file.stat().st_size > 5_000
    browser.resize(390, 800)
    browser.wait("document.querySelector('.turtles canvas').clientWidth <= 390")
    assert browser.run("return document.documentElement.scrollWidth") <= 390
    browser.click(".tools button", "Clear")
    browser.wait(f"{HERE} === '69 86 255'", 5.0, 9.0)
    browser.click(".tools button", "Reset")
    browser.wait("!document.body.innerText.includes('painter')")


def test_without_turtles_the_panel_says_so_in_its_middle(browser: Browser, web: Web) -> None:
    browser.resize(1400, 900)
    browser.open(web.page("turtles"))
    browser.wait_for_text("No turtles here")
    assert browser.run("return document.querySelector('.hint h3').getBoundingClientRect().top") > 250
