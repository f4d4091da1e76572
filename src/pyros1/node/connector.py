"""A subscription's way to one publisher, on the loop: ask its node, connect, greet, hand the link to the reader.

States::

    asking ──────> connecting ──────> greeting ──────> linked
      ^  requestTopic      TCP connect       header         │ link lost
      └────────────── resting <─────────────────────────────┘
                         (waits, longer after each failure)

* *refused*: the publisher answered with an error, or its type is not ours. Asking again would get the same answer, so
  we rest until the master announces the publishers anew.
* *ended*: the master no longer lists the publisher: nothing new is tried. What is under way goes on: its node may have
  taken us already, for a publisher that is not announced yet. A link that is up stays until the publisher closes it, so
  that its last messages are not lost.

Every step has a deadline. A publisher that cannot be reached delays no other.
"""

from __future__ import annotations

import contextlib
import selectors
import socket
from typing import TYPE_CHECKING, Any

from pyros1.errors import ConnectionRefusedByPeerError, Error, ProtocolError, UnknownHostError
from pyros1.net.connect import connect
from pyros1.node.context import find_local_context
from pyros1.node.inlink import InLink
from pyros1.node.keepalive import keep_alive
from pyros1.node.log import ERROR, WARN
from pyros1.wire.handshake import Refusal, check_publisher_answer
from pyros1.wire.header import HeaderReader, encode_header

if TYPE_CHECKING:
    from pyros1.net.loop import TimerHandle
    from pyros1.node.datagrams import DatagramInLink
    from pyros1.node.subscription import Subscription

STEP_TIMEOUT = 10.0
SILENCE = 4.0
"""Seconds after which a publisher that does not answer is named in the log."""
FIRST_REST = 0.1
LONGEST_REST = 20.0


