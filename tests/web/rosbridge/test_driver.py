"""What is read ahead of a client that sends faster than its operations are done is bounded in bytes."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest
from websockets.protocol import State

from pyros1.ground.errors import MasterUnreachableError
from pyros1.node import Node
from pyros1.web.robot import Robot
from pyros1.web.rosbridge.client import Client, DueFrames
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


class Silent(Talker):
    """A WebSocket whose client says nothing, and reads."""

    state = State.OPEN

    def __init__(self) -> None:
        super().__init__(0)
        self.written: list[bytes] = []
        self.transport = self

    async def __anext__(self) -> bytes:
        await asyncio.Event().wait()
        raise StopAsyncIteration

    def get_write_buffer_size(self) -> int:
        return 0

    def write(self, data: bytes) -> None:
        self.written.append(data)

    async def drain(self) -> None:
        """All is read at once."""


def test_a_fault_while_frames_are_made_ends_the_connection(monkeypatch: pytest.MonkeyPatch) -> None:
    """It may not leave a client that hears nothing any more."""
    clients: list[Client] = []
    monkeypatch.setattr(Client, "take", take_and_fail(clients))
    robot = Robot("http://localhost:1/", Access(), no_node)
    calls = ThreadPool(1, "test: calls")
    bridge = Bridge(robot, calls)

    async def serve() -> None:
        serving = asyncio.create_task(bridge.serve(Silent()))  # type: ignore[arg-type]  # it is used like one
        while not clients:
            await asyncio.sleep(0)
        await asyncio.sleep(0)
        clients[0].outbox.enqueue("a frame")
        await asyncio.wait_for(serving, 20)

    with pytest.raises(ZeroDivisionError):
        asyncio.run(serve())
    bridge.close()
    calls.shutdown(wait=True)


def take_and_fail(clients: list[Client]) -> Any:
    """Return a `Client.take` that has nothing at first, and then fails."""

    def take(client: Client, now: float) -> DueFrames:
        clients.append(client)
        if len(clients) > 1:
            raise ZeroDivisionError
        return DueFrames(iter(()), True, None)

    return take
