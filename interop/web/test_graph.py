"""The graph: nodes, message rates, broken connections, and a large system."""

from __future__ import annotations

import base64
import json
import os
import signal
import subprocess
import sys
import time
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from browsing import PATIENCE, Browser, Web

from pyros1.msgs.std_msgs.msg import Float64, String
from pyros1.web.links import panel_link

GRAPH = "document.querySelector('.graph')?.graph"
SHOWN = f"({GRAPH}?.model?.boxes.map((box) => box.id).sort() || [])"
STATES = f"Object.fromEntries({GRAPH}.model.edges.map((edge) => [edge.id, edge.links.map((link) => link.state)]))"
DRAWN = f"{GRAPH}?.picture.scene.items.size"


HUNG = """
from pyros1.node import Node

node = Node("hung")
node.advertise("chat", "std_msgs/String")
print(flush=True)
node.spin()
"""


@contextmanager
def running(code: str, environ: dict[str, str]) -> Iterator[subprocess.Popen[bytes]]:
    """Run Python code until the block ends; the block begins when it has printed a line."""
    everywhere = {**os.environ, **environ}
    with subprocess.Popen([sys.executable, "-c", code], env=everywhere, stdout=subprocess.PIPE) as process:
        try:
            assert process.stdout is not None
            process.stdout.readline()
            yield process
        finally:
            process.kill()


def link(web: Web, **settings: Any) -> str:
    """Return a link to the graph with settings."""
    tree = json.dumps({"panel": "graph", "settings": settings}).encode()
    return f"{web.link}#graph={base64.urlsafe_b64encode(tree).decode().rstrip('=')}"


def wait_for_boxes(browser: Browser, *ids: str) -> None:
    """Wait until exactly these boxes are drawn."""
    browser.wait(f"JSON.stringify({SHOWN}) === arguments[0]", json.dumps(sorted(ids), separators=(",", ":")))
    browser.wait(f"{DRAWN} === arguments[0]", len(ids))


def click(browser: Browser, box: str) -> None:
    """Press and release the pointer where a box is drawn, as soon as nothing moves any more."""
    browser.wait(
        f"""(() => {{
        const picture = {GRAPH}?.picture;
        if (!picture || picture.camera.target) return false;
        const items = [...picture.scene.items.values()];
        if (!picture.scene.items.has(arguments[0]) || items.some((item) => item.at !== item.to)) return false;
        const [x, y] = picture.camera.toScreen(...picture.scene.items.get(arguments[0]).to);
        const place = picture.canvas.getBoundingClientRect();
        const at = {{clientX: place.left + x, clientY: place.top + y, pointerId: 1, bubbles: true, button: 0}};
        picture.canvas.setPointerCapture = () => {{}};
        for (const kind of ['pointerdown', 'pointerup']) picture.canvas.dispatchEvent(new PointerEvent(kind, at));
        return true;
    }})()""",
        box,
    )


def press(browser: Browser, key: str) -> None:
    browser.run(
        "document.querySelector('.graph canvas').dispatchEvent(new KeyboardEvent('keydown',"
        " {key: arguments[0], bubbles: true, cancelable: true}))",
        key,
    )


def choose(browser: Browser, label: str, value: str) -> None:
    """Choose in a list of the panel."""
    browser.type(f".panel select[aria-label='{label}']", value)


def test_the_simulator_in_three_modes_with_details(
    browser: Browser, web: Web, start_program: Callable[..., Any]
) -> None:
    start_program("launch", "minimal_nodes", "minimal_simulator.launch")
    browser.open(web.page("graph"))
    nodes = ["n:/minimal_controller", "n:/minimal_simulator"]
    wait_for_boxes(browser, *nodes, "t:/force_cmd", "t:/velocity")
    choose(browser, "what is shown", "nodes")
    wait_for_boxes(browser, *nodes)
    choose(browser, "what is shown", "all")
    wait_for_boxes(browser, *nodes, "t:/force_cmd", "t:/velocity")
    browser.run("for (const name of ['leaf', 'dead']) document.querySelector(`[data-hide=${name}]`).click()")
    wait_for_boxes(browser, *nodes, "t:/force_cmd", "t:/vel_cmd", "t:/velocity")
    browser.wait(f"{GRAPH}.model.edges.some((edge) => edge.links.some((link) => link.hz > 5 && link.bytes > 20))")
    click(browser, "t:/velocity")
    browser.wait_for_text("std_msgs/Float64")
    browser.wait("/^data: -?[0-9.e-]+$/.test(document.querySelector('.sheet .message').textContent)")
    browser.click(".sheet summary", "Definition")
    browser.wait_for_text("float64 data")
    browser.click(".sheet .link", "/minimal_simulator")
    browser.wait("/^[0-9]+$/.test(document.querySelector('.sheet dd').textContent)")
    press(browser, "Escape")
    browser.wait("document.querySelector('.sheet').hidden")


