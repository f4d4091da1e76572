"""Who may connect: others are turned away from every port of ours before a byte of theirs is read.

Feature: unwanted connections are refused before a byte is read -- `--allow`, `PYROS1_ALLOW`: master, rosout, nodes,
    launchers, UDP, web pages
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import NamedTuple

import pytest
from harness import STOCK_PYTHON, Process
from hosts import Host, Network

URI = "http://robot:11311/"
CALL = """
import sys, xmlrpc.client
sys.stdout.write(repr(getattr(xmlrpc.client.ServerProxy(sys.argv[1]), sys.argv[2])('/guest', *sys.argv[3:])))
"""
RAW = """
import socket, sys
try:
    sock = socket.create_connection((sys.argv[1], int(sys.argv[2])), 10)
    sys.stdout.write('said ' + repr(sock.recv(100)))
except ConnectionResetError:
    sys.stdout.write('reset')
"""


class Place(NamedTuple):
    robot: Host
    friend: Host
    guest: Host
    core: Process


@pytest.fixture(scope="module")
def place() -> Iterator[Place]:
    """A robot whose core and nodes let in only a friend."""
    with Network() as network:
        robot, friend, guest = (network.add(name) for name in ("robot", "friend", "guest"))
        core = robot.start(robot.pyros1("core", "--allow", friend.address), robot.environ(URI), "core")
        robot.await_port(11311)
        yield Place(robot, friend, guest, core)


def call(host: Host, uri: str, method: str, *arguments: str) -> str:
    """Call a method of a master or node with an ordinary XML-RPC client; returns the answer, or the last line."""
    return host.run([STOCK_PYTHON, "-c", CALL, uri, method, *arguments]).output.strip().rpartition("\n")[2]


def ports(host: Host, kind: str = "t") -> set[tuple[str, int]]:
    """The addresses and ports that a host's programs listen at: t for TCP, u for UDP."""
    lines = host.run(["ss", f"-Hln{kind}"]).output.split("\n")
    places = [line.split()[3].rpartition(":") for line in lines if line]
    return {(address, int(port)) for address, _, port in places}


def test_the_master_serves_its_friends_and_nobody_else(place: Place) -> None:
    for name, tool in (("friend", ["rosparam", "set", "/speed", "1"]), ("robot", ["rosparam", "get", "/speed"])):
        host = getattr(place, name)
        assert host.run(tool, host.environ(URI, "stock")).code == 0
    guest = place.guest
    for method, arguments in (
        ("shutdown", ("because",)),
        ("setParam", ("/speed", "9")),
        ("registerPublisher", ("/scan", "std_msgs/String", "http://guest:1/")),
        ("getSystemState", ()),
    ):
        assert "ConnectionResetError" in call(guest, URI, method, *arguments)
    assert place.friend.run(["rosparam", "get", "/speed"], place.friend.environ(URI, "stock")).output == "1\n"
    said = guest.run(guest.pyros1("node", "list"), guest.environ(URI))
    assert said.code == 1 and "--allow (PYROS1_ALLOW) include this machine" in said.output
    place.core.wait_line(f"WARNING: refused a connection from {guest.address}")
    assert not place.core.unread("refused a connection"), "said once"


def test_every_port_of_the_core_and_of_a_node_is_closed_to_others(place: Place) -> None:
    """Also the node in the core, rosout, and the launcher's API."""
    robot, guest = place.robot, place.guest
    node = robot.peer("pyros1", "talker", URI, f"__allow:={place.friend.address}")
    node.advertise("/chatter", "std_msgs/String", latch=True)
    node.publish("/chatter")
    listening = ports(robot)
    assert len(listening) == 6 and {address for address, _ in listening} == {"0.0.0.0"}
    for _, port in listening:
        assert guest.run([sys.executable, "-c", RAW, "robot", str(port)]).output == "reset"
    node.wait_line(f"refused a connection from {guest.address}")
    friend = place.friend.peer("roscpp", "friend", URI)
    friend.subscribe("/chatter", "std_msgs/String")
    friend.received("/chatter")
    uri = place.friend.run(["rosnode", "info", "/talker"], place.friend.environ(URI, "stock")).output
    api = uri.partition("contacting node ")[2].split()[0]
    assert "ConnectionResetError" in call(guest, api, "shutdown", "because")
    assert "ConnectionResetError" in call(guest, api, "publisherUpdate", "/chatter", "")
    assert call(robot, api, "getName").startswith("[1,")
    assert "shutdown" in call(place.friend, api, "shutdown", "because") or node.wait() == 0


