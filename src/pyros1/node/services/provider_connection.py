"""The connection to a service's provider, for one call or a series of calls."""

from __future__ import annotations

import contextlib
import errno
import socket
from functools import partial
from math import inf
from time import monotonic
from typing import TYPE_CHECKING

from pyros1.ground.errors import (
    NodeShutdownError,
    ProtocolError,
    ServiceUnavailableError,
    UnknownHostError,
    WaitTimeoutError,
)
from pyros1.net.blocking_connect import blocking_connect
from pyros1.net.connectivity import connectivity_hint
from pyros1.net.hosts import parse_uri
from pyros1.net.keepalive import is_peer_dead, set_nodelay_and_keepalive
from pyros1.net.spin_wait import DONTWAIT, SpinWait
from pyros1.net.timeouts import SOCKET_TIMEOUTS, set_socket_timeouts
from pyros1.node import same_host
from pyros1.wire.service import RESPONSE_HEAD_SIZE, decode_response_head

if TYPE_CHECKING:
    from pyros1.node.context import Context

CONNECT_TIMEOUT = 10.0
SILENCE_TIMEOUT = 5.0
"""Seconds after which the log reports a provider that has not sent its header; even a busy node sends its header."""
POLL_INTERVAL = 0.2
"""Seconds after which a waiting call checks again whether its node is shutting down."""


