"""What pages may not do, see or reach; nodes that die, and browsers that vanish."""

from __future__ import annotations

import http.server
import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from browsing import Browser, Web
from harness import until

from pyros1.msgs.geometry_msgs.msg import TransformStamped
from pyros1.msgs.sensor_msgs.msg import Image
from pyros1.msgs.std_msgs.msg import Float64, String
from pyros1.msgs.std_srvs.srv import Empty, EmptyResponse
from pyros1.reconfigure import Parameters, Server
from pyros1.tf import StaticTransformBroadcaster
from pyros1.web.links import layout_link, panel_link

Make = Callable[..., Any]
TABS = "[...document.querySelectorAll('.tab')].map((tab) => tab.textContent)"
ROW = "[...document.querySelectorAll('.line:not(.group)')].find((line) => line.dataset.key.includes(arguments[0]))"
EARS = """
    window.heard = [];
    const Plain = WebSocket;
    window.WebSocket = class extends Plain {
      constructor(...args) {
        super(...args);
        this.addEventListener('message', ({data}) => {
          heard.push(typeof data === 'string' ? data : new TextDecoder('latin1').decode(data));
        });
      }
    };
"""


def robot_with(make_node: Make, word: str) -> Any:
    """Return a node with something of every kind, all with a word in their names."""
    node = make_node("worker")
    node.advertise(f"/{word}/number", Float64, latch=True).publish(7.5)
    node.advertise(f"/{word}/image", Image)
    node.subscribe(f"/{word}/wanted", String, lambda message: None)
    node.advertise_service(f"/{word}/service", Empty, lambda request: EmptyResponse())
    node.params[f"/{word}/param"] = 1
    node.params[f"/nested/{word}"] = 1
    link = TransformStamped(child_frame_id="base")
    link.header.frame_id, link.transform.rotation.w = "map", 1.0
    StaticTransformBroadcaster(node).send_transform([link])
    return node


def test_a_read_only_page_has_no_button_that_writes(
    browser: Browser, start_web: Callable[..., Web], make_node: Make, tmp_path: Path
) -> None:
    node = robot_with(make_node, "all")
    parameters = Parameters()
    parameters.add("speed", 1.0, minimum=0.0, maximum=2.0)
    server = Server(node, parameters, lambda config, level: config)
    web = start_web("--read-only", "--bags", str(tmp_path))
    browser.open(panel_link(web.link, "params", {"configure": "/worker"}))
    browser.wait_for_text("read-only")
    browser.wait("document.querySelector('.configure input')")
    assert browser.run("return [...document.querySelectorAll('.configure input')].every((each) => each.disabled)")
    for tab in browser.run(f"return {TABS}"):
        browser.click(".tab", tab)
        browser.wait("document.querySelector('.panel .body').childElementCount")
        if browser.run("return Boolean(document.querySelector('.listing'))"):
            row = {"Nodes": "worker", "Services": "all", "Topics": "number", "Parameters": "param"}.get(tab)
            if row:
                browser.wait(ROW, row)
                browser.run(f"{ROW}.querySelector('.cell').click()", row)
                browser.wait("document.querySelector('.about')?.textContent.length > 10")
        usable = browser.run(
            "return [...document.querySelectorAll('button')].filter((each) => each.offsetParent && !each.disabled)"
            ".map((each) => each.textContent)"
        )
        writing = {"Publish", "Call", "Save", "Set", "Delete", "Stop", "New …", "Send goal", "Cancel", "Record"}
        writing |= {"Nav goal", "Pose estimate", "Point", "Centre", "Randomize", "Publish from here"}
        writing -= {"Save"} if tab == "Console" else set()  # to a file
        assert not writing & {*usable}, tab
    changes = [
        *("topics.publish", "topics.advertise", "services.call", "params.put", "params.delete", "nodes.kill"),
        *("nodes.set_level", "reconfigure.update", "reconfigure.turn", "actions.send", "actions.cancel"),
        *("bags.record", "bags.stop", "launches.control", "launches.forget"),
    ]
    answers = browser.run(  # as if the page had the buttons
        "return Promise.all(arguments[0].map((name) => robot.call(name).then(() => name, (error) => error.message)))",
        changes,
    )
    assert {*answers} == {"this server is read-only (--read-only)"}
    assert (server.config["speed"], node.params["/all/param"]) == (1.0, 1)


