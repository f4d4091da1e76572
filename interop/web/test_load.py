"""Much at once: the page stays quick and small, shows the newest, and the server's memory is bounded.

Feature: the page under load: 10,000 log messages and 20,000 numbers per second, images, a cloud of a million points
    -- it stays responsive and shows the newest data; the server's memory is bounded
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from browsing import Browser, Web

from pyros1.web.links import layout_link

LOAD = Path(__file__).resolve().parents[1] / "bench" / "web.py"
ROWS = "document.querySelectorAll('.entry').length"
NUMBERS = "[...document.querySelectorAll('.entry .text')].map((each) => Number(/\\d+/.exec(each.textContent)) || 0)"
NEWEST = f"Math.max(0, ...{NUMBERS})"
Start = Callable[[str], subprocess.Popen[bytes]]


@pytest.fixture
def start_load(environ: dict[str, str]) -> Iterator[Start]:
    """Return a function that publishes a load of interop/bench/web.py until the test ends."""
    running: list[subprocess.Popen[bytes]] = []

    def start(kind: str) -> subprocess.Popen[bytes]:
        words = [sys.executable, str(LOAD), "--load", kind]
        running.append(subprocess.Popen(words, env={**os.environ, **environ}, stdin=subprocess.DEVNULL))
        return running[-1]

    yield start
    for process in running:
        process.terminate()
    for process in running:
        process.wait(20)


@pytest.mark.parametrize("size", [(1280, 800), (390, 844)], ids=["wide", "phone"])
def test_a_flooded_console_has_few_rows_and_shows_the_newest(
    browser: Browser, web: Web, start_load: Start, size: tuple[int, int]
) -> None:
    browser.resize(*size)
    browser.open(web.page("console"))
    start_load("log")
    browser.wait(f"{NEWEST} > 30000", seconds=60)
    assert browser.run(f"return {ROWS}") < 100
    assert browser.run("return document.querySelector('.log').getBoundingClientRect().bottom") <= size[1]
    browser.run("window.newest = 0")
    browser.wait(f"(window.newest ||= {NEWEST}) && {NEWEST} > window.newest + 20000", seconds=60)  # it goes on
    browser.click("button", "Pause")
    browser.run("document.querySelector('.log').dispatchEvent(new KeyboardEvent('keydown', {key: 'ArrowUp'}))")
    detail = browser.wait("document.querySelector('.detail:not([hidden])')?.getBoundingClientRect().toJSON()")
    assert detail["height"] > 40 and detail["bottom"] <= size[1]


def test_messages_that_the_page_did_not_get_are_counted(
    browser: Browser, web: Web, make_node: Callable[..., Any]
) -> None:
    browser.open(web.page("console"))
    node = make_node("talker")
    node.log.info("one")
    browser.wait_for_text("one")
    missing = "document.querySelector('.tools').innerText.includes('missing')"
    assert not browser.run(f"return {missing}")
    browser.run(
        "const stream = [...robot._streams.values()].find(({view}) => view === 'console');"
        "const after = (dropped, number) => stream.on.data({run: stream.args.run, dropped,"
        "  entries: [[number, 1e9, 2, '/x', 'later', '', '', 0, [], 0]]});"
        "after(1, 100); after(20000, 30000);"  # as the server tells them
    )
    browser.wait_for_text("20 k missing")
    browser.click("button", "Clear")
    browser.wait(f"!{missing}")


PANELS = [
    [{"panel": "console"}, {"panel": "plot", "settings": {"curves": [f"/wave{number}/data" for number in range(20)]}}],
    [
        {"panel": "image", "settings": {"topic": "/camera"}},
        {"panel": "scene", "settings": {"fixed": "map", "topics": ["/cloud"]}},
    ],
]
NEWEST_VALUES = "document.querySelector('.plot')?.plot.curves.map((curve) => curve.points.get(-1)?.lastValue())"
MAX_MEMORY = 700_000  # kB; about 330 MB are used on a machine that is not busy


@pytest.mark.timeout(170)  # on a busy machine, each wait takes long; a hang is noticed after three minutes
def test_log_curves_images_and_a_cloud_at_once(browser: Browser, web: Web, start_load: Start) -> None:
    """10,000 log messages, 20,000 numbers, 30 images and 10 clouds of a million points per second, on one page."""
    columns = [{"split": "column", "parts": two} for two in PANELS]
    browser.resize(1400, 900)
    browser.open(layout_link(web.link, "load", {"split": "row", "parts": columns}))
    for kind in ("log", "waves", "image", "cloud"):
        start_load(kind)
    browser.wait(f"{NEWEST} > 10000", seconds=90)
    browser.wait(f"{NEWEST_VALUES}?.length === 20 && {NEWEST_VALUES}.every(Number.isFinite)", seconds=90)
    browser.wait("document.querySelector('.image canvas')?.width === 640", seconds=90)
    browser.wait("document.querySelector('.scene')?.scene?.displays.get('/cloud')?.display.status.includes('points')")
    number, values = browser.run(f"return [{NEWEST}, {NEWEST_VALUES}]")
    browser.run("window.drawn = 0; const count = () => { window.drawn += 1; requestAnimationFrame(count); }; count()")
    browser.wait(f"{NEWEST} > {number + 20_000}", seconds=90)  # what two seconds bring
    browser.wait("window.drawn > 5", seconds=90)
    browser.wait(f"{NEWEST_VALUES}.every((value, index) => value !== arguments[0][index])", values, seconds=90)
    assert browser.run(f"return {ROWS}") < 100
    status = Path(f"/proc/{web.process.pid}/status").read_text().split()
    assert int(status[status.index("VmHWM:") + 1]) < MAX_MEMORY
