"""Clients of services (https://wiki.ros.org/rospy/Overview/Services)."""

from __future__ import annotations

import os
import threading
from collections.abc import Mapping
from time import monotonic
from typing import TYPE_CHECKING, Any, Final

from pyros1.ground.errors import (
    ConnectionRefusedByPeerError,
    LengthError,
    MasterError,
    MasterMethodError,
    MasterUnreachableError,
    MessageError,
    ProtocolError,
    SerializationError,
    ServiceError,
    ServiceUnavailableError,
    WaitTimeoutError,
)
from pyros1.ground.terminal_text import one_line
from pyros1.msgs import Message, Service
from pyros1.net.spin_wait import SpinWait
from pyros1.node.checks import check_timeout
from pyros1.node.log.levels import WARN
from pyros1.node.services.provider_connection import ProviderConnection
from pyros1.node.services.server import service_type
from pyros1.wire.handshake import check_service_response, make_service_client_header, make_service_response
from pyros1.wire.header import HeaderReader, encode_header
from pyros1.wire.service import RESPONSE_HEAD_SIZE, decode_response_head

if TYPE_CHECKING:
    from pyros1.net.master_client import MasterClient
    from pyros1.node.context import Context, ServiceInterface

PROBE_TIMEOUT = 5.0
_MAX_REQUEST_WITH_HEADER: Final = 65536
"""Maximum size in bytes of a request to send together with the header: a socket accepts both without blocking, so a
refusal can be read."""


