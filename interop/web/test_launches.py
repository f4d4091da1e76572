"""The panel of launches, with launches of both kinds."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from browsing import Browser, Web

from pyros1.launch.running.control import running_launches
from pyros1.master.server import Master
from pyros1.net.master_client import MasterClient

PATIENCE = 40.0
ROW = "[...document.querySelectorAll('.process')].find((row) => row.querySelector('.node').textContent === {!r})"
LAUNCH = """<launch>
  <node pkg="minimal_nodes" type="minimal_publisher" name="talker" required="true"/>
  <node pkg="minimal_nodes" type="minimal_publisher" name="quits" launch-prefix="bash -c 'echo &quot;it is &lt;b&gt;broken&quot;; exit 3'"/>
  <node pkg="minimal_nodes" type="minimal_publisher" name="again" launch-prefix="bash -c 'exit 4'" respawn="true" respawn_delay="300"/>
</launch>
"""  # noqa: E501  as it would be written

Start = Callable[..., "subprocess.Popen[bytes]"]


@pytest.fixture
def launched(start_program: Start, tmp_path: Path) -> Path:
    """A launch of ours that runs; its file."""
    file = tmp_path / "robot.launch"
    file.write_text(LAUNCH)
    start_program("launch", str(file))
    return file


@pytest.fixture
def stock_launch(environ: dict[str, str], tmp_path: Path) -> Iterator[None]:
    """A launch of stock's that runs."""
    file = tmp_path / "stock.launch"
    file.write_text('<launch><node pkg="topic_tools" type="relay" name="relay" ns="g" args="/in /out"/></launch>')
    env = {**os.environ, **environ, "PYTHONPATH": "", "ROS_PACKAGE_PATH": "/usr/share"}
    process = subprocess.Popen(
        ["/usr/bin/roslaunch", str(file)], env=env, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL
    )
    yield
    process.send_signal(signal.SIGINT)
    process.wait(30)


def state(browser: Browser, node: str, word: str) -> None:
    browser.wait(f"{ROW.format(node)}?.querySelector('.state').textContent.startsWith({word!r})")


@pytest.mark.usefixtures("launched")
def test_processes_are_seen_stopped_started_and_restarted(browser: Browser, web: Web) -> None:
    browser.open(web.page("launches"))
    state(browser, "/talker", "running")
    state(browser, "/quits", "died, exit code 3")
    state(browser, "/again", "waiting, exit code 4")
    browser.wait_for_text("robot.launch")
    for words in ("required", "respawn"):
        browser.wait(f"[...document.querySelectorAll('.process .badge')].some((b) => b.textContent === {words!r})")
    browser.wait(f"/MB/.test({ROW.format('/talker')}.querySelector('.memory').textContent)")
    verb = "{}.querySelector('[aria-label={}]').click()"
    browser.run(verb.format(ROW.format("/talker"), "Stop"))
    state(browser, "/talker", "stopped")  # its launch goes on, though it is required
    browser.wait(f"{ROW.format('/talker')}.querySelector('[aria-label=Start]:not(:disabled)')")
    browser.run(verb.format(ROW.format("/talker"), "Start"))
    state(browser, "/talker", "running")
    browser.wait(f"{ROW.format('/talker')}.querySelector('[aria-label=Restart]:not(:disabled)')")
    browser.run(verb.format(ROW.format("/talker"), "Restart"))
    browser.wait(f"{ROW.format('/talker')}.querySelector('.starts').textContent.endsWith(' 3')")
    browser.run(verb.format(ROW.format("/again"), "Stop"))
    state(browser, "/again", "stopped")


@pytest.mark.usefixtures("launched")
def test_details_with_the_log(browser: Browser, web: Web) -> None:
    browser.open(web.page("launches"))
    state(browser, "/quits", "died")
    browser.run(f"{ROW.format('/quits')}.click()")
    browser.wait("document.querySelector('.tail')?.textContent.includes('it is <b>broken')")
    browser.wait_for_text("__name:=quits")
    assert browser.run("return document.querySelectorAll('.details b').length") == 0
    browser.click(".details .actions button", "Start")
    browser.wait("document.querySelector('.tail').textContent.split('broken').length === 3")
    browser.run("document.querySelector('.launches').dispatchEvent(new KeyboardEvent('keydown', {key: 'End'}))")
    browser.wait("document.querySelector('.details h3').textContent !== '/talker'")
    browser.run("document.querySelector('.shut').click()")
    browser.wait("document.querySelector('.details').hidden")
    browser.type("input.search", "died")
    browser.wait("[...document.querySelectorAll('.process .node')].every((node) => node.textContent === '/quits')")


@pytest.mark.usefixtures("launched")
def test_from_a_node_to_its_process(browser: Browser, web: Web, make_node: Callable[..., Any]) -> None:
    make_node("alone")
    line = "[...document.querySelectorAll('.line')].find((line) => line.dataset.key === {!r})"
    for node, shown in (("/talker", "running"), ("/alone", "No launch is running /alone")):
        browser.open(web.page("nodes"))
        browser.run("localStorage.clear()")
        browser.open(web.page("nodes"))
        browser.wait(line.format(node))
        browser.run(f"{line.format(node)}.querySelector('.cell').click()")
        browser.click(".about button", "Process")
        browser.wait("document.querySelector('[data-panel=launches]').innerText.includes(arguments[0])", shown)
    browser.wait("document.querySelector('[data-panel=launches] .note').textContent.includes('/alone')")


@pytest.mark.usefixtures("stock_launch")
def test_a_stock_launch_is_looked_at(browser: Browser, web: Web) -> None:
    browser.open(web.page("launches"))
    state(browser, "/g/relay", "running")
    browser.wait_for_text("stock.launch")
    browser.wait_for_text("cannot stop or start them")
    browser.wait(f"/MB/.test({ROW.format('/g/relay')}.querySelector('.memory').textContent)")
    assert browser.run("return document.querySelectorAll('.verb').length") == 0


@pytest.mark.usefixtures("launched")
def test_a_launch_that_is_killed_is_forgotten(browser: Browser, web: Web, ros_master: Master) -> None:
    browser.open(web.page("launches"))
    state(browser, "/talker", "running")
    client = MasterClient("/test", ros_master.uri)
    ((launch, _),) = running_launches(client)
    os.kill(launch.report().pid, signal.SIGKILL)
    launch.close()
    browser.wait_for_text("does not answer")
    browser.click(".launch button", "Forget")
    browser.wait_for_text("No launch is running")
    assert running_launches(client) == []
    client.close()


@pytest.mark.usefixtures("launched")
def test_read_only_and_on_a_phone(browser: Browser, start_web: Callable[..., Web]) -> None:
    web = start_web("--read-only")
    browser.resize(390, 800)
    browser.open(web.page("launches"))
    state(browser, "/talker", "running")
    browser.wait("document.querySelectorAll('.verb').length === 0")
    assert browser.run("const e = document.querySelector('.launches'); return e.scrollWidth - e.clientWidth") <= 0
    browser.run(f"{ROW.format('/talker')}.click()")
    browser.wait_for_text("its launch ends when it exits")
    assert browser.run("return document.querySelector('.list').offsetParent") is None
