"""What a subscription has to do to be linked to one publisher: a state machine without sockets, clocks or threads.

States::

                announced
                    v
    RESTING ───> ASKING ───────> CONNECTING ───────> GREETING ───────> LINKED
       ^    rested  │ requestTopic     │ TCP connect     │ headers         │
       └────────────┴──────────────────┴─────────────────┴─────────────────┘
          failed, silent too long, or lost: rest, longer after each failure

* REFUSED: the publisher answered with an error, or its type is not ours. Asking again would get the same answer, so
  nothing is done until the master announces the publishers anew.
* A publisher in the same process, and one that sends datagrams (UDPROS), are LINKED right after ASKING.
* A publisher that the master no longer lists is not tried again. What is under way goes on: its node may have taken us
  already, for a publisher that is not announced yet. A link that is up stays until the publisher closes it, so that its
  last messages are not lost. GONE: the publisher is not listed, and nothing is linked or under way.

Each event is a method, and returns what is to be done, in order. Whoever drives the machine does that (`connector`),
and passes on no event of an attempt that `Drop` has ended.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from typing import Any, NamedTuple

from pyros1.errors import ConnectionRefusedByPeerError, ProtocolError, UnknownHostError
from pyros1.wire.handshake import TopicType, check_publisher_answer
from pyros1.wire.header import HeaderReader

FIRST_REST = 0.1
"""Seconds before the second attempt."""
LONGEST_REST = 20.0


class State(Enum):
    """See the module."""

    RESTING = "resting"
    ASKING = "asking"
    CONNECTING = "connecting"
    GREETING = "greeting"
    LINKED = "linked"
    REFUSED = "refused"
    GONE = "gone"


UNDER_WAY = frozenset({State.ASKING, State.CONNECTING, State.GREETING})


class Ask(NamedTuple):
    """Call the publisher's ``requestTopic``, or link to it if it is in this process.

    Attributes:
        watched: report `Dialogue.silent` if there is no link after a while.
    """

    watched: bool


class Connect(NamedTuple):
    """Open a TCP connection, and give up the sockets that were offered for datagrams."""

    host: str
    port: int


class Greet(NamedTuple):
    """Send our connection header, and wait for the publisher's."""


class Link(NamedTuple):
    """The connection is a link now.

    Attributes:
        header: the publisher's.
        rest: what came behind it.
    """

    header: dict[str, str]
    rest: bytes


class LinkDatagrams(NamedTuple):
    """The socket that was offered for datagrams is a link now.

    Attributes:
        header: the publisher's.
        place: its host and port.
        number: that it gave the link.
    """

    header: dict[str, str]
    place: tuple[str, int]
    number: int


class Rest(NamedTuple):
    """Report `Dialogue.rested` after so many seconds."""

    seconds: float


class Drop(NamedTuple):
    """End the attempt: close its sockets, stop its timers, forget its answers."""


class EndDatagrams(NamedTuple):
    """End the link of datagrams, whose publisher has gone."""


class Forget(NamedTuple):
    """This publisher needs no dialogue any more."""


class Tell(NamedTuple):
    """Log something about the publisher.

    Attributes:
        is_error: it is an error, else a warning.
        text, args: what it is, as for the log.
    """

    is_error: bool
    text: str
    args: tuple[str, ...]


class TellHost(NamedTuple):
    """Say that the publisher's host is not known here."""

    error: UnknownHostError


Action = Ask | Connect | Greet | Link | LinkDatagrams | Rest | Drop | EndDatagrams | Forget | Tell | TellHost

_SILENT = "no messages of %s from the publisher at %s yet: it does not answer. Is it stopped, or out of reach?"


