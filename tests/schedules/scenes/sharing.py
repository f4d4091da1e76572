"""Large messages in shared memory: threads that publish, readers that take, keep, give back, leave and are killed.

What a reader holds does not change in its hands; each thread's messages come in order and whole, all of them if the
queue has no bound; what a reader that is killed had is never written again; no block and no descriptor is left.
"""

from __future__ import annotations

import contextlib
import os
import struct
from typing import Any

from pyros1.msgs.std_msgs.msg import UInt8MultiArray
from pyros1.node.publishing import block_pool as pools
from pyros1.node.publishing import shared_link
from pyros1.node.publishing.publication import Publication
from pyros1.node.subscribing.queues import Batch
from pyros1.node.subscribing.shared_source import SharedSource
from pyros1.wire.handshake import Refusal, make_subscriber_header
from pyros1.wire.header import HeaderReader

from ..stage import Scenario, Stage
from ..unix_sockets import RecordSocket, UnixSocket, pair
from .parts import PUBLISHING, THREAD, check_orders, end_context, make_context, make_publication

THREADS, MESSAGES = 2, 4
LENGTH = 4100
"""Repetitions of a number in a message, whose array is so large that it is sent in pieces."""
_AT = struct.Struct("<I").unpack_from


def array_of(number: int) -> bytes:
    """Return an array that says a number again and again."""
    return struct.pack("<I", number) * LENGTH


class Reader:
    """A program that subscribes, and takes messages in a thread.

    Args:
        keeps: how many messages it has in its hands.
        most: messages after which it ends; None: it reads to the end.
        killed: whether the system ends it then, rather than itself.
    """

    def __init__(self, stage: Stage, keeps: int, most: int | None = None, killed: bool = False) -> None:
        self.near, self._far = pair(stage.network, UnixSocket)
        self.numbers: list[int] = []
        self._stage = stage
        self._keeps = keeps
        self._most = most
        self._killed = killed

    def link(self, publication: Publication) -> None:
        """Become a subscriber. From any thread."""
        publication.context.loop.call_soon(self._accept, publication)

    def _accept(self, publication: Publication) -> None:
        near: Any = self.near
        try:
            publication.accept(near, make_subscriber_header("/reader", "/t", publication.type, False))
        except Refusal:
            near.close()

    def read(self) -> None:
        """Take messages. In a thread."""
        reader, far = HeaderReader(), self._far
        header: dict[str, str] | None = None
        desk: RecordSocket | None = None
        while header is None:
            data = far.recv(4096)
            if far.handed:
                ((found),) = far.handed.popleft()
                assert isinstance(found, RecordSocket)
                desk = found
            if not data:  # the publisher ended before
                far.close()
                return
            header = reader.feed(data)
        assert desk is not None, "the greeting came without a desk"
        parts: Any = (far, desk)
        source = SharedSource(parts[0], "http://talker/", header, reader.bytes_after_header, parts[1])
        try:
            self._take(source)
        finally:
            if self._killed:
                far.break_off()
            source.close()

    def _take(self, source: SharedSource) -> None:
        hands: list[tuple[int, Any]] = []
        batch: Batch | None = source.take_received(0)
        while batch is not None and (self._most is None or len(self.numbers) < self._most):
            hands += map(self._note, batch.newest(len(batch)))
            batch = None  # the memory of messages that nobody keeps may be reused
            while len(hands) > self._keeps:
                self._check(*hands.pop(0))
            try:
                batch = source.receive(wait=True)
            except BlockingIOError:
                batch = source.take_received(0)
                for held in hands:
                    self._check(*held)
                hands.clear()
                continue
            except ConnectionResetError:
                break
        for held in hands:
            self._check(*held)

    def _note(self, body: Any) -> tuple[int, Any]:
        array = body.array(in_place=True) if not isinstance(body, bytes) else body[-4 * LENGTH :]
        number = _AT(array)[0]
        self.numbers.append(number)
        return number, array

    def _check(self, number: int, array: Any) -> None:
        self._stage.scheduler.point()
        assert bytes(array) == array_of(number), f"message {number} has changed in the reader's hands"


class Sharing(Scenario):
    """One reader from the beginning, one that comes later, one that is killed with messages in its hands."""

    modules = (
        *PUBLISHING,
        "pyros1.node.publishing.shared_link",
        "pyros1.node.publishing.block_pool",
        "pyros1.node.subscribing.shared_source",
    )
    limits = (
        ("pyros1.node.strand", "MAX_JOBS_PER_TURN", 2),
        ("pyros1.node.publishing.publication", "MIN_SHARED_SIZE", 64),
        ("pyros1.node.publishing.shared_link", "MAX_REFERENCES", 2),
        ("pyros1.node.publishing.block_pool", "MAX_FREE_BLOCKS", 1),
        ("pyros1.node.publishing.block_pool", "MAX_BLOCKS", 5),
    )
    room = 4000
    queue_size: int | None = 0

    def play(self, stage: Stage) -> None:
        """Play it."""
        before = _open_files()
        context = make_context(stage, "/talker")
        publication = make_publication(context, self.queue_size, message_class=UInt8MultiArray)
        first, late, killed = Reader(stage, 3), Reader(stage, 0), Reader(stage, 2, most=2, killed=True)
        readers = stage.spawn(first.read, late.read, killed.read)
        first.link(publication)
        stage.until(lambda: publication.links)

        def publisher(thread: int) -> Any:
            def publish() -> None:
                for number in range(MESSAGES):
                    publication.publish(UInt8MultiArray(data=array_of(THREAD * thread + number)))

            return publish

        def join() -> None:
            killed.link(publication)
            late.link(publication)

        counted: Any = publication.links[0]
        stage.together(join, *(publisher(thread) for thread in range(THREADS)))
        stage.until(lambda: not publication.strand.jobs and publication.strand.free)
        context.loop.run(lambda: None)
        publication.close(stage.time.monotonic() + 500.0)
        for reader in readers:
            reader.join()
        stage.until(lambda: not publication.links and publication.strand.free == [True] and not publication.strand.jobs)
        end_context(context)
        self.check(first, late, killed, counted)
        assert _open_files() == before, "a block is left"

    def check(self, first: Reader, late: Reader, killed: Reader, link: shared_link.SharedLink) -> None:
        """Check what the readers got."""
        gaps = bool(self.queue_size)
        for reader in (first, late):
            check_orders(reader.numbers, MESSAGES, gaps, tail=not gaps)
        check_orders(killed.numbers, gaps=gaps)
        assert len(first.numbers) + link.dropped == THREADS * MESSAGES, f"{first.numbers}, {link.dropped} dropped"
        assert gaps or not link.dropped
        assert not link.outstanding, "references are out of which nobody knows"


class SharingDropping(Sharing):
    """The same with short queues."""

    queue_size = 1


class SharingWaiting(Sharing):
    """The same with publishers that wait."""

    queue_size = None


def _open_files() -> int:
    found = 0
    with contextlib.suppress(FileNotFoundError):
        for name in os.listdir("/proc/self/fd"):
            with contextlib.suppress(OSError):
                found += "memfd:pyros1" in os.readlink(f"/proc/self/fd/{name}")
    return found


assert pools.MAX_BLOCKS  # loaded here, so that the stand-ins are put into it
