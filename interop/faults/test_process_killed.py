"""Publishers are killed and started again, many times: subscribers link anew, lose nothing then, and do not grow.

Feature: process faults: killed, stopped, hung, another program on their port, callbacks that raise or do not return
    -- each compared with stock: [interop/faults.md](interop/faults.md)
"""

from __future__ import annotations

import signal
import struct
from collections.abc import Callable

import pytest
from harness import Master, Peer
from vitals import vitals

FLOAT = "std_msgs/Float64"
AFTER_WARMING_UP = 2
"""Restarts after which a subscriber has what it needs."""
SLACK = 3
"""Descriptors and threads that come and go."""
MORE = 4 << 20
"""Bytes that a subscriber may grow by."""


def numbers(sink: Peer, topic: str, count: int) -> list[float]:
    return [struct.unpack("<d", bytes.fromhex(sink.received(topic, 60)))[0] for _ in range(count)]


@pytest.mark.parametrize("killed", ["stock", "ours"])
def test_a_publisher_is_killed_again_and_again(own_master: Callable[[str], Master], long: bool, killed: str) -> None:
    master = own_master("ours")
    master.start()
    for kind in ("roscpp", "rospy", "pyros1") if long else ("roscpp",):
        source_kind, sink_kind = (kind, "pyros1") if killed == "stock" else ("pyros1", kind)
        kill_again_and_again(master, source_kind, sink_kind, 100 if long else 8)


def kill_again_and_again(master: Master, source_kind: str, sink_kind: str, times: int) -> None:
    sink = master.ready_peer(sink_kind, f"mourner_{source_kind}_{sink_kind}")
    sink.subscribe("/t", FLOAT, queue_size=0)
    before = None
    for generation in range(times):
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
    after = vitals(sink.pid)
    assert before is not None
    assert after.files <= before.files + SLACK and after.threads <= before.threads + SLACK
    assert after.memory <= before.memory + MORE
    assert not sink.unread("(?i)error|traceback")
    print(f"{source_kind} -> {sink_kind}: {before} {after}")
    sink.close()
