"""A bridge's ROS 2 node, implemented with rclpy.

Messages are sent and received encoded. A session has two threads: one runs rclpy's executor, and creates and destroys
all of the node's entities, so that rclpy never waits on an entity that is being destroyed; the other polls the graph.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from functools import partial
from itertools import count
from typing import Any, TypeVar

from pyros1.bridge.exchange.actions import Send
from pyros1.bridge.rules.rules import Priority
from pyros1.bridge.transport.connections import Connection
from pyros1.bridge.transport.zenoh_link import LinkError
from pyros1.ground.errors import Error, ServiceRefusal
from pyros1.ground.terminal_text import one_line
from pyros1.ros2.rclpy_side.calls import NoResponse, RclpyCall
from pyros1.ros2.rclpy_side.echoes import Echoes
from pyros1.ros2.rclpy_side.graph_reader import GID_SIZE, GraphReader, process_id
from pyros1.ros2.rclpy_side.outgoing_calls import OutgoingCalls
from pyros1.ros2.rclpy_side.qos import to_rclpy
from pyros1.ros2.rclpy_side.rclpy_modules import RclpyModules
from pyros1.ros2.rclpy_side.type_classes import TypeClasses
from pyros1.ros2.zenoh.attachments import Attachment, encode_attachment
from pyros1.ros2.zenoh.names import DataKey
from pyros1.ros2.zenoh.qos import Qos

GRAPH_PERIOD = 0.5
"""Seconds between reads of the ROS 2 graph."""
_CHANGING_PERIOD = 0.1
"""Seconds between reads of the ROS 2 graph while it is changing, as at the start."""
_GRAPH_FACTOR = 10
"""Minimum seconds between reads of the ROS 2 graph per second that a read takes."""
_DECLARE_TIME = 10.0
RETRY_PERIOD = 0.1
"""Seconds to wait after an rclpy error."""
CLOSE_TIME = 3.0
_Published = tuple[DataKey, Qos, Priority]
_Name = TypeVar("_Name", str, DataKey)
_How = TypeVar("_How")


class DeclarationError(Error):
    """rclpy did not declare everything in time, or failed."""


class RclpySession:
    """A session; see `pyros1.ros2.bridge.side.Ros2Side`.

    Args:
        node: the name of its node in ROS 2.
        domain: the ROS domain.
        classes: finds message and service classes.
        on_token: called with a token for each ROS 2 entity, and whether it exists or is gone.
        on_message: called with the key, encoded message and attachment of each message, and the id of its publisher's
            process; empty if rclpy does not provide it.
        on_call: called with each call of an offered service.

    Raises:
        LinkError: rclpy cannot be imported, or cannot start.

    Attributes:
        problem: what is wrong with rclpy; empty if nothing is.
        session: rclpy's node.
    """

    way = "rclpy"

    def __init__(
        self,
        node: str,
        domain: int,
        classes: TypeClasses,
        on_token: Callable[[str, bool], object],
        on_message: Callable[[DataKey, bytes, bytes, str], object],
        on_call: Callable[[RclpyCall], object],
    ) -> None:
        self.problem = ""
        self._classes = classes
        self._on_token = on_token
        self._on_message = on_message
        self._on_call = on_call
        self._publishers: dict[tuple[str, _Published], Any] = {}
        self._subscribers: dict[tuple[DataKey, Qos], Any] = {}
        self._services: dict[tuple[DataKey, None], Any] = {}
        self._clients: dict[tuple[DataKey, None], Any] = {}
        self._by_route: dict[str, tuple[str, Any]] = {}  # route -> topic and publisher
        self._numbers = count(1)
        self._turns: dict[str, int] = {}  # topic -> number of messages whose publishers rclpy did not name
        self._pending: set[Any] = set()  # futures of responses
        self._closing = threading.Event()
        try:
            self._rclpy = RclpyModules()
            self._context, self.session, self._executor = self._rclpy.start(node, domain)
        except Exception as error:  # rclpy's own, of any kind
            raise LinkError(f"rclpy cannot start: {one_line(error, 300)}") from error
        self._outgoing_calls = OutgoingCalls(self._rclpy)
        self._domain = domain
        self._graph = GraphReader(self.session, domain, node, classes.types.hash_of)
        self._echoes = Echoes(self._graph.own_gids, self._rclpy.tells_publishers)
        self._threads = [
            threading.Thread(target=self._spin, name="bridge: rclpy", daemon=True),
            threading.Thread(target=self._watch, name="bridge: ROS 2's graph", daemon=True),
        ]
        for thread in self._threads:
            thread.start()

    # Threads ----------------------------------------------------------------------------------------------------------

    def _spin(self) -> None:
        while not self._closing.is_set() or self._pending:
            try:
                self._executor.spin_once()
                self.problem = ""
            except NoResponse:
                pass
            except Exception as error:  # noqa: BLE001 - from a callback or rclpy: other callbacks must go on
                if not self._context.ok():
                    self.problem = "rclpy was shut down"
                    return
                self.problem = f"rclpy fails: {one_line(error, 200)}"
                self._closing.wait(RETRY_PERIOD)

    def _wake(self) -> None:
        """Wake the executor, so that it checks for finished calls."""
        self._executor.create_task(lambda: None)

    def _watch(self) -> None:
        known: set[str] = set()
        pause = 0.0
        while not self._closing.wait(pause):
            start = time.monotonic()
            self._outgoing_calls.poll()
            try:
                found = self._graph.read()
            except Exception as error:  # noqa: BLE001 - rclpy's own, of any kind
                if not self._closing.is_set():
                    self.problem = f"rclpy cannot read the ROS 2 graph: {one_line(error, 200)}"
                pause = GRAPH_PERIOD
                continue
            for token in known - found:
                self._on_token(token, False)
            for token in found - known:
                self._on_token(token, True)
            period = GRAPH_PERIOD if found == known else _CHANGING_PERIOD
            pause = max(period, _GRAPH_FACTOR * (time.monotonic() - start))
            known = found

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
        lists = publishers, subscribers, dict.fromkeys(services), dict.fromkeys(clients)
        self._in_executor(self._declare, *lists, refused)
        return refused

    def _in_executor(self, function: Callable[..., None], *arguments: Any) -> None:
        """Run a function in the executor's thread, and wait until it returns.

        Raises:
            DeclarationError: it takes too long, or fails.
        """
        done = threading.Event()
        errors: list[Exception] = []

        def run() -> None:
            try:
                function(*arguments)
            except Exception as error:  # noqa: BLE001 - rclpy's own, of any kind
                errors.append(error)
            finally:
                done.set()

        self._executor.create_task(run)
        if not done.wait(_DECLARE_TIME) and not self._closing.is_set():
            raise DeclarationError(f"rclpy has not responded for {_DECLARE_TIME:.0f} s {self.problem}")
        for error in errors:
            raise DeclarationError(f"rclpy fails: {one_line(error, 200)}") from error

    def _declare(
        self,
        publishers: Mapping[str, _Published],
        subscribers: Mapping[DataKey, Qos],
        services: Mapping[DataKey, None],
        clients: Mapping[DataKey, None],
        refused: dict[str, str],
    ) -> None:
        node = self.session
        if self._closing.is_set():
            return
        _adjust(self._publishers, publishers, self._publish, node.destroy_publisher, refused)
        self._by_route = {route: (how[0].name, each) for (route, how), each in self._publishers.items()}
        self._echoes.set_topics({name for name, _ in self._by_route.values()} & {key.name for key in subscribers})
        _adjust(self._subscribers, subscribers, self._subscribe, node.destroy_subscription, refused)
        _adjust(self._services, services, self._offer, node.destroy_service, refused)
        _adjust(self._clients, clients, self._make_client, self._end_client, refused)

    def rename(self, node: str) -> None:
        """See `pyros1.ros2.bridge.side.Ros2Side.rename`."""
        self._in_executor(self._rename, node)

    def _rename(self, name: str) -> None:
        if self._closing.is_set():
            return
        node = self._rclpy.make_node(name, self._context, self._executor)  # if it fails, the old one stays
        self._declare({}, {}, {}, {}, {})
        old, self.session = self.session, node
        self._graph.use_node(node, name)
        self._executor.remove_node(old)
        old.destroy_node()

    def look_for_routers(self) -> None:
        """Do nothing: the middleware has no routers, or finds them itself."""

    def _publish(self, _route: str, how: _Published) -> Any:
        key, qos, _ = how
        return self.session.create_publisher(
            self._classes.message(key.type), key.name, to_rclpy(qos, self._rclpy.qos), callback_group=self._rclpy.group
        )

    def _subscribe(self, key: DataKey, qos: Qos) -> Any:
        return self.session.create_subscription(
            self._classes.message(key.type),
            key.name,
            self._receiver(key, qos.transient_local),
            to_rclpy(qos, self._rclpy.qos),
            raw=True,
            callback_group=self._rclpy.group,
        )

    def _offer(self, key: DataKey, _how: None) -> Any:
        service = self._classes.service(key.type)

        async def serve(request: Any, _response: Any) -> Any:
            if self._closing.is_set():
                raise NoResponse
            future = self._rclpy.future(self._executor)
            self._pending.add(future)
            try:
                call = RclpyCall(key, bytes(self._rclpy.serialize(request)), partial(self._end_call, future))
                self._on_call(call)
                return self._rclpy.deserialize(await future, service.Response)
            finally:
                self._pending.discard(future)

        return self.session.create_service(service, key.name, serve, callback_group=self._rclpy.group)

    def _make_client(self, key: DataKey, _how: None) -> Any:
        return self.session.create_client(self._classes.service(key.type), key.name, callback_group=self._rclpy.group)

    def _end_client(self, client: Any) -> None:
        self.session.destroy_client(client)
        self._outgoing_calls.drop_client(client)

    # Messages ---------------------------------------------------------------------------------------------------------

    def _receiver(self, key: DataKey, is_latched: bool) -> Callable[..., None]:
        """Return the callback of a subscriber. rclpy inspects its parameters to decide what to pass."""

        def receive(body: bytes, info: Mapping[str, Any]) -> None:
            gid = bytes((info.get("publisher_gid") or {}).get("data", b""))[:GID_SIZE]
            self._receive(key, is_latched, body, gid, info.get("source_timestamp", 0))

        def receive_without_info(body: bytes) -> None:
            self._receive(key, is_latched, body, b"", 0)

        return receive if self._rclpy.tells_info else receive_without_info

    def _receive(self, key: DataKey, is_latched: bool, body: bytes, gid: bytes, source_time: int) -> None:
        if not self._echoes.is_echo(key.name, body, gid):
            source = gid.ljust(GID_SIZE, b"\0") if gid or not is_latched else self._next_source(key.name)
            attachment = Attachment(next(self._numbers), source_time, source)
            self._on_message(key, body, encode_attachment(attachment), process_id(gid) if gid else "")

    def _next_source(self, topic: str) -> bytes:
        """Return a stand-in for the GID of a latched message's publisher, which rclpy does not report before Kilted.

        The stand-ins rotate, so the newest messages of a topic are kept, as many as it has publishers.
        """
        turn = self._turns[topic] = self._turns.get(topic, -1) + 1
        return (turn % max(1, self._graph.latched_publishers(topic))).to_bytes(GID_SIZE, "big")

    def send(self, packet: Send) -> None:
        """Send a message; do nothing if its publisher no longer exists."""
        topic, publisher = self._by_route.get(packet.key, ("", None))
        if publisher is None or self._closing.is_set():
            return
        self._echoes.on_send(topic, packet.body)
        try:
            publisher.publish(bytes(packet.body))
        except Exception:  # rclpy's own, of any kind
            if self._by_route.get(packet.key, ("", None))[1] is publisher and not self._closing.is_set():
                raise

    def try_send(self, packet: Send) -> bool:
        """Send a message and return True: rclpy hands it to other threads or the network, and hardly ever blocks."""
        self.send(packet)
        return True

    def listen(self, site: str, key: str, on: bool) -> None:
        """Do nothing: `declare` sets what to receive."""

    def connections(self) -> list[Connection]:
        """Return an empty list: the middleware does not report connections."""
        return []

    # Calls ------------------------------------------------------------------------------------------------------------

    def _end_call(self, future: Any, body: bytes | None) -> None:
        """Pass the response of a call to the executor."""
        if not future.done():
            if body is None:
                future.set_exception(NoResponse())
            else:
                future.set_result(body)
            self._wake()

    def call(self, key: DataKey, request: bytes, timeout: float) -> bytes:
        """See `pyros1.ros2.bridge.side.Ros2Side.call`."""
        client = self._clients.get((key, None))
        if client is None or self._closing.is_set():
            raise ServiceRefusal("the bridge has no connection to ROS 2")
        return self._outgoing_calls.call(client, self._classes.service(key.type).Request, request, timeout)

    def start_call(
        self, key: DataKey, request: bytes, timeout: float, done: Callable[[bytes | ServiceRefusal], object]
    ) -> None:
        """See `pyros1.ros2.bridge.side.Ros2Side.start_call`."""
        client = self._clients.get((key, None))
        if client is None or self._closing.is_set():
            raise ServiceRefusal("the bridge has no connection to ROS 2")
        self._outgoing_calls.start(client, self._classes.service(key.type).Request, request, timeout, done)

    # Shutdown ---------------------------------------------------------------------------------------------------------

    def close(self) -> None:
        """End the node and the threads. This waits only a few seconds, since the middleware may hang."""
        self._closing.set()
        self._outgoing_calls.close()
        closer = threading.Thread(target=self._end, name="bridge: end of rclpy", daemon=True)
        closer.start()
        closer.join(CLOSE_TIME)

    def _end(self) -> None:
        for future in [*self._pending]:
            self._end_call(future, None)
        self._wake()
        for thread in self._threads:
            thread.join(CLOSE_TIME)
        with suppress(Exception):  # the context may have been shut down already
            self._executor.shutdown(timeout_sec=0)
            self.session.destroy_node()
            self._context.try_shutdown()


def _adjust(
    declared: dict[tuple[_Name, _How], Any],
    wanted: Mapping[_Name, _How],
    declare: Callable[[_Name, _How], Any],
    destroy: Callable[[Any], object],
    refused: dict[str, str],
) -> None:
    """Declare what is missing, and destroy what is no longer needed; add failures to `refused`."""
    for each in declared.keys() - {*wanted.items()}:
        destroy(declared.pop(each))
    for key, how in wanted.items():
        if (key, how) not in declared:
            try:
                declared[key, how] = declare(key, how)
            except Exception as error:  # noqa: BLE001 - rclpy's own, of any kind; the others must be declared
                name = key.name if isinstance(key, DataKey) else key.partition(" ")[0]
                refused[name] = one_line(error, 300)
