"""The connector: drives the `dialogue` with one publisher, using sockets, timers and calls."""

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
from pyros1.node.subscribing import dialogue as dialogue_actions
from pyros1.node.subscribing.dialogue import Action, Dialogue, State
from pyros1.node.subscribing.tcp_source import TcpSource
from pyros1.wire.handshake import Refusal
from pyros1.wire.header import encode_header
from pyros1.wire.local import make_offer

if TYPE_CHECKING:
    from pyros1.net.loop import TimerHandle
    from pyros1.node.subscribing.subscription import Subscription
    from pyros1.node.subscribing.udp_source import UdpSource

STEP_TIMEOUT = 10.0
"""Maximum number of seconds for each step towards a link."""
SILENCE_TIMEOUT = 4.0
"""Seconds after which the log reports a publisher that does not respond."""
MAX_REPORTS = 3
"""Maximum number of different warnings about publishers per logging period; the log only counts further ones."""
_RECEIVE_SIZE = 65536


class Connector:
    """Keeps a subscription connected to one publisher; other publishers do not delay it. All methods run on the loop.

    Args:
        subscription: the subscription that receives the messages.
        uri: URI of the publisher's slave API.
    """

    def __init__(self, subscription: Subscription, uri: str) -> None:
        self.uri = uri
        self.dialogue = Dialogue(
            subscription.topic,
            uri,
            lambda: subscription.type,
            own_host=subscription.context.host,
            accepts_tcp="tcp" in subscription.hints.transports,
        )
        self._subscription = subscription
        self._context = subscription.context
        self._attempt_number = 0  # events of older attempts are ignored
        self._timer: TimerHandle | None = None  # the timer of the pause, or of the current step
        self._silence_timer: TimerHandle | None = None
        self._sock: socket.socket | None = None
        self._offered_source: UdpSource | None = None  # offered to the publisher, or linked
        self._unsent_header = b""  # the part of our header that has not been sent
        self._control_socket: socket.socket | None = (
            None  # the socket that came with the publisher's header; see `pyros1.wire.local`
        )

    @property
    def is_finished(self) -> bool:
        """Whether the connector has nothing left to do."""
        return self.dialogue.state is State.GONE

    def on_publisher_listed(self) -> None:
        """Note that the master lists the publisher, again or for the first time."""
        self._execute(self.dialogue.on_publisher_listed())

    def on_publisher_unlisted(self) -> None:
        """Note that the master no longer lists the publisher."""
        self._execute(self.dialogue.on_publisher_unlisted())

    def stop(self) -> None:
        """Give up the current attempt, since the subscription has ended."""
        self._execute(self.dialogue.stop())

    def on_link_lost(self, reason: str | None) -> None:
        """Note that the link has ended; reconnect soon if the publisher is still listed.

        Args:
            reason: the reason; None for an orderly end.
        """
        self._execute(self.dialogue.on_link_lost(reason))

    # Actions ----------------------------------------------------------------------------------------------------------

    def _execute(self, actions: Sequence[Action]) -> None:  # noqa: PLR0912 - one or two lines per kind of action
        for action in actions:
            match action:
                case dialogue_actions.EndAttempt():
                    self._end_attempt()
                case dialogue_actions.RequestTopic(report_silence):
                    self._request_topic(report_silence)
                case dialogue_actions.Connect(host, port):
                    self._close_offered_source()
                    connect(self._context.loop, host, port, STEP_TIMEOUT, self._if_current(self._on_connected))
                case dialogue_actions.ConnectLocal(name):
                    self._close_offered_source()
                    self._connect_local(name)
                case dialogue_actions.SendHeader(header):
                    self._send_header(header)
                case dialogue_actions.Link(header, initial_bytes):
                    self._link(header, initial_bytes)
                case dialogue_actions.LinkDatagrams(header, peer_address, number):
                    self._link_datagrams(header, peer_address, number)
                case dialogue_actions.EndDatagrams():
                    self._close_offered_source()
                case dialogue_actions.Backoff(seconds):
                    if not self._context.stopping.is_set():
                        self._timer = self._context.loop.call_later(seconds, self._on_backoff_over)
                case dialogue_actions.LogMessage(is_error, text, args):
                    if is_error:
                        self._context.log.peer_event(ERROR, text, *args)
                    else:  # many warnings often have one cause, such as a killed launch
                        self._context.log.peer_event(WARN, text, *args, max_texts=MAX_REPORTS)
                case dialogue_actions.LogUnknownHost(error):
                    self._context.warn_unknown_host(self._subscription.topic, self.uri, error)
                case dialogue_actions.Forget():
                    self._subscription.forget(self.uri)

    def _if_current(self, function: Callable[..., object]) -> Callable[..., None]:
        """Return a callback that calls ``function`` only during the current attempt; after that, the callback
        only closes the socket that was passed to it, if any.
        """
        attempt_number = self._attempt_number

        def call_if_current(*args: Any) -> None:
            if attempt_number == self._attempt_number:
                function(*args)
            elif args and isinstance(args[0], socket.socket):
                args[0].close()

        return call_if_current

    def _end_attempt(self) -> None:
        self._attempt_number += 1
        self._stop_timers()
        self._unsent_header = b""
        sock, self._sock = self._sock, None
        if sock is not None:
            with contextlib.suppress(KeyError, ValueError):
                self._context.loop.unregister(sock)
            sock.close()
        self._close_control_socket()
        self._close_offered_source()

    def _stop_timers(self) -> None:
        for timer in (self._timer, self._silence_timer):
            if timer is not None:
                timer.cancel()
        self._timer = self._silence_timer = None

    def _close_offered_source(self) -> None:
        offered_source, self._offered_source = self._offered_source, None
        if offered_source is not None:
            offered_source.close()

    def _on_backoff_over(self) -> None:
        self._timer = None
        self._execute(self.dialogue.on_backoff_over())

    # Requesting -------------------------------------------------------------------------------------------------------

    def _request_topic(self, report_silence: bool) -> None:
        context, topic = self._context, self._subscription.topic
        local_context = find_local_context(self.uri)
        if local_context is not None:
            self._execute(self._link_in_process(local_context.publications.get(topic)))
            return
        if report_silence:
            self._silence_timer = context.loop.call_later(SILENCE_TIMEOUT, self._on_silence)
        on_response = self._if_current(self._on_topic_response)
        context.rpc.call(
            self.uri, "requestTopic", (context.name, topic, self._protocols()), on_response, timeout=STEP_TIMEOUT
        )

    def _link_in_process(self, publication: Any) -> list[Action]:
        if publication is None:
            return self.dialogue.on_attempt_failed()
        try:
            self._subscription.link_in_process(self.uri, publication)
        except (Refusal, Error) as refusal:
            return self.dialogue.on_publisher_refused(
                f"publisher {self.uri} of {publication.topic} refused the connection: {refusal}"
            )
        return self.dialogue.on_linked()

    def _protocols(self) -> list[list[Any]]:
        """Return the protocols to request, in order of preference (T62)."""
        protocols: list[list[Any]] = []
        for transport in self._subscription.hints.transports:
            if transport == "local":
                continue
            if transport == "tcp":
                protocols.append(["TCPROS"])
            elif self._context.address is not None:
                try:
                    self._offered_source = self._subscription.offer_datagrams(self.uri)
                except OSError as error:
                    self._context.log.error(
                        "cannot open a UDP socket for %s: %s", self._subscription.topic, error.strerror or error
                    )
                else:
                    protocols.append(self._offered_source.offer())
        # The local transport comes last, so that a publisher that only looks at the first protocol finds TCPROS.
        if self._context.local_key and self.dialogue.offers_local and "local" in self._subscription.hints.transports:
            protocols.append(make_offer(self._context.local_key))
        return protocols

    def _on_topic_response(self, value: Any, error: Exception | None) -> None:
        if error is not None:
            self._on_failure(error)
        else:
            self._execute(self.dialogue.on_topic_response(value, datagrams_offered=self._offered_source is not None))

    def _on_failure(self, error: Exception | None) -> None:
        if is_out_of_files(error):
            self._context.log_system_error(f"no messages of {self._subscription.topic} from {self.uri}: {error}")
        self._execute(self.dialogue.on_attempt_failed(error))

    def _on_silence(self) -> None:
        self._silence_timer = None
        self._execute(self.dialogue.on_publisher_silent())

    # Connecting and handshake -----------------------------------------------------------------------------------------

    def _connect_local(self, name: str) -> None:
        if not self._context.local_key:  # this node has not offered the local transport
            self._execute(self.dialogue.on_local_connect_failed())
            return
        try:
            self._sock = same_host.connect(name)
        except OSError:
            self._execute(self.dialogue.on_local_connect_failed())
        else:
            self._execute(self.dialogue.on_connected(self._subscription.request_header()))

    def _on_connected(self, sock: socket.socket | None, error: Exception | None) -> None:
        if sock is None:
            self._on_failure(error)
            return
        self._sock = sock
        set_nodelay_and_keepalive(sock)
        self._execute(self.dialogue.on_connected(self._subscription.request_header()))

    def _send_header(self, header: Mapping[str, str]) -> None:
        assert self._sock is not None
        self._unsent_header = encode_header(header)
        self._context.loop.register(
            self._sock,
            selectors.EVENT_READ | selectors.EVENT_WRITE,
            self._if_current(partial(self._on_ready, self._sock)),
        )
        self._timer = self._context.loop.call_later(
            STEP_TIMEOUT, lambda: self._execute(self.dialogue.on_attempt_failed())
        )

    def _on_ready(self, sock: socket.socket, mask: int) -> None:
        """Send our header, in pieces if it is long, and read the publisher's."""
        try:
            if mask & selectors.EVENT_WRITE and self._unsent_header:
                with contextlib.suppress(BlockingIOError):
                    self._unsent_header = self._unsent_header[sock.send(self._unsent_header) :]
                if not self._unsent_header:
                    on_ready = self._if_current(partial(self._on_ready, sock))
                    self._context.loop.modify(sock, selectors.EVENT_READ, on_ready)
            if mask & selectors.EVENT_READ:
                self._execute(self.dialogue.on_received(self._receive(sock)))
        except BlockingIOError:
            pass
        except OSError:
            self._execute(self.dialogue.on_attempt_failed())

    def _receive(self, sock: socket.socket) -> bytes:
        """Receive bytes; over a Unix socket, also keep the control socket that arrives with the publisher's header."""
        if sock.family in (socket.AF_INET, socket.AF_INET6):
            return sock.recv(_RECEIVE_SIZE)
        data, descriptors, _, _ = socket.recv_fds(sock, _RECEIVE_SIZE, 2)
        for descriptor in descriptors:
            self._close_control_socket()
            try:
                self._control_socket = socket.socket(fileno=descriptor)
                # Received descriptors are inheritable, unlike sockets created by Python.
                self._control_socket.set_inheritable(False)
            except OSError:
                os.close(descriptor)  # the descriptor is not a socket
        return data

    def _close_control_socket(self) -> None:
        control_socket, self._control_socket = self._control_socket, None
        if control_socket is not None:
            control_socket.close()

    def _link(self, header: dict[str, str], initial_bytes: bytes) -> None:
        control_socket, self._control_socket = self._control_socket, None
        sock, self._sock = self._sock, None
        assert sock is not None
        self._stop_timers()
        self._context.loop.unregister(sock)
        if control_socket is None:
            if sock.family not in (socket.AF_INET, socket.AF_INET6):  # shared memory needs the control socket
                sock.close()
                reason = "no descriptor came with the publisher's header: are too many files open?"
                self._execute(self.dialogue.on_link_lost(reason))
                return
            self._subscription.link(TcpSource(sock, self.uri, header, initial_bytes))
            return
        from pyros1.node.subscribing.shared_source import SharedSource  # noqa: PLC0415 - few need it, and only on Linux

        try:
            source = SharedSource(sock, self.uri, header, initial_bytes, control_socket)
        except ProtocolError as error:
            sock.close()
            control_socket.close()
            self._execute(self.dialogue.on_link_lost(str(error)))
        else:
            self._subscription.link(source)

    def _link_datagrams(self, header: dict[str, str], peer_address: tuple[str, int], number: int) -> None:
        assert self._offered_source is not None
        self._stop_timers()
        self._offered_source.begin(header, peer_address, number)
        self._subscription.add_inbox_link(self._offered_source)
