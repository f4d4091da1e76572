"""The guide on the page, beside panels that show what its steps do.

Feature: the guide in a browser -- `pyros1 web guide`: the steps next to live panels
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from browsing import Browser, Web

from pyros1.msgs.std_msgs.msg import Float64

TITLE = "document.querySelector('.guide-text h2').textContent"


def test_a_step_beside_what_it_does(browser: Browser, web: Web, tmp_path: Path) -> None:
    browser.open(web.page("guide"))
    browser.wait_for_text("1. A package")
    browser.wait("document.querySelectorAll('.panel').length === 2")  # the graph is beside it
    assert browser.run("return document.querySelector('[aria-label=\"previous page\"]').disabled")
    browser.click(".guide-end button", "Next: A publisher and a subscriber")
    browser.wait(f"{TITLE} === '2. A publisher and a subscriber'")
    code = "document.querySelector('.guide-file pre').textContent"
    assert browser.run(f"return {code}").startswith("#!/usr/bin/env python3\nimport pyros1\n")
    name = browser.run("return document.querySelector('.guide-file figcaption').firstChild.textContent")
    assert name == "my_robot/scripts/counter"
    assert not browser.run("return document.querySelector('.guide-text').innerHTML.includes('```')")
    browser.choose('.tools select[aria-label="step or page"]', "simulator")
    browser.wait(f"{TITLE}.startsWith('7. ')")
    browser.wait("document.querySelector('.guide-picture img')?.naturalWidth === 1280")
    browser.picture(tmp_path / "guide.png")
    width = "document.querySelector('.guide-text').clientWidth"
    before = browser.run(f"return {width}")
    browser.click(".guide-beside button", "Graph")  # is there
    browser.click(".guide-beside button", "Plot")
    browser.wait_for_text("/force_cmd/data")
    assert browser.run("return [...document.querySelectorAll('.panel')].map((each) => each.dataset.panel)") == [
        "guide",
        "graph",
        "plot",
    ]
    assert browser.run(f"return {width}") >= before, "the text keeps its room"
    browser.driver.refresh()
    browser.wait(f"document.querySelector('.guide-text h2') && {TITLE}.startsWith('7. ')")  # where one was
    browser.resize(390, 800)
    browser.wait("document.querySelector('.guide-text').clientWidth <= 390")
    assert browser.run("return document.documentElement.scrollWidth") <= 390
    assert browser.complaints() == []


def test_a_page_with_a_table_and_links(browser: Browser, web: Web, tmp_path: Path) -> None:
    browser.open(web.page("guide"))
    browser.wait_for_text("1. A package")
    browser.choose('.tools select[aria-label="step or page"]', "howto/browser")
    browser.wait(f"{TITLE} === 'The robot in a browser'")
    first = "document.querySelector('.guide-table td').textContent"
    assert browser.run(f"return {first}") == "Graph"
    browser.picture(tmp_path / "page.png")
    text = browser.run("return document.querySelector('.guide-text').innerText")
    assert "](" not in text and "`" not in text and "|--" not in text
    assert not browser.run("return document.querySelector('.guide-end')")
    browser.click(".guide-link", "who may connect")
    browser.wait(f"{TITLE} === 'Who may connect'")
    browser.driver.refresh()
    browser.wait(f"document.querySelector('.guide-text h2') && {TITLE} === 'Who may connect'")  # where one was
    browser.resize(390, 800)
    browser.wait("document.querySelector('.guide-text').clientWidth <= 390")
    assert browser.run("return document.documentElement.scrollWidth") <= 390
    assert browser.complaints() == []


def test_an_exercise_is_checked(browser: Browser, web: Web, make_node: Callable[..., Any], tmp_path: Path) -> None:
    browser.open(web.page("guide"))
    browser.wait_for_text("1. A package")
    browser.choose('.tools select[aria-label="step or page"]', "publisher")
    browser.click(".guide-end button", "Check the exercise")
    result = "document.querySelector('.guide-result').textContent"
    browser.wait(f"{result}.startsWith('Not yet: no node publishes /topic2')")
    assert str(Path.cwd()) in browser.run(f"return {result}")
    browser.run("document.querySelector('.guide-text').scrollTo(0, 1e6)")
    browser.picture(tmp_path / "missing.png")
    node = make_node("counter")
    publisher = node.advertise("topic2", Float64)
    timer = node.timer(0.1, lambda event: publisher.publish(1.0))
    browser.click(".guide-end button", "Check the exercise")
    browser.wait(f"{result} === '✓ Done.'")
    timer.shutdown()
    browser.picture(tmp_path / "done.png")
    assert browser.complaints() == []
