"""Nodes come, go, die, are replaced, and start before their master; stock peers watch, or are watched."""

from __future__ import annotations

import signal
from collections.abc import Callable

import pytest
from harness import Master, Peer, until

TEXT, IMAGE = "std_msgs/String", "sensor_msgs/Image"
STOCK = ("roscpp", "rospy")


@pytest.mark.parametrize("stock", STOCK)
@pytest.mark.parametrize("dying", ["our publisher", "stock publisher"])
def test_subscriber_resumes_after_publisher_was_killed(
    launcher: Master, ours_kind: str, topic: str, stock: str, dying: str
) -> None:
    """T52: SIGKILL, and a new process of the same name on another port."""
    publisher_kind, subscriber_kind = (ours_kind, stock) if dying == "our publisher" else (stock, ours_kind)
    sink = launcher.ready_peer(subscriber_kind, "mourner")
    sink.subscribe(topic, TEXT)
    for generation in range(3):
        source = launcher.ready_peer(publisher_kind, "mortal")
        source.advertise(topic, TEXT)
        source.linked(topic)
        sent = source.publish(topic, generation)
        assert sink.received(topic) == sent
        source.signal(signal.SIGKILL)
        source.wait()


@pytest.mark.parametrize("stock", STOCK)
def test_publisher_drops_a_killed_subscriber(launcher: Master, ours: Peer, topic: str, stock: str) -> None:
    ours.advertise(topic, TEXT)
    sink = launcher.ready_peer(stock, "short_lived")
    sink.subscribe(topic, TEXT)
    ours.linked(topic, 1)
    sink.signal(signal.SIGKILL)
    ours.linked(topic, 0)


@pytest.mark.parametrize("kind", ["ours", "stock"])
def test_node_started_before_its_master(own_master: Callable[[str], Master], ours_kind: str, kind: str) -> None:
    master = own_master(kind)
    node = master.peer(ours_kind, "early")
    node.wait_line("(?i)master")
    assert not node.unread("^ready")
    master.start()
    assert node.event("ready") == "/early"
    node.advertise("/late", TEXT)
    until(lambda: master.publishers("/late") == ["/early"], "the publisher is registered")


@pytest.mark.ours_only
@pytest.mark.parametrize("kind", ["ours", "stock"])
def test_nodes_register_again_with_a_restarted_master(
    own_master: Callable[[str], Master], ours_kind: str, kind: str
) -> None:
    """What stock nodes cannot do (M44): ours notice and come back."""
    master = own_master(kind)
    master.start()
    source, sink = master.ready_peer(ours_kind, "source"), master.ready_peer(ours_kind, "sink")
    source.advertise("/kept", TEXT)
    source.serve("/kept_service", "std_srvs/Trigger")
    sink.subscribe("/kept", TEXT)
    source.linked("/kept")
    master.stop()
    master.start()
    until(lambda: master.publishers("/kept") == ["/source"], "the publisher registers again", timeout=60)
    until(lambda: master.subscribers("/kept") == ["/sink"], "the subscriber registers again", timeout=60)
    until(lambda: master.call("lookupService", "/kept_service")[0] == 1, "the service registers again", timeout=60)
    listener = master.ready_peer("roscpp", "newcomer")
    listener.subscribe("/kept", TEXT)
    source.linked("/kept", 2)
    sent = source.publish("/kept")
    assert sink.received("/kept") == listener.received("/kept") == sent


@pytest.mark.parametrize("stock", STOCK)
@pytest.mark.parametrize("first", ["ours", "stock"])
def test_second_node_of_the_same_name_replaces_the_first(
    launcher: Master, ours_kind: str, topic: str, stock: str, first: str
) -> None:
    """M34: the old one says why and ends."""
    kinds = (ours_kind, stock) if first == "ours" else (stock, ours_kind)
    old = launcher.ready_peer(kinds[0], "highlander")
    old.advertise(topic, TEXT)
    # A roscpp node subscribes a parameter with its first log message. If that were the one about its own end, the
    # master would take it for a newcomer of that name and end the other one.
    old.ask("log", "info", "there can be only one", event="logged info")
    new = launcher.ready_peer(kinds[1], "highlander")
    new.advertise(topic, TEXT)
    old.wait_line("new node registered with same name")
    old.wait()
    new.linked(topic, 0)
    assert launcher.publishers(topic) == ["/highlander"]
    assert launcher.call("lookupNode", "/highlander")[2] == launcher.call("lookupNode", new.name)[2]


