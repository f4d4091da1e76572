"""Services of stock nodes at one stock master, called by stock nodes and tools at another, over bridges between them.

Feature: stock clients call stock services of another master -- single and persistent calls, errors, rosservice
"""

from __future__ import annotations

import itertools
import sys
from collections.abc import Callable, Iterator
from typing import NamedTuple

import pytest
from harness import Master, Peer, Process, free_port, until

pytest.importorskip("zenoh")
KINDS = ("roscpp", "rospy")
RULES = ("--serve", "/interop/**", "--params", "/interop")


class Sites(NamedTuple):
    """A robot and a base, each with a stock master and a bridge."""

    red: Master
    base: Master
    bridge: Process


@pytest.fixture(scope="module")
def sites(new_master: Callable[[str], Master]) -> Iterator[Sites]:
    red, base = new_master("stock"), new_master("stock")
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    pyros1 = [sys.executable, "-m", "pyros1", "bridge"]
    try:
        for master in (red, base):
            master.start()
        base.run(
            [*pyros1, "--site", "base", "--listen", endpoint, "--call", "red:**"], python="ours", label="base's bridge"
        )
        bridge = red.run([*pyros1, "--site", "red", "--to", endpoint, *RULES], python="ours", label="red's bridge")
        yield Sites(red, base, bridge)
    finally:
        base.close()
        red.close()


def providers(master: Master, name: str) -> list[str]:
    return list(dict(master.call("getSystemState")[2][2]).get(name, []))


def serve(sites: Sites, server: Peer, topic: str, type_name: str, mode: str = "answer") -> str:
    """Let a node at red provide a service; return its name at the base, once it is there."""
    server.serve(topic, type_name, mode)
    until(lambda: providers(sites.base, f"/red{topic}") == ["/bridge_base"], f"/red{topic} at the base")
    return f"/red{topic}"


@pytest.mark.parametrize("persistent", [False, True], ids=["single", "persistent"])
@pytest.mark.parametrize(("serving", "calling"), list(itertools.product(KINDS, KINDS)))
def test_calls(sites: Sites, serving: str, calling: str, topic: str, persistent: bool) -> None:
    server, client = sites.red.shared("server", serving), sites.base.shared("client", calling)
    for number, type_name in enumerate(("std_srvs/Empty", "std_srvs/SetBool", "nav_msgs/GetPlan")):
        name = serve(sites, server, f"{topic}_{number}", type_name)
        client.available(name)
        for seed in (1, 2, 3):
            request, response = client.call(name, type_name, seed, persistent)
            assert server.event("served", f"{topic}_{number}") == request
            assert (response == "-") == (type_name == "std_srvs/Empty")
        if persistent:
            client.ask("hangup", name, event=f"hung {name}")


@pytest.mark.parametrize("mode", ["refuse", "throw"])
@pytest.mark.parametrize(("serving", "calling"), list(itertools.product(KINDS, KINDS)))
def test_a_handler_that_fails(sites: Sites, serving: str, calling: str, topic: str, mode: str) -> None:
    server, client = sites.red.shared("server", serving), sites.base.shared("client", calling)
    name = serve(sites, server, topic, "std_srvs/SetBool", mode)
    client.available(name)
    for _ in range(2):
        error = client.call_failing(name, "std_srvs/SetBool")
        server.event("served", topic)
        if client.kind != "roscpp" and not (server.kind == "roscpp" and mode == "refuse"):
            assert "no luck" in error


@pytest.mark.parametrize("serving", KINDS)
def test_a_server_that_dies_during_the_call(sites: Sites, serving: str, topic: str) -> None:
    mortal, client = sites.red.ready_peer(serving, "mortal_server"), sites.base.shared("client", "rospy")
    name = serve(sites, mortal, topic, "std_srvs/SetBool", "die")
    error = client.call_failing(name, "std_srvs/SetBool")
    assert "failed" in error
    assert mortal.wait() == 9


def test_rosservice(sites: Sites, topic: str) -> None:
    name = serve(sites, sites.red.shared("server", "roscpp"), topic, "std_srvs/SetBool")
    assert sites.base.tool("rosservice", "type", name) == "std_srvs/SetBool\n"
    info = sites.base.tool("rosservice", "info", name)
    assert "Node: /bridge_base" in info and "Type: std_srvs/SetBool" in info and "Args: data" in info
    assert "success:" in sites.base.tool("rosservice", "call", name, "true")


def test_parameters(sites: Sites, topic: str) -> None:
    sites.red.call("setParam", topic, {"text": "two\nlines", "speed": 1.5})
    until(lambda: providers(sites.base, "/bridge_base/bridge_parameters"), "the bridge")
    command = [sys.executable, "-m", "pyros1", "bridge", "param", "red:", topic, "--to", "/copy"]
    assert sites.base.run(command, python="ours").wait() == 0
    assert sites.base.tool("rosparam", "get", "/copy/text") == sites.red.tool("rosparam", "get", f"{topic}/text")
    assert sites.base.call("getParam", "/copy/speed")[2] == 1.5


def test_a_bridge_that_is_killed(sites: Sites, topic: str) -> None:
    """The last test: its calls end with errors as soon as the site counts as lost."""
    name = serve(sites, sites.red.shared("server", "rospy"), topic, "std_srvs/SetBool")
    client = sites.base.shared("client", "rospy")
    client.call(name, "std_srvs/SetBool")
    sites.bridge.signal(9)
    sites.bridge.wait()
    for _ in range(2):
        assert "site red does not respond" in client.call_failing(name, "std_srvs/SetBool")
