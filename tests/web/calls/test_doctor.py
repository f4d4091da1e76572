"""What `wtf` finds, about one topic or node."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from pyros1.doctor.finding import ERROR, Finding
from pyros1.master.server import Master
from pyros1.msgs.std_msgs.msg import Float64, String
from pyros1.net.master_client import MasterClient
from pyros1.web import calls
from pyros1.web.calls.doctor import findings_about, without_hidden
from pyros1.web.robot import Robot
from pyros1.web.server.wire import RequestError

LINKS = Finding(
    "missing-link", ERROR, "nodes should be connected", "cure", ("/a->/b (/t)", "/a->/c (/other)", "/ab: x")
)
TYPES = Finding("type-mismatch", ERROR, "the nodes of topic /t do not agree: a, b", "cure", ("publisher /a: x",))
CLOCK = Finding("no-clock", ERROR, "/use_sim_time is true, but no node publishes /clock", "cure")


def test_only_what_names_it_and_only_whole_names() -> None:
    assert findings_about([LINKS, TYPES], "/t") == [Finding(*_but(LINKS, "/a->/b (/t)")), TYPES]
    assert findings_about([LINKS], "/a")[0].items == ("/a->/b (/t)", "/a->/c (/other)")
    assert findings_about([LINKS, TYPES], "/nobody") == []
    assert findings_about([CLOCK], "/t") == [CLOCK]


def test_what_is_hidden_is_not_told() -> None:
    assert without_hidden([LINKS], {"/other"})[0].items == ("/a->/b (/t)", "/ab: x")
    assert without_hidden([TYPES], {"/t"}) == []
    assert without_hidden([Finding(*_but(LINKS, "/a->/b (/t)"))], {"/t"}) == []
    assert without_hidden([CLOCK], {"/t"}) == [CLOCK]


def _but(finding: Finding, *items: str) -> tuple[Any, ...]:
    return (finding.kind, finding.severity, finding.text, finding.fix, items)


@pytest.mark.slow
def test_a_broken_topic_and_a_dead_node(
    make_robot: Callable[..., Robot], master: Master, make_node: Callable[..., Any], closed_port: int
) -> None:
    robot = make_robot(topics=("/chat", "/quiet"))
    talker, listener = make_node("talker"), make_node("listener", log_level="fatal")
    for topic in ("chat", "hidden"):
        talker.advertise(topic, String)
        listener.subscribe(topic, Float64, lambda message: None)
    client = MasterClient("/gone", master.uri)
    client.register_publisher("/quiet", "std_msgs/String", f"http://localhost:{closed_port}/")
    client.close()
    (found,) = calls.run(robot, "doctor.topic", {"topic": "/chat"})
    assert found["kind"] == "type-mismatch"
    assert found["items"] == ["publisher /talker: std_msgs/String", "subscriber /listener: std_msgs/Float64"]
    assert [each["kind"] for each in calls.run(robot, "doctor.topic", {"topic": "/quiet"})] == ["dead-node"]
    assert [each["kind"] for each in calls.run(robot, "doctor.node", {"node": "/gone"})] == ["dead-node"]
    assert [each["text"] for each in calls.run(robot, "doctor.node", {"node": "/talker"})] == [found["text"]]
    with pytest.raises(RequestError, match="--topics"):
        calls.run(robot, "doctor.topic", {"topic": "/hidden"})
    with pytest.raises(RequestError, match="there is no node /nobody"):
        calls.run(robot, "doctor.node", {"node": "/nobody"})
