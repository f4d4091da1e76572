"""The zenoh session of a bridge in the dialect of zenoh-plugin-ros1.

zenoh's callbacks run on its own threads, so they must return at once.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from pyros1.bridge.exchange.actions import Send
from pyros1.bridge.plugin_ros1.keys import BEACON_ROOT
from pyros1.bridge.rules.rules import Priority
from pyros1.bridge.transport.zenoh_link import MAX_PACKET, ZenohSession
from pyros1.ground.errors import Error, ServiceRefusal
from pyros1.ground.terminal_text import one_line

if TYPE_CHECKING:
    import zenoh

CALL_TIME = 60.0
"""Seconds to wait for a service's response."""
_MAX_ERROR = 1000


class DeclarationError(Error):
    """zenoh refuses a key."""


class FirstReply:
    """The first reply to a call; later ones are ignored."""

    def __init__(self) -> None:
        self._reply: Any = None
        self._ended = threading.Event()
        self._lock = threading.Lock()

    def put(self, reply: Any) -> None:
        """Handle a reply, or None, which means that there are no more."""
        with self._lock:
            if not self._ended.is_set():
                self._reply = reply
                self._ended.set()

    def get(self, timeout: float) -> Any:
        """Wait for a reply, and return it; None if there is none within `timeout` seconds."""
        self._ended.wait(timeout)
        with self._lock:
            self._ended.set()
            reply, self._reply = self._reply, None
        return reply