@pytest.mark.ours_only
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["SIGINT", "SIGTERM"])
def test_signals_unregister_everything(launcher: Master, ours_kind: str, topic: str, number: int) -> None:
    node = launcher.ready_peer(ours_kind, "polite")
    node.advertise(topic, TEXT)
    node.subscribe(topic + "/in", TEXT)
    node.serve(topic + "/service", "std_srvs/Trigger")
    until(lambda: launcher.subscribers(topic + "/in"), "the subscription is registered")
    node.signal(number)
    assert node.wait() == 0
    assert node.lines[-1] == "bye"
    state = launcher.call("getSystemState")[2]
    assert not [name for kind in state for name, nodes in kind if "/polite" in nodes]


def test_stopped_subscriber_does_not_delay_the_others(launcher: Master, ours: Peer, topic: str) -> None:
    """A peer that no longer reads costs its own messages only."""
    stuck, well = launcher.ready_peer("roscpp", "stuck"), launcher.ready_peer("rospy", "well")
    ours.advertise(topic, IMAGE, queue_size=2)
    for sink in (stuck, well):
        sink.subscribe(topic, IMAGE, queue_size=0)
    ours.linked(topic, 2)
    stuck.signal(signal.SIGSTOP)
    try:
        for _ in range(30):
            sent = ours.publish(topic, 1_000_000)
            assert well.received(topic) == sent
    finally:
        stuck.signal(signal.SIGCONT)
    assert stuck.received(topic)


def test_names_remappings_and_private_parameters(launcher: Master, ours_kind: str, topic: str) -> None:
    """N03, N08, N12-N14: the same arguments mean the same to ours and to rospy."""
    results = []
    for kind in (ours_kind, "rospy"):
        arguments = [f"__ns:=/ns{topic}", f"__name:=renamed_{kind}", "chatter:=other", "_rate:=2.5", "_deep/er:=a b"]
        node = launcher.ready_peer(kind, "ignored", *arguments)
        for name in ("chatter", "~private", "/chatter", "relative/chatter"):
            node.advertise(name, TEXT)
        published = [name for name, _ in launcher.node(node.name, "getPublications")[2]]
        values = [node.ask("getparam", f"~{key}", event=f"getparam ~{key}") for key in ("rate", "deep/er")]
        results.append([node.name, sorted(published), values])
        results[-1] = [str(part).replace(kind, "KIND") for part in results[-1]]
    assert results[0] == results[1]
    assert f"/ns{topic}/other" in results[0][1]


def test_namespace_from_the_environment(launcher: Master, ours_kind: str, topic: str) -> None:
    node = launcher.ready_peer(ours_kind, "spaced", ROS_NAMESPACE="/from/environment")
    assert node.name == "/from/environment/spaced"
    node.advertise("x", TEXT)
    assert launcher.publishers("/from/environment/x") == [node.name]


@pytest.mark.parametrize("variable", ["ROS_IP", "ROS_HOSTNAME"])
def test_advertised_address(launcher: Master, ours_kind: str, topic: str, variable: str) -> None:
    """N18, N23: what is advertised is what stock peers use to connect."""
    node = launcher.ready_peer(ours_kind, "addressed", **{"ROS_HOSTNAME": None, variable: "127.0.0.1"})
    node.advertise(topic, TEXT)
    assert launcher.call("lookupNode", node.name)[2].startswith("http://127.0.0.1:")
    sink = launcher.ready_peer("roscpp", "addressee")
    sink.subscribe(topic, TEXT)
    node.linked(topic)
    sent = node.publish(topic)
    assert sink.received(topic) == sent
