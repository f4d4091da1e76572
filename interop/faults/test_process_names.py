"""A node is started again under the name of one that hangs: it takes over at once, and the old one ends when it can."""

from __future__ import annotations

import pytest
from harness import Master
from vitals import stopped

MASTERS = ("ours",)
TEXT = "std_msgs/String"
PAIRS = [("roscpp", "pyros1"), ("rospy", "pyros1"), ("pyros1", "roscpp")]


@pytest.mark.parametrize(("old_kind", "new_kind"), PAIRS)
def test_a_node_that_hangs_is_replaced(launcher: Master, topic: str, old_kind: str, new_kind: str) -> None:
    sink = launcher.ready_peer("pyros1", "witness")
    sink.subscribe(topic, TEXT)
    old = launcher.ready_peer(old_kind, "highlander")
    old.advertise(topic, TEXT)
    old.serve(f"{topic}/who", "std_srvs/Trigger")
    old.ask("log", "info", "there can be only one", event="logged info")  # see test_node_lifecycle.py
    old.linked(topic)
    assert old.publish(topic) == sink.received(topic)
    with stopped(old):
        new = launcher.ready_peer(new_kind, "highlander")
        new.advertise(topic, TEXT)
        new.serve(f"{topic}/who", "std_srvs/Trigger")
        new.linked(topic)
        assert new.publish(topic, 2) == sink.received(topic)
        sink.available(f"{topic}/who")
        sink.call(f"{topic}/who", "std_srvs/Trigger")
        assert new.event("served", f"{topic}/who")
        place = launcher.call("lookupNode", "/highlander")[2]
    old.wait_line("new node registered with same name", timeout=60)
    old.wait(60)
    assert launcher.call("lookupNode", "/highlander")[2] == place, "the old one takes nothing with it"
    assert launcher.publishers(topic) == ["/highlander"]
    assert new.publish(topic, 3) == sink.received(topic)
    sink.call(f"{topic}/who", "std_srvs/Trigger")
