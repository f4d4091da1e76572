"""Foxglove's own client (npm: @foxglove/ws-protocol, rosmsg, rosmsg-serialization) at the server's port.

Feature: Foxglove clients: messages of all types, publishing, services, parameters, graph, files
"""

from __future__ import annotations

import json
import os
import shutil
import struct
import subprocess
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from browsing import Web

from pyros1.msgs import AnyMsg, from_definition
from pyros1.node.topic_type import topic_type

PACKAGES = ["@foxglove/ws-protocol@0.8.0", "@foxglove/rosmsg@5", "@foxglove/rosmsg-serialization@2", "ws@8"]
TOUR = Path(__file__).with_name("foxglove_tour.js")


@pytest.fixture(scope="session")
def modules(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder with the client's packages, from the registry."""
    if not shutil.which("node") or not shutil.which("npm"):
        if os.environ.get("PYROS1_REQUIRE_STOCK"):
            pytest.fail("node and npm are missing: interop/setup installs them")
        pytest.skip("node and npm are not installed")
    folder = tmp_path_factory.mktemp("npm")
    (folder / "package.json").write_text("{}")
    done = subprocess.run(
        ["npm", "install", "--no-audit", "--no-fund", *PACKAGES],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=180,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return folder / "node_modules"


def run_tour(modules: Path, link: str) -> dict[str, Any]:
    done = subprocess.run(
        ["node", str(TOUR), link.replace("http", "ws", 1)],
        env={**os.environ, "NODE_PATH": str(modules)},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def test_a_tour_with_the_real_client(modules: Path, web: Web, make_node: Callable[..., Any]) -> None:
    node = make_node("robot")
    pose = node.advertise("pose", "geometry_msgs/PoseStamped", latch=True)
    message = pose.type()
    message.header.stamp.secs, message.header.frame_id, message.pose.position.x = 12, "map", 1.5
    pose.publish(message)
    pair = from_definition("my_msgs/Pair", "int32[] numbers\nduration late\n")  # of a type that is not installed
    publisher = node.advertise("pair", AnyMsg, raw_type=topic_type(pair), latch=True)
    publisher.publish(AnyMsg(struct.pack("<I2i2i", 2, 3, 4, 5, 0)))
    heard: list[str] = []
    both = threading.Event()

    def hear(said: Any) -> None:
        heard.append(said.data)
        if len(heard) == 2:
            both.set()

    def add(request: Any) -> int:
        if request.a < 0:
            raise ValueError("too small")
        return int(request.a + request.b)

    node.subscribe("said", "std_msgs/String", hear)
    node.advertise_service("add", "rospy_tutorials/AddTwoInts", add)
    node.master.set_param("/speed", 2.0)

    seen = run_tour(modules, web.link)

    assert "clientPublish" in seen["info"]["capabilities"]
    assert seen["pose"]["type"] == "geometry_msgs/PoseStamped"
    assert abs(seen["pose"]["time"] - time.time()) < 60
    assert seen["pose"]["value"]["header"]["stamp"] == {"sec": 12, "nsec": 0}
    assert seen["pose"]["value"]["header"]["frame_id"] == "map"
    assert seen["pose"]["value"]["pose"]["position"] == {"x": 1.5, "y": 0, "z": 0}
    assert seen["pair"]["type"] == "my_msgs/Pair"
    assert seen["pair"]["value"] == {"numbers": {"0": 3, "1": 4}, "late": {"sec": 5, "nsec": 0}}
    assert both.wait(20)
    assert heard == ["from Foxglove", "as JSON"]
    assert seen["published"]["level"] == 2
    assert seen["sum"] == [77, 7]
    assert "too small" in seen["failure"]
    first = {each["name"]: each["value"] for each in seen["parameters"]["first"]}
    assert first["/speed"] == 2.0
    assert seen["parameters"]["second"] == [{"name": "/speed", "value": 3.5, "type": "float64"}]
    assert seen["parameters"]["changed"] == seen["parameters"]["second"]
    assert node.master.get_param("/speed") == 3.5
    publishers = {each["name"]: each["publisherIds"] for each in seen["graph"]["publishedTopics"]}
    assert publishers["/pose"] == ["/robot"]
    assert {"name": "/add", "providerIds": ["/robot"]} in seen["graph"]["advertisedServices"]
    assert "<name>minimal_nodes</name>" in seen["asset"]
    assert seen["outside"] == "this does not refer to a file in a package"
