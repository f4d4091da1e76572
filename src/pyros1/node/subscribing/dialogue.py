"""The dialogue of a subscription with one publisher: a state machine without sockets, clocks or threads.

States::

              listed by the master
                    v
    BACKING_OFF ───> REQUESTING ───> CONNECTING ──────> HANDSHAKE ──────> LINKED
       ^ pause over │ requestTopic     │ TCP connect     │ headers         │
       └────────────┴──────────────────┴─────────────────┴─────────────────┘
          failed, timed out, or link lost: pause, longer after each failure

* REFUSED: the publisher responded with an error, or its type differs. Another attempt would get the same response, so
  nothing is done until the master lists the publisher again.
* A publisher in the same process, and one that sends datagrams (UDPROS), are LINKED right after REQUESTING.
* If the master no longer lists the publisher, no further attempts are made. An attempt in progress continues: the node
  may have accepted the connection already, for a new publisher that the master does not list yet. An open link stays
  until the publisher closes it, so that its last messages are not lost.
* GONE: the publisher is not listed, and there is neither a link nor an attempt.

Each event is a method that returns the actions to take, in order. The connector (`connector.py`) executes them. After
the action `EndAttempt` it ignores further events of that attempt.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import Enum
from typing import Any, NamedTuple

from pyros1.ground.errors import ConnectionRefusedByPeerError, ProtocolError, UnknownHostError, XmlRpcFault
from pyros1.net.connectivity import connectivity_hint
from pyros1.net.hosts import parse_uri
from pyros1.wire import local as local_wire
from pyros1.wire.handshake import TopicType, check_publisher_response
from pyros1.wire.header import HeaderReader

MIN_BACKOFF = 0.1
"""Seconds before the second attempt."""
MAX_BACKOFF = 20.0
REPORTED_BACKOFF = 3.0
"""Minimum pause in seconds after which failures are logged, so that none is logged for a publisher that has just
exited.
"""


class State(Enum):
    """State of a dialogue; see the module's docstring."""

    BACKING_OFF = "backing off"
    REQUESTING = "requesting"
    CONNECTING = "connecting"
    HANDSHAKE = "handshake"
    LINKED = "linked"
    REFUSED = "refused"
    GONE = "gone"


IN_PROGRESS = frozenset({State.REQUESTING, State.CONNECTING, State.HANDSHAKE})


class RequestTopic(NamedTuple):
    """Action: call the publisher's ``requestTopic``, or link to the publisher if it is in this process.

    Attributes:
        report_silence: whether to call `Dialogue.on_publisher_silent` if there is no link after a while.
    """

    report_silence: bool


class Connect(NamedTuple):
    """Action: open a TCP connection, and close the socket that was offered for datagrams."""

    host: str
    port: int


class ConnectLocal(NamedTuple):
    """Action: connect to the Unix socket called ``name``."""

    name: str


class SendHeader(NamedTuple):
    """Action: send our connection header, and wait for the publisher's."""

    header: Mapping[str, str]


class Link(NamedTuple):
    """Action: turn the connection into a link.

    Attributes:
        header: the publisher's connection header.
        initial_bytes: bytes that were received after the header.
    """

    header: dict[str, str]
    initial_bytes: bytes


class LinkDatagrams(NamedTuple):
    """Action: turn the socket that was offered for datagrams into a link.

    Attributes:
        header: the publisher's connection header.
        peer_address: the publisher's host and port.
        number: the connection number assigned by the publisher.
    """

    header: dict[str, str]
    peer_address: tuple[str, int]
    number: int


class Backoff(NamedTuple):
    """Action: call `Dialogue.on_backoff_over` after ``seconds``."""

    seconds: float


class EndAttempt(NamedTuple):
    """Action: end the attempt, which means to close its sockets, stop its timers, and ignore responses to it."""


class EndDatagrams(NamedTuple):
    """Action: end the UDP link, since its publisher is gone."""


class Forget(NamedTuple):
    """Action: end the dialogue with this publisher."""


class LogMessage(NamedTuple):
    """Action: log a message about the publisher.

    Attributes:
        is_error: whether to log an error, not a warning.
        text, args: the format string of the message, and its arguments.
    """

    is_error: bool
    text: str
    args: tuple[str, ...]


class LogUnknownHost(NamedTuple):
    """Action: log that the publisher's host name cannot be resolved on this machine."""

    error: UnknownHostError


Action = (
    RequestTopic
    | Connect
    | ConnectLocal
    | SendHeader
    | Link
    | LinkDatagrams
    | Backoff
    | EndAttempt
    | EndDatagrams
    | Forget
    | LogMessage
    | LogUnknownHost
)

_SILENT = "no messages of %s from the publisher at %s yet: %s does not answer. Is it stopped? Otherwise: %s"
_UNREACHABLE = "no messages of %s from the publisher at %s: %s. %s"
_LOST = "lost the connection to the publisher of %s at %s: %s"
_PORT_TAKEN = "Has another program taken the port of a node that has exited?"


