"""Stock rosnode on pyros1's nodes, under both masters."""

from __future__ import annotations

import re
import signal

from harness import Master, Peer, until

TEXT = "std_msgs/String"


def test_list(ours: Peer, master: Master) -> None:
    names = master.tool("rosnode", "list").splitlines()
    assert ours.name in names and "/rosout" in names
    assert f"{master.call('lookupNode', ours.name)[2]} \t{ours.name}" in master.tool("rosnode", "list", "-a")


def test_info(ours: Peer, launcher: Master, topic: str) -> None:
    """Every line of rosnode info, with a connection in each direction."""
    node = launcher.ready_peer(ours.kind, "informative")
    other = launcher.ready_peer("roscpp", "informed")
    for source, sink, name in ((node, other, topic + "/out"), (other, node, topic + "/in")):
        source.advertise(name, TEXT)
        sink.subscribe(name, TEXT)
        source.linked(name)
        sink.linked(name)
    node.serve(topic + "/service", "std_srvs/Trigger")
    uri = launcher.call("lookupNode", node.name)[2]
    other_uri = launcher.call("lookupNode", other.name)[2]
    expected = rf"""-{{80}}
Node \[/informative\]
Publications: 
 \* {topic}/out \[std_msgs/String\]
 \* /rosout \[rosgraph_msgs/Log\]

Subscriptions: 
 \* {topic}/in \[std_msgs/String\]

Services: 
 \* /informative/get_loggers
 \* /informative/set_logger_level
 \* {topic}/service


contacting node {uri} \.\.\.
Pid: {node.pid}
Connections:
((?: \* topic: .*\n    \* to: .*\n    \* direction: .*\n    \* transport: (?:TCPROS|LOCAL)\n)+)\n*"""  # noqa: W291  rosnode prints these blanks

    def connected() -> re.Match[str] | None:
        out = launcher.tool("rosnode", "info", node.name)
        assert "Unknown" not in out
        found = re.fullmatch(expected, out)
        assert found, out
        # rosout subscribes a moment after the node is up
        return found if "to: /rosout" in found[1] else None

    connections = until(connected, "rosout is connected")[1]
    connection = " * topic: {}\n    * to: {}\n    * direction: {} \\(\\d+ - {}:\\d+\\) \\[\\d+\\]\n"
    assert re.search(connection.format("/rosout", "/rosout", "outbound", "[^ ]+").replace("*", r"\*", 3), connections)
    out = connection.format(topic + "/out", other.name, "outbound", "[^ ]+").replace("*", r"\*", 3)
    assert re.search(out, connections), connections
    into = rf" \* topic: {topic}/in\n    \* to: {other.name} \({re.escape(other_uri)}\)\n    \* direction: inbound"
    assert re.search(into, connections), connections


def test_ping(ours: Peer, master: Master) -> None:
    out = master.tool("rosnode", "ping", "-c", "2", ours.name)
    assert len(re.findall(r"xmlrpc reply from http://.*\ttime=[\d.]+ms", out)) == 2
    assert "ping average:" in out
    assert f"{master.call('lookupNode', ours.name)[2]}" in master.tool("rosnode", "ping", "--all")


def test_machine(ours: Peer, master: Master) -> None:
    assert ours.name in master.tool("rosnode", "machine", "localhost").splitlines()


def test_kill(ours: Peer, launcher: Master, topic: str) -> None:
    """S06: the node says who asked, leaves the master, and ends."""
    victim = launcher.ready_peer(ours.kind, "victim")
    victim.advertise(topic, TEXT)
    assert "killed" in launcher.tool("rosnode", "kill", victim.name)
    victim.wait_line("shutdown request: .*user request")
    assert victim.wait() == 0
    assert not launcher.publishers(topic)
    assert victim.name not in launcher.tool("rosnode", "list").splitlines()


def test_cleanup(ours: Peer, launcher: Master, topic: str) -> None:
    victim = launcher.ready_peer(ours.kind, "crashed")
    victim.advertise(topic, TEXT)
    victim.signal(signal.SIGKILL)
    victim.wait()
    assert launcher.publishers(topic) == [victim.name]
    out = launcher.tool("rosnode", "cleanup", stdin="y\n")
    assert victim.name in out and ours.name not in out
    assert not launcher.publishers(topic)
