"""The services that a node provides (https://wiki.ros.org/rospy/Overview/Services); each call in progress uses one
thread.
"""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable
from time import monotonic
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import LengthError, MessageError, NodeError, ServiceRefusal
from pyros1.msgs import Message, Service
from pyros1.net.keepalive import set_nodelay_and_keepalive
from pyros1.node.log.levels import WARN
from pyros1.node.services.client_connection import ClientConnection
from pyros1.wire.handshake import ServiceType, is_true, make_service_response
from pyros1.wire.header import encode_header
from pyros1.wire.service import encode_failure, encode_success

if TYPE_CHECKING:
    from pyros1.node.context import Context
    from pyros1.node.services.workers import Workers

MAX_CALLS = 256
"""Maximum number of concurrent calls to one service; more are refused."""
MAX_EARLY_CALLS = 8
"""A thread waits briefly for a new client's first request only while fewer calls than this are in progress."""
SPIN_WARNING_DELAY = 5.0
"""Seconds that a call waits for the program to spin before a warning is logged."""


def service_type(service_class: type[Service]) -> ServiceType:
    """Return a service class's type for connection headers."""
    return ServiceType(
        service_class._type,
        service_class._md5sum,
        service_class._request_class._type,
        service_class._response_class._type,
    )


class ServiceServer:
    """A service provided by a node; created by ``Node.advertise_service``. As a context manager, it shuts down on exit.

    Attributes:
        name: the service's full name.
        type: the service class.
        uri: the URI that is registered with the master.
    """

    def __init__(
        self,
        context: Context,
        workers: Workers,
        name: str,
        uri: str,
        service_class: type[Service],
        handler: Callable[[Any], Any],
        unregister: Callable[[ServiceServer], None],
        direct: bool = False,
    ) -> None:
        self._callback_queue = None if direct else context.callback_queue  # None: the handler runs in the call's thread
        self.name = name
        self.uri = uri
        self.type = service_class
        self._context = context
        self._workers = workers
        self._wire_type = service_type(service_class)
        self._handler = handler
        self._unregister: Callable[[ServiceServer], None] | None = unregister
        self._connections: set[ClientConnection] = set()
        self._num_calls = 0
        self._lock = threading.RLock()
        self._closed = False

    def accept(self, sock: socket.socket, header: dict[str, str], initial_bytes: bytes) -> None:
        """Respond to a client's header and serve its requests. Called on the loop.

        Raises:
            Refusal: the client expects another type.
        """
        response_header = encode_header(make_service_response(header, self._context.name, self.name, self._wire_type))
        set_nodelay_and_keepalive(sock)
        if is_true(header.get("probe")):
            sock.send(response_header)
            sock.close()
            return
        connection = ClientConnection(
            self._context.loop,
            sock,
            header,
            initial_bytes,
            self._respond,
            self._submit,
            self._may_linger,
            self._on_connection_closed,
        )
        with self._lock:
            self._connections.add(connection)
            if self._closed:
                connection.end()
        connection.begin(response_header)

    def _submit(self, job: Callable[[], None]) -> str | None:
        """Run a job in a thread and return None, or return the reason why that is not possible."""
        with self._lock:
            if self._num_calls >= MAX_CALLS:
                return f"too many simultaneous calls to {self.name}, try again later"
            self._num_calls += 1

        def run() -> None:
            try:
                job()
            finally:
                with self._lock:
                    self._num_calls -= 1

        if self._workers.submit(run):
            return None
        with self._lock:
            self._num_calls -= 1
        return f"too many simultaneous calls to services of {self._context.name}, try again later"

    def _may_linger(self, num_answered: int) -> bool:
        """Return whether a thread may wait for more requests from a client after it has answered ``num_answered``."""
        # Few threads wait for clients that have only connected, so that such clients cannot occupy all threads.
        return self._num_calls < (MAX_CALLS // 2 if num_answered else MAX_EARLY_CALLS) and not self._closed

    def _on_connection_closed(self, connection: ClientConnection, error: Exception | None) -> None:
        with self._lock:
            self._connections.discard(connection)
        if error is not None and not self._closed and not isinstance(error, ConnectionError):
            client = connection.header.get("callerid", "?")
            self._context.log.peer_event(WARN, "a call to %s by %s failed: %s", self.name, client, error)

    def call_local(self, frame: bytes, header: dict[str, str]) -> bytes:
        """Handle a call that the service's own node makes, in the calling thread.

        Args:
            frame: the encoded request, including the length prefix.
            header: the header that a client would send.

        Returns:
            The encoded response.
        """
        request = self.type._request_class._decode(frame, 4, len(frame))
        request._connection_header = header
        return self._handle(request)

    def _respond(self, data: bytes, start: int, end: int, header: dict[str, str]) -> bytes:
        """Handle a request and return the encoded response."""
        decode = self.type._request_class._decode
        try:
            request = decode(data, start, end, True)
        except LengthError as error:
            client, text = header.get("callerid", "?"), "a call to %s by %s: %s"
            self._context.log.peer_event(WARN, text, self.name, client, error, max_texts=1, link=self.name)
            request = decode(data, start, end)
        except MessageError as error:
            return encode_failure(f"service [{self.name}]: {error}")
        request._connection_header = header
        callback_queue = self._callback_queue
        if callback_queue is None:
            return self._handle(request)
        closing = encode_failure(f"service [{self.name}] is shutting down")
        done = threading.Event()
        responses: list[bytes] = []

        def run() -> None:
            response = encode_failure(f"service [{self.name}]: its program was interrupted")
            try:
                # After the end, the client has received an error, and may have called another provider.
                response = closing if self._closed else self._handle(request)
            finally:
                responses.append(response)
                done.set()

        callback_queue.push(run)
        warn_at = monotonic() + SPIN_WARNING_DELAY
        while not done.wait(0.2):
            if self._closed or self._context.stopping.is_set():
                return closing
            if monotonic() > warn_at:
                warn_at = float("inf")
                client = header.get("callerid", "?")
                self._context.log.peer_event(
                    WARN, "a call to %s by %s is waiting for this program to spin", self.name, client
                )
        return responses[0]

    def _handle(self, request: Message) -> bytes:
        try:
            response = self._to_response(self._handler(request))
            frame = response.__class__._encode_frame(response)
            return encode_success(frame if isinstance(frame, bytes) else b"".join(frame))
        except ServiceRefusal as error:
            return encode_failure(str(error.args[0]))
        except NodeError as error:
            return encode_failure(f"service cannot process request: {error}")
        except Exception as error:
            self._context.log.exception(f"error processing a request of {self.name}", error=error)
            return encode_failure(f"error processing request: {error}")
        except BaseException as error:
            if self._callback_queue is not None:
                raise  # the handler runs in the program's own thread
            text = f"error processing a request of {self.name}"  # asyncio.CancelledError, for example
            if isinstance(error, (SystemExit, KeyboardInterrupt)):
                cause = "sys.exit()" if isinstance(error, SystemExit) else "KeyboardInterrupt"
                text = f"handler of {self.name}: {cause} ends a program only from its main thread; call node.shutdown()"
            self._context.log.exception(text, error=error)
            return encode_failure(f"error processing request: {error!r}")

    def _to_response(self, result: Any) -> Message:
        """Convert the handler's result to a response (P19).

        Raises:
            NodeError: the handler returned None.
        """
        response_class = self.type._response_class
        if isinstance(result, response_class):
            return result
        if isinstance(result, Message) and result._md5sum == response_class._md5sum:
            return result
        if result is None:
            raise NodeError(f"service handler of {self.name} returned None: return a {response_class.__name__}")
        if isinstance(result, dict):
            return response_class(**result)
        if isinstance(result, (list, tuple)):
            return response_class(*result)
        return response_class(result)

    def close(self) -> None:
        """Abort all calls; the clients receive an error."""
        with self._lock:
            self._closed = True
            connections = list(self._connections)
        for connection in connections:
            connection.end()

    def shutdown(self, reason: str = "") -> None:
        """Stop providing the service.

        Args:
            reason: the reason to log.
        """
        unregister, self._unregister = self._unregister, None
        if unregister is not None:
            if reason:
                self._context.log.info("service %s shuts down: %s", self.name, reason)
            unregister(self)

    def __enter__(self) -> ServiceServer:
        return self

    def __exit__(self, *_: object) -> None:
        self.shutdown()