class Dialogue:
    """The dialogue with one publisher.

    Args:
        topic: the topic's full name.
        uri: URI of the publisher's slave API.
        requested_type: returns the type that the subscription requests; ``*`` may later be replaced by a specific type.
        own_host: the host name or address that the subscriber's node advertises.
        accepts_tcp: whether the subscription accepts messages over TCP.

    Attributes:
        state: the current state.
        is_listed: whether the master lists the publisher.
        offers_local: whether to offer the local transport; False once it has failed.
    """

    def __init__(
        self,
        topic: str,
        uri: str,
        requested_type: Callable[[], TopicType],
        *,
        own_host: str = "",
        accepts_tcp: bool = True,
    ) -> None:
        self.state = State.GONE
        self.is_listed = False
        self.offers_local = True
        self._uses_local = False
        self._topic = topic
        self._uri = uri
        self._requested_type = requested_type
        self._own_host = own_host
        self._accepts_tcp = accepts_tcp
        self._is_udp_link = False
        self._listed_again = False  # during the current attempt, whose response may be from the old publisher
        self._reported_refusal = ""  # the publisher's reason that was logged last
        self._peer_address: tuple[str, int] | None = None
        self._is_outage_logged = False  # whether the log says that there is no link
        self._backoff = MIN_BACKOFF
        self._sent_header: Mapping[str, str] = {}
        self._header_reader = HeaderReader()

    # From the master --------------------------------------------------------------------------------------------------

    def on_publisher_listed(self) -> list[Action]:
        """Return the actions to take when the master lists the publisher, again or for the first time."""
        # This may be a new publisher at the URI of one that has left: the master may have merged the two updates.
        self._listed_again = self.state in IN_PROGRESS
        self.is_listed = True
        if self.state in IN_PROGRESS or self.state is State.LINKED:
            return []
        self._reported_refusal = ""
        self._is_outage_logged = False
        self.offers_local = True
        self._backoff = MIN_BACKOFF
        return self._request_topic()

    def on_publisher_unlisted(self) -> list[Action]:
        """Return the actions to take when the master no longer lists the publisher."""
        self.is_listed = False
        if self.state in IN_PROGRESS:
            return []
        if self.state is State.LINKED:  # no datagram signals that the publisher is gone
            return [EndDatagrams()] if self._is_udp_link else []
        self.state = State.GONE
        return [EndAttempt(), Forget()]

    def stop(self) -> list[Action]:
        """Return the actions to take when the subscription has ended. An open link remains."""
        self.is_listed = False
        self.state = State.GONE
        return [EndAttempt()]

    # From the connector -----------------------------------------------------------------------------------------------

    def on_backoff_over(self) -> list[Action]:
        """Return the actions to take when the pause is over."""
        return self._request_topic()

    def on_linked(self) -> list[Action]:
        """Return the actions to take when a publisher in this process has been linked."""
        self._succeed()
        return []

    def on_topic_response(self, value: Any, *, datagrams_offered: bool = False) -> list[Action]:
        """Return the actions to take when the publisher's node has responded to ``requestTopic``.

        Args:
            value: the response.
            datagrams_offered: whether a socket for datagrams was offered.
        """
        match value:
            case [1, str(), ["UDPROS", *_] as udpros_response] if datagrams_offered:
                return self._link_datagrams(udpros_response)
            case [0, str(reason), _] if not self._accepts_tcp:
                return self.on_publisher_refused(f"{self._uri} does not send {self._topic} over UDP: {reason}")
            case [1, str(), [local_wire.LOCAL_PROTOCOL, str(name), *_]] if self.offers_local:
                self.state = State.CONNECTING
                self._uses_local = True
                return [ConnectLocal(name)]
            case [1, str(), ["TCPROS", str(host), int(port), *_]] if 0 < port < 65536:
                self.state = State.CONNECTING
                self._peer_address = (host, port)
                return [Connect(host, port)]
            case [int(), str(reason), *_]:  # the node is not a publisher yet, or no longer
                return self._on_not_publisher(f"it answers: {reason}")
        return self._on_not_publisher("it does not answer like a node")

    def on_local_connect_failed(self) -> list[Action]:
        """Return the actions to take when the Unix socket cannot be used: try again over TCP."""
        self.offers_local = False
        return self._request_topic()

    def on_connected(self, header: Mapping[str, str]) -> list[Action]:
        """Return the actions to take when the connection is open.

        Args:
            header: the subscription's connection header.
        """
        self.state = State.HANDSHAKE
        self._sent_header = header
        self._header_reader = HeaderReader()
        return [SendHeader(header)]

    def on_received(self, data: bytes) -> list[Action]:
        """Return the actions to take for received ``data``; if empty, the publisher has closed the connection."""
        if not data:
            self.offers_local = self.offers_local and not self._uses_local
            return self._retry()
        try:
            header = self._header_reader.feed(data)
        except ProtocolError as error:
            return self.on_publisher_refused(f"publisher {self._uri} of {self._topic}: {error}")
        if header is None:
            return []
        try:
            warning = check_publisher_response(
                header, self._topic, self._requested_type(), self._uri, self._sent_header
            )
        except (ConnectionRefusedByPeerError, ProtocolError) as refusal:
            return self.on_publisher_refused(str(refusal))
        self._succeed()
        return [*_warning(warning), Link(header, self._header_reader.bytes_after_header)]

    def on_attempt_failed(self, error: Exception | None = None) -> list[Action]:
        """Return the actions to take when the publisher was not reached or did not respond in time: try again later."""
        if isinstance(error, UnknownHostError) and self.is_listed:
            return [LogUnknownHost(error), *self._retry()]
        if isinstance(error, (ProtocolError, XmlRpcFault)):
            return self._fail(str(error), _PORT_TAKEN)
        if error is not None and self._backoff >= REPORTED_BACKOFF:
            return self._fail(str(error), connectivity_hint(self._current_address()[0], error, self._own_host))
        return self._retry()

    def on_publisher_refused(self, reason: str) -> list[Action]:
        """Return the actions to take when the publisher has refused, or does not match the subscription."""
        report: list[Action] = []
        if self.is_listed and reason != self._reported_refusal:
            self._reported_refusal = reason
            report = [LogMessage(True, "%s", (reason,))]
        if self._listed_again or not self.is_listed:
            return report + self._retry()
        self.state = State.REFUSED
        return [*report, EndAttempt()]

    def on_publisher_silent(self) -> list[Action]:
        """Return the actions to take when there is still no link after a while: log this, once per outage.

        Otherwise the user would not learn that the process is stopped or the host unreachable.
        """
        self._is_outage_logged = True
        host, port = self._current_address()
        hint = connectivity_hint(host, None, self._own_host)
        return [LogMessage(False, _SILENT, (self._topic, self._uri, f"{host}:{port}", hint))]

    def _current_address(self) -> tuple[str, int | str]:
        """Return the host and port that the attempt is using: the publisher's slave API, or its TCPROS server."""
        if self.state is not State.REQUESTING and self._peer_address is not None:
            return self._peer_address
        try:
            return parse_uri(self._uri)
        except ProtocolError:
            return (self._uri, "?")

    def on_link_lost(self, reason: str | None) -> list[Action]:
        """Return the actions to take when the link has ended; the reason is None if the publisher has closed it."""
        self._backoff = MIN_BACKOFF
        if reason is None:
            return self._retry()
        self.offers_local = self.offers_local and not self._uses_local
        return [LogMessage(False, _LOST, (self._topic, self._uri, reason)), *self._retry()]

    # ------------------------------------------------------------------------------------------------------------------

    def _request_topic(self) -> list[Action]:
        self._listed_again = self._uses_local = False
        self.state = State.REQUESTING
        return [EndAttempt(), RequestTopic(report_silence=not self._is_outage_logged)]

    def _link_datagrams(self, udpros_response: list[Any]) -> list[Action]:
        from pyros1.wire.datagram import parse_udpros_response  # noqa: PLC0415 - few nodes need it

        try:
            response = parse_udpros_response(udpros_response)
            if response is None:
                return self._retry()
            warning = check_publisher_response(response[0], self._topic, self._requested_type(), self._uri)
        except (ConnectionRefusedByPeerError, ProtocolError) as refusal:
            return self.on_publisher_refused(str(refusal))
        self._succeed(datagrams=True)
        return [*_warning(warning), LinkDatagrams(*response)]

    def _succeed(self, *, datagrams: bool = False) -> None:
        self.state = State.LINKED
        self._is_udp_link = datagrams
        self._is_outage_logged = False
        self._backoff = MIN_BACKOFF

    def _on_not_publisher(self, answer: str) -> list[Action]:
        """Pause; log the response if attempts keep failing."""
        return self._fail(answer, _PORT_TAKEN) if self._backoff >= REPORTED_BACKOFF else self._retry()

    def _fail(self, reason: str, hint: str) -> list[Action]:
        """Pause; log the reason, but only once until there is a link or the master lists the publisher again."""
        if not self.is_listed or self._is_outage_logged:
            return self._retry()
        self._is_outage_logged = True
        return [LogMessage(False, _UNREACHABLE, (self._topic, self._uri, reason, hint)), *self._retry()]

    def _retry(self) -> list[Action]:
        if not self.is_listed:
            self.state = State.GONE
            return [EndAttempt(), Forget()]
        self.state = State.BACKING_OFF
        seconds, self._backoff = self._backoff, min(2 * self._backoff, MAX_BACKOFF)
        return [EndAttempt(), Backoff(seconds)]


def _warning(text: str) -> list[Action]:
    return [LogMessage(False, "%s", (text,))] if text else []
