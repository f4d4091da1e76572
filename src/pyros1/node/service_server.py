"""Providing a service (https://wiki.ros.org/rospy/Overview/Services): one thread per call under way."""

from __future__ import annotations

import contextlib
import socket
import threading
from collections.abc import Callable
from time import monotonic
from typing import TYPE_CHECKING, Any

from pyros1.errors import MessageError, NodeError, ProtocolError
from pyros1.msgs import Message, Service
from pyros1.net.timeouts import WaitOver, bound_waits
from pyros1.wire.framing import FrameBuffer
from pyros1.wire.handshake import ServiceType, answer_service_client, is_true
from pyros1.wire.header import encode_header
from pyros1.wire.service import encode_failure, encode_success

if TYPE_CHECKING:
    from pyros1.node.context import Context
    from pyros1.node.workers import Workers

REQUEST_TIMEOUT = 30.0
"""Seconds that a client has for sending a request, once it has begun."""


def service_type(service_class: type[Service]) -> ServiceType:
    """Return what a service class says about itself in connection headers."""
    return ServiceType(
        service_class._type,
        service_class._md5sum,
        service_class._request_class._type,
        service_class._response_class._type,
    )


class ServiceServer:
    """A service that a node provides; made by ``Node.advertise_service``. Also a context manager that shuts down.

    Attributes:
        name: full name.
        type: the service class.
    """

    def __init__(
        self,
        context: Context,
        workers: Workers,
        name: str,
        service_class: type[Service],
        handler: Callable[[Any], Any],
        unregister: Callable[[ServiceServer], None],
        direct: bool = False,
    ) -> None:
        self._callbacks = None if direct else context.callbacks  # None: the handler runs in the call's thread
        self.name = name
        self.type = service_class
        self._context = context
        self._workers = workers
        self._wire_type = service_type(service_class)
        self._handler = handler
        self._unregister: Callable[[ServiceServer], None] | None = unregister
        self._clients: set[socket.socket] = set()
        self._lock = threading.Lock()
        self._closed = False

    def accept(self, sock: socket.socket, header: dict[str, str], first: bytes) -> None:
        """Answer a client's header and serve it. On the loop.

        Raises:
            Refusal: the client wants another type.
            ProtocolError: too many calls are under way.
        """
        answer = encode_header(answer_service_client(header, self._context.name, self.name, self._wire_type))
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        if is_true(header.get("probe")):
            sock.send(answer)
            sock.close()
            return
        with self._lock:
            self._clients.add(sock)
        if not self._workers.submit(lambda: self._serve(sock, header, answer, first)):
            with self._lock:
                self._clients.discard(sock)  # still open: the caller is told why
            raise ProtocolError(f"too many calls of {self.name} are under way, try again later")

    def _serve(self, sock: socket.socket, header: dict[str, str], answer: bytes, first: bytes) -> None:
        persistent = is_true(header.get("persistent"))
        buffer = FrameBuffer(4096, first=first)
        try:
            bound_waits(sock, REQUEST_TIMEOUT)
            sock.sendall(answer)
            frames = buffer.received(0)
            begun = monotonic()  # when the first byte of the current request came
            while not self._closed:
                data = buffer.take(frames) if frames else b""
                for start, end in frames:
                    sock.sendall(self._answer(data, start, end, header))
                    if not persistent:
                        return
                frames, fresh = [], not buffer.partial
                try:
                    count = sock.recv_into(buffer.writable())
                except WaitOver:
                    if persistent and not buffer.partial:
                        continue  # an idle persistent connection
                    return
                if not count:
                    return
                frames = buffer.received(count)
                if fresh:
                    begun = monotonic()
                elif not frames and monotonic() - begun > REQUEST_TIMEOUT:
                    raise ProtocolError(f"its request was not complete after {REQUEST_TIMEOUT:g} s")
        except (OSError, ProtocolError) as error:
            if not self._closed and not isinstance(error, ConnectionError):
                self._context.log.warn("call of %s by %s broke: %s", self.name, header.get("callerid", "?"), error)
        finally:
            self._forget(sock)

    def _forget(self, sock: socket.socket) -> None:
        with self._lock:
            self._clients.discard(sock)
        sock.close()

    def _answer(self, data: bytes, start: int, end: int, header: dict[str, str]) -> bytes:
        """Return the bytes that answer one request."""
        try:
            request = self.type._request_class._decode(data, start, end)
        except MessageError as error:
            return encode_failure(f"service [{self.name}]: {error}")
        request._connection_header = header
        callbacks = self._callbacks
        if callbacks is None:
            return self._handle(request)
        done = threading.Event()
        answers: list[bytes] = []

        def run() -> None:
            answers.append(self._handle(request))
            done.set()

        callbacks.push(run)
        while not done.wait(0.2):
            if self._closed or self._context.stopping.is_set():
                return encode_failure(f"service [{self.name}] is shutting down")
        return answers[0]

    def _handle(self, request: Message) -> bytes:
        try:
            response = self._convert(self._handler(request))
            frame = response.__class__._encode_frame(response)
            return encode_success(frame if isinstance(frame, bytes) else b"".join(frame))
        except NodeError as error:
            return encode_failure(f"service cannot process request: {error}")
        except Exception as error:
            self._context.log.exception(f"error processing a request of {self.name}", error=error)
            return encode_failure(f"error processing request: {error}")

    def _convert(self, value: Any) -> Message:
        """Turn what the handler returned into a response (P19).

        Raises:
            NodeError: it returned None.
        """
        response_class = self.type._response_class
        if isinstance(value, response_class):
            return value
        if isinstance(value, Message) and value._md5sum == response_class._md5sum:
            return value
        if value is None:
            raise NodeError(f"service handler of {self.name} returned None: return a {response_class.__name__}")
        if isinstance(value, dict):
            return response_class(**value)
        if isinstance(value, (list, tuple)):
            return response_class(*value)
        return response_class(value)

    def close(self) -> None:
        """End all calls; their callers get an error."""
        with self._lock:
            self._closed = True
            clients = list(self._clients)
        for sock in clients:
            with contextlib.suppress(OSError):
                sock.shutdown(socket.SHUT_RD)  # a call under way may still answer

    def shutdown(self, reason: str = "") -> None:
        """Stop providing the service.

        Args:
            reason: for the log.
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