class Dialogue:
    """The dialogue with one publisher.

    Args:
        topic: full name.
        uri: the publisher's slave API.
        wanted: returns the type that the subscription wants, which may become narrower.
        takes_tcp: the subscription takes messages over TCP.

    Attributes:
        state: see the module.
        listed: whether the master lists the publisher.
    """

    def __init__(self, topic: str, uri: str, wanted: Callable[[], TopicType], *, takes_tcp: bool = True) -> None:
        self.state = State.GONE
        self.listed = False
        self._topic = topic
        self._uri = uri
        self._wanted = wanted
        self._takes_tcp = takes_tcp
        self._datagrams = False  # the link is one of datagrams
        self._again = False  # announced anew while an attempt was under way, whose answer may be that of the old one
        self._told = ""  # why it refused us
        self._named = False  # in the log, as one that does not answer
        self._rest = FIRST_REST
        self._header = HeaderReader()

    # From the master --------------------------------------------------------------------------------------------------

    def announced(self) -> list[Action]:
        """The master lists the publisher, again or for the first time."""
        # Notices of a publisher that left and one that came may have become one.
        self._again = self.state in UNDER_WAY
        self.listed = True
        if self.state in UNDER_WAY or self.state is State.LINKED:
            return []
        self._told = ""
        self._named = False
        self._rest = FIRST_REST
        return self._ask()

    def vanished(self) -> list[Action]:
        """The master no longer lists the publisher."""
        self.listed = False
        if self.state in UNDER_WAY:
            return []
        if self.state is State.LINKED:  # no datagram says that the publisher has gone
            return [EndDatagrams()] if self._datagrams else []
        self.state = State.GONE
        return [Drop(), Forget()]

    def stop(self) -> list[Action]:
        """Nobody subscribes any more. A link is not touched."""
        self.listed = False
        self.state = State.GONE
        return [Drop()]

    # From the driver --------------------------------------------------------------------------------------------------

    def rested(self) -> list[Action]:
        """The rest is over."""
        return self._ask()

    def linked(self) -> list[Action]:
        """The publisher is in this process, and linked."""
        self._succeed()
        return []

    def answered(self, value: Any, *, offered: bool = False) -> list[Action]:
        """The publisher's node has answered ``requestTopic``.

        Args:
            value: the answer.
            offered: whether a socket for datagrams was offered.
        """
        match value:
            case [1, str(), ["UDPROS", *_] as answer] if offered:
                return self._link_datagrams(answer)
            case [0, str(reason), _] if not self._takes_tcp:
                return self.refused(f"{self._uri} does not send {self._topic} in datagrams: {reason}")
            case [1, str(), ["TCPROS", str(host), int(port), *_]] if 0 < port < 65536:
                self.state = State.CONNECTING
                return [Connect(host, port)]
        return self._retry()  # it is not a publisher (yet, or any more), or talks nonsense

    def connected(self) -> list[Action]:
        """The connection is open."""
        self.state = State.GREETING
        self._header = HeaderReader()
        return [Greet()]

    def received(self, data: bytes) -> list[Action]:
        """Bytes have come on the connection; none at its end."""
        if not data:
            return self._retry()
        try:
            header = self._header.feed(data)
            if header is None:
                return []
            check_publisher_answer(header, self._topic, self._wanted(), self._uri)
        except (ConnectionRefusedByPeerError, ProtocolError) as refusal:
            return self.refused(str(refusal))
        self._succeed()
        return [Link(header, self._header.rest)]

    def failed(self, error: Exception | None = None) -> list[Action]:
        """The publisher could not be asked or reached, or was silent for too long: that may change."""
        if isinstance(error, UnknownHostError) and self.listed:
            return [TellHost(error), *self._retry()]
        return self._retry()

    def refused(self, reason: str) -> list[Action]:
        """The publisher does not want us, or is none for us."""
        told: list[Action] = []
        if self.listed and reason != self._told:
            self._told = reason
            told = [Tell(True, "%s", (reason,))]
        if self._again or not self.listed:
            return told + self._retry()
        self.state = State.REFUSED
        return [*told, Drop()]

    def silent(self) -> list[Action]:
        """There is no link after a while. That is said once, until there is one: a process that was stopped, or a host
        that cannot be reached, would leave the subscriber waiting without a word."""
        self._named = True
        return [Tell(False, _SILENT, (self._topic, self._uri))]

    def lost(self, reason: str | None) -> list[Action]:
        """The link has ended; without a reason if it was the publisher's will."""
        self._rest = FIRST_REST
        if reason is None:
            return self._retry()
        return [Tell(False, "lost %s from %s: %s", (self._topic, self._uri, reason)), *self._retry()]

    # ------------------------------------------------------------------------------------------------------------------

    def _ask(self) -> list[Action]:
        self._again = False
        self.state = State.ASKING
        return [Drop(), Ask(watched=not self._named)]

    def _link_datagrams(self, answer: list[Any]) -> list[Action]:
        from pyros1.wire.datagram import read_answer  # noqa: PLC0415 - few nodes need it

        try:
            found = read_answer(answer)
            if found is None:
                return self._retry()
            check_publisher_answer(found[0], self._topic, self._wanted(), self._uri)
        except (ConnectionRefusedByPeerError, ProtocolError) as refusal:
            return self.refused(str(refusal))
        self._succeed(datagrams=True)
        return [LinkDatagrams(*found)]

    def _succeed(self, *, datagrams: bool = False) -> None:
        self.state = State.LINKED
        self._datagrams = datagrams
        self._named = False
        self._rest = FIRST_REST

    def _retry(self) -> list[Action]:
        if not self.listed:
            self.state = State.GONE
            return [Drop(), Forget()]
        self.state = State.RESTING
        seconds, self._rest = self._rest, min(2 * self._rest, LONGEST_REST)
        return [Drop(), Rest(seconds)]