def test_topics_that_pages_may_not_see_are_nowhere(
    browser: Browser, start_web: Callable[..., Web], make_node: Make
) -> None:
    node = robot_with(make_node, "secret")
    robot_with(lambda name: node, "open")
    node.log.info("hello")  # with the names of the node's topics
    web = start_web("--topics", "/open/*", "--topics", "/rosout", "--topics", "/tf*")
    driver = browser.driver
    added = driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": EARS})
    try:
        browser.open(panel_link(web.link, "plot", {}))
        for tab in browser.wait(f"{TABS}.length && {TABS}"):
            browser.click(".tab", tab)
            browser.wait("document.querySelector('.panel .body').childElementCount")
            row = {"Nodes": "worker", "Services": "open", "Topics": "open", "Parameters": "open"}.get(tab)
            if row:
                browser.wait(ROW, row)
                browser.run(f"{ROW}.querySelector('.cell').click()", row)
                browser.wait("document.querySelector('.about')?.textContent.length > 10")
            if tab == "Plot":
                browser.type("[aria-label='add a curve']", "/")
                browser.wait("[...document.querySelectorAll('datalist option')].some((each) => each.value)")
            if tab == "Console":
                browser.wait_for_text("hello")
            if tab == "Graph":
                browser.wait("document.querySelector('.graph')?.graph")
            assert "secret" not in browser.run("return document.documentElement.outerHTML"), tab
        found = browser.run(
            """
            const names = ['topics', 'topics_and_raw_types', 'services', 'get_param_names', 'action_servers', 'nodes'];
            const calls = [...names.map((name) => [name, {}]), ['node_details', {node: '/worker'}],
              ['topics_for_type', {type: 'std_msgs/Float64'}], ['services_for_type', {type: 'std_srvs/Empty'}],
              ['get_param', {name: '/nested', default: ''}], ['get_param', {name: '/', default: ''}]];
            const socket = new WebSocket(location.href.replace('http', 'ws').replace(/#.*/, ''));
            const heard = [];
            return new Promise((done) => {
              socket.onmessage = ({data}) => { heard.push(data); if (heard.length === calls.length) done(heard); };
              socket.onopen = () => calls.forEach(([name, args], id) => {
                socket.send(JSON.stringify({op: 'call_service', id: String(id), service: '/rosapi/' + name, args}));
              });
            });
            """
        )
        assert "/open/number" in "".join(found)
        assert "secret" not in "".join(found)
        assert browser.run("return heard.length") > 20
        assert not browser.run("return heard.filter((each) => each.includes('secret'))")
    finally:
        driver.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", added)


@contextmanager
def site() -> Iterator[str]:
    """The address of a site with an empty page, which is not ours."""

    class Empty_(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(b"<!DOCTYPE html><link rel=icon href=data:,><title>other</title>")

        def log_message(self, *args: Any) -> None:
            """Say nothing."""

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Empty_) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield f"http://localhost:{server.server_port}/"
        server.shutdown()
        thread.join()