class ServiceClient:
    """Client of a service; created by ``Node.service``. As a context manager, it closes on exit.

    Calling the object calls the service: ``client(a, b)``, ``client(a=1)`` or ``client(request)``. A signal handler may
    call the service as well; if the handler has interrupted a call, it uses a separate connection.

    Attributes:
        name: the service's full name.
        type: the service class.
    """

    def __init__(
        self,
        context: Context,
        master: MasterClient,
        name: str,
        service_class: type[Service],
        persistent: bool,
        headers: Mapping[str, str],
    ) -> None:
        self.name = name
        self.type = service_class
        self._context = context
        self._master = master
        self._persistent = persistent
        self._headers = dict(headers)
        self._wire_type = service_type(service_class)
        self._spin_wait = SpinWait()  # shared by all calls, as each call of a series may use a new connection
        # Codecs are created on first use: here, not in a signal handler that interrupts an import.
        service_class._request_class()
        _ = service_class._request_class._encode_frame, service_class._response_class._decode
        self._reset_connections()

    def _reset_connections(self) -> None:
        self._persistent_connection: ProviderConnection | None = None
        self._connections_in_use: set[ProviderConnection] = set()
        self._lock = threading.RLock()  # allows one call at a time on a persistent connection
        self._is_connection_in_use = False  # whether the thread that holds the lock is making a call on it
        self._pid = os.getpid()

    def __call__(self, *args: Any, **fields: Any) -> Any:
        """Call the service without a time limit; see `call`."""
        request_class = self.type._request_class
        if len(args) == 1 and not fields and isinstance(args[0], Message):
            request = args[0]
            if request._md5sum != request_class._md5sum and len(request_class.__slots__) == 1:
                request = request_class(request)
        else:
            request = request_class(*args, **fields)
        return self.call(request)

    def call(self, request: Message, timeout: float | None = None) -> Any:
        """Call the service and wait for its response.

        Args:
            request: an instance of the service's request class.
            timeout: maximum number of seconds; None waits until the connection breaks or the node shuts down.

        Returns:
            The response message; its ``_connection_header`` is the provider's connection header.

        Raises:
            ServiceUnavailableError: no node provides the service, or the provider cannot be reached.
            ServiceError: the provider refused the call or failed (with its reason), or the connection broke.
            WaitTimeoutError: there was no response in time.
            SerializationError: a value in the request does not fit its field.
            TypeError, MessageError: the request is not a message, or is of another type.
            NodeShutdownError: the node is shutting down.
        """
        if not isinstance(request, Message):
            class_name = self.type._request_class.__name__
            raise TypeError(f"service [{self.name}]: the request must be a {class_name}, not {request!r:.80}")
        check_timeout(timeout)
        if request._md5sum != self.type._request_class._md5sum:
            raise MessageError(f"service [{self.name}] takes {self.type._request_class._type}, not {request._type}")
        try:
            frame = request.__class__._encode_frame(request)
        except SerializationError as error:
            raise SerializationError(f"service [{self.name}]: {error}") from None
        data = frame if isinstance(frame, bytes) else b"".join(frame)
        deadline = None if timeout is None else monotonic() + timeout
        self._close_inherited()
        if self._own_service() is not None:
            server = self._own_service(self._look_up())
            if server is not None:
                return self._call_local(server, data)
        if not self._persistent:
            return self._exchange(self._connect(deadline), data)
        return self._call_persistent(data, deadline)

    def _call_persistent(self, data: bytes, deadline: float | None) -> Any:
        """Call the service on the persistent connection, after calls of other threads.

        Raises:
            WaitTimeoutError: a call of another thread has not ended by the deadline.
        """
        timeout = -1.0 if deadline is None else min(max(0.0, deadline - monotonic()), threading.TIMEOUT_MAX)
        is_acquired = False
        try:
            # `map` prevents that a signal handler runs between `acquire` and the assignment.
            (is_acquired,) = map(self._lock.acquire, (True,), (timeout,))
            if not is_acquired:
                raise WaitTimeoutError(f"service [{self.name}] is still answering a call of another thread")
            if self._is_connection_in_use:  # a signal handler has interrupted a call
                return self._exchange(self._connect(deadline), data)
            self._is_connection_in_use = True
            try:
                persistent_connection = self._persistent_connection  # `close` may remove it meanwhile
                if persistent_connection is None or persistent_connection.is_broken:
                    persistent_connection = self._reconnect(persistent_connection, deadline)
                persistent_connection.deadline = deadline
                return self._exchange(persistent_connection, data)
            finally:
                self._is_connection_in_use = False
        finally:
            if is_acquired:
                self._lock.release()

    def _close_inherited(self) -> None:
        """In a forked process, close the connections, which belong to the parent process."""
        if self._pid != os.getpid():
            for other in [
                *self._connections_in_use,
                *([self._persistent_connection] if self._persistent_connection else []),
            ]:
                other.sock.close()
            self._reset_connections()

    def _own_service(self, uri: str | None = None) -> ServiceInterface | None:
        """Return the service if this node provides it and its handler can only run in the calling thread; else None.

        Args:
            uri: the URI that the service is registered with; None if it is not known yet.
        """
        context = self._context
        server = (
            context.services.get(self.name)
            if context.callback_queue is not None and context.callback_queue.is_callback_thread()
            else None
        )
        if server is None or server.type._md5sum != self.type._md5sum or uri not in (None, server.uri):
            return None
        return server

    def _call_local(self, server: ServiceInterface, request: bytes) -> Any:
        header = make_service_client_header(
            self._context.name, self.name, self._wire_type, self._persistent, self._headers
        )
        response = server.call_local(request, header)
        ok, _ = decode_response_head(response)
        provider_header = make_service_response(header, self._context.name, self.name, service_type(server.type))
        return self._read_response(ok, response[RESPONSE_HEAD_SIZE:], provider_header)

    def _look_up(self) -> str:
        """Look up the service's URI with the master and return it.

        Raises:
            ServiceUnavailableError: no node provides the service.
            ServiceError: the master does not respond, or cannot look up services.
            NodeShutdownError: the node is shutting down.
        """
        self._context.check_running()
        try:
            return self._master.lookup_service(self.name)
        except (MasterUnreachableError, MasterMethodError) as error:
            raise ServiceError(f"service [{self.name}] cannot be looked up: {error}") from error
        except MasterError:
            raise ServiceUnavailableError(f"service [{self.name}] unavailable: no node provides it") from None

    def _connect(self, deadline: float | None) -> ProviderConnection:
        return ProviderConnection(self._context, self.name, self._look_up(), deadline, self._spin_wait)

    def _reconnect(self, broken_connection: ProviderConnection | None, deadline: float | None) -> ProviderConnection:
        """Replace the persistent connection with a new one and return it."""
        if broken_connection is not None:
            self._persistent_connection = None
            broken_connection.close()
        self._persistent_connection = persistent_connection = self._connect(deadline)
        return persistent_connection

    def _exchange(self, connection: ProviderConnection, request: bytes) -> Any:
        """Send the request, preceded by the header on a new connection, and return the response."""
        self._connections_in_use.add(connection)
        is_complete = False
        try:
            if connection.has_header:
                connection.send(request)
            elif connection.is_local and len(request) <= _MAX_REQUEST_WITH_HEADER:
                self._exchange_headers(connection, request)
            else:  # stock providers lose data that arrives together with the header
                self._exchange_headers(connection)
                connection.send(request)
            ok, body = connection.receive_response()
            is_complete = True
        except ConnectionRefusedByPeerError as error:
            raise ServiceError(str(error)) from None
        except (OSError, ProtocolError) as error:
            if isinstance(error, WaitTimeoutError):
                raise
            self._context.check_running()
            raise ServiceError(f"call to service [{self.name}] failed: {error}") from error
        finally:
            self._connections_in_use.discard(connection)
            if not is_complete or connection is not self._persistent_connection:
                if connection is self._persistent_connection:
                    self._persistent_connection = None  # the next call reconnects
                connection.close()
        return self._read_response(ok, body, connection.header)

    def _read_response(self, ok: bool, body: bytes, header: dict[str, str]) -> Any:
        if not ok:
            raise ServiceError(
                f"service [{self.name}] responded with an error: {one_line(body.decode('utf-8', 'replace'))}", body
            )
        decode = self.type._response_class._decode
        try:
            response = decode(body, 0, len(body), True)
        except LengthError as error:
            self._context.log.peer_event(WARN, "the response of %s: %s", self.name, error, max_texts=1, link=self.name)
            response = decode(body, 0, len(body))
        response._connection_header = header
        return response

    def _exchange_headers(self, connection: ProviderConnection, request: bytes = b"") -> None:
        header = make_service_client_header(
            self._context.name, self.name, self._wire_type, self._persistent, self._headers
        )
        connection.send(encode_header(header) + request)
        reader = HeaderReader()
        provider_header = None
        while provider_header is None:
            provider_header = reader.feed(connection.receive())
        warning = check_service_response(provider_header, self.name, self._wire_type, header)
        if warning:
            self._context.log.peer_event(WARN, "%s", warning, max_texts=1, link=self.name)
        connection.data = reader.bytes_after_header
        connection.header = provider_header
        connection.has_header = True

    def wait(self, timeout: float | None = None) -> None:
        """Wait until the service is available; see ``Node.wait_for_service``."""
        wait_for_service(self._context, self._master, self.name, timeout)

    def close(self) -> None:
        """Close the connection; a call in progress in another thread fails."""
        self._close_inherited()
        persistent_connection, self._persistent_connection = self._persistent_connection, None
        connections_in_use = list(self._connections_in_use)
        for connection in connections_in_use:
            connection.abort()  # the thread that reads closes it: the descriptor must not be reused during a read
        if persistent_connection is not None and persistent_connection not in connections_in_use:
            persistent_connection.close()

    def __enter__(self) -> ServiceClient:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def probe(context: Context, service: str, uri: str, timeout: float = PROBE_TIMEOUT) -> dict[str, str]:
    """Ask a provider for its connection header, without calling the service (L79).

    Args:
        context: the context of the calling node.
        service: the service's full name.
        uri: the provider's URI, ``rosrpc://host:port``.
        timeout: maximum number of seconds.

    Returns:
        The provider's connection header: type, md5sum, callerid and more.

    Raises:
        ServiceUnavailableError: the provider does not respond, or does not provide the service.
        WaitTimeoutError: the provider did not accept the connection in time.
        NodeShutdownError: the node is shutting down.
    """
    connection = ProviderConnection(context, service, uri, monotonic() + timeout)
    try:
        connection.send(
            encode_header({"callerid": context.name, "service": service, "md5sum": "*", "type": "*", "probe": "1"})
        )
        reader = HeaderReader()
        provider_header = None
        while provider_header is None:
            provider_header = reader.feed(connection.receive())
    except (OSError, ProtocolError) as error:
        raise ServiceUnavailableError(f"service [{service}] at {uri} does not answer: {error}") from error
    finally:
        connection.close()
    if "error" in provider_header:
        raise ServiceUnavailableError(f"service [{service}] at {uri}: {one_line(provider_header['error'])}")
    return provider_header


