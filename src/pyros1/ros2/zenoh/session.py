"""The zenoh session of a bridge: a ROS 2 node with publishers, subscribers and services, as rmw_zenoh would make it.

Callbacks run on zenoh's own threads, so they must return at once.
"""

from __future__ import annotations

import json
import secrets
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from itertools import count
from typing import TYPE_CHECKING, Any, TypeVar

from pyros1.bridge.exchange.actions import Send
from pyros1.bridge.plugin_ros1.session import FirstReply
from pyros1.bridge.rules.rules import Priority
from pyros1.bridge.transport.zenoh_link import MAX_PACKET, ZenohSession
from pyros1.ground.errors import Error, ServiceRefusal
from pyros1.ground.terminal_text import one_line
from pyros1.ros2.zenoh.attachments import Attachment, encode_attachment
from pyros1.ros2.zenoh.calls import IncomingCall, LaterReply, response_of
from pyros1.ros2.zenoh.names import DataKey, data_key
from pyros1.ros2.zenoh.qos import Qos
from pyros1.ros2.zenoh.tokens import Entity, Kind, encode_token, gid, tokens_of

if TYPE_CHECKING:
    import zenoh

_HEARTBEAT = 0.5
"""Seconds between a latched publisher's heartbeats, by which subscribers notice missed messages."""
_SERVICE_QOS = Qos()
"""The default QoS of services in ROS 2."""
_Published = tuple[DataKey, Qos, Priority]
_Name = TypeVar("_Name", str, DataKey)
_How = TypeVar("_How")


def make_zid() -> str:
    """Return a new id for a zenoh session, which must not begin with a zero."""
    return "a" + secrets.token_hex(15) + "a"


class _Endpoint:
    """A publisher, subscriber or service with its liveliness token; a client consists only of its token."""

    def __init__(self, declared: Any, session: Any, token: str) -> None:
        self.declared = declared
        self._gid = gid(token)
        try:
            self._token = session.liveliness().declare_token(token)
        except Exception:  # any error from zenoh
            if declared is not None:
                declared.undeclare()
            raise
        self._numbers = count(1)

    def attachment(self) -> bytes:
        """Return the attachment of the next message."""
        return encode_attachment(Attachment(next(self._numbers), time.time_ns(), self._gid))

    def undeclare(self) -> None:
        """Remove the endpoint from the network."""
        self._token.undeclare()
        if self.declared is not None:
            self.declared.undeclare()


