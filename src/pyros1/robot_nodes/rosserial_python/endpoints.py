"""The topics and services of a board in ROS."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from functools import partial
from typing import Any

from pyros1.ground.errors import Error, MessageError, NodeError, ServiceError
from pyros1.ground.terminal_text import one_line
from pyros1.msgs import load_message, load_service
from pyros1.node import Node
from pyros1.node.log.levels import ERROR, INFO
from pyros1.robot_nodes.rosserial_python.servers import Servers
from pyros1.robot_nodes.rosserial_python.session import MAX_ENDPOINTS, Endpoint, Kind

QUEUE_SIZE = 10
RESPONSE_TIMEOUT = 5.0
"""Seconds that a board has to respond to a service call."""
CALL_TIMEOUT = 10.0
"""Seconds that a service has to respond to a board."""
_Send = Callable[[int, bytes], bool]
_Submit = Callable[[Callable[[], None]], None]
_TITLES = {
    Kind.PUBLISHER: "publisher",
    Kind.SUBSCRIBER: "subscriber",
    Kind.SERVER_RESPONSES: "service server",
    Kind.SERVER_REQUESTS: "service server",
    Kind.CLIENT_REQUESTS: "service client",
    Kind.CLIENT_RESPONSES: "service client",
}


class Endpoints:
    """Creates a board's publishers, subscribers and services, and exchanges messages between them and the board.

    Args:
        node: the node that has them.
        send: sends a serialized message to the board; returns whether it was sent.
        submit: runs a function in a thread that may block.
        servers: the services of all boards.
        name: the board's name, for the log.
    """

    def __init__(self, node: Node, send: _Send, submit: _Submit, servers: Servers, name: str) -> None:
        self._node = node
        self._servers = servers
        self._name = name
        self._send = send
        self._submit = submit
        self._parts: dict[tuple[str, str], Any] = {}
        self._receivers: dict[int, Callable[[bytes], None]] = {}

    def set_up(self, endpoint: Endpoint) -> None:
        """Create an endpoint, or update the topic id of an existing one. Errors are logged."""
        title = _TITLES[endpoint.kind]
        self._receivers.pop(endpoint.id, None)
        try:
            if (title, endpoint.name) not in self._parts and len(self._parts) >= MAX_ENDPOINTS:
                text = "the board has already announced %d topics and services: %s is ignored"
                self._node.log.error(text, MAX_ENDPOINTS, one_line(endpoint.name, 100), throttle=10)
                return
            self._set_up(title, endpoint)
        except (Error, ValueError, TypeError) as error:
            text = "cannot create the board's %s %s: %s"
            self._node.log.peer_event(ERROR, text, title, endpoint.name, error, link=self._name)

    def _set_up(self, title: str, endpoint: Endpoint) -> None:
        key = title, endpoint.name
        is_topic = endpoint.kind in (Kind.PUBLISHER, Kind.SUBSCRIBER)
        cls: Any = load_message(endpoint.type) if is_topic else load_service(endpoint.type)
        _check_md5sum(endpoint, cls)
        part = self._parts.get(key)
        if part is not None and part.type is not cls:
            self._close(part)
            del self._parts[key]
            self._receivers = {id: receive for id, receive in self._receivers.items() if receive != part.receive}
            part = None
        is_new = part is None
        if part is None:
            create = partial(_PARTS[title], self._node, self._send, self._submit, endpoint, cls)
            is_server = endpoint.kind in (Kind.SERVER_REQUESTS, Kind.SERVER_RESPONSES)
            part = self._servers.replace(self._node.resolve(endpoint.name), create) if is_server else create()
            self._parts[key] = part
        else:
            part.attach(endpoint)
        self._receivers[endpoint.id] = part.receive
        if is_new:
            text, link = "Setup %s on %s [%s]", (self._name, endpoint.kind)
            self._node.log.peer_event(
                INFO, text, title, endpoint.name, endpoint.type, max_texts=MAX_ENDPOINTS, link=link
            )

    def deliver(self, endpoint: Endpoint, data: bytes) -> None:
        """Pass on a message from the board."""
        receive = self._receivers.get(endpoint.id)
        if receive is None:
            return  # it could not be created; this was logged
        try:
            receive(data)
        except MessageError as error:
            self._node.log.warn("%s: the board sent an invalid message: %s", endpoint.name, error, throttle=10)

    def on_disconnected(self) -> None:
        """Let pending service calls fail."""
        for part in list(self._parts.values()):
            part.on_disconnected()

    def close(self) -> None:
        """Remove all endpoints from ROS."""
        for part in self._parts.values():
            self._close(part)
        self._parts.clear()
        self._receivers.clear()

    def _close(self, part: _Part) -> None:
        part.close()
        self._servers.forget(part)


def _check_md5sum(endpoint: Endpoint, cls: Any) -> None:
    """Check that the board and the host have the same definition of a type.

    Raises:
        NodeError: the definitions differ.
    """
    if endpoint.kind in (Kind.SERVER_REQUESTS, Kind.CLIENT_REQUESTS):
        cls = cls._request_class
    elif endpoint.kind in (Kind.SERVER_RESPONSES, Kind.CLIENT_RESPONSES):
        cls = cls._response_class
    if cls._md5sum != endpoint.md5sum:
        raise NodeError(
            f"the board's {endpoint.type} is not the one here (md5 sum {endpoint.md5sum[:40]!r} on the board, "
            f"{cls._md5sum} here): generate the board's ros_lib again from these definitions, or install the board's"
        )


class _Part:
    """A topic or service of the board.

    Args:
        node, send, submit: see `Endpoints`.
        endpoint: the board's description of it.
        type: the message or service class.
    """

    def __init__(self, node: Node, send: _Send, submit: _Submit, endpoint: Endpoint, type: Any) -> None:
        self.type = type
        self._node, self._send, self._submit, self._name = node, send, submit, endpoint.name
        self._id: int | None = None
        self._room = 0
        self.attach(endpoint)  # before messages arrive
        self._handle = self._open()

    def _open(self) -> Any:
        raise NotImplementedError

    def attach(self, endpoint: Endpoint) -> None:
        """If messages of an endpoint go to the board, use its topic id and buffer size for them."""
        if endpoint.kind in (Kind.SUBSCRIBER, Kind.SERVER_REQUESTS, Kind.CLIENT_RESPONSES):
            self._id, self._room = endpoint.id, endpoint.buffer_size

    def receive(self, data: bytes) -> None:
        """Handle a message from the board."""

    def on_disconnected(self) -> None:
        """Give up everything that waits for the board."""

    def close(self) -> None:
        """Remove it from ROS."""
        if self._handle is not None:
            self._handle.unregister()

    def _send_message(self, message: Any) -> bool:
        data = type(message)._encode(message)
        if 0 < self._room < len(data):
            text = "%s: a message of %d bytes is dropped, since the board's buffer has %d"
            self._node.log.error(text, self._name, len(data), self._room, throttle=10)
            return False
        return self._id is not None and self._send(self._id, data)


class _BoardPublisher(_Part):
    def _open(self) -> Any:
        return self._node.advertise(self._name, self.type, queue_size=QUEUE_SIZE)

    def receive(self, data: bytes) -> None:
        self._handle.publish(self.type._decode(data, 0, len(data), True))


class _BoardSubscriber(_Part):
    def _open(self) -> Any:
        return self._node.subscribe(self._name, self.type, self._send_message, queue_size=QUEUE_SIZE)


class _BoardServer(_Part):
    """A service that the board provides. It handles one call at a time, since responses have no ids."""

    def _open(self) -> Any:
        self._lock = threading.Lock()
        self._responses: queue.Queue[bytes | None] = queue.Queue(1)
        return self._node.advertise_service(self._name, self.type, self._call)

    def close(self) -> None:
        self._respond(None)
        self._handle.shutdown()

    def _call(self, request: Any) -> Any:
        with self._lock:
            while not self._responses.empty():
                self._responses.get_nowait()  # discard the response to a call that timed out
            if not self._send_message(request):
                raise ServiceError(f"{self._name}: the board is not connected")
            try:
                data = self._responses.get(timeout=RESPONSE_TIMEOUT)
            except queue.Empty:
                raise ServiceError(f"{self._name}: the board did not respond in {RESPONSE_TIMEOUT:g} s") from None
            if data is None:
                raise ServiceError(f"{self._name}: the connection to the board broke")
            return self.type._response_class._decode(data, 0, len(data), True)

    def receive(self, data: bytes) -> None:
        self._respond(data)

    def on_disconnected(self) -> None:
        self._respond(None)

    def _respond(self, data: bytes | None) -> None:
        if not self._responses.full():  # nobody waits for a second one
            self._responses.put_nowait(data)


class _BoardClient(_Part):
    """Calls a service for the board."""

    def _open(self) -> Any:
        return self._node.service(self._name, self.type)

    def close(self) -> None:
        self._handle.close()

    def receive(self, data: bytes) -> None:
        request = self.type._request_class._decode(data, 0, len(data), True)
        self._submit(lambda: self._call(request))

    def _call(self, request: Any) -> None:
        self._send_message(self._handle.call(request, timeout=CALL_TIMEOUT))


_PARTS: dict[str, type[_Part]] = {
    "publisher": _BoardPublisher,
    "subscriber": _BoardSubscriber,
    "service server": _BoardServer,
    "service client": _BoardClient,
}
