"""The publication of a topic: its links, its latched message, and the order in which messages leave.

https://wiki.ros.org/rospy/Overview/Publishers%20and%20Subscribers
"""

from __future__ import annotations

import itertools
import secrets
import socket
import struct
import time
from collections.abc import Callable, Mapping
from threading import get_ident
from time import perf_counter
from typing import TYPE_CHECKING, Any, Protocol

from pyros1.ground.errors import SerializationError
from pyros1.net.keepalive import keep_alive
from pyros1.node.lane import Lane
from pyros1.node.publishing.local_link import LocalLink
from pyros1.node.publishing.tcp_link import TcpLink, WaitingLink
from pyros1.wire.handshake import Refusal, TopicType, answer_subscriber, is_true
from pyros1.wire.header import encode_header
from pyros1.wire.local import TOKEN_SIZE
from pyros1.wire.outqueue import Buffer, Frame, frame_size, keepable

if TYPE_CHECKING:
    from pyros1.node.context import Context
    from pyros1.node.publishing.pool import Pool
    from pyros1.node.publishing.shared_link import SharedLink
    from pyros1.node.publishing.udp_link import UdpLink
    from pyros1.node.subscribing.sources import Receiver

_LENGTH = 4
_U32 = struct.Struct("<I")
SHARED = 1 << 16
"""Bytes from which a message is shared with subscribers of this machine; smaller ones are as fast through a socket."""
FAREWELL = 1.0
"""Seconds that subscribers have to take the last messages of a publisher that ends."""
MOST_LINKS = 1024
PAUSE = 0.0001
LONGEST_TURN = 1.0
"""Most seconds that a publisher without a queue waits for the lane, whose worker a signal handler may delay."""


class Link(Protocol):
    """The part of a link that a publication needs. `start`, `send` and `recover` are called in the topic's lane."""

    peer: str
    messages: int
    bytes_sent: int
    transport: str
    address: str

    @property
    def dropped(self) -> int: ...
    @property
    def waiting(self) -> int: ...
    @property
    def connected(self) -> bool: ...
    def start(self) -> None: ...
    def send(self, frame: Frame) -> None: ...
    def recover(self) -> None: ...
    def wait(self) -> None: ...
    def close(self) -> None: ...
    def finish(self, until: float) -> None: ...