def test_numbers_of_a_message_are_plotted_by_a_click(browser: Browser, web: Web, make_node: Callable[..., Any]) -> None:
    make_node("talker").advertise("number", Float64, latch=True).publish(4.5)
    browser.open(link(web, mode="all", hide=["debug"]))
    wait_for_boxes(browser, "n:/talker", "t:/number")
    click(browser, "t:/number")
    browser.click(".sheet .message .link", "4.5")
    browser.wait("document.querySelector('.chip .name')?.textContent === '/number/data'")


def test_the_newest_message_is_shown_also_if_it_came_just_after_another(
    browser: Browser, web: Web, make_node: Callable[..., Any]
) -> None:
    publisher = make_node("talker").advertise("number", Float64)
    browser.open(link(web, mode="all", hide=["debug"]))
    wait_for_boxes(browser, "n:/talker", "t:/number")
    click(browser, "t:/number")
    assert publisher.wait_for_subscribers(timeout=20)
    shown = "document.querySelector('.sheet .message').textContent === arguments[0]"
    for number in (1.5, 2.5):
        publisher.publish(number)
        browser.wait(shown, f"data: {number}")


def test_the_latest_message_stays_when_a_subscriber_comes(
    browser: Browser, web: Web, make_node: Callable[..., Any]
) -> None:
    publisher = make_node("talker").advertise("number", Float64)
    browser.open(link(web, mode="all", hide=["debug"]))
    wait_for_boxes(browser, "n:/talker", "t:/number")
    click(browser, "t:/number")
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(1.5)
    message = "document.querySelector('.sheet .message').textContent"
    browser.wait(f"{message} === 'data: 1.5'")
    make_node("listener").subscribe("number", Float64, lambda message: None)
    browser.wait("document.querySelector('.sheet').textContent.includes('/listener')")
    assert browser.run(f"return {message}") == "data: 1.5"


def test_changes_move_the_picture_no_more_than_needed(
    browser: Browser, web: Web, make_node: Callable[..., Any]
) -> None:
    talker, listener = make_node("talker"), make_node("listener")
    talker.advertise("chat", String)
    listener.subscribe("chat", String, lambda message: None)
    browser.open(web.page("graph"))
    wait_for_boxes(browser, "n:/listener", "n:/talker", "t:/chat")
    place = f"{GRAPH}.picture.scene.items.get('n:/talker').to"
    layouts = f"{GRAPH}.picture.number"
    before, count = browser.run(f"{GRAPH}.picture.highlight('n:/talker', null); return [{place}, {layouts}]")
    browser.wait(f"{GRAPH}.system !== arguments[0]", None)
    later = make_node("later")
    later.subscribe("chat", String, lambda message: None)
    wait_for_boxes(browser, "n:/later", "n:/listener", "n:/talker", "t:/chat")
    after, again = browser.run(f"return [{place}, {layouts}]")
    assert after == before
    assert again == count + 1, "a layout for one change, and none for new rates"
    later.shutdown()
    wait_for_boxes(browser, "n:/listener", "n:/talker", "t:/chat")


