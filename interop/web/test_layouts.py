"""Panels beside each other, and layouts with names.

Feature: the page: token, rejected host names and origins, custom layouts, a menu on phones, reconnecting to a
    restarted server
"""

from __future__ import annotations

import json
from pathlib import Path

from browsing import Browser, Web
from selenium.webdriver.common.keys import Keys

from pyros1.web.links import layout_link

PANELS = "[...document.querySelectorAll('.panel')].map((each) => each.dataset.panel)"


def test_panels_are_split_changed_and_closed(browser: Browser, web: Web) -> None:
    browser.open(web.page("plot"))
    browser.click("button[title='add a panel to the right']")
    browser.wait(f'JSON.stringify({PANELS}) === \'["plot","plot"]\'')
    browser.run("document.querySelectorAll('.kind')[1].value = 'console'")
    browser.run("document.querySelectorAll('.kind')[1].dispatchEvent(new Event('change'))")
    browser.wait(f'JSON.stringify({PANELS}) === \'["plot","console"]\'')
    browser.driver.refresh()  # it is kept
    browser.wait(f'JSON.stringify({PANELS}) === \'["plot","console"]\'')
    browser.click("button[title='close this panel']")
    browser.wait(f"JSON.stringify({PANELS}) === '[\"console\"]'")


def test_two_pages_keep_what_each_has_changed(browser: Browser, web: Web) -> None:
    driver = browser.driver
    browser.open(web.page("plot"))
    browser.wait("document.querySelector('[data-panel=plot]')")
    first = driver.current_window_handle
    driver.switch_to.new_window("tab")
    try:
        browser.open(web.page("console"))
        browser.click("button[title='add a panel below']")
        browser.wait(f"{PANELS}.length === 2")
    finally:
        driver.close()
        driver.switch_to.window(first)
    browser.click("button[title='add a panel to the right']")
    browser.wait(f'JSON.stringify({PANELS}) === \'["plot","plot"]\'')
    browser.click(".tab", "Console")
    browser.wait(f'JSON.stringify({PANELS}) === \'["console","console"]\'')


def test_a_layout_that_is_made_in(browser: Browser, web: Web) -> None:
    browser.open(web.page(""))
    browser.click("#bar button", "Layouts")
    browser.click(".layouts .title", "Tutorial")
    browser.wait(f"{PANELS}.includes('plot') && {PANELS}.includes('console')")
    browser.wait("[...document.querySelectorAll('.chip .name')].some((each) => each.textContent === '/velocity/data')")
    assert not browser.run("return document.querySelector('dialog').open")


def test_a_link_names_a_built_in_layout(browser: Browser, web: Web) -> None:
    browser.open(web.page("Tutorial"))
    browser.wait(f'JSON.stringify({PANELS}) === \'["graph","plot","topics","console"]\'')


def test_a_layout_of_ones_own(browser: Browser, web: Web, tmp_path: Path) -> None:
    browser.open(web.page("console"))
    browser.click("button[title='add a panel below']")
    browser.click("#bar button", "Layouts")
    browser.type("[aria-label='name of the layout']", "mine <b>")
    browser.click(".layouts form button")
    browser.click("dialog button", "Close")
    browser.click(".tab", "Plot")
    browser.wait(f"JSON.stringify({PANELS}) === '[\"plot\"]'")
    browser.click("#bar button", "Layouts")
    browser.click(".layouts .title", "mine <b>")
    browser.wait(f'JSON.stringify({PANELS}) === \'["console","console"]\'')

    file = tmp_path / "layout.json"
    file.write_text(json.dumps({"form": "pyros1 layout 1", "name": "of a file", "tree": {"panel": "plot"}}))
    browser.click("#bar button", "Layouts")
    browser.driver.find_element("css selector", ".layouts input[type=file]").send_keys(str(file))
    browser.click(".layouts .title", "of a file")
    browser.wait(f"JSON.stringify({PANELS}) === '[\"plot\"]'")


def test_a_link_with_a_strange_layout_does_no_harm(browser: Browser, web: Web) -> None:
    deep = {"panel": "console"}
    for _ in range(50):
        deep = {"split": "row", "parts": [deep, {"panel": "plot"}]}  # type: ignore[dict-item]
    trees = [None, 1, [], {"panel": "x"}, {"parts": []}, {"parts": [{"panel": "plot", "settings": 5}] * 100}, deep]
    for tree in trees:
        browser.run("localStorage.clear()") if tree is not trees[0] else None
        encode = "btoa(JSON.stringify(arguments[0])).replaceAll('+', '-').replaceAll('/', '_').replaceAll('=', '')"
        browser.open(web.page("plot"))
        text = browser.run(f"return {encode}", tree)
        browser.open(web.page(f"plot={text}"))
        browser.wait("document.querySelectorAll('.panel').length > 0")
        assert browser.run("return document.querySelectorAll('.panel').length") <= 8
    browser.open(web.page("%E0%A4%A"))
    browser.wait("document.querySelectorAll('.panel').length > 0")


