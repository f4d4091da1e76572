"""The link over eclipse-zenoh (https://zenoh.io), whose library does routing, encryption and reconnecting.

A site that listens is a router, so that sites that only dial out, such as those behind NAT, reach each other through
it. A site that only dials one other is a client, which costs least; one that dials several is a router too, since a
client has only one connection. Sites find each other only through the endpoints that they are given: multicast and
gossip are off.

zenoh's callbacks run on its own threads, so they must return at once.

Packets must never wait for a site that has stopped reading, neither here nor in a router on the way, where they would
hold up all packets from the same site. So they are dropped when a connection's queue is full, and sites resend those
that must not be lost. zenoh's alternative, to wait and then to close the connection, has another flaw: if two threads
wait, the second one closes the new connection, and the site is cut off for good (seen with zenoh 1.10.2).
"""

from __future__ import annotations

import json
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from pyros1.bridge.exchange.actions import Send
from pyros1.bridge.protocol.key_expressions import ROOT, parse_key, site_key
from pyros1.bridge.rules.rules import Priority
from pyros1.bridge.transport.connections import Connection, session_connections
from pyros1.bridge.transport.failures import explain_dialling, explain_listening
from pyros1.bridge.transport.link import Receive
from pyros1.ground.errors import Error

if TYPE_CHECKING:
    import zenoh

MAX_PACKET = 64 << 20
"""Maximum size of a packet in bytes; zenoh refuses larger ones before it has received them."""
_QUEUE = "transport/link/tx/queue"
_BATCHES = 16
"""Maximum number of 64 kB batches of waiting packets, for each connection and priority. zenoh packs waiting packets
into as few batches as possible, so this is enough for long lists, and for packets that arrive during a pause.
"""
_QUEUED_PRIORITIES = ("real_time", "interactive_high", "data", "data_low", "background")
_FRAGMENTS_TIME = 2_000_000
"""Maximum microseconds that the rest of a large packet waits for the network before the packet is dropped."""
_SEND_BUFFER = 256 << 10
"""Bytes that the operating system queues for a connection. By default, it queues megabytes: half a minute on a slow
network, in which commands cannot overtake images, nor new images replace old ones. This is enough for 20 Mbit/s at 100
ms.
"""
_MAX_PUBLISHERS = 10_000
_DIAL_PERIOD = 1
"""Seconds between attempts to reach the first site."""
_DIAL_TIME = 8
"""Seconds that an attempt may take: it needs about five round trips, and lost packets are resent after a second."""
CLOSE_TIME = 5.0
"""Seconds to wait for zenoh to close its connections."""


class LinkError(Error):
    """zenoh is not installed, or cannot start."""


def check_installed() -> None:
    """Raise LinkError if eclipse-zenoh is not installed."""
    if find_spec("zenoh") is None:
        raise LinkError("bridges need eclipse-zenoh, which is not installed here: pip install 'pyros1[bridge]'")


