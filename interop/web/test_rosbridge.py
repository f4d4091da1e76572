"""Programs of roslibjs and roslibpy on the server's port.

Feature: roslibjs and roslibpy programs (rosbridge, rosapi) -- topics, services, parameters; PNG, CBOR, fragments,
    throttling
"""

from __future__ import annotations

import json
import os
import queue
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from browsing import Web

from pyros1.ground.errors import ServiceRefusal
from pyros1.guide.documents import pages
from pyros1.msgs.rospy_tutorials.srv import AddTwoInts
from pyros1.msgs.sensor_msgs.msg import Image
from pyros1.msgs.std_msgs.msg import Float64, Float64MultiArray, String
from pyros1.node import Node

PATIENCE = 30.0
PROGRAM = Path(__file__).with_name("roslib_client.mjs")


@pytest.fixture
def robot(make_node: Callable[..., Node]) -> Node:
    """A node with something of each kind."""
    node = make_node("robot")
    node.advertise("floats", Float64MultiArray, latch=True).publish(data=[0.5, float("inf"), -2.0])
    node.advertise("image", Image, latch=True).publish(
        height=48, width=64, encoding="mono8", step=64, data=bytes(range(256)) * 12
    )
    fast = node.advertise("fast", Float64)
    node.timer(0.02, lambda _: fast.publish(1.0))
    echo = node.advertise("echo", String)
    node.subscribe("words", String, lambda message: echo.publish(message.data.upper()))

    def add(request: Any) -> int:
        if request.a < 0:
            raise ServiceRefusal("too small")
        return int(request.a + request.b)

    node.advertise_service("add", AddTwoInts, add)
    return node


def socket_url(web: Web) -> str:
    return web.link.replace("http://", "ws://")