def wait_for_service(context: Context, master: MasterClient, service: str, timeout: float | None) -> None:
    """Wait until a service is available, which means that its provider responds.

    Args:
        context: the node's context.
        master: the client of the master.
        service: the service's full name.
        timeout: maximum number of seconds to wait; None waits until the node shuts down.

    Raises:
        WaitTimeoutError: the service was not available in time.
        ServiceError: the master cannot look up services.
        NodeShutdownError: the node is shutting down.
    """
    check_timeout(timeout)
    started_at = monotonic()
    last_warned_at = started_at
    while True:
        context.check_running()
        uri, failure = "", "cannot be reached"
        try:
            uri = master.lookup_service(service)
            probe(context, service, uri, PROBE_TIMEOUT if timeout is None else min(PROBE_TIMEOUT, max(timeout, 0.1)))
            return
        except MasterMethodError as error:
            raise ServiceError(f"cannot wait for service [{service}]: {error}") from error
        except (MasterError, ServiceError, WaitTimeoutError, ProtocolError) as error:
            if uri and isinstance(error.__cause__, TimeoutError):
                failure = "does not answer (was its node stopped?)"
        now = monotonic()
        if timeout is not None and now - started_at >= timeout:
            details = f": it is registered at {uri}, but {failure}" if uri else ""
            raise WaitTimeoutError(f"timeout exceeded while waiting for service {service}{details}")
        if now - last_warned_at >= (
            10.0 if last_warned_at > started_at or failure == "cannot be reached" else PROBE_TIMEOUT
        ):
            last_warned_at = now
            state = f"registered at {uri}, but {failure}" if uri else "no node provides it yet"
            context.log.warn("waiting for service %s: %s", service, state)
        context.pause(0.05 if timeout is None else min(0.05, max(0.001, timeout - (now - started_at))))