class ProviderConnection:
    """The connection to a service's provider; all waits are aborted at the deadline, or when the node shuts down.

    Args:
        context: context of the calling node.
        service: the service's full name.
        uri: the provider's URI, ``rosrpc://host:port``.
        deadline: the deadline in `monotonic` time; None for no limit.
        spin_wait: waits for responses, and learns from earlier calls; None if there are no earlier calls.

    Attributes:
        data: bytes that were received but have not been used yet.
        has_header: whether the provider's header has been received.
        header: the provider's header.
        is_local: whether the connection is a Unix socket, to a pyros1 node of the same user on this machine.

    Raises:
        ServiceUnavailableError: the provider cannot be reached.
        WaitTimeoutError: the deadline has passed.
        NodeShutdownError: the node is shutting down.
    """

    def __init__(
        self, context: Context, service: str, uri: str, deadline: float | None, spin_wait: SpinWait | None = None
    ) -> None:
        self._context = context
        self._spin_wait = spin_wait or SpinWait()
        self.service = service
        self.deadline = deadline
        try:
            host, port = parse_uri(uri, "rosrpc")
        except ProtocolError as error:
            raise ServiceUnavailableError(f"service [{service}] is registered with a wrong address: {error}") from error
        self.data = b""
        self.header: dict[str, str] = {}
        local_sock = self._connect_local(uri)
        self.is_local = local_sock is not None
        try:
            self.sock = local_sock or blocking_connect(
                host, port, CONNECT_TIMEOUT, lambda: self._remaining_time(POLL_INTERVAL)
            )
        except WaitTimeoutError:
            raise
        except (OSError, UnknownHostError) as error:
            raise ServiceUnavailableError(
                f"service [{service}] is registered at {uri}, but cannot be reached: {error}. "
                f"{connectivity_hint(host, error, context.host)}"
            ) from error
        self._recv = partial(self.sock.recv, 65536)
        set_nodelay_and_keepalive(self.sock)
        self._socket_timeout = 0.0
        self._uri = uri
        self._warn_at = monotonic() + SILENCE_TIMEOUT
        self.has_header = False

    def _connect_local(self, uri: str) -> socket.socket | None:
        """Return a connection over a Unix socket; None if the provider has none for this user on this machine."""
        self._remaining_time(POLL_INTERVAL)
        key = self._context.local_key
        if not key:
            return None
        try:
            sock = same_host.connect(same_host.socket_name_for(uri, key))
        except OSError:
            return None
        sock.setblocking(True)
        return sock

    def _set_socket_timeout(self) -> None:
        """Set the timeout of the next socket call, so that the deadline and the shutdown of the node are noticed in
        time.
        """
        remaining = self._remaining_time(POLL_INTERVAL)
        if remaining != self._socket_timeout:
            set_socket_timeouts(self.sock, remaining)
            self._socket_timeout = remaining

    def _remaining_time(self, maximum: float) -> float:
        if self._context.stopping.is_set():
            raise NodeShutdownError(f"call to {self.service}: the node is shutting down")
        if self.deadline is None:
            return maximum
        remaining = self.deadline - monotonic()
        if remaining <= 0:
            raise WaitTimeoutError(f"service [{self.service}] did not answer in time")
        return min(maximum, remaining)

    def _check_peer(self, error: OSError) -> None:
        """Raise ConnectionError if the system has given up the connection, or should have done so by now."""
        if error.errno == errno.ETIMEDOUT or is_peer_dead(self.sock):
            raise ConnectionError("the provider's machine no longer answers")

    def send(self, data: bytes) -> None:
        """Send all of the data.

        Raises:
            WaitTimeoutError: the deadline has passed.
            NodeShutdownError: the node is shutting down.
            OSError: the connection is broken.
        """
        remaining_data: bytes | memoryview = data
        while remaining_data:
            self._set_socket_timeout()
            try:
                sent = self.sock.send(remaining_data)
                remaining_data = b"" if sent == len(remaining_data) else memoryview(remaining_data)[sent:]
            except SOCKET_TIMEOUTS as error:
                self._check_peer(error)  # the deadline is checked by `_remaining_time`

    def receive(self) -> bytes:
        """Wait for bytes from the provider and return them.

        Raises:
            ConnectionError: the provider has closed the connection, or its machine no longer responds.
            WaitTimeoutError, NodeShutdownError, OSError: as for `send`.
        """
        while True:
            self._set_socket_timeout()
            try:
                data = self._spin_wait.wait(self._recv)
            except SOCKET_TIMEOUTS as error:
                self._check_peer(error)  # the deadline is checked by `_remaining_time`
                self._warn_silent_provider()
                continue
            if not data:
                self._context.check_running()
                raise ConnectionError("the provider closed the connection")
            return data

    def _warn_silent_provider(self) -> None:
        if not self.has_header and monotonic() > self._warn_at:
            self._warn_at = inf
            self._context.log.warn(
                "a call to service %s is waiting for %s, which does not answer. "
                "Is its node stopped, or is another program using its port?",
                self.service,
                self._uri,
            )

    @property
    def is_broken(self) -> bool:
        """Whether the provider has sent unrequested data, so that each later call would get the wrong response."""
        if self.data:
            return True
        if not (self.has_header and DONTWAIT):
            return False
        try:
            return bool(self.sock.recv(1, DONTWAIT | socket.MSG_PEEK))
        except OSError:  # no data, or the connection is broken, which the call will report
            return False

    def receive_response(self) -> tuple[bool, bytes]:
        """Receive a response; return whether the call succeeded, and the body of the response.

        Raises:
            ProtocolError: the response is too large.
            ConnectionError, WaitTimeoutError, NodeShutdownError, OSError: as for `receive`.
        """
        data = self.data or self.receive()
        while len(data) < RESPONSE_HEAD_SIZE:
            data += self.receive()
        ok, size = decode_response_head(data)
        end = RESPONSE_HEAD_SIZE + size
        if len(data) < end:
            parts, received = [data], len(data)
            while received < end:
                parts.append(self.receive())
                received += len(parts[-1])
            data = b"".join(parts)
        self.data = data[end:]
        return ok, data[RESPONSE_HEAD_SIZE:end]

    def abort(self) -> None:
        """Make a call in progress in another thread fail; that thread then closes the connection."""
        with contextlib.suppress(OSError):
            self.sock.shutdown(socket.SHUT_RDWR)  # wakes a thread that is waiting for a response

    def close(self) -> None:
        """Close the connection; a call in progress in another thread fails."""
        self.abort()
        self.sock.close()
