"""What is read ahead of a client that sends faster than its operations are done is bounded in bytes."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Iterator
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
        self.num_unread_bytes = 0
        self.leaves = asyncio.Event()
        self.was_drained = asyncio.Event()
        self.transport = self

    async def __anext__(self) -> bytes:
        await self.leaves.wait()
        raise StopAsyncIteration

    def get_write_buffer_size(self) -> int:
        return self.num_unread_bytes

    def write(self, data: bytes) -> None:
        self.written.append(data)

    async def drain(self) -> None:
        self.was_drained.set()


def test_a_fault_while_frames_are_made_ends_the_connection(monkeypatch: pytest.MonkeyPatch) -> None:
    """It may not leave a client that hears nothing any more, or lose frames silently."""
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
    """Return a `Client.take` that fails once, the second time; at other times it has nothing."""

    def take(client: Client, now: float) -> DueFrames:
        clients.append(client)
        if len(clients) == 2:
            raise ZeroDivisionError
        return DueFrames(iter(()), True, None)

    return take


def test_a_slow_client_is_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """What it has not read may not grow."""
    made: list[Client] = []
    take = Client.take

    def note(client: Client, now: float) -> DueFrames:
        made.append(client)
        return take(client, now)

    monkeypatch.setattr(Client, "take", note)
    robot = Robot("http://localhost:1/", Access(), no_node)
    calls = ThreadPool(1, "test: calls")
    bridge = Bridge(robot, calls)

    async def serve() -> list[bytes]:
        client = Silent()
        client.num_unread_bytes = 1
        serving = asyncio.create_task(bridge.serve(client))  # type: ignore[arg-type]  # it is used like one
        while not made:
            await asyncio.sleep(0)
        await asyncio.sleep(0)
        made[0].outbox.enqueue("a frame")
        await asyncio.wait_for(client.was_drained.wait(), 20)
        serving.cancel()
        await asyncio.gather(serving, return_exceptions=True)
        return client.written

    assert asyncio.run(serve()) == [b"\x81\x07a frame"]
    bridge.close()
    calls.shutdown(wait=True)


def test_a_client_that_leaves_while_its_frames_are_made(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its end may not be missed: the connection would be served for ever."""
    made: list[Client] = []
    is_making, may_end = threading.Event(), threading.Event()

    def make() -> Iterator[str]:
        is_making.set()
        assert may_end.wait(20)
        yield "a frame"

    def take(client: Client, now: float) -> DueFrames:
        made.append(client)
        return DueFrames(make(), False, None) if len(made) == 2 else DueFrames(iter(()), True, None)

    monkeypatch.setattr(Client, "take", take)
    robot = Robot("http://localhost:1/", Access(), no_node)
    calls = ThreadPool(1, "test: calls")
    bridge = Bridge(robot, calls)

    async def serve() -> None:
        client = Silent()
        serving = asyncio.create_task(bridge.serve(client))  # type: ignore[arg-type]  # it is used like one
        while not made:
            await asyncio.sleep(0)
        await asyncio.sleep(0)
        made[0].outbox.enqueue("a frame")
        await asyncio.to_thread(is_making.wait, 20)
        client.leaves.set()
        for _ in range(10):
            await asyncio.sleep(0)
        may_end.set()
        await asyncio.wait_for(serving, 20)

    asyncio.run(serve())
    bridge.close()
    calls.shutdown(wait=True)
