"""Stock rosservice, rossrv and rosmsg on pyros1's services and topics, under both masters."""

from __future__ import annotations

import re

from harness import Master, Peer
from samples import text


def test_list_info_type_node_uri_find(ours: Peer, master: Master, topic: str) -> None:
    ours.serve(topic, "std_srvs/SetBool")
    assert topic in master.tool("rosservice", "list").splitlines()
    assert master.tool("rosservice", "type", topic) == "std_srvs/SetBool\n"
    assert master.tool("rosservice", "node", topic) == ours.name + "\n"
    uri = master.tool("rosservice", "uri", topic).strip()
    assert uri.startswith("rosrpc://localhost:")
    assert master.tool("rosservice", "info", topic) == (
        f"Node: {ours.name}\nURI: {uri}\nType: std_srvs/SetBool\nArgs: data\n"
    )
    assert topic in master.tool("rosservice", "find", "std_srvs/SetBool").splitlines()


def test_call(ours: Peer, master: Master, topic: str) -> None:
    ours.serve(topic + "/set", "std_srvs/SetBool")
    ours.serve(topic + "/trigger", "std_srvs/Trigger")
    ours.serve(topic + "/plan", "nav_msgs/GetPlan")
    assert master.tool("rosservice", "call", topic + "/set", "true").splitlines()[0] == "success: True"
    assert 'message: "off"' in master.tool("rosservice", "call", topic + "/set", "data: false")
    answer = master.tool("rosservice", "call", topic + "/trigger")
    assert answer.encode().decode("unicode_escape").splitlines()[1] == f'message: "{text(1)}"'
    plan = master.tool("rosservice", "call", topic + "/plan", "{start: {header: {frame_id: here}}, tolerance: 2.0}")
    assert 'frame_id: "here"' in plan


def test_call_that_fails(ours: Peer, master: Master, topic: str) -> None:
    ours.serve(topic, "std_srvs/Trigger", "throw")
    out = master.tool("rosservice", "call", topic, code=None)
    assert f"ERROR: service [{topic}] responded with an error:" in out and "no luck" in out


def test_get_loggers_and_set_logger_level(ours: Peer, master: Master) -> None:
    """P02: every node has these two services, and debug messages appear once asked for."""
    out = master.tool("rosservice", "call", ours.name + "/get_loggers")
    assert re.search(r'name: "rosout"\n +level: "info"', out, re.IGNORECASE), out
    ours.ask("log", "debug", "unheard", event="logged debug")
    master.tool("rosservice", "call", ours.name + "/set_logger_level", "rosout", "debug")
    ours.ask("log", "debug", "heard", event="logged debug")
    master.tool("rosservice", "call", ours.name + "/set_logger_level", "rosout", "info")
    assert ours.unread(r"\[DEBUG\].*: heard$")
    assert not ours.unread("unheard$")


def test_types_that_rosmsg_and_rossrv_know(ours: Peer, master: Master, topic: str) -> None:
    ours.advertise(topic + "/a", "tf2_msgs/TFMessage")
    ours.serve(topic + "/b", "std_srvs/SetBool")
    message = master.tool("rostopic", "type", topic + "/a").strip()
    assert "geometry_msgs/TransformStamped[] transforms" in master.tool("rosmsg", "show", message)
    service = master.tool("rosservice", "type", topic + "/b").strip()
    assert master.tool("rossrv", "show", service).startswith("bool data\n---\nbool success\nstring message\n")