class PluginSession(ZenohSession):
    """A zenoh session; see `pyros1.bridge.transport.link.Link` for the methods that the sender uses.

    Args:
        on_beacon: called with the key of each beacon, on zenoh's threads.
        on_message: called with the key and body of each message on a subscribed key, on zenoh's threads.
        on_call: called with the key of a service and a query, on zenoh's threads.
        beacons: the key expressions of beacons.
        connect, listen, settings: see `pyros1.bridge.transport.zenoh_link.ZenohSession`.

    Raises:
        LinkError: eclipse-zenoh is not installed, cannot listen, or rejects a setting.
    """

    def __init__(
        self,
        on_beacon: Callable[[str], object],
        on_message: Callable[[str, bytes], object],
        on_call: Callable[[str, Any], object],
        beacons: Iterable[str],
        connect: Sequence[str] = (),
        listen: Sequence[str] = (),
        settings: Mapping[str, str] = {},
    ) -> None:
        self._on_beacon = on_beacon
        self._on_message = on_message
        self._on_call = on_call
        self._beacons = [*beacons]
        self._publishers: dict[str, Any] = {}
        self._subscribers: dict[str, Any] = {}
        self._services: dict[str, Any] = {}
        self._calls: set[FirstReply] = set()
        self._fixed: list[Any] = []
        super().__init__("zenoh-bridge-ros1", connect, listen, settings)

    def on_open(self) -> None:
        """Subscribe to beacons; this subscription never changes. Called with the lock held."""
        self._fixed = [
            self.session.declare_subscriber(key, self._on_beacon_sample, allowed_origin=self.zenoh.Locality.REMOTE)
            for key in self._beacons
        ]

    def _on_beacon_sample(self, sample: zenoh.Sample) -> None:
        self._on_beacon(str(sample.key_expr))

    # Declarations -----------------------------------------------------------------------------------------------------

    def declare(
        self, publishers: Mapping[str, Priority], subscribers: Collection[str], services: Collection[str]
    ) -> None:
        """Declare exactly these keys from now on; does nothing before there is a connection.

        Args:
            publishers: the keys of topics to send, and the priorities of their messages.
            subscribers: the keys of topics to receive.
            services: the keys of services that can be called here.

        Raises:
            DeclarationError: zenoh refuses one of them.
        """
        with self.lock:
            if self.session is None or self.is_closing:
                return
            try:
                _adjust(self._publishers, publishers, partial(self._publish, publishers))
                _adjust(self._subscribers, subscribers, self._subscribe)
                _adjust(self._services, services, self._serve)
            except self.zenoh.ZError as error:
                raise DeclarationError(f"zenoh refuses a topic: {one_line(error, 200)}") from error

    def _publish(self, publishers: Mapping[str, Priority], key: str) -> Any:
        return self.session.declare_publisher(
            key,
            congestion_control=self.zenoh.CongestionControl.DROP,
            priority=self.priorities[publishers[key]],
            allowed_destination=self.zenoh.Locality.REMOTE,
        )

    def _subscribe(self, key: str) -> Any:
        return self.session.declare_subscriber(
            key, partial(self._on_sample, key), allowed_origin=self.zenoh.Locality.REMOTE
        )

    def _on_sample(self, key: str, sample: zenoh.Sample) -> None:
        # Keys with wildcards match each other, so several subscribers may get a message: only one handles it.
        is_put = sample.kind == self.zenoh.SampleKind.PUT
        if is_put and str(sample.key_expr) == key and len(sample.payload) <= MAX_PACKET:
            self._on_message(key, sample.payload.to_bytes())

    def _serve(self, key: str) -> Any:
        return self.session.declare_queryable(
            key, partial(self._on_call, key), allowed_origin=self.zenoh.Locality.REMOTE
        )

    def keys_with_receivers(self) -> set[str]:
        """Return the keys of the topics to send that have receivers."""
        with self.lock:
            if self.is_closing:
                return set()
            return {key for key, publisher in self._publishers.items() if publisher.matching_status.matching}

    # Messages ---------------------------------------------------------------------------------------------------------

    def send(self, packet: Send) -> None:
        """Send a message or a beacon. If the network is congested, this waits a short time, and then drops it."""
        if packet.key.startswith(BEACON_ROOT):
            if self.session is not None:
                self.session.put(
                    packet.key,
                    b"",
                    congestion_control=self.zenoh.CongestionControl.DROP,
                    priority=self.priorities[packet.priority],
                    allowed_destination=self.zenoh.Locality.REMOTE,
                )
        elif (publisher := self._publishers.get(packet.key)) is not None:
            publisher.put(packet.body)

    def try_send(self, packet: Send) -> bool:
        """Return False without sending, since sending may block."""
        return False

    def listen(self, site: str, key: str, on: bool) -> None:
        """Do nothing: `declare` sets what to receive."""

    def call(self, key: str, request: bytes) -> bytes:
        """Call a service elsewhere, and return the response, or the error text that bridges send in its place.

        Raises:
            ServiceRefusal: there was no response, or an error reply.
        """
        replies = FirstReply()
        with self.lock:
            if self.session is None or self.is_closing:
                raise ServiceRefusal("the bridge has no connection")
            self._calls.add(replies)
        try:
            self.session.get(
                key,
                self.zenoh.handlers.Callback(replies.put, partial(replies.put, None)),
                payload=request,
                timeout=CALL_TIME,
                congestion_control=self.zenoh.CongestionControl.DROP,  # also applies to the response
                consolidation=self.zenoh.ConsolidationMode.NONE,  # the first reply counts, as for the plugin
                allowed_destination=self.zenoh.Locality.REMOTE,
            )
            reply = replies.get(CALL_TIME + 1)
        except self.zenoh.ZError as error:
            raise ServiceRefusal(f"the bridge cannot call it: {one_line(error, 200)}") from error
        finally:
            with self.lock:
                self._calls.discard(replies)
        if reply is None:
            raise ServiceRefusal("the bridge of the service does not respond, or the call took too long")
        if reply.ok is None:
            text = reply.err.payload.to_bytes()[:_MAX_ERROR].decode("utf-8", "replace")
            raise ServiceRefusal(one_line(text, _MAX_ERROR))
        return bytes(reply.ok.payload.to_bytes())

    def on_close(self) -> None:
        """End the pending calls. Called with the lock held."""
        for replies in self._calls:
            replies.put(None)


def _adjust(declared: dict[str, Any], keys: Collection[str], declare: Callable[[str], Any]) -> None:
    """Declare what is missing, and undeclare what is not among the keys."""
    for key in declared.keys() - {*keys}:
        declared.pop(key).undeclare()
    for key in keys:
        if key not in declared:
            declared[key] = declare(key)