def test_sites_beside_their_bridge(browser: Browser, web: Web, make_node: Callable[..., Any]) -> None:
    """Feature: other sites in the graph, with their topics and dropped messages -- `pyros1 web`"""
    sites = [{"name": "red", "state": "present", "round_trip": 0.0123, "nodes": ["/red/driver"]}]
    flow = {"messages_per_second": 10.0, "bytes_per_second": 7200.0, "dropped": {"too old": 3}}
    status = {
        "site": "base",
        "link": "",
        "sites": sites,
        "sent": [{"local": "/red/cmd_vel", "wanted_by": ["red"], **flow, "dropped": {}}],
        "received": [{"local": "/red/odom", "from": "red", "state": "subscribed", **flow}],
    }
    bridge, listener = make_node("bridge_base"), make_node("listener")
    bridge.advertise_service("~bridge_status", "std_srvs/Trigger", lambda _: (True, json.dumps(status)))
    make_node("driver", namespace="/red")
    bridge.advertise("/red/odom", String)
    listener.subscribe("/red/odom", String, lambda message: None)
    browser.open(web.page("graph"))
    wait_for_boxes(browser, "n:/bridge_base", "n:/listener", "t:/red/odom", "s:red")
    browser.wait(f"JSON.stringify({STATES}['s:red n:/bridge_base']) === '[\"ok\"]'")
    browser.wait(f"JSON.stringify({STATES}['n:/bridge_base s:red']) === '[\"ok\"]'")
    click(browser, "s:red")
    browser.wait_for_text("reaches it: present")
    browser.wait_for_text("dropped: 3 too old")
    browser.wait_for_text("/red/driver")
    sites[0].update(state="lost", round_trip=None)
    browser.wait(f"{STATES}['s:red n:/bridge_base']?.[0] === 'broken'")
    browser.wait_for_text("1 site lost")
    browser.wait_for_text("says: it is lost")
    browser.run(f"{GRAPH}._choose({{edge: {GRAPH}.model.edges.find((each) => each.from === 's:red')}})")
    browser.wait_for_text("The site is lost.")


def test_a_broken_connection_and_a_silent_node_and_why(
    browser: Browser, web: Web, environ: dict[str, str], make_node: Callable[..., Any]
) -> None:
    talker, listener = make_node("talker"), make_node("listener", log_level="fatal")
    talker.advertise("chat", String)
    listener.subscribe("chat", Float64, lambda message: None)
    with running(HUNG, environ) as hung:
        hung.send_signal(signal.SIGSTOP)
        browser.open(link(web, mode="nodes"))
        wait_for_boxes(browser, "n:/hung", "n:/listener", "n:/talker")
        browser.wait(f"{STATES}['n:/talker n:/listener']?.[0] === 'broken'")
        browser.wait(f"{STATES}['n:/hung n:/listener']?.[0] === 'unknown'")
        browser.wait_for_text("1 silent")
        browser.wait_for_text("1 broken")
        browser.run(f"{GRAPH}._choose({{edge: {GRAPH}.model.edges.find((each) => each.from === 'n:/talker')}})")
        browser.wait_for_text("do not agree on its type: std_msgs/Float64, std_msgs/String")
        click(browser, "n:/hung")
        browser.wait_for_text("it does not answer")
        browser.wait_for_text("they hang or are suspended")


def test_a_node_is_stopped_after_a_question(browser: Browser, web: Web, start_program: Callable[..., Any]) -> None:
    process = start_program("run", "minimal_nodes", "minimal_publisher")
    browser.open(link(web, mode="all", hide=["debug"]))
    browser.wait(f"{DRAWN} > 0")
    (node,) = browser.run(f"return {SHOWN}.filter((id) => id.startsWith('n:'))")
    click(browser, node)
    browser.click(".sheet .danger", "Stop")
    browser.click(".sheet .buttons button", "No")
    assert process.poll() is None
    browser.click(".sheet .danger", "Stop")
    browser.click(".sheet .danger", "Stop it")
    assert process.wait(20) == 0
    browser.wait_for_text("This node has exited")


def test_a_page_that_may_only_look_does_not_offer_to_stop(
    browser: Browser, start_web: Callable[..., Web], make_node: Callable[..., Any]
) -> None:
    make_node("talker")
    browser.open(link(start_web("--read-only"), mode="all"))
    browser.wait("document.body.innerText.includes('read-only')")
    wait_for_boxes(browser, "n:/talker")
    click(browser, "n:/talker")
    browser.wait_for_text("Connections")
    assert not browser.run("return document.querySelectorAll('.sheet .danger').length")


