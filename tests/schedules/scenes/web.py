"""A rosbridge client, and a viewer: messages of two topics arrive in threads, which send them or leave it to the loop.

All frames are whole, each topic's messages are in order, and nothing follows the end. Which of them sends is also
tested alone, in tests/web/server/test_turns.py: a topic's order does not depend on it as long as one thread brings it.
"""

from __future__ import annotations

import struct
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import Any

import cbor2
from websockets.protocol import State

from pyros1.msgs import AnyMsg
from pyros1.observe.decoder import Decoder
from pyros1.web.foxglove import frames
from pyros1.web.foxglove.outbox import Outbox, QueuedMessage
from pyros1.web.hub import Arrival
from pyros1.web.rosbridge.client import Client
from pyros1.web.server.sending import keeps_up, send_now, shared_transport, write_frames
from pyros1.web.server.shared_transport import SharedTransport

from ..stage import Scenario, Stage

TOPICS, MESSAGES = ("/a", "/b"), 4
PING, CLOSE = b"\x89\x00", b"\x88\x00"
STATUS = '{"op":"status"}'


class Socket:
    """A socket that accepts as much as there is room. Each send takes a moment; two at the same time are an error."""

    def __init__(self, stage: Stage, room: int) -> None:
        self._stage = stage
        self.room = room
        self.received = bytearray()
        self.is_open = True
        self._is_sending = False

    def dup(self) -> Socket:
        """The same connection."""
        return self

    def sendmsg(self, pieces: Any) -> int:
        """Send pieces."""
        return self.send(b"".join(pieces))

    def send(self, data: Any) -> int:
        """Send a part, perhaps."""
        assert not self._is_sending, "two threads send at the same time"
        assert self.is_open, "a thread sends after the end"
        self._is_sending = True
        self._stage.scheduler.point()
        accepted = bytes(data[: self.room])
        self.room -= len(accepted)
        self.received += accepted
        self._stage.scheduler.point()
        self._is_sending = False
        if data and not accepted:
            raise BlockingIOError
        return len(accepted)

    def close(self) -> None:
        """End."""
        assert not self._is_sending, "closed while a thread sends"
        self.is_open = False


class Loop:
    """An event loop with its transport, as asyncio's: it sends at once what it can, and buffers the rest."""

    def __init__(self, socket: Socket) -> None:
        self.socket = socket
        self.calls: deque[Callable[[], object]] = deque()
        self.buffer = b""
        self.is_lost = False

    def call_soon_threadsafe(self, function: Callable[..., object], *args: object) -> None:
        """Call later."""
        self.calls.append(lambda: function(*args))

    def get_extra_info(self, name: str, default: Any = None) -> Any:
        """The socket."""
        return self.socket if name == "socket" else default

    def is_closing(self) -> bool:
        """It is not."""
        return False

    def get_write_buffer_size(self) -> int:
        """As of a transport."""
        return len(self.buffer)

    def write(self, data: Any) -> None:
        """As of a transport."""
        if self.is_lost:
            return
        self.buffer += data
        if len(self.buffer) == len(data):
            self.flush()

    def flush(self) -> None:
        """Send what is buffered, as far as there is room."""
        if self.buffer and self.socket.room:
            self.buffer = self.buffer[self.socket.send(self.buffer) :]

    def abort(self) -> None:
        """As of a transport."""
        self.buffer = b""


class Link:
    """What the client's driver needs of a connection."""

    def __init__(self, loop: Loop) -> None:
        self.state = State.OPEN
        self.transport = SharedTransport(loop, loop, lambda: self.state is State.OPEN)  # type: ignore[arg-type]


class Robot:
    """A robot with topics whose messages a test brings."""

    def __init__(self) -> None:
        self.listeners: dict[str, Callable[[Arrival], object]] = {}

    def full_name(self, name: str) -> str:
        """It is full."""
        return name

    def check_visible(self, name: str) -> None:
        """It is."""

    def listen(self, topic: str, listener: Callable[[Arrival], object], done: Callable[[], object]) -> Any:
        """Keep the listener."""
        self.listeners[topic] = listener
        done()
        return lambda: None