def test_datagrams_of_others_are_not_taken(place: Place) -> None:
    """A datagram says nothing of who sent it but its address."""
    robot, friend, guest = place.robot, place.friend, place.guest
    listen = (
        "import sys, pyros1\n"
        "node = pyros1.Node('listener')\n"
        "def told(message): print('got', message.data, flush=True)\n"
        "node.subscribe('/udp', 'std_msgs/String', told, transports='udp')\n"
        "print('ready', flush=True)\n"
        "node.spin()\n"
    )
    environ = robot.environ(URI, PYROS1_ALLOW=friend.address, PYROS1_PORTS="41000-41002")
    listener = robot.start([sys.executable, "-c", listen], environ, "listener")
    listener.wait_line("ready", timeout=60)
    talker = friend.peer("roscpp", "udp_talker", URI)
    talker.advertise("/udp", "std_msgs/String", latch=True)
    talker.linked("/udp")
    (port,) = (port for _, port in ports(robot, "u") if 41000 <= port <= 41002)
    forged = "import socket, sys\nsocket.socket(type=2).sendto(b'x' * 20, ('robot', int(sys.argv[1])))"
    assert guest.run([sys.executable, "-c", forged, str(port)]).code == 0
    listener.wait_line(f"refused a connection from {guest.address}")
    talker.publish("/udp")
    listener.wait_line("^got ")


def test_a_page_lets_in_the_same_machines(place: Place) -> None:
    robot, friend, guest = place.robot, place.friend, place.guest
    words = ("web", "--host", "0.0.0.0", "--token", "", "--allow", friend.address)
    page = robot.start(robot.pyros1(*words), robot.environ(URI), "web")
    page.wait_line("in a browser", timeout=60)
    get = "import sys, urllib.request; sys.stdout.write(str(urllib.request.urlopen(sys.argv[1], timeout=10).status))"
    assert friend.run([sys.executable, "-c", get, "http://robot:9090/"]).output == "200"
    refused = guest.run([sys.executable, "-c", get, "http://robot:9090/"]).output
    assert "ConnectionResetError" in refused or "closed connection without response" in refused
    page.wait_line(f"refused a connection from {guest.address}")


def test_what_listens_at_one_address() -> None:
    """Stock's core listens at all, ours where ``--bind`` says, and is reached only there.

    Feature: the address to listen on can be set -- `--bind`, `PYROS1_BIND`
    """
    with Network() as network:
        robot, other = network.add("robot"), network.add("other")
        robot.must("ip addr add 10.89.0.1/24 dev eth0")
        words = ("core", "--bind", "10.89.0.1", "--ports", "41000-41009")
        core = robot.start(robot.pyros1(*words), robot.environ(), "core")
        other.core("stock", 11312)
        core.wait_line(r"started core service \[/rosout\]", timeout=60)
        listening = ports(robot)
        assert {address for address, _ in listening} == {"10.89.0.1"}
        assert all(port == 11311 or 41000 <= port <= 41009 for _, port in listening) and len(listening) == 4
        assert robot.run(robot.pyros1("node", "list"), robot.environ("http://10.89.0.1:11311")).output == "/rosout\n"
        assert robot.run(robot.pyros1("node", "list"), robot.environ("http://robot:11311")).code == 1
        assert {address for address, _ in ports(other)} == {"0.0.0.0"}
