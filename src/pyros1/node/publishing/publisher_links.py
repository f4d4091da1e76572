"""Manages the links of a publication to its subscribers: adds and removes them, and sends connection headers."""

from __future__ import annotations

import itertools
import os
import socket
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Protocol

from pyros1.net.keepalive import enable_keepalive
from pyros1.node.publishing.local_link import LocalLink
from pyros1.node.publishing.tcp_link import TcpLink, WaitingLink
from pyros1.node.strand import Strand
from pyros1.wire.handshake import Refusal, TopicType, is_true, make_publisher_response
from pyros1.wire.header import encode_header
from pyros1.wire.local import TOKEN_SIZE
from pyros1.wire.outqueue import Frame

if TYPE_CHECKING:
    from pyros1.node.context import Context
    from pyros1.node.publishing.block_pool import BlockPool
    from pyros1.node.publishing.shared_link import SharedLink
    from pyros1.node.publishing.udp_link import UdpLink
    from pyros1.node.subscribing.delivery_loop import DeliveryLoop

MAX_LINKS = 1024


class Link(Protocol):
    """A link to a subscriber. `start`, `send` and `recover` are called in the topic's strand."""

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
    def finish(self, deadline: float) -> None: ...


class PublisherLinks:
    """The part of a publication that manages its links.

    Args:
        context: the node's context.
        topic: the topic's full name.
        message_class: class of the messages; for AnyMsg, ``type_`` is their actual type.
        type_: the type name, md5 sum and definition to send to subscribers.
        queue_size: maximum number of messages queued per slow subscriber; 0 for no limit. None: `publish` waits for
            subscribers.
        latch: whether to keep the last message and send it to every new subscriber.
        headers: extra fields of the connection header.
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
        self.type = type_
        self.queue_size = queue_size
        self.latch = latch
        self.headers = dict(headers)
        self.links: tuple[Link, ...] = ()
        self._remote: tuple[Link, ...] = ()  # links that accept encoded messages
        self._local: tuple[LocalLink, ...] = ()  # links that accept message objects
        self._shared: tuple[SharedLink, ...] = ()  # those of `_remote` that share memory
        self._pool: BlockPool | None = None
        self.change_listeners: list[Callable[[], None]] = []
        self._connection_numbers = itertools.count(1)  # for UDP
        self._latched: dict[object, Frame] = {}  # the last message of each source, as in roscpp
        # Guards sequence numbers, latched messages and links, so that all links receive messages in the same order.
        self.strand = Strand(context.loop.call_soon, self._recover)
        self._closed = False

    def _recover(self) -> None:
        """Let all links recover after a signal handler has interrupted a job with an exception."""
        for link in self.links:
            link.recover()

    def accept(self, sock: socket.socket, header: dict[str, str]) -> None:
        """Respond to a subscriber's header and add a link. Called on the loop.

        Raises:
            Refusal: the subscriber expects another type, there are too many subscribers, or the publication is closed.
        """
        response = self._make_response(header)
        self._check_num_links()
        if sock.family == getattr(socket, "AF_UNIX", None):
            self._add_shared_link(sock, header, response)
            return
        enable_keepalive(sock)
        if is_true(header.get("tcp_nodelay")):
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        encoded_header = encode_header(response)
        link_class: Any = WaitingLink if self.queue_size is None else TcpLink
        link = link_class(self.context.loop, self.strand, sock, header, encoded_header, self.queue_size, self._remove)
        self.strand.do(self._add, link)

    def _add_shared_link(self, sock: socket.socket, header: dict[str, str], response: dict[str, str]) -> None:
        """Add a link to a subscriber on this machine that shares memory with this process. Called on the loop."""
        from pyros1.node.publishing import shared_link  # noqa: PLC0415 - needs modules that only Linux has
        from pyros1.node.publishing.block_pool import BlockPool  # noqa: PLC0415

        if self._pool is None:
            self._pool = BlockPool()
        link_class = shared_link.WaitingSharedLink if self.queue_size is None else shared_link.SharedLink
        loop, token = self.context.loop, os.urandom(TOKEN_SIZE)
        link = link_class(loop, self.strand, sock, header, response, self.queue_size, self._remove, self._pool, token)
        self.strand.do(self._add, link)

    def accept_datagrams(self, header: dict[str, str], peer_address: tuple[str, int], max_size: int) -> UdpLink:
        """Add a link to a subscriber that requests datagrams. Called on the loop.

        Args:
            header: the subscriber's connection header.
            peer_address: the subscriber's host and port.
            max_size: maximum size of a datagram in bytes.

        Raises:
            Refusal: the subscriber expects another type or cannot be reached, there are too many subscribers, or the
                publication is closed.
        """
        from pyros1.node.publishing.udp_link import UdpLink  # noqa: PLC0415 - few nodes need it

        response = self._make_response(header)
        self._check_num_links()
        connection_number = next(self._connection_numbers)
        link = UdpLink(
            self.context.loop, self.strand, header, response, peer_address, max_size, connection_number, self._remove
        )
        if not link.connected:
            raise Refusal(f"cannot send datagrams to {peer_address[0]}:{peer_address[1]}")
        self.strand.do(self._add, link)
        return link

    def connect_in_process(
        self, receiver: DeliveryLoop, uri: str, header: dict[str, str], on_closed: Callable[[LocalLink], None]
    ) -> LocalLink:
        """Add a link to a subscription in the same process, without a socket.

        Args:
            receiver: receives the messages.
            uri: URI of this node's slave API.
            header: the connection header that the subscriber would send.
            on_closed: called when the link is closed.

        Raises:
            Refusal: the subscription expects another type, or the publication is closed.
        """
        try:
            response = self._make_response(header)
        except Refusal as refusal:  # logged here, as `TcprosServer` does for TCP
            self.context.log.warn("refused a connection from %s for %s: %s", header["callerid"], self.topic, refusal)
            raise
        _ = self.message_class._copy  # creates the codec, as in `Publication.__init__`
        inbox_bytes = self.context.local_room
        link = LocalLink(
            self.strand, receiver, uri, header, response, self.queue_size, inbox_bytes, self._remove, on_closed
        )
        self.strand.do(self._add, link)
        return link

    def _check_num_links(self) -> None:
        if len(self.links) >= MAX_LINKS:
            raise Refusal(f"[{self.topic}] has {MAX_LINKS} subscribers already")

    def _make_response(self, header: dict[str, str]) -> dict[str, str]:
        if self._closed:
            raise self._make_closed_refusal()
        return make_publisher_response(header, self.context.name, self.topic, self.type, self.latch, self.headers)

    def _add(self, link: Link) -> None:
        if self._closed:
            link.close()
            return
        self._set_links((*self.links, link))
        link.start()
        for frame in self._latched.values():
            link.send(frame)

    def _make_closed_refusal(self) -> Refusal:
        return Refusal(f"[{self.context.name}] is no longer a publisher of [{self.topic}]")

    def _remove(self, link: Link) -> None:
        self.strand.do(self._remove_now, link)

    def _remove_now(self, link: Link) -> None:
        self._set_links(tuple(other for other in self.links if other is not link))
        if self._pool is not None and not self._shared:
            self._pool.close()  # the pool may be large, and nobody uses it

    def _set_links(self, links: tuple[Link, ...]) -> None:
        self.links = links
        self._local = tuple(link for link in links if isinstance(link, LocalLink))
        self._remote = tuple(link for link in links if not isinstance(link, LocalLink))
        self._shared = tuple(link for link in self._remote if link.transport == "LOCAL")  # type: ignore[misc]  # SharedLinks
        if self.change_listeners:
            self.context.loop.call_soon(self._on_links_changed)  # callbacks must not run in the strand

    def _on_links_changed(self) -> None:
        for callback in tuple(self.change_listeners):
            callback()