class ZenohSession:
    """Base class of zenoh sessions; a session opens as soon as the other side can be reached.

    Args:
        name: the bridge's name, for threads.
        connect, listen: endpoints, as for `pyros1.bridge.transport.endpoints.check_endpoint`.
        settings: further zenoh settings, each as JSON, by path, such as ``transport/link/tls/root_ca_certificate``.

    Raises:
        LinkError: eclipse-zenoh is not installed, cannot listen, or rejects a setting.

    Attributes:
        problem: why there is no connection, if known; empty if there is one.
        is_closing: whether the session is closed or closing.
        zenoh: the module.
        session: zenoh's session; None until there is one.
        lock: guards the session's declarations.
        priorities: zenoh's priorities, by ours.
    """

    def __init__(
        self, name: str, connect: Sequence[str] = (), listen: Sequence[str] = (), settings: Mapping[str, str] = {}
    ) -> None:
        check_installed()
        import zenoh  # noqa: PLC0415 - large, and only needed to run a bridge

        self.zenoh = zenoh
        self.problem = ""
        self.is_closing = False
        self.session: Any = None
        self.lock = threading.Lock()
        priority = zenoh.Priority
        self.priorities = {
            Priority.URGENT: priority.REAL_TIME,
            Priority.HIGH: priority.INTERACTIVE_HIGH,
            Priority.NORMAL: priority.DATA,
            Priority.LOW: priority.DATA_LOW,
            Priority.BACKGROUND: priority.BACKGROUND,
        }
        self._name = name
        self._closing = threading.Event()
        is_client = len(connect) == 1 and not listen
        config = make_config(zenoh, "client" if is_client else "router", connect, listen, settings)
        if not is_client:
            try:
                self._open(config)
            except zenoh.ZError as error:
                raise LinkError(f"cannot start the bridge's network: {explain_listening(error, listen)}") from error
        else:
            # A client's session can be opened only while its router can be reached.
            threading.Thread(
                target=self._open_client, args=(config, connect[0]), name="bridge: dial", daemon=True
            ).start()

    def on_open(self) -> None:
        """Make declarations in the new session. Called with the lock held."""

    def on_close(self) -> None:
        """Wake the threads that are waiting for responses. Called with the lock held."""

    def _open(self, config: Any) -> None:
        session: Any = self.zenoh.open(config)
        try:
            with self.lock:
                if not self.is_closing:
                    self.session = session
                    self.on_open()
        except BaseException:
            self.session = None
            raise
        finally:
            if self.session is None:  # `on_open` failed, so nobody else closes the session
                session.close()
        self.problem = ""

    def _open_client(self, config: Any, endpoint: str) -> None:
        while not self.is_closing:
            try:
                self._open(config)
            except self.zenoh.ZError as error:
                self.problem = explain_dialling(error, endpoint)
                self._closing.wait(_DIAL_PERIOD)
            else:
                return

    def connections(self) -> list[Connection]:
        """Return the current connections; none if this version of zenoh cannot tell."""
        session = self.session
        try:
            return [] if session is None or self.is_closing else session_connections(session)
        except self.zenoh.ZError:  # the session is closing
            return []

    def close(self) -> None:
        """Close the connections. This takes at most `CLOSE_TIME`; zenoh's own close may wait for a hung peer."""
        self.is_closing = True
        self._closing.set()
        with self.lock:
            self.on_close()
        closer = threading.Thread(target=self._close_session, name=f"close link of {self._name}", daemon=True)
        closer.start()
        closer.join(CLOSE_TIME)

    def _close_session(self) -> None:
        # Do not wait for a session to open, since dialling takes long: one that opens now is closed again.
        if self.session is not None:
            self.session.close()