def test_a_page_of_another_site_gets_nothing(browser: Browser, start_web: Callable[..., Web]) -> None:
    attack = """
        const [link, token] = arguments;
        const got = [];
        const open = (name, ...args) => new Promise((done) => {
          const socket = new WebSocket(...args);
          socket.onopen = () => { got.push(name); done(); };
          socket.onclose = () => done();
        });
        const read = (path, options) => fetch(link + path, options).then(
          async (answer) => { if (await answer.text()) got.push(path); }, () => {});
        const frame = document.createElement('iframe');
        frame.src = link + token;
        const framed = new Promise((done) => { frame.onload = done; });
        document.body.append(frame);
        const ws = link.replace('http', 'ws');
        return Promise.all([
          read('panels.json'), read(''), read('', {mode: 'no-cors'}), read('package?uri=package://a/b.stl'),
          open('page', ws + 'ws' + token, 'pyros1.v1'), open('page without', ws + 'ws', 'pyros1.v1'),
          open('rosbridge', ws), open('rosbridge wrong', ws + '?token=x'),
          open('foxglove', ws, 'foxglove.websocket.v1'),
          framed.then(() => { if (frame.contentDocument) got.push('frame'); }),
        ]).then(() => got);
    """
    with site() as other:
        for words in ((), ("--token", "")):
            link, _, query = start_web(*words).link.partition("?")
            browser.open(other)
            assert browser.run(attack, link, f"?{query}" if query else "") == []
    complaints = browser.complaints()
    assert any("frame" in text for text in complaints)  # the browser shows no page of ours in one of theirs


VICTIM = """
import sys, threading
import pyros1
from pyros1.msgs.geometry_msgs.msg import TransformStamped
from pyros1.msgs.sensor_msgs.msg import Image, JointState
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.msgs.std_srvs.srv import Empty, EmptyResponse
from pyros1.msgs.visualization_msgs.msg import Marker
from pyros1.reconfigure import Parameters, Server
from pyros1.tf import TransformBroadcaster

node = pyros1.Node("victim", argv=[], handle_signals=False)
node.params["/robot_description"] = (
    "<robot name='r'><link name='base'/><link name='arm'/><joint name='j' type='continuous'>"
    "<parent link='base'/><child link='arm'/></joint></robot>")
number, image = node.advertise("/value", Float64), node.advertise("/image", Image)
joints, marker = node.advertise("/joint_states", JointState), node.advertise("/marker", Marker)
node.advertise_service("/victim/switch", Empty, lambda request: EmptyResponse())
parameters = Parameters()
parameters.add("speed", 1.0, minimum=0.0, maximum=2.0)
Server(node, parameters, lambda config, level: config)
frames = TransformBroadcaster(node)
link = TransformStamped(child_frame_id="base")
link.header.frame_id, link.transform.rotation.w = "map", 1.0
box = Marker(type=1)
box.header.frame_id = "base"
box.scale.x = box.scale.y = box.scale.z = box.color.a = box.pose.orientation.w = 1.0
node.log.info("victim runs")
while True:
    link.header.stamp = node.now()
    frames.send_transform([link])
    number.publish(float(sys.argv[1]))
    image.publish(Image(width=1, height=1, encoding="mono8", step=1, data=b"x"))
    joints.publish(JointState(name=["j"], position=[0.5]))
    marker.publish(box)
    threading.Event().wait(0.05)
"""