def test_search_keys_and_files(
    browser: Browser, web: Web, start_program: Callable[..., Any], environ: dict[str, str]
) -> None:
    start_program("launch", "minimal_nodes", "minimal_simulator.launch")
    browser.open(link(web, mode="nodes", hide=[]))
    browser.wait(f"{SHOWN}.length === 3 && {DRAWN} === 3")  # two, and this server
    press(browser, "/")
    assert browser.run("return document.activeElement.type") == "search"
    browser.type(".tools input[type=search]", "CONTROLLER")
    browser.wait_for_text("1 found")
    assert browser.run(f"return [...{GRAPH}.picture.highlighted.boxes]") == ["n:/minimal_controller"]
    browser.type(".tools input[type=search]", "")
    scale = f"{GRAPH}.picture.camera.scale"
    browser.wait(f"!{GRAPH}.picture.camera.target")
    before = browser.run(f"return {scale}")
    press(browser, "+")
    assert browser.run(f"return {scale}") > before
    press(browser, "-")
    press(browser, "f")
    browser.wait(f"!{GRAPH}.picture.camera.target")
    press(browser, "Enter")
    browser.wait("!document.querySelector('.sheet').hidden")
    press(browser, "Escape")

    svg = browser.run(f"return {GRAPH}.picture.svg()")
    root = ET.fromstring(svg)
    texts = [element.text for element in root.iter("{http://www.w3.org/2000/svg}text")]
    assert "/minimal_controller" in texts and "var(" not in svg and "class=" not in svg
    words = [sys.executable, "-m", "pyros1", "graph", "--dot"]
    until = time.monotonic() + PATIENCE  # the nodes may still be connecting to each other
    while True:
        told = subprocess.run(
            words, env={**os.environ, **environ}, capture_output=True, text=True, timeout=60, check=True
        )
        ours = browser.run(
            f"return import(new URL('lib/graph/model.js', location.href)).then(({{dot}}) => dot({GRAPH}.model))"
        )
        if ours == told.stdout:
            break
        assert time.monotonic() < until, (ours, told.stdout)


def test_nothing_runs_or_all_is_hidden(browser: Browser, web: Web, make_node: Callable[..., Any]) -> None:
    browser.open(web.page("graph"))
    browser.wait_for_text("Everything is hidden")
    browser.click(".nothing button", "Show them")
    browser.wait(f"{DRAWN} > 0 && document.querySelector('.graph .nothing').hidden")


def test_a_link_may_hide_what_this_page_does_not_know(
    browser: Browser, web: Web, make_node: Callable[..., Any]
) -> None:
    browser.open(panel_link(web.link, "graph", {"hide": ["debug", 'a"b']}))
    browser.wait_for_text("Everything is hidden")
    press(browser, "r")
    browser.click(".nothing button", "Show them")
    browser.wait(f"{DRAWN} > 0 && document.querySelector('.graph .nothing').hidden")


def test_topics_that_nobody_subscribes_to_are_counted_and_shown_by_a_click(
    browser: Browser, web: Web, make_node: Callable[..., Any]
) -> None:
    talker = make_node("talker")
    for number in range(15):
        talker.advertise(f"topic{number}", String)
    browser.open(web.page("graph"))
    wait_for_boxes(browser, "n:/talker")
    browser.wait_for_text("15 topics without subscribers hidden · show")
    browser.click(".graph .note button", "show")
    wait_for_boxes(browser, "n:/talker", *(f"t:/topic{number}" for number in range(15)))
    browser.wait("!document.querySelector('.graph .note').innerText.includes('hidden')")
    browser.run("for (const name of ['leaf', 'dead']) document.querySelector(`[data-hide=${name}]`).click()")
    wait_for_boxes(browser, "n:/talker")


LARGE = """
import time
from pyros1.node import Node
from pyros1.msgs.std_msgs.msg import Float64

nodes = [Node(f"node{n % 10}", argv=[f"__ns:=/robot{n // 10}"], rosout=False, handle_signals=False) for n in range(200)]
publishers = []
for t in range(1000):
    n = t % 200
    topic = f"/robot{n // 10}/part{t // 200}_{n % 10}/data"
    publishers.append(nodes[n].advertise(topic, Float64))
    near = n // 10 * 10 + t * 7 % 10
    nodes[t * 13 % 200 if t % 20 == 0 else near].subscribe(topic, Float64, lambda message: None)
print(flush=True)
time.sleep(600)
"""


