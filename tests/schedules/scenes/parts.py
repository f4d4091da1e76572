"""What the scenes share: a node's context without the node, readers and writers at the other ends of its links."""

from __future__ import annotations

import struct
from typing import Any

from pyros1.msgs.std_msgs.msg import UInt64
from pyros1.net.loop import Loop
from pyros1.net.rpc_caller import RpcCaller
from pyros1.net.signal_safe import Event
from pyros1.node.callback_queue import CallbackQueue
from pyros1.node.context import Context
from pyros1.node.publishing.publication import Publication
from pyros1.node.subscribing.hints import Hints
from pyros1.node.subscribing.subscription import Subscription
from pyros1.node.topic_type import topic_type
from pyros1.wire.handshake import Refusal, make_subscriber_header

from ..network import Socket
from ..stage import Stage

THREAD = 1000
"""Message numbers are this times the number of the thread, and the number in that thread, from 0."""
DATA = "pyros1.net.loop", "pyros1.net.signal_safe", "pyros1.node.strand", "pyros1.wire.outqueue"
PUBLISHING = (
    *DATA,
    "pyros1.node.publishing.publication",
    "pyros1.node.publishing.publisher_links",
    "pyros1.node.publishing.tcp_link",
)
SUBSCRIBING = tuple(
    f"pyros1.node.subscribing.{name}"
    for name in (
        "delivery_loop",
        "dispatcher",
        "queues",
        "subscription",
        "tcp_source",
        "threads",
    )
)


class Log:
    """A node's log; an error of pyros1 itself ends the run."""

    def __init__(self, stage: Stage) -> None:
        self._stage = stage

    def info(self, text: object, *args: object) -> None:
        """Note a line."""
        self._stage.told.append(str(text) % args if args else str(text))

    debug = warn = error = info

    def peer_event(self, _level: int, text: str, *args: object, max_texts: int = 0) -> None:
        """Note a line."""
        self.info(text, *args)

    def exception(self, text: object, *args: object, error: BaseException | None = None) -> None:
        """End the run."""
        self._stage.scheduler.fail(error or AssertionError(str(text) % args))


def make_context(stage: Stage, name: str, spin: bool = False) -> Context:
    """Return the context of a node, with its loop."""
    loop = Loop(f"{name}:loop", on_error=stage.scheduler.fail)
    log: Any = Log(stage)
    context = Context(name, loop, RpcCaller(loop), log, CallbackQueue() if spin else None, {}, stopping=Event())
    loop.thread.owner = context
    context.uri = f"http://localhost:{name}/"
    loop.start()
    return context


def end_context(context: Context) -> None:
    """End the threads of a context."""
    context.close_delivery_threads(5.0)
    context.loop.run(lambda: None)
    context.loop.stop()


def make_publication(
    context: Context, queue_size: int | None, latch: bool = False, message_class: Any = UInt64
) -> Publication:
    """Return the publication of a topic."""
    publication = Publication(context, "/t", message_class, topic_type(message_class), queue_size, latch, {})
    context.publications = {"/t": publication}
    return publication


def make_subscription(context: Context, message_class: Any = UInt64) -> Subscription:
    """Return the subscription of a topic."""
    return Subscription(context, "/t", message_class, Hints())


class Reader:
    """The other end of a publisher's link: reads all until the end.

    Args:
        pause: seconds between two reads.
        most: bytes after which it breaks the connection off; None: it reads to the end.
    """

    def __init__(
        self, stage: Stage, pause: float = 0.0, most: int | None = None, size: int = 64, name: str = "/reader"
    ) -> None:
        self.near, self._far = stage.network.pair()
        self.data = b""
        self._stage = stage
        self._pause = pause
        self._most = most
        self._size = size
        self._name = name

    def link(self, publication: Publication) -> None:
        """Become a subscriber. From any thread."""
        publication.context.loop.call_soon(self._accept, publication)

    def _accept(self, publication: Publication) -> None:
        """Do what a node's server does with a connection. On the loop."""
        near: Any = self.near
        try:
            publication.accept(near, make_subscriber_header(self._name, "/t", publication.type, False))
        except Refusal:
            near.close()

    def read(self) -> None:
        """Read all. In a thread."""
        while self._most is None or len(self.data) < self._most:
            if self._pause:
                self._stage.time.sleep(self._pause)
            data = self._far.recv(self._size)
            if not data:
                self._far.close()
                return
            self.data += data
        self._far.break_off()
        self._far.close()

    def numbers(self, begin: int = 0, whole: bool = True) -> list[int]:
        """Return the numbers of the messages that came.

        Args:
            begin: where a number begins in a message.
            whole: whether there must be nothing behind the last one.
        """
        frames: list[bytes] = []
        position = 0
        while position + 4 <= len(self.data):
            size = struct.unpack_from("<I", self.data, position)[0]
            if position + 4 + size > len(self.data):
                break
            frames.append(self.data[position + 4 : position + 4 + size])
            position += 4 + size
        assert not whole or position == len(self.data), "a torn frame at the end"
        return [int.from_bytes(frame[begin : begin + 8], "little") for frame in frames[1:]]


def write_frames(sock: Socket, thread: int, count: int) -> None:
    """Write messages to a subscriber, and close. In a thread."""
    for number in range(count):
        sock.sendall(struct.pack("<IQ", 8, THREAD * thread + number))
    sock.close()


def check_orders(numbers: list[int], count: int | None = None, gaps: bool = False, tail: bool = True) -> None:
    """Check that the messages of each thread are in order.

    Args:
        count: messages of each thread; None: not known.
        gaps: whether some may be missing in between.
        tail: whether the last of each thread must be there, if ``count`` is known.
    """
    for thread in {number // THREAD for number in numbers}:
        came = [number % THREAD for number in numbers if number // THREAD == thread]
        assert came == sorted(set(came)), f"of thread {thread}: {came}"
        assert gaps or came == list(range(came[0], came[0] + len(came))), f"of thread {thread}: {came}"
        assert count is None or not tail or came[-1] == count - 1, f"of thread {thread} only {came}"