def test_a_node_dies_while_every_panel_shows_it(browser: Browser, web: Web, environ: dict[str, str]) -> None:
    panels: list[list[dict[str, Any]]] = [
        [{"panel": "graph"}, {"panel": "console"}, {"panel": "plot", "settings": {"curves": ["/value/data"]}}],
        [{"panel": "scene", "settings": {"topics": ["/marker"], "fixed": "map"}}, {"panel": "joints"}],
        [{"panel": "topics", "settings": {"selected": "/value"}}, {"panel": "frames"}, {"panel": "launches"}],
        [{"panel": "image", "settings": {"topic": "/image"}}, {"panel": "nodes", "settings": {"selected": "/victim"}}],
        [{"panel": "params", "settings": {"configure": "/victim"}}],
        [{"panel": "services", "settings": {"selected": "/victim/switch"}}],
    ]
    columns = [{"split": "column", "parts": parts} if len(parts) > 1 else parts[0] for parts in panels]

    def run(value: str) -> subprocess.Popen[bytes]:
        return subprocess.Popen(
            [sys.executable, "-c", VICTIM, value], env={**os.environ, **environ}, stdin=subprocess.DEVNULL
        )

    def shown(value: str) -> str:
        return (
            f"document.querySelector('.chip .value')?.textContent === '{value}'"
            " && document.querySelector('.configure .num')"
            " && document.querySelector('.scene')?.scene?.displays.get('/marker')?.display.status === '1 marker'"
            " && document.querySelector('[data-joint=j] .joints-number')?.value === '0.5'"
            " && document.querySelector('.image canvas')?.width === 1"
        )

    wrong = (
        "[...document.querySelectorAll(`[data-panel=${arguments[0]}] .outcome.wrong`)]"
        ".some((each) => each.textContent.includes('Connection refused'))"
    )
    browser.resize(2400, 1200)
    victim = run("1.5")
    try:
        browser.open(layout_link(web.link, "all", {"split": "row", "parts": columns}))
        browser.wait(shown("1.5"))
        assert browser.run("return document.querySelectorAll('.panel').length") == 12
        victim.send_signal(signal.SIGKILL)
        victim.wait(20)
        browser.wait("document.querySelector('[data-panel=nodes] .details')?.textContent.includes('does not answer')")
        browser.click("[data-panel=services] .caller button", "Call")
        browser.wait(wrong, "services")
        browser.run("document.querySelector('.configure input[type=range]').value = 2")
        browser.run("document.querySelector('.configure input[type=range]').dispatchEvent(new Event('input'))")
        browser.wait(wrong, "params")
        victim = run("2.5")
        browser.wait(shown("2.5"))
        assert "this panel has failed" not in browser.run("return document.body.textContent")
    finally:
        victim.kill()
        victim.wait(20)


CLIENT = """
import json, sys
from websockets.sync.client import connect

link, protocol, begin = sys.argv[1:]
with connect(link, subprotocols=[protocol] if protocol else None, compression=None) as client:
    while "CHANNEL" in begin:
        for channel in json.loads(client.recv(20)).get("channels", ()):
            begin = begin.replace("CHANNEL", str(channel["id"])) if channel["topic"] == "/image" else begin
    client.send(begin)
    client.recv(20)
    print("begun", flush=True)
    while True:
        client.recv()
"""


def test_browsers_that_vanish_are_forgotten(web: Web, make_node: Make) -> None:
    publisher = make_node("camera").advertise("/image", Image, latch=True)
    publisher.publish(Image(width=1, height=1, encoding="mono8", step=1, data=b"x"))
    link = web.link.replace("http", "ws")
    viewer = {"op": "subscribe", "subscriptions": [{"id": 1, "channelId": "CHANNEL"}]}
    clients = [
        (link.replace("?", "ws?"), "pyros1.v1", {"open": "message", "stream": 1, "args": {"topic": "/image"}}),
        (link, "", {"op": "subscribe", "topic": "/image", "type": "sensor_msgs/Image"}),
        (link, "foxglove.websocket.v1", viewer),
    ]
    texts = [
        (address, protocol, json.dumps(begin).replace('"CHANNEL"', "CHANNEL")) for address, protocol, begin in clients
    ]
    running = [subprocess.Popen([sys.executable, "-c", CLIENT, *words], stdout=subprocess.PIPE) for words in texts]
    try:
        for client in running:
            assert client.stdout is not None
            assert client.stdout.readline() == b"begun\n"
        assert publisher.num_connections
        for client in running:
            client.send_signal(signal.SIGSTOP)  # nothing is read, answered or closed any more
        image = Image(width=1000, height=1000, encoding="mono8", step=1000, data=bytes(1_000_000))

        def gone() -> bool:
            publisher.publish(image)
            return not publisher.num_connections

        until(gone, "nobody subscribes any more", 60)
        status = Path(f"/proc/{web.process.pid}/status").read_text().split()
        assert int(status[status.index("VmHWM:") + 1]) < 400_000  # kB
    finally:
        for client in running:
            client.kill()
            client.communicate(timeout=20)
