"""Much at once: the page stays quick and small, shows the newest, and the server's memory is bounded."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from browsing import Browser, Web

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