class Connector:
    """Keeps a subscription connected to one publisher. All methods run on the loop.

    Args:
        subscription: who wants the messages.
        uri: the publisher's slave API.
    """

    def __init__(self, subscription: Subscription, uri: str) -> None:
        self.uri = uri
        self.linked = False
        self._subscription = subscription
        self._context = subscription.context
        self._rest = FIRST_REST
        self._ended = False
        self._again = False  # announced anew while an attempt was under way, whose answer may be that of the old one
        self._told = ""  # why it refused us
        self._attempt = 0  # answers to older attempts are ignored
        self._under_way = False
        self._timer: TimerHandle | None = None
        self._silence: TimerHandle | None = None  # of the attempt that is under way
        self._named = False  # in the log, as one that does not answer
        self._sock: socket.socket | None = None
        self._datagrams: DatagramInLink | None = None  # offered, or the link
        self._unsent = b""  # of our greeting

    @property
    def idle(self) -> bool:
        """Whether nothing is linked, nothing is under way, and nothing will be tried."""
        return self._ended and not (self.linked or self._under_way)

    def announced(self) -> None:
        """The master lists the publisher, again or for the first time."""
        # Notices of a publisher that left and one that came may have become one.
        self._again = self._under_way
        self._ended = False
        if not (self.linked or self._under_way):
            self._told = ""
            self._named = False
            self._rest = FIRST_REST
            self._start()

    def vanished(self) -> None:
        """The master no longer lists the publisher."""
        self._ended = True
        if self.linked and self._datagrams is not None:
            self._close_datagrams()  # no publisher says that it has gone
        if not self._under_way:
            self._cancel_timer()

    def stop(self) -> None:
        """Give up what is under way."""
        self._ended = True
        self._give_up()

    def _give_up(self) -> None:
        self._under_way = False
        self._attempt += 1
        self._cancel_timer()
        self._close_socket()
        self._close_datagrams()

    def lost(self, reason: str | None) -> None:
        """The link broke: try again soon, if the master still lists the publisher."""
        self.linked = False
        self._rest = FIRST_REST
        if reason is not None:
            self._context.log.peer(WARN, "lost %s from %s: %s", self._subscription.topic, self.uri, reason)
        self._retry()

    # Steps ------------------------------------------------------------------------------------------------------------

    def _start(self) -> None:
        self._cancel_timer()
        if self._ended:
            return
        self._attempt += 1
        self._again = False
        local = find_local_context(self.uri)
        if local is not None:
            publication = local.publications.get(self._subscription.topic)
            if publication is None:
                self._retry()
                return
            try:
                self._subscription.link_local(self, publication)
            except (Refusal, Error) as refusal:
                self._refuse(f"publisher {self.uri} of {publication.topic} refused the connection: {refusal}")
            return
        attempt = self._attempt
        self._under_way = True
        if not self._named:
            self._silence = self._context.loop.call_later(SILENCE, self._name)
        self._context.rpc.call(
            self.uri,
            "requestTopic",
            (self._context.name, self._subscription.topic, self._protocols()),
            lambda value, error: self._asked(attempt, value, error),
            timeout=STEP_TIMEOUT,
        )

    def _protocols(self) -> list[list[Any]]:
        """Return what is asked for, in the order of preference (T62)."""
        hints, address = self._subscription.hints, self._context.address
        protocols: list[list[Any]] = []
        for transport in hints.transports:
            if transport == "tcp":
                protocols.append(["TCPROS"])
            elif address is not None:
                from pyros1.node.datagrams import DatagramInLink  # noqa: PLC0415 - few nodes need it

                try:
                    self._datagrams = DatagramInLink(self._subscription, self.uri, address, hints.max_datagram_size)
                except OSError as error:
                    self._context.log.error("no socket for datagrams of %s: %s", self._subscription.topic, error)
                else:
                    protocols.append(self._datagrams.offer())
        return protocols

    def _asked(self, attempt: int, value: Any, error: Exception | None) -> None:
        if attempt != self._attempt:
            return
        if error is not None:
            self._fail(error)
            return
        match value:
            case [1, str(), ["UDPROS", *_] as answer] if self._datagrams is not None:
                self._receive_datagrams(self._datagrams, answer)
            case [0, str(reason), _] if "tcp" not in self._subscription.hints.transports:
                self._refuse(f"{self.uri} does not send {self._subscription.topic} in datagrams: {reason}")
            case [1, str(), ["TCPROS", str(host), int(port), *_]] if 0 < port < 65536:
                self._close_datagrams()
                connect(self._context.loop, host, port, STEP_TIMEOUT, lambda s, e: self._connected(attempt, s, e))
            case _:  # not a publisher (yet, or any more), or nonsense
                self._retry()

    def _receive_datagrams(self, link: DatagramInLink, answer: list[Any]) -> None:
        from pyros1.node.datagrams import read_answer  # noqa: PLC0415

        subscription = self._subscription
        try:
            found = read_answer(answer)
            if found is None:
                self._retry()
                return
            check_publisher_answer(found[0], subscription.topic, subscription.type, self.uri)
        except (ConnectionRefusedByPeerError, ProtocolError) as refusal:
            self._refuse(str(refusal))
            return
        self._cancel_timer()
        self._under_way = False
        self.linked = True
        self._named = False
        self._rest = FIRST_REST
        link.begin(*found)
        subscription.add_local(link)

    def _connected(self, attempt: int, sock: socket.socket | None, error: Exception | None) -> None:
        if attempt != self._attempt:
            if sock is not None:
                sock.close()
            return
        if sock is None:
            self._fail(error)
            return
        self._sock = sock
        subscription = self._subscription
        keep_alive(sock)
        with contextlib.suppress(OSError):  # some systems say so here that the peer has gone; reading tells, too
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        reader = HeaderReader()
        self._unsent = encode_header(subscription.request_header())
        self._context.loop.register(
            sock,
            selectors.EVENT_READ | selectors.EVENT_WRITE,
            lambda mask: self._greet(attempt, sock, reader, mask),
        )
        self._timer = self._context.loop.call_later(STEP_TIMEOUT, self._silent, attempt)

    def _name(self) -> None:
        """A publisher that takes its time is named once, until it answers: a process that was stopped, or a host that
        cannot be reached, would leave the subscriber waiting without a word."""
        self._silence = None
        self._named = True
        self._context.log.peer(
            WARN,
            "no messages of %s from the publisher at %s yet: it does not answer. Is it stopped, or out of reach?",
            self._subscription.topic,
            self.uri,
        )

    def _silent(self, attempt: int) -> None:
        if attempt == self._attempt:
            self._timer = None
            self._retry()

    def _greet(self, attempt: int, sock: socket.socket, reader: HeaderReader, mask: int) -> None:
        """Send our header, in pieces if it is long, and take the publisher's."""
        if attempt != self._attempt:
            return
        if mask & selectors.EVENT_WRITE:
            try:
                self._unsent = self._unsent[sock.send(self._unsent) :]
            except BlockingIOError:
                pass
            except OSError:
                self._retry()
                return
            if not self._unsent:
                self._context.loop.modify(
                    sock, selectors.EVENT_READ, lambda mask: self._greet(attempt, sock, reader, mask)
                )
        if mask & selectors.EVENT_READ:
            self._greeted(sock, reader)

    def _greeted(self, sock: socket.socket, reader: HeaderReader) -> None:
        try:
            data = sock.recv(65536)
            if not data:
                self._retry()
                return
            header = reader.feed(data)
            if header is None:
                return
            check_publisher_answer(header, self._subscription.topic, self._subscription.type, self.uri)
        except BlockingIOError:
            return
        except (ConnectionRefusedByPeerError, ProtocolError) as refusal:
            self._refuse(str(refusal))
            return
        except OSError:
            self._retry()
            return
        self._cancel_timer()
        self._context.loop.unregister(sock)
        self._sock = None
        self._under_way = False
        self.linked = True
        self._named = False
        self._rest = FIRST_REST
        self._subscription.link(self, InLink(sock, self.uri, header, reader.rest))

    def _refuse(self, reason: str) -> None:
        if not self._ended and reason != self._told:
            self._told = reason
            self._context.log.peer(ERROR, "%s", reason)
        if self._again or self._ended:
            self._retry()
        else:
            self._give_up()

    def _fail(self, error: Exception | None) -> None:
        """No connection was made: try again later. That may always fail, if the host is not known here."""
        if isinstance(error, UnknownHostError) and not self._ended:
            self._context.warn_of_host(self._subscription.topic, self.uri, error)
        self._retry()

    def _retry(self) -> None:
        self._give_up()
        if self._ended:
            self._subscription.forget(self)
        elif not self._context.stopping.is_set():
            self._timer = self._context.loop.call_later(self._rest, self._start)
            self._rest = min(2 * self._rest, LONGEST_REST)

    def _cancel_timer(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        if self._silence is not None:
            self._silence.cancel()
            self._silence = None

    def _close_datagrams(self) -> None:
        datagrams, self._datagrams = self._datagrams, None
        if datagrams is not None:
            datagrams.close()

    def _close_socket(self) -> None:
        sock, self._sock = self._sock, None
        if sock is not None:
            with contextlib.suppress(KeyError, ValueError):
                self._context.loop.unregister(sock)
            sock.close()