class ZenohLink(ZenohSession):
    """A link over zenoh; see `pyros1.bridge.transport.link.Link`.

    Args:
        site: this site's name.
        receive: called with the packets for it, on zenoh's threads.
        connect, listen, settings: see `ZenohSession`.

    Raises:
        LinkError: eclipse-zenoh is not installed, cannot listen, or rejects a setting.
    """

    def __init__(
        self,
        site: str,
        receive: Receive,
        connect: Sequence[str] = (),
        listen: Sequence[str] = (),
        settings: Mapping[str, str] = {},
    ) -> None:
        self._site = site
        self._receive = receive
        self._publishers: dict[tuple[str, Priority], Any] = {}
        self._topics: dict[tuple[str, str], Any] = {}
        self._fixed: list[Any] = []
        self._is_client = len(connect) == 1 and not listen
        self._may_forward = not self._is_client
        super().__init__(site, connect, listen, settings)

    def on_open(self) -> None:
        """Subscribe to this site's packets and the requested topics. Called with the lock held."""
        own = ("hello", f"to/{self._site}", f"again/{self._site}/**", f"call/{self._site}/**")
        keys = [f"{ROOT}/*/{key}" for key in own]
        self._fixed = [self._subscribe(key) for key in keys]
        self._topics = {topic: self._subscribe(site_key(*topic)) for topic in self._topics}

    def _subscribe(self, key: str) -> Any:
        locality = self.zenoh.Locality.REMOTE
        return self.session.declare_subscriber(key, self._on_sample, allowed_origin=locality)

    def _on_sample(self, sample: zenoh.Sample) -> None:
        """Hand over a sample. Called on zenoh's threads."""
        key, attachment = parse_key(str(sample.key_expr)), sample.attachment
        if key is not None and attachment is not None and len(attachment) < 100 and len(sample.payload) <= MAX_PACKET:
            self._receive(key, attachment.to_bytes(), sample.payload.to_bytes())

    def send(self, packet: Send) -> None:
        """Send a packet. It is lost where a connection's queue is full, and before the first connection. This waits for
        the network only in the middle of a large packet, for at most `_FRAGMENTS_TIME`.
        """
        publisher = self._publisher(packet.key, packet.priority)
        if publisher is not None:
            publisher.put(packet.body, attachment=packet.head)

    def connections(self) -> list[Connection]:
        """See `ZenohSession`. Must be called about once per second, so that `try_send` knows the connections."""
        found = super().connections()
        self._may_forward = not self._is_client and len(found) != 1  # zero may mean that this version cannot tell
        return found

    def try_send(self, packet: Send) -> bool:
        """Send a packet that fits into the queue, unless its key must first be declared. If a connection's queue is
        full, zenoh waits a millisecond before it drops the packet; but if it is forwarding a large packet of the same
        priority from one connection to another, it waits until that is sent. So where it may forward, only urgent
        packets are sent at once.
        """
        if self._may_forward and packet.priority > Priority.HIGH:
            return False
        publisher = self._publishers.get((packet.key, packet.priority))  # without the lock, which may be held for long
        if publisher is None or self.is_closing:
            return False
        publisher.put(packet.body, attachment=packet.head)
        return True

    def _publisher(self, key: str, priority: Priority) -> Any:
        with self.lock:
            found = self._publishers.get((key, priority))
            if found is None and self.session is not None and not self.is_closing:
                if len(self._publishers) >= _MAX_PUBLISHERS:
                    self._publishers.pop(next(iter(self._publishers))).undeclare()
                found = self._publishers[key, priority] = self.session.declare_publisher(
                    site_key(self._site, key),
                    congestion_control=self.zenoh.CongestionControl.DROP,
                    priority=self.priorities[priority],
                    allowed_destination=self.zenoh.Locality.REMOTE,
                )
            return found

    def listen(self, site: str, key: str, on: bool) -> None:
        """Receive what another site sends on a key, or stop."""
        with self.lock:
            topic = (site, key)
            if on and topic not in self._topics:
                self._topics[topic] = None if self.session is None else self._subscribe(site_key(site, key))
            elif not on and (known := self._topics.pop(topic, None)) is not None:
                known.undeclare()


def make_config(
    zenoh: Any, mode: str, connect: Sequence[str], listen: Sequence[str], settings: Mapping[str, str]
) -> Any:
    """Return zenoh's configuration for a ``client`` or ``router``."""
    is_client = mode == "client"
    config = zenoh.Config()
    values: dict[str, Any] = {
        "mode": mode,
        "connect/endpoints": [*connect],
        "connect/timeout_ms": 1000 * _DIAL_TIME if is_client else -1,  # the other site may start later
        "connect/exit_on_failure": is_client,
        "connect/retry": {"period_init_ms": 500, "period_max_ms": 4000, "period_increase_factor": 2},
        "listen/endpoints": [*listen],
        "listen/timeout_ms": 0,
        "listen/exit_on_failure": True,
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,  # otherwise sites connect to addresses that they were not given
        "scouting/delay": 0,  # milliseconds that a router waits for scouting, even if that is off
        **{f"{_QUEUE}/size/{priority}": _BATCHES for priority in _QUEUED_PRIORITIES},
        f"{_QUEUE}/congestion_control/drop/max_wait_before_drop_fragments": _FRAGMENTS_TIME,
        "transport/link/rx/max_message_size": MAX_PACKET + (1 << 16),
        "transport/shared_memory/enabled": False,  # it would bypass the links' limits
    }
    for path, value in values.items():
        config.insert_json5(path, json.dumps(value))
    for protocol in ("tcp", "tls"):
        with suppress(zenoh.ZError):  # versions before 1.3 cannot set it
            config.insert_json5(f"transport/link/{protocol}/so_sndbuf", str(_SEND_BUFFER))
    for path, text in settings.items():
        config.insert_json5(path, text)
    return config