@pytest.fixture(scope="session", params=["roslib@1", "roslib@2"])
def roslib(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with roslib, from the npm registry, and a program that uses it."""
    folder = tmp_path_factory.mktemp("roslib")
    missing = [name for name in ("node", "npm") if not shutil.which(name)]
    if missing and os.environ.get("PYROS1_REQUIRE_STOCK"):
        pytest.fail(f"{missing} are missing: interop/setup installs them")
    if missing:
        pytest.skip(f"{missing} are not installed")
    (folder / "package.json").write_text('{"type": "module"}')
    done = subprocess.run(
        ["npm", "install", "--no-audit", "--no-fund", "--ignore-scripts", request.param, "ws@8"],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    shutil.copy(PROGRAM, folder)
    return folder


@pytest.fixture
def roslib_program(roslib: Path, web: Web, robot: Node) -> Iterator[subprocess.Popen[str]]:
    """A program of roslib that runs."""
    process = subprocess.Popen(
        ["node", PROGRAM.name, socket_url(web)],
        cwd=roslib,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        stdin=subprocess.DEVNULL,
        text=True,
    )
    yield process
    process.kill()
    process.communicate()


def test_roslibjs(
    request: pytest.FixtureRequest,
    roslib_program: subprocess.Popen[str],
    make_node: Callable[..., Node],
    robot: Node,
) -> None:
    said: dict[str, Any] = {}
    assert roslib_program.stdout is not None
    for line in roslib_program.stdout:
        if not line.startswith("["):
            continue
        name, value = json.loads(line)
        said[name] = value
        assert name != "problem", said
        if name == "ready":
            break
    types = dict(zip(said["topics"]["topics"], said["topics"]["types"], strict=True))
    assert types["/floats"] == "std_msgs/Float64MultiArray" == said["type"]
    assert "/robot" in said["nodes"]
    assert "/add" in said["services"]
    assert said["service type"] == "rospy_tutorials/AddTwoInts"
    assert [each["type"] for each in said["details"]] == ["geometry_msgs/Twist", "geometry_msgs/Vector3"]
    assert said["param"] == {"p": 1.5, "words": ["a", "b"]}
    assert robot.master.get_param("/web/gain") == {"p": 1.5, "words": ["a", "b"]}
    for compression in ("none", "png", "cbor"):
        assert said[f"floats {compression}"] == [0.5, None, -2.0]
    assert said["image cbor"] == [48, 64, 48 * 64, 7]
    assert said["floats cbor-raw"] == 36
    assert said["echo"] == "HELLO"
    if "roslib@2" in request.node.name:  # version 1 does not put fragments together
        for compression in ("none", "png"):
            data, pieces = said[f"fragments of {compression}"]
            assert data == [0.5, None, -2.0] and pieces >= 4
        known, pieces = said["fragments of an answer"]
        assert known and pieces >= 4
    assert said["fragments"] == "IN PIECES"
    assert sum(said["throttled"]) >= 800  # three times 300 ms, less what the network spreads
    check_newest(said["newest"])
    assert said["sum"] == {"sum": 42}
    assert "a" in said["failure"]
    caller = make_node("caller")
    caller.wait_for_service("/provided", PATIENCE)
    with caller.service("/provided", "std_srvs/SetBool") as client:
        answer = client.call(client.type._request_class(False), PATIENCE)
    assert (answer.success, answer.message) == (True, "by roslib")


def check_newest(words: list[str]) -> None:
    """Of the words 0 to 9, sent at once, a queue of two keeps the last two; others may come before it is full."""
    assert words[0] == "0" and words[-2:] == ["8", "9"] and len(words) < 9, words


def throttled_and_in_fragments(ros: Any, robot: Node) -> None:
    """Let roslibpy throttle topics, and send a message in fragments; it puts none together."""
    import roslibpy

    words: queue.Queue[str] = queue.Queue()
    times: queue.Queue[float] = queue.Queue()
    robot.subscribe("spoken", String, lambda message: words.put(message.data))
    slow = roslibpy.Topic(ros, "/fast", "std_msgs/Float64", throttle_rate=300, queue_length=1)
    slow.subscribe(lambda _: times.put(time.monotonic()))
    stamps = [times.get(timeout=PATIENCE) for _ in range(4)]
    slow.unsubscribe()
    assert stamps[-1] - stamps[0] >= 0.8  # three times 300 ms, less what the network spreads
    burst = roslibpy.Topic(ros, "/words", "std_msgs/String")
    heard: queue.Queue[str] = queue.Queue()
    newest = roslibpy.Topic(ros, "/echo", "std_msgs/String", throttle_rate=300, queue_length=2)
    newest.subscribe(lambda message: heard.put(message["data"]))
    burst.publish({"data": "0"})
    said = [heard.get(timeout=PATIENCE)]
    for number in range(1, 10):
        burst.publish({"data": str(number)})
    while said[-1] != "9":
        said.append(heard.get(timeout=PATIENCE))
    check_newest(said)
    whole = json.dumps({"op": "publish", "topic": "/spoken", "type": "std_msgs/String", "msg": {"data": "x" * 100}})
    ros.send_on_ready({"op": "advertise", "topic": "/spoken", "type": "std_msgs/String"})
    for number in range(4):
        size = -(-len(whole) // 4)
        data = whole[number * size : (number + 1) * size]
        ros.send_on_ready({"op": "fragment", "id": "whole", "num": number, "total": 4, "data": data})
    assert words.get(timeout=PATIENCE) == "x" * 100


def test_roslibpy(web: Web, robot: Node, make_node: Callable[..., Node]) -> None:
    import roslibpy

    commands: list[float] = []
    robot.subscribe("vel_cmd", Float64, lambda message: commands.append(message.data))
    ros = roslibpy.Ros(socket_url(web))
    ros.run(PATIENCE)
    try:
        assert "/floats" in ros.get_topics()
        assert ros.get_topic_type("/floats") == "std_msgs/Float64MultiArray"
        assert ros.get_topics_for_type("sensor_msgs/Image") == ["/image"]
        assert "/robot" in ros.get_nodes()
        assert "/floats" in ros.get_node_details("/robot")["publishing"]
        assert ros.get_service_type("/add") == "rospy_tutorials/AddTwoInts"
        assert ros.get_services_for_type("rospy_tutorials/AddTwoInts") == ["/add"]
        assert ros.get_time()["secs"] > 0

        gain = roslibpy.Param(ros, "/gain")
        gain.set([1, 2.5, "x"])
        assert gain.get() == [1, 2.5, "x"]
        assert "/gain" in ros.get_params()
        gain.delete()
        assert gain.get() is None

        images: list[Any] = []
        roslibpy.Topic(ros, "/image", "sensor_msgs/Image").subscribe(images.append)
        topic = roslibpy.Topic(ros, "/vel_cmd", "std_msgs/Float64")
        topic.publish(roslibpy.Message({"data": 1.5}))
        add = roslibpy.Service(ros, "/add", "rospy_tutorials/AddTwoInts")
        assert add.call(roslibpy.ServiceRequest({"a": 1, "b": 2}), timeout=PATIENCE)["sum"] == 3
        with pytest.raises(roslibpy.core.ServiceException, match="too small"):
            add.call(roslibpy.ServiceRequest({"a": -1, "b": 2}), timeout=PATIENCE)

        provided = roslibpy.Service(ros, "/provided", "std_srvs/SetBool")
        provided.advertise(lambda request, response: response.update(success=True, message="by roslibpy") or True)
        caller = make_node("caller")
        caller.wait_for_service("/provided", PATIENCE)
        with caller.service("/provided", "std_srvs/SetBool") as client:
            assert client.call(client.type._request_class(False), PATIENCE).message == "by roslibpy"
        deadline = time.monotonic() + PATIENCE
        while not (images and commands):
            assert time.monotonic() < deadline
            time.sleep(0.02)
        assert commands == [1.5]
        throttled_and_in_fragments(ros, robot)  # one roslibpy in a process: it begins only once
        assert len(images[0]["data"]) == 48 * 64 / 3 * 4
    finally:
        ros.terminate()


def test_the_pages_example(web: Web, make_node: Callable[..., Node]) -> None:
    (program,) = pages()["viewers"].code("python")
    commands: queue.Queue[float] = queue.Queue()
    node = make_node("simulator")
    node.advertise("velocity", Float64)
    node.subscribe("vel_cmd", Float64, lambda message: commands.put(message.data))
    # roslibpy sends in another thread: an answer means that what came before was sent
    end = "ros.get_topics()\nros.terminate()\n"
    done = subprocess.run(
        [sys.executable, "-c", program + end],
        env={**os.environ, "LINK": socket_url(web)},
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout == "std_msgs/Float64\n"
    assert commands.get(timeout=PATIENCE) == 1.0