class Sending(Scenario):
    """The client reads all the time, more or less; the loop sends pings and a response in between."""

    modules = (
        "pyros1.web.rosbridge.outbox",
        "pyros1.web.rosbridge.client",
        "pyros1.web.server.turns",
        "pyros1.web.server.sending",
        "pyros1.web.server.shared_transport",
    )
    buffer = 1_000
    reads = 1_000
    """Bytes that the client reads at a time."""
    closes = loses = False

    def play(self, stage: Stage) -> None:
        """Play it."""
        socket, robot = Socket(stage, self.buffer), Robot()
        faults: list[Exception] = []
        loop = Loop(socket)
        link = Link(loop)
        transport = shared_transport(link)
        assert transport is not None
        client = Client(
            robot,  # type: ignore[arg-type]  # it is used like one
            lambda function: function(),
            lambda: loop.calls.append(wake),
            send_now=lambda frames: send_now(transport, frames),
            on_fault=faults.append,
        )
        for topic in TOPICS:
            client.handle([f'{{"op":"subscribe","topic":"{topic}","compression":"cbor-raw"}}'])

        def wake() -> None:  # as the driver
            if link.state is not State.OPEN:
                return
            due = client.take(stage.time.monotonic())
            write_frames(link, due.frames)  # type: ignore[arg-type]  # it is used like a connection
            if due.next_time is not None:
                loop.calls.append(wake)
            elif keeps_up(link):  # type: ignore[arg-type]
                client.outbox.release()

        def bring(topic: str) -> None:
            decoder = Decoder()
            for number in range(MESSAGES):
                robot.listeners[topic](Arrival(AnyMsg(bytes((number,)) * 30), 0.0, float(number), decoder))

        def close() -> None:
            link.state = State.CLOSING
            transport.write(CLOSE)

        def lose() -> None:
            link.state = State.CLOSED
            transport.lose()
            loop.is_lost, loop.buffer = True, b""

        def read() -> None:
            while not ended:
                socket.room = min(self.buffer, socket.room + self.reads)
                stage.time.sleep(0.0003)

        def run_loop() -> None:
            loop.calls.append(wake)
            plan = [lambda: transport.write(PING), lambda: client.outbox.enqueue(STATUS), lambda: transport.write(PING)]
            plan += [close] if self.closes else [lose] if self.loses else []
            while any(each.is_alive() for each in threads) or plan or loop.calls or loop.buffer:
                stage.scheduler.point()
                loop.flush()
                if loop.calls:
                    loop.calls.popleft()()
                if plan:
                    plan.pop(0)()
                elif not loop.calls:
                    stage.time.sleep(0.001)
            ended.append(True)

        ended: list[bool] = []
        threads = stage.spawn(*(partial(bring, topic) for topic in TOPICS))
        reader = stage.spawn(read)
        run_loop()
        reader[0].join()
        assert not faults, faults
        self.check(bytes(socket.received))

    def check(self, stream: bytes) -> None:
        """Check what the client has received."""
        found: dict[str, list[int]] = {topic: [] for topic in TOPICS}
        others: list[bytes] = []
        while stream:
            first, size = stream[0], stream[1] if len(stream) > 1 else 0
            start = 4 if size == 126 else 2
            size = int.from_bytes(stream[2:4], "big") if size == 126 else size
            payload, complete = stream[start : start + size], len(stream) >= start + size
            assert complete or self.loses, "a frame is cut off"
            assert first in (0x81, 0x82, PING[0], CLOSE[0]), "a frame is torn"
            assert others[-1:] != [CLOSE], "something follows the end"
            if first == 0x82 and complete:
                value = cbor2.loads(payload)
                assert len({*value["msg"]["bytes"]}) == 1
                found[value["topic"]].append(value["msg"]["bytes"][0])
            else:
                others.append(stream[:2] if first in (PING[0], CLOSE[0]) else payload)
            stream = stream[start + size :]
        for numbers in found.values():
            assert numbers == sorted({*numbers}), f"out of order, or twice: {numbers}"
        if not self.closes and not self.loses:
            assert all(numbers == list(range(MESSAGES)) for numbers in found.values()), f"lost: {found}"
            assert sorted(others) == sorted([PING, STATUS.encode(), PING])


class SendingSlowly(Sending):
    """The client reads slowly: frames are accepted in parts."""

    buffer, reads = 50, 7


class SendingUntilClosed(SendingSlowly):
    """The loop closes the connection in the meantime."""

    closes = True


class SendingUntilLost(SendingSlowly):
    """The connection breaks in the meantime."""

    loses = True


class Unsubscribing(Scenario):
    """A viewer's subscription is ended by a thread, and the loop then tells the viewer: no message may follow."""

    modules = (
        "pyros1.web.foxglove.outbox",
        "pyros1.web.server.turns",
        "pyros1.web.server.sending",
        "pyros1.web.server.shared_transport",
    )
    buffer, reads = 100, 20

    def play(self, stage: Stage) -> None:
        """Play it."""
        socket = Socket(stage, self.buffer)
        loop = Loop(socket)
        link = Link(loop)
        transport = shared_transport(link)
        assert transport is not None
        outbox = Outbox(wake=lambda: loop.calls.append(wake))
        ended, kept = outbox.open(), outbox.open()

        def frame(message: QueuedMessage) -> Any:
            return frames.message(message.ticket, message.time, message.payload)

        def wake() -> None:  # as the viewer's task
            while messages := outbox.take(1):
                write_frames(link, map(frame, messages))  # type: ignore[arg-type]  # it is used like a connection
            if keeps_up(link):  # type: ignore[arg-type]
                outbox.release()

        def bring(ticket: int) -> None:
            for number in range(MESSAGES):
                message = QueuedMessage(ticket, number, bytes(20), None, float(number))
                if outbox.put(message, outbox.is_free):
                    is_sent = send_now(transport, (frame(message),))
                    outbox.end_sending(None if is_sent else message)

        def end() -> None:
            outbox.close(ended)
            loop.calls.append(lambda: write_frames(link, (STATUS,)))  # type: ignore[arg-type]

        loop.calls.append(wake)
        threads = stage.spawn(partial(bring, ended), partial(bring, kept), end)
        while any(each.is_alive() for each in threads) or loop.calls or loop.buffer:
            stage.scheduler.point()
            socket.room = min(self.buffer, socket.room + self.reads)
            loop.flush()
            if loop.calls:
                loop.calls.popleft()()
            else:
                stage.time.sleep(0.001)
        self.check(bytes(socket.received), ended, kept)

    def check(self, stream: bytes, ended: int, kept: int) -> None:
        """Check what the viewer has received."""
        found: dict[int, list[int]] = {ended: [], kept: []}
        is_told = False
        while stream:
            payload, stream = stream[2 : 2 + stream[1]], stream[2 + stream[1] :]
            if payload == STATUS.encode():
                is_told = True
                continue
            _, ticket, number = struct.unpack_from("<BIQ", payload)
            assert ticket == kept or not is_told, "a message follows the end of its subscription"
            found[ticket].append(number)
        assert is_told
        assert found[kept] == list(range(MESSAGES)), f"lost, or out of order: {found}"
        assert found[ended] == list(range(len(found[ended]))), f"lost, or out of order: {found}"
