"""The memory that large messages take: what is received needs at most three times its size, decoded or refused.

Feature: a large message takes at most three times its size in memory -- strings and bytes, whether accepted or
    rejected; lists of numbers take as much as in Python, unless they are views
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pyros1.msgs import AnyMsg, load_message
from pyros1.node import Node
from pyros1.wire.handshake import TopicType

from ...bodies import encode

pytestmark = pytest.mark.once

SIZE = 96 << 20
SPARE = 24 << 20
"""Bytes that the process may take besides: what it imports, what it sets aside."""

SUBSCRIBER = """
import sys
from pyros1.msgs import AnyMsg, load_message
from pyros1.node import Node

def memory(name):
    for line in open("/proc/self/status"):
        if line.startswith(name):
            return int(line.split()[1]) * 1024

node = Node("subscriber", argv=[], handle_signals=False)
cls = AnyMsg if sys.argv[1] == "*" else load_message(sys.argv[1])
node.subscribe("/large", cls, lambda message: print(memory("VmHWM"), flush=True))
print(memory("VmRSS"), flush=True)
sys.stdin.read()
node.shutdown()
"""


def string_body(last: bytes = b"b") -> bytes:
    """An encoded String of SIZE bytes."""
    return (SIZE - 4).to_bytes(4, "little") + b"a" * (SIZE - 4 - len(last)) + last


def not_text_body() -> bytes:
    """A String that is not UTF-8; as a str it has 2 bytes per letter."""
    return string_body(b"\xff")


def too_long_body() -> bytes:
    """An array that says it is longer than what comes."""
    return bytes(SIZE)


def bytes_body() -> bytes:
    """An encoded UInt8MultiArray of SIZE bytes."""
    return bytes(8) + (SIZE - 12).to_bytes(4, "little") + bytes(SIZE - 12)


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="needs the memory that a process had at most")
@pytest.mark.parametrize(
    ("type_name", "subscribed", "body", "latch", "times"),
    [
        ("std_msgs/String", "std_msgs/String", string_body, False, 3),
        ("std_msgs/String", "std_msgs/String", string_body, True, 3),
        ("std_msgs/String", "*", string_body, False, 3),
        ("std_msgs/String", "std_msgs/String", not_text_body, False, 7),
        ("std_msgs/UInt8MultiArray", "std_msgs/UInt8MultiArray", bytes_body, False, 3),
        ("std_msgs/UInt8MultiArray", "std_msgs/UInt8MultiArray", too_long_body, False, 3)
    ],
    ids=["string", "latched", "any", "not UTF-8", "bytes", "too long"],
)  # fmt: skip
def test_a_large_message_takes_few_times_its_size(
    make_node: Callable[..., Node],
    environ: dict[str, str],
    type_name: str,
    subscribed: str,
    body: Callable[[], bytes],
    latch: bool,
    times: int,
) -> None:
    cls: Any = load_message(type_name)
    node = make_node("publisher")
    wire_type = TopicType(cls._type, cls._md5sum, cls._full_text)
    publisher = node.advertise("/large", AnyMsg, queue_size=0, raw_type=wire_type, latch=latch)
    child = subprocess.Popen(
        [sys.executable, "-c", SUBSCRIBER, subscribed],
        env={**environ, "PYTHONPATH": ":".join(filter(None, sys.path))},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )
    assert child.stdin is not None and child.stdout is not None
    try:
        before = int(child.stdout.readline())
        assert publisher.wait_for_subscribers(timeout=20)
        publisher.publish(AnyMsg(body()))
        publisher.publish(AnyMsg(encode(cls())))  # is delivered even if the other one is refused
        peak = int(child.stdout.readline())
        assert SIZE < peak - before < times * SIZE + SPARE
    finally:
        child.stdin.close()
        child.stdout.close()
        child.wait(20)