def test_panels_of_layouts_that_are_made_in_have_room(browser: Browser, web: Web) -> None:
    least = "Math.min(...[...document.querySelectorAll('.panel .body')].map((body) => body.clientHeight))"
    charts = "Math.min(...[...document.querySelectorAll('.plot .charts')].map((area) => area.clientHeight))"
    for size in ((1280, 800), (390, 844)):
        browser.resize(*size)
        browser.open(web.page("plot"))
        for name in ("Mobile robot", "Arm", "Tutorial"):
            browser.click("#bar button", "Layouts")
            browser.click(".layouts .title", name)
            browser.wait(f"{charts} >= 90 && {least} >= 100")
            assert browser.run("return document.documentElement.scrollWidth <= innerWidth")


def drag(browser: Browser, start: str, end: tuple[float, float], panel: str) -> None:
    """Drag with the mouse from an element to a place within a panel, from 0 to 1 across and down."""
    corner = browser.run(f"return document.querySelector({json.dumps(start)}).getBoundingClientRect().toJSON()")
    box = browser.run(f"return document.querySelector('[data-panel={panel}]').getBoundingClientRect().toJSON()")
    places = [(corner["x"] + corner["width"] / 2, corner["y"] + corner["height"] / 2)]
    places += [(box["x"] + end[0] * box["width"], box["y"] + end[1] * box["height"])]
    kinds = [("mousePressed", 0), ("mouseMoved", 1), ("mouseMoved", 1), ("mouseReleased", 1)]
    for kind, place in kinds:
        x, y = places[place]
        at = {"type": kind, "x": x, "y": y, "button": "left", "buttons": 1, "clickCount": 1}
        browser.driver.execute_cdp_cmd("Input.dispatchMouseEvent", at)


def three(browser: Browser, web: Web) -> None:
    """Show three panels beside each other."""
    browser.resize(1400, 900)
    parts = [{"panel": name} for name in ("plot", "console", "topics")]
    browser.open(layout_link(web.link, "three", {"split": "row", "sizes": [2, 1, 1], "parts": parts}))
    browser.wait(f'JSON.stringify({PANELS}) === \'["plot","console","topics"]\'')


def test_panels_are_dragged_to_others(browser: Browser, web: Web) -> None:
    three(browser, web)
    drag(browser, "[data-panel=plot] .grip", (0.5, 0.5), "topics")  # onto it: they are swapped
    browser.wait(f'JSON.stringify({PANELS}) === \'["topics","console","plot"]\'')
    drag(browser, "[data-panel=topics] .grip", (0.5, 0.95), "console")  # below it
    browser.wait(f'JSON.stringify({PANELS}) === \'["console","topics","plot"]\'')
    places = "['console', 'topics'].map((name) => document.querySelector(`[data-panel=${name}]`).offsetTop)"
    above, below = browser.run(f"return {places}")
    assert above < below
    browser.run("document.querySelector('[data-panel=plot] .grip').focus()")
    browser.driver.switch_to.active_element.send_keys(Keys.ARROW_LEFT)
    browser.wait(f'JSON.stringify({PANELS}) === \'["console","plot","topics"]\'')
    browser.driver.switch_to.active_element.send_keys(Keys.ARROW_LEFT)
    browser.wait(f'JSON.stringify({PANELS}) === \'["plot","console","topics"]\'')
    browser.driver.refresh()  # it is kept
    browser.wait(f'JSON.stringify({PANELS}) === \'["plot","console","topics"]\'')


def test_a_split_is_moved_by_the_keyboard(browser: Browser, web: Web) -> None:
    three(browser, web)
    handle = browser.driver.find_element("css selector", "[role=separator]")
    assert handle.get_attribute("aria-orientation") == "vertical"
    assert handle.get_attribute("aria-valuenow") == "67"
    wide = browser.run("return document.querySelector('.panel').offsetWidth")
    handle.send_keys(Keys.ARROW_LEFT * 3)
    assert browser.run("return document.querySelector('.panel').offsetWidth") < wide - 50
    assert int(handle.get_attribute("aria-valuenow")) < 60
    handle.send_keys(Keys.END)
    assert handle.get_attribute("aria-valuenow") == "89"


def test_panels_with_wrong_settings_begin_anew(browser: Browser, web: Web) -> None:
    wrong = {"plot": {"curves": 7}, "console": {"hidden": 3}, "frames": {"closed": 5}}
    parts = [{"panel": name, "settings": settings} for name, settings in wrong.items()]
    browser.open(layout_link(web.link, "wrong", {"split": "row", "parts": parts}))
    for text in ("No curves yet", "No messages yet", "No frames yet"):
        browser.wait_for_text(text)
    assert browser.run("return document.querySelectorAll('[data-panel=plot] form').length") == 1
    assert "has failed" not in browser.run("return document.body.textContent")


def test_a_single_panel_has_nowhere_to_go(browser: Browser, web: Web) -> None:
    browser.open(web.page("plot"))
    browser.wait("document.querySelector('.arrangement') && !document.querySelector('.grip')")