class Publication:
    """A topic that a node publishes, and its links.

    Args:
        context: the node.
        topic: full name.
        message_class: class of the messages; with AnyMsg, ``type_`` gives their real type.
        type_: type name, md5 sum and definition that are sent to subscribers.
        queue_size: most waiting messages per slow subscriber; 0: no limit; None: publishing waits for subscribers.
        latch: keep the last message and give it to every new subscriber.
        headers: more fields of the connection header.
    """

    def __init__(
        self,
        context: Context,
        topic: str,
        message_class: type[Any],
        type_: TopicType,
        queue_size: int | None,
        latch: bool,
        headers: Mapping[str, str],
    ) -> None:
        self.context = context
        self.topic = topic
        self.message_class = message_class
        # Codecs are made when they are first used: here, not in a signal handler in the middle of an import.
        message_class()
        self._encode = message_class._encode_frame
        self.type = type_
        self.queue_size = queue_size
        self.latch = latch
        self.headers = dict(headers)
        self.links: tuple[Link, ...] = ()
        self._remote: tuple[Link, ...] = ()  # the links that take frames
        self._local: tuple[LocalLink, ...] = ()  # the links that take messages
        self._shared: tuple[SharedLink, ...] = ()  # those of `_remote` that share memory
        self._pool: Pool | None = None
        self.handles = 0
        self.on_change: list[Callable[[], None]] = []
        self._connections = itertools.count(1)  # over UDP
        self._seq = itertools.count(1)  # from 1, as rospy (T22)
        self._latched: dict[object, Frame] = {}  # by source: each has its own, as in roscpp
        # It guards numbers, latched message and links, so that all of them see one order of messages.
        self.lane = Lane(context.loop.call_soon, self._recover)
        self._closed = False
        self.publish: Callable[[Any], None] = self._publish_numbered if message_class._has_header else self._publish
        """Send a message to all links; see Publisher.publish."""

    # The lane is entered here and not by `Lane.do`, since every message comes this way.

    def _publish(self, message: Any) -> None:  # noqa: PLR0912 - a call costs as much as ten lines
        if not (self.links or self.latch):
            return
        me, lane = get_ident(), self.lane
        if not lane.free:
            lane.linger()
        try:
            del lane.free[0]
        except IndexError:
            lane.leave(self._send, *_safe(*self._prepare(message)))
        else:
            # Encoded in the lane, so that messages of a signal handler come after this one: a robot that the handler
            # stops must not be set going again by this message.
            lane.worker = me
            try:
                if lane.jobs and not lane.catch_up():  # some of them may be this thread's: this one comes after them
                    lane.jobs.append((self._send, _safe(*self._prepare(message))))
                elif self._local or self.latch or message.__class__ is not self.message_class:
                    self._send(*self._prepare(message))
                else:
                    try:
                        frame = self._encode(message)
                    except SerializationError as error:
                        raise self._named(error) from None
                    if self._shared:
                        self._send_frame(frame)
                    else:
                        for link in self._remote:
                            link.send(frame)
            except BaseException:
                self._recover()
                raise
            finally:
                lane.free.append(True)
                if lane.jobs:
                    lane.work()
        if self.queue_size is None:
            self._wait()

    def _publish_numbered(self, message: Any) -> None:
        if not (self.links or self.latch):
            return
        me, lane = get_ident(), self.lane
        if not lane.free:
            lane.linger()
        try:
            del lane.free[0]
        except IndexError:
            lane.leave(self._send_numbered, message, *_safe(*self._prepare(message)))
        else:
            lane.worker = me
            try:
                if lane.jobs and not lane.catch_up():  # some of them may be this thread's: this one comes after them
                    lane.jobs.append((self._send_numbered, (message, *_safe(*self._prepare(message)))))
                else:
                    message.header.seq = next(self._seq)
                    self._send(*self._prepare(message))
            except BaseException:
                self._recover()
                raise
            finally:
                lane.free.append(True)
                if lane.jobs:
                    lane.work()
        if self.queue_size is None:
            self._wait()

    def _prepare(self, message: Any) -> tuple[Frame | None, Any]:
        """Return a message in the forms that the links need: its frame, its copy, or both."""
        cls = message.__class__
        try:
            copy = cls._copy(message) if self._local and not self.latch else None
            if copy is not None and not self._remote:
                return None, copy
            return self._encode(message) if cls is self.message_class else cls._encode_frame(message), copy
        except SerializationError as error:
            raise self._named(error) from None

    def _named(self, error: SerializationError) -> SerializationError:
        return SerializationError(f"{self.topic}: {error}")

    def _send(self, frame: Frame | None, copy: Any, source: object = None) -> None:
        """Give a message to all links and keep it, if latched. In the lane.

        New links may have come since it was prepared.
        """
        if frame is None and (self._remote or self.latch):
            frame = copy.__class__._encode_frame(copy)
        if frame is not None:
            if self.latch:
                self._latched[source] = frame if isinstance(frame, bytes) else b"".join(frame)
            self._send_frame(frame)
        for taker in self._local:
            if copy is not None:
                taker.hand_over(copy)
            elif frame is not None:
                taker.send(frame)

    def _send_frame(self, frame: Frame) -> None:
        """Give an encoded message to all links; a large one is written once for those that share memory."""
        place = None
        if self._shared and self._pool is not None and frame_size(frame) > SHARED:
            for shared in self._shared:
                shared.take_back()
            place = self._pool.place(frame, {block for shared in self._shared for block in shared.out.values()})
        if place is None:
            for link in self._remote:
                link.send(frame)
            return
        for link in self._remote:
            if link not in self._shared or not link.refer(place):
                link.send(frame)

    def _send_numbered(self, message: Any, frame: Frame | None, copy: Any) -> None:
        """Send a message that was left in the lane, with the number of its turn."""
        message.header.seq = number = next(self._seq)
        if copy is not None:
            copy.header.seq = number
        if frame is not None:
            frame = _numbered(frame, number)
        self._send(frame, copy)

    def _recover(self) -> None:
        """Let all links recover after a signal handler has raised in the middle of a job."""
        for link in self.links:
            link.recover()

    def _wait(self) -> None:
        """Wait until all links have sent the published messages, as rospy does without a queue size."""
        lane, until = self.lane, perf_counter() + LONGEST_TURN
        while lane.jobs and perf_counter() < until:  # this thread's message may be among them
            if lane.mine:
                return  # in a signal handler: the interrupted function goes on afterwards
            lane.work()
            if not lane.free:
                time.sleep(PAUSE)
        if not lane.mine:
            for link in self.links:
                link.wait()

    def _publish_to_nobody(self, message: Any) -> None:
        """Log that the node has ended. As in rospy, this is not an error: a loop may have called `ok` just before.

        It is logged once, unless a signal has ended the node.
        """
        context = self.context
        if context.tells_late_publishers:
            context.tells_late_publishers = False
            context.log.warn("publish() on %s after the end of its node: the message is lost", self.topic)

    def publish_body(self, body: bytes, source: object = None) -> None:
        """Send an already encoded message.

        Args:
            body: its bytes.
            source: for a latched topic, the source of the message. Later subscribers get the last one of each source.
        """
        if self.links or self.latch:
            self.lane.do(self._send, len(body).to_bytes(_LENGTH, "little") + body, None, source)
            if self.queue_size is None:
                self._wait()

    def publish_to(self, link: Link, message: Any) -> None:
        """Send a message to one link; see ``Peer.publish``."""
        if self.message_class._has_header:
            message.header.seq = next(self._seq)
        try:
            frame = message.__class__._encode_frame(message)
        except SerializationError as error:
            raise self._named(error) from None
        self.lane.do(link.send, keepable(frame))

    def forget(self, source: object) -> None:
        """Forget a source's latched message."""
        self.lane.do(self._latched.pop, source, None)

    def accept(self, sock: socket.socket, header: dict[str, str]) -> None:
        """Answer a subscriber's header and link it. On the loop.

        Raises:
            Refusal: the subscriber wants another type.
        """
        answer = self._answer(header)
        self._check_room()
        if sock.family == getattr(socket, "AF_UNIX", None):
            self._share(sock, header, answer)
            return
        keep_alive(sock)
        if is_true(header.get("tcp_nodelay")):
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        greeting = encode_header(answer)
        link_class: Any = WaitingLink if self.queue_size is None else TcpLink
        link = link_class(self.context.loop, self.lane, sock, header, greeting, self.queue_size, self._remove)
        self.lane.do(self._add, link)

    def _share(self, sock: socket.socket, header: dict[str, str], answer: dict[str, str]) -> None:
        """Link a subscriber of this machine that shares memory with this process. On the loop."""
        from pyros1.node.publishing import shared_link  # noqa: PLC0415 - needs modules that only Linux has
        from pyros1.node.publishing.pool import Pool  # noqa: PLC0415

        if self._pool is None:
            self._pool = Pool()
        kind = shared_link.WaitingSharedLink if self.queue_size is None else shared_link.SharedLink
        loop, token = self.context.loop, secrets.token_bytes(TOKEN_SIZE)
        link = kind(loop, self.lane, sock, header, answer, self.queue_size, self._remove, self._pool, token)
        self.lane.do(self._add, link)

    def accept_datagrams(self, header: dict[str, str], place: tuple[str, int], size: int) -> UdpLink:
        """Link a subscriber that wants datagrams. On the loop.

        Args:
            header: the subscriber's connection header.
            place: the subscriber's host and port.
            size: bytes of the largest datagram.

        Raises:
            Refusal: the subscriber wants another type, or cannot be reached.
        """
        from pyros1.node.publishing.udp_link import UdpLink  # noqa: PLC0415 - few nodes need it

        answer = self._answer(header)
        self._check_room()
        number = next(self._connections)
        link = UdpLink(self.context.loop, self.lane, header, answer, place, size, number, self._remove)
        if not link.connected:
            raise Refusal(f"cannot send datagrams to {place[0]}:{place[1]}")
        self.lane.do(self._add, link)
        return link

    def connect_local(
        self, receiver: Receiver, uri: str, header: dict[str, str], on_closed: Callable[[LocalLink], None]
    ) -> LocalLink:
        """Link a subscription of the same process, without a socket.

        Args:
            receiver: takes the messages.
            uri: URI of this node's slave API.
            header: the connection header that the subscriber would send.
            on_closed: called when the link has ended.

        Raises:
            Refusal: the subscription wants another type.
        """
        try:
            answer = self._answer(header)
        except Refusal as refusal:  # over TCP the server logs it
            self.context.log.warn("refused a connection of %s for %s: %s", header["callerid"], self.topic, refusal)
            raise
        _ = self.message_class._copy  # as in __init__
        link = LocalLink(self.lane, receiver, uri, header, answer, self.queue_size, self._remove, on_closed)
        self.lane.do(self._add, link)
        return link

    def _check_room(self) -> None:
        if len(self.links) >= MOST_LINKS:
            raise Refusal(f"[{self.topic}] has {MOST_LINKS} subscribers already")

    def _answer(self, header: dict[str, str]) -> dict[str, str]:
        if self._closed:
            raise self._gone()
        return answer_subscriber(header, self.context.name, self.topic, self.type, self.latch, self.headers)

    def _add(self, link: Link) -> None:
        if self._closed:
            link.close()
            return
        self._set_links((*self.links, link))
        link.start()
        for frame in self._latched.values():
            link.send(frame)

    def _gone(self) -> Refusal:
        return Refusal(f"[{self.context.name}] is no longer a publisher of [{self.topic}]")

    def _remove(self, link: Link) -> None:
        self.lane.do(self._remove_now, link)

    def _remove_now(self, link: Link) -> None:
        self._set_links(tuple(other for other in self.links if other is not link))

    def _set_links(self, links: tuple[Link, ...]) -> None:
        self.links = links
        self._local = tuple(link for link in links if isinstance(link, LocalLink))
        self._remote = tuple(link for link in links if not isinstance(link, LocalLink))
        self._shared = tuple(link for link in self._remote if link.transport == "LOCAL")  # type: ignore[misc]  # SharedLinks
        if self.on_change:
            self.context.loop.call_soon(self._changed)  # code of other parts does not belong in the lane

    def _changed(self) -> None:
        for callback in tuple(self.on_change):
            callback()

    def close(self, until: float | None = None) -> None:
        """End all links; waiting messages are sent first, as far as subscribers take them in time.

        Args:
            until: the deadline, as `perf_counter` time; None: in FAREWELL seconds.
        """
        self.publish = self._publish_to_nobody
        if until is None:
            until = perf_counter() + FAREWELL
        self.lane.do(self._seal)
        while not (self._closed or self.lane.mine) and perf_counter() < until:
            time.sleep(PAUSE)  # the thread that works there does it
        if self._closed:
            self._finish(until)
        else:  # that thread is stuck, or interrupted by this call, which a signal handler makes
            self.lane.do(self._finish, until)

    def _seal(self) -> None:
        """Take no more links. In the lane, so those that come at the same time are there before, with a greeting."""
        self._closed = True
        self._latched.clear()

    def _finish(self, until: float) -> None:
        for link in self.links:
            link.finish(until)
        if self._pool is not None:
            self._pool.close()


def _safe(frame: Frame | None, copy: Any) -> tuple[Frame | None, Any]:
    """Return a message that may wait: without memory that its owner could change meanwhile."""
    return None if frame is None else keepable(frame), copy


def _numbered(frame: Frame, number: int) -> Frame:
    """Return the frame of a message whose first field is a Header with another sequence number."""
    rest: list[Buffer] = []
    first: Buffer = frame if isinstance(frame, bytes) else frame[0]
    if not isinstance(frame, bytes):
        rest = frame[1:]
    head = bytearray(first)
    _U32.pack_into(head, _LENGTH, number)
    return [bytes(head), *rest] if rest else bytes(head)
