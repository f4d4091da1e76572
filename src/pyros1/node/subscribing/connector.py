"""The connector, which drives the dialogue with one publisher (`dialogue`): sockets, timers, calls."""

from __future__ import annotations

import contextlib
import os
import selectors
import socket
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import Error, ProtocolError
from pyros1.net.acceptor import is_out_of_files
from pyros1.net.connect import connect
from pyros1.net.keepalive import set_nodelay_and_keepalive
from pyros1.node import same_host
from pyros1.node.context import find_local_context
from pyros1.node.log.levels import ERROR, WARN
from pyros1.node.subscribing import dialogue as do
from pyros1.node.subscribing.dialogue import Action, Dialogue, State
from pyros1.node.subscribing.tcp_source import TcpSource
from pyros1.wire.handshake import Refusal
from pyros1.wire.header import encode_header
from pyros1.wire.local import offer

if TYPE_CHECKING:
    from pyros1.net.loop import TimerHandle
    from pyros1.node.subscribing.subscription import Subscription
    from pyros1.node.subscribing.udp_source import UdpSource

STEP_TIMEOUT = 10.0
"""Maximum seconds for each step. A publisher that cannot be reached delays no other."""
SILENCE_TIMEOUT = 4.0
"""Seconds after which a publisher that does not answer is named in the log."""
MAX_REPORTS = 3
"""Maximum number of different warnings about publishers in a period; further ones are counted."""
_RECEIVE_SIZE = 65536


