"""Stock rostopic on pyros1's publishers and subscribers, under both masters.

Feature: stock rostopic, rosnode, rosservice, rosparam work on our nodes and master
"""

from __future__ import annotations

import re

from harness import Master, Peer, Process, until
from samples import text

TEXT, JOINTS = "std_msgs/String", "sensor_msgs/JointState"


def running(launcher: Master, *command: str) -> Process:
    return launcher.run(command, label=" ".join(command))


def test_list_type_info_find(ours: Peer, master: Master, topic: str) -> None:
    ours.advertise(topic + "/out", TEXT)
    ours.subscribe(topic + "/in", JOINTS)
    until(lambda: ours.name in master.subscribers(topic + "/in"), "the subscription is registered")
    assert {topic + "/out", topic + "/in"} <= set(master.tool("rostopic", "list").splitlines())
    verbose = master.tool("rostopic", "list", "-v")
    assert f" * {topic}/out [{TEXT}] 1 publisher" in verbose
    assert f" * {topic}/in [{JOINTS}] 1 subscriber" in verbose
    assert master.tool("rostopic", "type", topic + "/out") == TEXT + "\n"
    uri = master.call("lookupNode", ours.name)[2]
    assert master.tool("rostopic", "info", topic + "/out") == (
        f"Type: {TEXT}\n\nPublishers: \n * {ours.name} ({uri})\n\nSubscribers: None\n\n\n"
    )
    assert master.tool("rostopic", "info", topic + "/in") == (
        f"Type: {JOINTS}\n\nPublishers: None\n\nSubscribers: \n * {ours.name} ({uri})\n\n\n"
    )
    assert topic + "/out" in master.tool("rostopic", "find", TEXT).splitlines()


def test_echo(ours: Peer, master: Master, topic: str) -> None:
    """A latched message is there when rostopic comes; its text is as genpy prints it."""
    ours.advertise(topic, JOINTS, latch=True)
    ours.publish(topic, 3)
    assert re.sub(r"seq: \d+", "seq: N", master.tool("rostopic", "echo", "-n", "1", topic)) == (
        'header: \n  seq: N\n  stamp: \n    secs: 1700000003\n    nsecs: 123456789\n  frame_id: "map \\xE9 3"\n'
        "name: \n  - \"Gr\\xFC\\xDFe \\u4E16\\u754C \\U0001F916 3\"\n  - ''\n  - joint\n"
        "position: [3.0, 3.125, 3.25]\nvelocity: [-3.0]\neffort: []\n---\n"
    )
    assert master.tool("rostopic", "echo", "-n", "1", topic + "/position[1]") == "3.125\n---\n"
    assert master.tool("rostopic", "echo", "-p", "-n", "1", topic + "/position[2]").splitlines()[1].endswith(",3.25")


def test_hz_and_bw(ours: Peer, launcher: Master, topic: str) -> None:
    for tool, pattern in (("hz", r"average rate: \d+"), ("bw", r"average: [\d.]+")):
        name = f"{topic}/{tool}"
        ours.advertise(name, TEXT)
        process = running(launcher, "rostopic", tool, name)
        ours.linked(name)
        until(lambda: (ours.publish(name), process.unread(pattern))[1], f"rostopic {tool} prints a rate")  # noqa: B023


def test_pub_once(ours: Peer, launcher: Master, topic: str) -> None:
    ours.subscribe(topic, TEXT)
    launcher.tool("rostopic", "pub", "-1", topic, TEXT, f"data: '{text(1)}'")
    assert bytes.fromhex(ours.received(topic))[4:].decode() == text(1)


def test_pub_at_a_rate_ends_with_sigint(ours: Peer, launcher: Master, topic: str) -> None:
    ours.subscribe(topic, "std_msgs/Int64")
    process = running(launcher, "rostopic", "pub", "-r", "50", topic, "std_msgs/Int64", "5")
    for _ in range(5):
        assert ours.received(topic) == "0500000000000000"
    process.close()
    ours.linked(topic, 0)


def test_pub_message_with_header_and_arrays(ours: Peer, launcher: Master, topic: str) -> None:
    ours.subscribe(topic, JOINTS)
    values = "{header: {frame_id: a}, name: [x, y], position: [1.5, 2.5], velocity: [], effort: []}"
    launcher.tool("rostopic", "pub", "-1", topic, JOINTS, values)
    body = bytes.fromhex(ours.received(topic))
    assert body[12:] == b"\1\0\0\0a\2\0\0\0\1\0\0\0x\1\0\0\0y\2\0\0\0\0\0\0\0\0\0\xf8?\0\0\0\0\0\0\x04@" + bytes(8)


def test_any_type_subscription_hears_rostopic(ours: Peer, launcher: Master, topic: str) -> None:
    """Our subscription to any type (T09) names the type that it found."""
    ours.subscribe(topic, "*")
    running(launcher, "rostopic", "pub", topic, TEXT, "hello")
    assert ours.received(topic) == b"\5\0\0\0hello".hex()
    header = ours.header(topic)
    assert (header["type"], header["md5sum"]) == (TEXT, "992ce8a1687cec8c8bd883ec73ca41d1")


def test_relay_of_any_type(ours: Peer, launcher: Master, topic: str) -> None:
    """topic_tools/relay subscribes with ``*`` and advertises what our connection header says (O05, O06)."""
    ours.advertise(topic, JOINTS)
    ours.subscribe(topic + "/relayed", JOINTS)
    running(launcher, "/usr/lib/topic_tools/relay", topic, topic + "/relayed")
    ours.linked(topic)
    ours.publish(topic, 1)  # the relay advertises when the first message has come
    ours.linked(topic + "/relayed")
    launcher.sends(topic + "/relayed")
    sent = ours.publish(topic, 2)
    bodies = [ours.received(topic + "/relayed")]
    if bodies[-1][8:] != sent[8:]:
        bodies.append(ours.received(topic + "/relayed"))
    assert bodies[-1][8:] == sent[8:]


def test_delay(ours: Peer, launcher: Master, topic: str) -> None:
    ours.advertise(topic, JOINTS)
    process = running(launcher, "rostopic", "delay", topic)
    ours.linked(topic)
    until(lambda: (ours.publish(topic), process.unread(r"average delay: "))[1], "rostopic delay prints a figure")
    assert re.search(r"min: \d+", " ".join(process.lines))
