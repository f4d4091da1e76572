"""Publishers are killed and started again, many times: their subscribers link anew, lose nothing then, and do not grow."""

from __future__ import annotations

import itertools
import signal
import struct
from collections.abc import Callable

import pytest
from harness import Master, Peer
from vitals import vitals

FLOAT = "std_msgs/Float64"
AFTER_WARMING_UP = 2
"""Restarts after which a subscriber has what it needs."""
MORE = 4 << 20
"""Bytes that a subscriber may grow by."""
MASTERS = ("ours",)


def numbers(sink: Peer, topic: str, count: int) -> list[float]:
    return [struct.unpack("<d", bytes.fromhex(sink.received(topic, 60)))[0] for _ in range(count)]


@pytest.mark.parametrize(
    ("source_kind", "sink_kind"),
    [("roscpp", "pyros1"), ("rospy", "pyros1"), ("pyros1", "pyros1"), ("pyros1", "roscpp"), ("pyros1", "rospy")],
)
def test_a_publisher_is_killed_again_and_again(
    own_master: Callable[[str], Master], long: bool, source_kind: str, sink_kind: str
) -> None:
    master = own_master("ours")
    master.start()
    sink = master.ready_peer(sink_kind, "mourner")
    sink.subscribe("/t", FLOAT, queue_size=0)
    before = None
    for generation in range(100 if long else 6):
        source = master.ready_peer(source_kind, "mortal")
        source.advertise("/t", FLOAT, queue_size=1000)
        source.linked("/t")
        first = 100 * generation
        source.ask("burst", "/t", first, 100, event="burst /t", timeout=60)
        assert numbers(sink, "/t", 100) == [seed + 0.1 for seed in range(first, first + 100)]
        if generation == AFTER_WARMING_UP:
            before = vitals(sink.pid)
        source.signal(signal.SIGKILL)
        source.wait()
    sink.linked("/t", 0)
    after = vitals(sink.pid)
    assert before is not None
    assert after.files <= before.files and after.threads <= before.threads
    assert after.memory <= before.memory + MORE
    assert not sink.unread("(?i)error|traceback")


@pytest.mark.parametrize(("old", "new"), list(itertools.product(["pyros1"], ["roscpp", "rospy", "pyros1"])))
def test_a_service_is_killed_and_started_again(launcher: Master, topic: str, old: str, new: str) -> None:
    """The persistent client's call under way fails; the next one reaches the new process."""
    client = launcher.ready_peer(old, "customer")
    for _ in range(2):
        server = launcher.ready_peer(new, "shop")
        server.serve(topic, "std_srvs/SetBool")
        client.available(topic)
        client.call(topic, "std_srvs/SetBool", persistent=True)
        server.signal(signal.SIGKILL)
        server.wait()
        assert "rror" in client.call_failing(topic, "std_srvs/SetBool", persistent=True)