class Connector:
    """Keeps a subscription connected to one publisher. All methods run on the loop.

    Args:
        subscription: the subscription that receives the messages.
        uri: the publisher's slave API.
    """

    def __init__(self, subscription: Subscription, uri: str) -> None:
        self.uri = uri
        self.dialogue = Dialogue(
            subscription.topic,
            uri,
            lambda: subscription.type,
            own_host=subscription.context.host,
            takes_tcp="tcp" in subscription.hints.transports,
        )
        self._subscription = subscription
        self._context = subscription.context
        self._attempt = 0  # events of older attempts are ignored
        self._timer: TimerHandle | None = None  # of the pause, or of the current step
        self._silence_timer: TimerHandle | None = None
        self._sock: socket.socket | None = None
        self._offered: UdpSource | None = None  # or of the link
        self._unsent = b""  # of our header
        self._control_socket: socket.socket | None = None  # came with the publisher's header, see `pyros1.wire.local`

    @property
    def is_finished(self) -> bool:
        """Whether the connector has nothing left to do."""
        return self.dialogue.state is State.GONE

    def publisher_listed(self) -> None:
        """Note that the master lists the publisher, again or for the first time."""
        self._do(self.dialogue.publisher_listed())

    def publisher_unlisted(self) -> None:
        """Note that the master no longer lists the publisher."""
        self._do(self.dialogue.publisher_unlisted())

    def stop(self) -> None:
        """Give up the current attempt."""
        self._do(self.dialogue.stop())

    def link_lost(self, reason: str | None) -> None:
        """Note that the link has ended: try again soon, if the master still lists the publisher."""
        self._do(self.dialogue.link_lost(reason))

    # Actions ----------------------------------------------------------------------------------------------------------

    def _do(self, actions: Sequence[Action]) -> None:  # noqa: PLR0912 - one line or two for each
        for action in actions:
            match action:
                case do.Drop():
                    self._drop()
                case do.RequestTopic(report_silence):
                    self._request_topic(report_silence)
                case do.Connect(host, port):
                    self._close_offered()
                    connect(self._context.loop, host, port, STEP_TIMEOUT, self._if_current(self._connected))
                case do.ConnectLocal(name):
                    self._close_offered()
                    self._connect_local(name)
                case do.SendHeader(header):
                    self._send_header(header)
                case do.Link(header, rest):
                    self._link(header, rest)
                case do.LinkDatagrams(header, peer_address, number):
                    self._link_datagrams(header, peer_address, number)
                case do.EndDatagrams():
                    self._close_offered()
                case do.Backoff(seconds):
                    if not self._context.stopping.is_set():
                        self._timer = self._context.loop.call_later(seconds, self._backoff_over)
                case do.LogMessage(is_error, text, args):
                    if is_error:
                        self._context.log.peer(ERROR, text, *args)
                    else:  # many often have one cause, such as a killed launch
                        self._context.log.peer(WARN, text, *args, max_texts=MAX_REPORTS)
                case do.LogHostMessage(error):
                    self._context.warn_unknown_host(self._subscription.topic, self.uri, error)
                case do.Forget():
                    self._subscription.forget(self.uri)

    def _if_current(self, function: Callable[..., object]) -> Callable[..., None]:
        """Return a callback that does nothing once another attempt has begun."""
        attempt = self._attempt

        def call(*args: Any) -> None:
            if attempt == self._attempt:
                function(*args)
            elif args and isinstance(args[0], socket.socket):
                args[0].close()

        return call

    def _drop(self) -> None:
        self._attempt += 1
        self._stop_timers()
        self._unsent = b""
        sock, self._sock = self._sock, None
        if sock is not None:
            with contextlib.suppress(KeyError, ValueError):
                self._context.loop.unregister(sock)
            sock.close()
        self._close_control_socket()
        self._close_offered()

    def _stop_timers(self) -> None:
        for timer in (self._timer, self._silence_timer):
            if timer is not None:
                timer.cancel()
        self._timer = self._silence_timer = None

    def _close_offered(self) -> None:
        offered, self._offered = self._offered, None
        if offered is not None:
            offered.close()

    def _backoff_over(self) -> None:
        self._timer = None
        self._do(self.dialogue.backoff_over())

    # Asking -----------------------------------------------------------------------------------------------------------

    def _request_topic(self, report_silence: bool) -> None:
        context, topic = self._context, self._subscription.topic
        local = find_local_context(self.uri)
        if local is not None:
            self._do(self._link_in_process(local.publications.get(topic)))
            return
        if report_silence:
            self._silence_timer = context.loop.call_later(SILENCE_TIMEOUT, self._on_silence)
        topic_answered = self._if_current(self._answered)
        context.rpc.call(
            self.uri, "requestTopic", (context.name, topic, self._protocols()), topic_answered, timeout=STEP_TIMEOUT
        )

    def _link_in_process(self, publication: Any) -> list[Action]:
        if publication is None:
            return self.dialogue.attempt_failed()
        try:
            self._subscription.link_in_process(self.uri, publication)
        except (Refusal, Error) as refusal:
            return self.dialogue.publisher_refused(
                f"publisher {self.uri} of {publication.topic} refused the connection: {refusal}"
            )
        return self.dialogue.linked()

    def _protocols(self) -> list[list[Any]]:
        """Return the requested protocols, in the order of preference (T62)."""
        protocols: list[list[Any]] = []
        for transport in self._subscription.hints.transports:
            if transport == "local":
                continue
            if transport == "tcp":
                protocols.append(["TCPROS"])
            elif self._context.address is not None:
                try:
                    self._offered = self._subscription.offer_datagrams(self.uri)
                except OSError as error:
                    self._context.log.error(
                        "no socket for datagrams of %s: %s", self._subscription.topic, error.strerror or error
                    )
                else:
                    protocols.append(self._offered.offer())
        # Last, so that a publisher that only looks at the first protocol finds one it knows.
        if self._context.local_key and self.dialogue.local and "local" in self._subscription.hints.transports:
            protocols.append(offer(self._context.local_key))
        return protocols

    def _answered(self, value: Any, error: Exception | None) -> None:
        if error is not None:
            self._failed(error)
        else:
            self._do(self.dialogue.topic_answered(value, offered=self._offered is not None))

    def _failed(self, error: Exception | None) -> None:
        if is_out_of_files(error):
            self._context.warn_once(f"no messages of {self._subscription.topic} from {self.uri}: {error}")
        self._do(self.dialogue.attempt_failed(error))

    def _on_silence(self) -> None:
        self._silence_timer = None
        self._do(self.dialogue.publisher_silent())

    # Connecting and greeting ------------------------------------------------------------------------------------------

    def _connect_local(self, name: str) -> None:
        if not self._context.local_key:  # nobody has requested it
            self._do(self.dialogue.local_connect_failed())
            return
        try:
            self._sock = same_host.connect(name)
        except OSError:
            self._do(self.dialogue.local_connect_failed())
        else:
            self._do(self.dialogue.connected(self._subscription.request_header()))

    def _connected(self, sock: socket.socket | None, error: Exception | None) -> None:
        if sock is None:
            self._failed(error)
            return
        self._sock = sock
        set_nodelay_and_keepalive(sock)
        self._do(self.dialogue.connected(self._subscription.request_header()))

    def _send_header(self, header: Mapping[str, str]) -> None:
        assert self._sock is not None
        self._unsent = encode_header(header)
        self._context.loop.register(
            self._sock,
            selectors.EVENT_READ | selectors.EVENT_WRITE,
            self._if_current(partial(self._ready, self._sock)),
        )
        self._timer = self._context.loop.call_later(STEP_TIMEOUT, lambda: self._do(self.dialogue.attempt_failed()))

    def _ready(self, sock: socket.socket, mask: int) -> None:
        """Send our header, in pieces if it is long, and read the publisher's."""
        try:
            if mask & selectors.EVENT_WRITE and self._unsent:
                with contextlib.suppress(BlockingIOError):
                    self._unsent = self._unsent[sock.send(self._unsent) :]
                if not self._unsent:
                    ready = self._if_current(partial(self._ready, sock))
                    self._context.loop.modify(sock, selectors.EVENT_READ, ready)
            if mask & selectors.EVENT_READ:
                self._do(self.dialogue.received(self._receive(sock)))
        except BlockingIOError:
            pass
        except OSError:
            self._do(self.dialogue.attempt_failed())

    def _receive(self, sock: socket.socket) -> bytes:
        """Receive bytes; and, over a Unix socket, the descriptor that comes with a header."""
        if sock.family in (socket.AF_INET, socket.AF_INET6):
            return sock.recv(_RECEIVE_SIZE)
        data, descriptors, _, _ = socket.recv_fds(sock, _RECEIVE_SIZE, 2)
        for descriptor in descriptors:
            self._close_control_socket()
            try:
                self._control_socket = socket.socket(fileno=descriptor)
                self._control_socket.set_inheritable(False)  # like sockets created by Python; received ones are not
            except OSError:
                os.close(descriptor)  # it is not a socket
        return data

    def _close_control_socket(self) -> None:
        control_socket, self._control_socket = self._control_socket, None
        if control_socket is not None:
            control_socket.close()

    def _link(self, header: dict[str, str], rest: bytes) -> None:
        control_socket, self._control_socket = self._control_socket, None
        sock, self._sock = self._sock, None
        assert sock is not None
        self._stop_timers()
        self._context.loop.unregister(sock)
        if control_socket is None:
            if sock.family not in (socket.AF_INET, socket.AF_INET6):  # references could not be followed
                sock.close()
                reason = "no descriptor came with the publisher's header: are too many files open?"
                self._do(self.dialogue.link_lost(reason))
                return
            self._subscription.link(TcpSource(sock, self.uri, header, rest))
            return
        from pyros1.node.subscribing.shared_source import SharedSource  # noqa: PLC0415 - few need it, and only on Linux

        try:
            source = SharedSource(sock, self.uri, header, rest, control_socket)
        except ProtocolError as error:
            sock.close()
            control_socket.close()
            self._do(self.dialogue.link_lost(str(error)))
        else:
            self._subscription.link(source)

    def _link_datagrams(self, header: dict[str, str], peer_address: tuple[str, int], number: int) -> None:
        assert self._offered is not None
        self._stop_timers()
        self._offered.begin(header, peer_address, number)
        self._subscription.add_inbox_link(self._offered)
