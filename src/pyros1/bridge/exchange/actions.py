"""The actions that the state machine returns: plain values, to be carried out in order."""

from __future__ import annotations

from typing import NamedTuple

from pyros1.bridge.conversions.conversion import Conversion
from pyros1.bridge.names import SharedName
from pyros1.bridge.protocol.calls import CallId, Status
from pyros1.bridge.rules.rules import Priority


class Send(NamedTuple):
    """Send a packet.

    Attributes:
        key: below this site's prefix, see `pyros1.bridge.protocol.key_expressions`.
        head, body: the packet.
        priority: packets of higher priority are sent first.
        replaces: this packet replaces a waiting one with the same key, priority and `replaces`; None: it replaces
            nothing.
        may_drop: whether a newer packet replaces a waiting one only while the network is slow; if false, always.
        expires: time by the site's clock after which the packet is useless; None: never.
    """

    key: str
    head: bytes
    body: bytes = b""
    priority: Priority = Priority.HIGH
    replaces: int | None = None
    may_drop: bool = False
    expires: float | None = None


class Listen(NamedTuple):
    """Receive what another site sends on a key, or stop if `on` is false."""

    site: str
    key: str
    on: bool


class Subscribe(NamedTuple):
    """Subscribe to a topic of this site's master, or stop if `on` is false.

    Attributes:
        conversion: how its messages are converted; None if they are not.
    """

    local: str
    on: bool
    conversion: Conversion | None = None


class RestartConversion(NamedTuple):
    """Make the next converted message of a topic decodable without earlier ones: another site has just requested it."""

    local: str
    conversion: Conversion


class Advertise(NamedTuple):
    """Publish a topic on this site's master, although there are no messages yet. If it is already published, only
    whether it is latched changes.

    Attributes:
        local: its name.
        type, md5sum, definition: its message type.
        latched: whether it has latched messages.
        origins: the original publishers, such as ``red:/driver``.
    """

    local: str
    type: str
    md5sum: str
    definition: str
    latched: bool
    origins: tuple[str, ...] = ()


class SetOrigins(NamedTuple):
    """Record the new original publishers of a topic that is already published."""

    local: str
    origins: tuple[str, ...]


class Withdraw(NamedTuple):
    """Stop publishing a topic."""

    local: str


class Source(NamedTuple):
    """The origin of messages: a publisher at another site.

    Attributes:
        site: the site that sends them.
        topic: the topic's name between sites: several topics of a site may have the same local name.
        publisher: the original publisher's number in the topic.
    """

    site: str
    topic: SharedName
    publisher: int


class Publish(NamedTuple):
    """Publish a message.

    Attributes:
        local: the topic.
        source: the original publisher.
        body: the encoded message.
        latched: whether it is kept for later subscribers, as its source's last message.
        expires: time by the site's clock after which it is too old to be published; None: never.
    """

    local: str
    source: Source
    body: bytes
    latched: bool
    expires: float | None = None


class Forget(NamedTuple):
    """Discard a source's last message, since its publisher is gone."""

    local: str
    source: Source


class Provide(NamedTuple):
    """Provide a service of another site on this site's master."""

    local: str
    type: str
    md5sum: str
    request: str
    response: str


class StopProviding(NamedTuple):
    """Stop providing a service."""

    local: str


class CallService(NamedTuple):
    """Call a service of this site's master for another site, and give the result to `Site.on_result`.

    Attributes:
        call: the call.
        local: the service's name.
        body: the encoded request.
        timeout: maximum number of seconds.
    """

    call: CallId
    local: str
    body: bytes
    timeout: float


class Return(NamedTuple):
    """Deliver a result to the caller on this site.

    Attributes:
        token: the token given to `Site.call`.
        status: whether the call has succeeded.
        body: the encoded response, or the text of the error.
    """

    token: int
    status: Status
    body: bytes


class RepresentNode(NamedTuple):
    """Represent a node of another site by a local node, as long as it responds.

    Attributes:
        local: the name of the local node.
        site, node: the other site, and the node's name there; empty once it is no longer represented.
    """

    local: str
    site: str
    node: str


class Probe(NamedTuple):
    """A probe to send to a site, see `pyros1.bridge.transport.pacer`.

    Attributes:
        site: the site.
        round_trip: the shortest of the last heartbeats' round trips, in seconds.
        packet: the probe.
    """

    site: str
    round_trip: float
    packet: Send


class ProbeReply(NamedTuple):
    """A site has answered a probe, see `pyros1.bridge.transport.pacer`."""

    site: str
    number: int


class Log(NamedTuple):
    """Log a message, which may contain text from other sites."""

    text: str
    is_warning: bool = False


ServiceAction = Provide | StopProviding | CallService | Return
TopicAction = Listen | Subscribe | RestartConversion | Advertise | SetOrigins | Withdraw | Publish | Forget
Action = Send | TopicAction | RepresentNode | ServiceAction | ProbeReply | Log