class Ros2Session(ZenohSession):
    """A zenoh session; see `pyros1.bridge.transport.link.Link` for the part that the sender uses.

    Args:
        zid: its id in zenoh.
        node: the name of its node in ROS 2.
        domain: the ROS domain.
        on_token: called with the key of each ROS 2 entity, and whether it exists or is gone, on zenoh's threads.
        on_message: called with the key, encoded message and attachment of each message, and the id of its publisher's
            session (empty if zenoh does not provide it), on zenoh's threads.
        on_call: called with each call of an offered service, on zenoh's threads.
        connect, listen, settings: see `pyros1.bridge.transport.zenoh_link.ZenohSession`.

    Raises:
        LinkError: eclipse-zenoh is not installed, cannot listen, or rejects a setting.
    """

    way = "zenoh"

    def __init__(
        self,
        zid: str,
        node: str,
        domain: int,
        on_token: Callable[[str, bool], object],
        on_message: Callable[[DataKey, bytes, bytes, str], object],
        on_call: Callable[[IncomingCall], object],
        connect: Sequence[str] = (),
        listen: Sequence[str] = (),
        settings: Mapping[str, str] = {},
    ) -> None:
        self._zid = zid
        self._node = node
        self._domain = domain
        self._on_token = on_token
        self._on_message = on_message
        self._on_call = on_call
        self._publishers: dict[tuple[str, _Published], _Endpoint] = {}
        self._subscribers: dict[tuple[DataKey, Qos], _Endpoint] = {}
        self._services: dict[tuple[DataKey, None], _Endpoint] = {}
        self._clients: dict[tuple[DataKey, None], _Endpoint] = {}
        self._calls: set[FirstReply | LaterReply] = set()
        self._by_key: dict[str, _Endpoint] = {}
        self._entity_ids = count(1)
        self._connect = [*connect]
        self._fixed: list[Any] = []
        super().__init__("ROS 2", connect, listen, {"timestamping/enabled": "true", "id": json.dumps(zid), **settings})

    def on_open(self) -> None:
        """Declare the node, and subscribe to all tokens. Called with the lock held."""
        others = self.session.liveliness().declare_subscriber(
            tokens_of(self._domain), self._on_liveliness, history=True
        )
        self._fixed = [self._declare_node(), others]

    def _declare_node(self) -> Any:
        node = Entity(self._domain, self._zid, 0, 0, Kind.NODE, self._node)
        return self.session.liveliness().declare_token(encode_token(node))

    def rename(self, node: str) -> None:
        """See `pyros1.ros2.bridge.side.Ros2Side.rename`."""
        with self.lock:
            self._node = node
            if self.session is None or self.is_closing:
                return
            self._by_key = {}
            all_declared: tuple[dict[Any, _Endpoint], ...] = (
                self._publishers,
                self._subscribers,
                self._services,
                self._clients,
            )
            for declared in all_declared:
                for endpoint in declared.values():
                    endpoint.undeclare()
                declared.clear()
            self._fixed[0].undeclare()
            self._fixed[0] = self._declare_node()

    def look_for_routers(self) -> None:
        """Record in `problem` if this session has no connection to a router, since zenoh does not report a lost router:
        it just keeps trying to reconnect.
        """
        session = self.session
        if session is not None and self._connect and not self.is_closing:
            with suppress(self.zenoh.ZError):  # the session is closing
                is_there = bool(session.info.routers_zid())
                self.problem = "" if is_there else f"no router responds at {' or '.join(self._connect)}"

    def _token(self, kind: Kind, key: DataKey, qos: Qos) -> str:
        number = next(self._entity_ids)
        entity = Entity(
            self._domain, self._zid, 0, number, kind, self._node, topic=key.name, type=key.type, hash=key.hash, qos=qos
        )
        return encode_token(entity)

    def _on_liveliness(self, sample: zenoh.Sample) -> None:
        self._on_token(str(sample.key_expr), bool(sample.kind == self.zenoh.SampleKind.PUT))

    # Declarations -----------------------------------------------------------------------------------------------------

    def declare(
        self,
        publishers: Mapping[str, _Published],
        subscribers: Mapping[DataKey, Qos],
        services: Iterable[DataKey] = (),
        clients: Iterable[DataKey] = (),
    ) -> dict[str, str]:
        """See `pyros1.ros2.bridge.side.Ros2Side.declare`."""
        refused: dict[str, str] = {}
        with self.lock:
            if self.session is None or self.is_closing:
                return refused
            self._adjust(self._publishers, publishers, self._publish, refused)
            self._adjust(self._subscribers, subscribers, self._subscribe, refused)
            self._adjust(self._services, dict.fromkeys(services), self._offer, refused)
            self._adjust(self._clients, dict.fromkeys(clients), self._make_client, refused)
            self._by_key = {route: endpoint for (route, _), endpoint in self._publishers.items()}
        return refused

    def _adjust(
        self,
        declared: dict[tuple[_Name, _How], _Endpoint],
        wanted: Mapping[_Name, _How],
        declare: Callable[[_Name, _How], _Endpoint],
        refused: dict[str, str],
    ) -> None:
        """Declare what is missing, and undeclare what is no longer needed; add what zenoh refuses to `refused`."""
        for each in declared.keys() - {*wanted.items()}:
            with self._collect_refusals(each, refused):
                declared.pop(each).undeclare()
        for each in wanted.items():
            if each not in declared:
                with self._collect_refusals(each, refused):
                    declared[each] = declare(*each)

    @contextmanager
    def _collect_refusals(self, each: tuple[Any, Any], refused: dict[str, str]) -> Iterator[None]:
        try:
            yield
        except (self.zenoh.ZError, Error) as error:
            name, how = each
            key: DataKey = name if isinstance(name, DataKey) else how[0]
            refused[key.name] = f"zenoh refuses it: {one_line(error, 200)}"

    def _publish(self, _route: str, how: _Published) -> _Endpoint:
        key, qos, priority = how[0], how[1], self.priorities[how[2]]
        remote, drop = self.zenoh.Locality.REMOTE, self.zenoh.CongestionControl.DROP
        if qos.transient_local:
            ext = self.zenoh.ext
            declared = ext.declare_advanced_publisher(
                self.session,
                data_key(key),
                congestion_control=drop,
                priority=priority,
                allowed_destination=remote,
                cache=ext.CacheConfig(qos.depth),
                publisher_detection=True,
                sample_miss_detection=ext.MissDetectionConfig(sporadic_heartbeat=_HEARTBEAT),
            )
        else:
            declared = self.session.declare_publisher(
                data_key(key), congestion_control=drop, priority=priority, allowed_destination=remote
            )
        return _Endpoint(declared, self.session, self._token(Kind.PUBLISHER, key, qos))

    def _subscribe(self, key: DataKey, qos: Qos) -> _Endpoint:
        callback, remote = partial(self._on_sample, key), self.zenoh.Locality.REMOTE
        if qos.transient_local:
            ext = self.zenoh.ext
            declared = ext.declare_advanced_subscriber(
                self.session,
                data_key(key),
                callback,
                allowed_origin=remote,
                history=ext.HistoryConfig(detect_late_publishers=True, max_samples=qos.depth),
                recovery=ext.RecoveryConfig(heartbeat=True),
                subscriber_detection=True,
            )
        else:
            declared = self.session.declare_subscriber(data_key(key), callback, allowed_origin=remote)
        return _Endpoint(declared, self.session, self._token(Kind.SUBSCRIBER, key, qos))

    def _offer(self, key: DataKey, _how: None) -> _Endpoint:
        declared = self.session.declare_queryable(
            data_key(key),
            lambda query: self._on_call(IncomingCall(key, query)),
            complete=True,
            allowed_origin=self.zenoh.Locality.REMOTE,
        )
        return _Endpoint(declared, self.session, self._token(Kind.SERVICE, key, _SERVICE_QOS))

    def _make_client(self, key: DataKey, _how: None) -> _Endpoint:
        return _Endpoint(None, self.session, self._token(Kind.CLIENT, key, _SERVICE_QOS))

    # Messages ---------------------------------------------------------------------------------------------------------

    def _on_sample(self, key: DataKey, sample: zenoh.Sample) -> None:
        attachment = sample.attachment
        if sample.kind != self.zenoh.SampleKind.PUT or attachment is None:
            return
        if len(attachment) < 1000 and len(sample.payload) <= MAX_PACKET:
            self._on_message(key, sample.payload.to_bytes(), attachment.to_bytes(), _session_of(sample))

    def send(self, packet: Send) -> None:
        """Send a message. If the network is congested, this waits a short time, and then drops the message."""
        endpoint = self._by_key.get(packet.key)
        if endpoint is not None and not self.is_closing:
            endpoint.declared.put(packet.body, attachment=endpoint.attachment())

    def try_send(self, packet: Send) -> bool:
        """Return False without sending, since a large message may block."""
        return False

    def listen(self, site: str, key: str, on: bool) -> None:
        """Do nothing: `declare` sets what to receive."""

    # Calls ------------------------------------------------------------------------------------------------------------

    def call(self, key: DataKey, request: bytes, timeout: float) -> bytes:
        """See `pyros1.ros2.bridge.side.Ros2Side.call`."""
        replies = FirstReply()
        try:
            self._query(key, request, timeout, replies)
            return response_of(replies.get(timeout + 1))
        finally:
            with self.lock:
                self._calls.discard(replies)

    def start_call(
        self, key: DataKey, request: bytes, timeout: float, done: Callable[[bytes | ServiceRefusal], object]
    ) -> None:
        """See `pyros1.ros2.bridge.side.Ros2Side.start_call`."""
        replies = LaterReply(done)
        with self.lock:  # remove calls that have ended
            self._calls = {each for each in self._calls if not (isinstance(each, LaterReply) and each.is_done)}
        try:
            self._query(key, request, timeout, replies)
        except ServiceRefusal:
            if replies.withdraw():  # otherwise, the call has already been answered
                raise

    def _query(self, key: DataKey, request: bytes, timeout: float, replies: FirstReply | LaterReply) -> None:
        """Make a call.

        Raises:
            ServiceRefusal: it cannot be made.
        """
        with self.lock:
            client = self._clients.get((key, None))
            if client is None or self.is_closing:
                raise ServiceRefusal("the bridge has no connection to ROS 2")
            self._calls.add(replies)
            attachment = client.attachment()
        try:
            self.session.get(
                data_key(key),
                self.zenoh.handlers.Callback(replies.put, partial(replies.put, None)),
                payload=request,
                attachment=attachment,
                target=self.zenoh.QueryTarget.ALL_COMPLETE,
                consolidation=self.zenoh.ConsolidationMode.NONE,
                timeout=timeout,
                congestion_control=self.zenoh.CongestionControl.DROP,  # also applies to the response
                allowed_destination=self.zenoh.Locality.REMOTE,
            )
        except self.zenoh.ZError as error:
            with self.lock:
                self._calls.discard(replies)
            raise ServiceRefusal(f"the bridge cannot call it: {one_line(error, 200)}") from error

    def on_close(self) -> None:
        """End the pending calls. Called with the lock held."""
        for replies in self._calls:
            replies.put(None)


def _session_of(sample: zenoh.Sample) -> str:
    """Return the id of the session that sent a message; empty if zenoh does not provide it."""
    info = getattr(sample, "source_info", None)
    return "" if info is None or info.source_id is None else str(info.source_id.zid)
