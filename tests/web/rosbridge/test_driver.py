"""What is read ahead of a client that sends faster than its operations are done is bounded in bytes."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest

from pyros1.ground.errors import MasterUnreachableError
from pyros1.node import Node
from pyros1.web.robot import Robot
from pyros1.web.rosbridge.driver import Bridge
from pyros1.web.server.access import Access
from pyros1.web.server.threads import ThreadPool

MOST = 1 << 20
TURNS = 20_000
"""Of the loop: far more than a client without a bound needs for ten times as much."""


class Talker:
    """A WebSocket whose client never stops to send frames of a size."""

    def __init__(self, size: int) -> None:
        self.frame = b"x" * size
        self.taken = 0

    def __aiter__(self) -> Talker:
        return self

    async def __anext__(self) -> bytes:
        await asyncio.sleep(0)
        self.taken += 1
        return self.frame

    async def send(self, frame: Any) -> None:
        """Nothing is sent before the server's node is there."""


def no_node() -> Node:
    raise MasterUnreachableError("there is no master")


@pytest.mark.parametrize("size", [0, 1_000, 100_000, 3 * MOST])
def test_frames_that_are_read_ahead(size: int) -> None:
    robot = Robot("http://localhost:1/", Access(), no_node)  # clients wait for its node for some seconds
    calls = ThreadPool(1, "test: calls")
    bridge = Bridge(robot, calls)
    talker = Talker(size)

    async def talk() -> None:
        serving = asyncio.create_task(bridge.serve(talker))  # type: ignore[arg-type]  # it is used like one
        for _ in range(TURNS):
            await asyncio.sleep(0)
        serving.cancel()
        await asyncio.gather(serving, return_exceptions=True)

    asyncio.run(talk())
    bridge.close()
    calls.shutdown(wait=True)
    assert talker.taken >= 1
    assert (talker.taken - 1) * size <= MOST  # one more is, however large
    assert talker.taken <= 2_000  # small ones cost, too