def test_200_nodes_and_1000_topics(browser: Browser, web: Web, environ: dict[str, str]) -> None:
    with running(LARGE, environ):
        browser.open(link(web))
        browser.wait(f"{SHOWN}.length === 20 && {DRAWN} === 20", seconds=60)  # each robot is one box
        browser.run(f"{GRAPH}.picture.on.fold('/robot7')")
        browser.wait(f"{DRAWN} === 79")
        browser.type(".tools input[type=search]", "/robot3/node4")
        browser.wait(f"[...({GRAPH}.picture.highlighted?.boxes || [])].join() === 'g:/robot3'")
        browser.run(f"{GRAPH}.accept({{selected: '/robot3/node4'}})")
        browser.wait(f"{DRAWN} === 138 && {GRAPH}.picture.chosen === 'n:/robot3/node4'")
        browser.open(link(web, depth=0))
        browser.wait(f"{DRAWN} === 1200", seconds=60)
        times = browser.run(f"return {GRAPH}.picture.times")
        assert times["layout"] < 15, times["layout"]  # 1.3 s alone
        browser.driver.set_script_timeout(30)
        frames = browser.driver.execute_async_script(
            f"""const done = arguments[0], picture = {GRAPH}.picture, begin = performance.now(); let frames = 0;
            const step = () => {{
              frames += 1;
              picture.camera.move(frames % 60 < 30 ? 5 : -5, 2);
              if (performance.now() - begin < 2000) requestAnimationFrame(step); else done(frames / 2);
            }};
            requestAnimationFrame(step);"""
        )
        print(f"layout {times['layout']:.2f} s, {frames:.0f} frames per second")
        assert frames > 5  # 30 alone


def test_boxes_are_dragged_and_put_back(browser: Browser, web: Web, make_node: Callable[..., Any]) -> None:
    make_node("talker").advertise("chat", String, latch=True).publish(String(data="hi"))
    make_node("listener").subscribe("chat", String, lambda message: None)
    browser.open(link(web))
    wait_for_boxes(browser, "n:/talker", "t:/chat", "n:/listener")
    drag = """
        const { picture } = document.querySelector('.graph').graph;
        const item = picture.scene.items.get('n:/talker');
        const [x, y] = picture.camera.toScreen(...item.at);
        const { left, top } = picture.canvas.getBoundingClientRect();
        picture.canvas.setPointerCapture = () => {};
        const send = (type, across, button) => picture.canvas.dispatchEvent(new PointerEvent(type, {
            clientX: left + x + across, clientY: top + y + across, bubbles: true, pointerId: 7,
            pointerType: 'mouse', button }));
        const before = [...item.at];
        send('pointerdown', 0, 0);
        for (let step = 1; step <= 10; step += 1) send('pointermove', step * 8, -1);
        send('pointerup', 80, 0);
        return [before, item.at, picture.camera.scale];
    """
    browser.wait(f"!{GRAPH}.picture.scene.step(Infinity)")
    (x, y), (right, down), scale = browser.run(drag)
    assert abs(right - x - 80 / scale) < 8 and abs(down - y - 80 / scale) < 8
    assert browser.run(f"return {GRAPH}.chosen") is None  # it was no click
    away = browser.run(f"return {GRAPH}.picture.scene.offsets")
    browser.click("#bar button", "Link")
    shared = browser.wait("location.hash.includes('=') && location.href")
    browser.run("localStorage.clear()")
    browser.open(shared)  # as others get it
    browser.wait(f"JSON.stringify({GRAPH}?.picture.scene.offsets) === JSON.stringify(arguments[0])", away)
    browser.wait(f"{GRAPH}.picture.scene.movedBoxes.size === 1")
    x = browser.run(f"return {GRAPH}.picture.scene.items.get('n:/talker').home[0]")
    browser.wait("document.querySelector('.zoom button:last-child').offsetParent")
    browser.click(".zoom button", "↺")
    browser.wait(f"Math.abs({GRAPH}.picture.scene.items.get('n:/talker').at[0] - arguments[0]) < 1", x)
    browser.wait("!document.querySelector('.zoom button:last-child').offsetParent")
