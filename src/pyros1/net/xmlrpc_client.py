"""A blocking XML-RPC client with deadlines, whose pending call can be interrupted."""

from __future__ import annotations

import contextlib
import os
import select
import socket
import threading
from typing import Any

from pyros1.ground.errors import DeadlineError, ProtocolError, UnknownHostError, UnreachableError
from pyros1.net.hosts import parse_uri
from pyros1.net.resolve import HostLookup
from pyros1.net.timeouts import TransferDeadline, limit_unsent
from pyros1.wire.http import Response, ResponseParser, build_request
from pyros1.wire.xmlrpc import dumps_call, loads_response


class _ConnectionLostError(Exception):
    """The connection was closed before a response arrived."""


class XmlRpcClient:
    """Client for one URI, over a connection that is kept open.

    Calls from several threads take turns. A signal handler that makes a call while its thread is making one uses
    another connection, and so does a forked process.

    Args:
        uri: ``http://host:port/``.
        timeout: maximum number of seconds for a call, including connecting; extended while a large amount of data is
            transferred (`TransferDeadline`).

    Raises:
        ProtocolError: the URI is not valid.
    """

    def __init__(self, uri: str, *, timeout: float = 10.0) -> None:
        self.uri = uri
        self.timeout = timeout
        self._host, self._port = parse_uri(uri)
        self._path = "/" + uri.partition("://")[2].partition("/")[2]
        self._closed = False
        self._sock: socket.socket | None = None
        self._lookup: HostLookup | None = None  # the look-up in progress
        self._initialize_state()

    def _initialize_state(self) -> None:
        self._lock = threading.RLock()
        self._is_call_running = False  # whether the thread that holds the lock is making a call
        self._parser = ResponseParser()  # one for each connection: it remembers the form of the responses
        self._pid = os.getpid()

    def call(self, method: str, *params: Any, timeout: float | None = None) -> Any:
        """Call a method, wait for the response and return the result.

        Args:
            method: the name of the method.
            params: the method's arguments.
            timeout: maximum number of seconds for this call; None for the client's timeout.

        Raises:
            UnreachableError: no connection was possible, it was lost, or the client was closed. Its subclass
                UnknownHostError means that the host's name cannot be resolved.
            DeadlineError: there was no response in time.
            ProtocolError: the response is not XML-RPC over HTTP.
            XmlRpcFault: the response is a fault.
            SerializationError: an argument cannot be encoded.
        """
        body = dumps_call(method, params)
        seconds = self.timeout if timeout is None else timeout
        transfer_deadline = TransferDeadline(seconds)
        if self._pid != os.getpid():
            self._disconnect()  # connection, look-up thread and lock belong to the parent process
            self._lookup = None
            self._initialize_state()
        if not self._lock.acquire(timeout=max(0.0, seconds)):
            raise self._deadline_error(seconds)
        if self._is_call_running:
            return self._call_separately(method, params, seconds)
        try:
            self._is_call_running = True
            response = self._exchange(build_request(f"{self._host}:{self._port}", self._path, body), transfer_deadline)
        except TimeoutError as error:
            self._disconnect()
            raise self._deadline_error(seconds) from error
        except (OSError, _ConnectionLostError, ProtocolError) as error:
            self._disconnect()
            if self._closed:
                raise UnreachableError(f"the call to {self.uri} was cancelled: the client was closed") from error
            if isinstance(error, ProtocolError):
                raise
            reason = getattr(error, "strerror", None) or str(error)
            raise UnreachableError(f"cannot reach {self.uri}: {reason}") from error
        except BaseException:
            self._disconnect()  # otherwise the next call would get the response to this one
            raise
        finally:
            self._is_call_running = False
            self._lock.release()
            if self._closed:  # another thread called close() during the call, and could not acquire the lock
                self._disconnect_if_free()
        if response.status != 200:
            raise ProtocolError(f"{self.uri} answered with HTTP status {response.status} {response.reason}".rstrip())
        return loads_response(response.body)

    def _call_separately(self, method: str, params: tuple[Any, ...], timeout: float) -> Any:
        separate_client = XmlRpcClient(self.uri, timeout=timeout)
        try:
            if self._closed:
                separate_client.close()
            return separate_client.call(method, *params)
        finally:
            separate_client.close()
            self._lock.release()

    def close(self) -> None:
        """Close the connection; a call pending in another thread fails immediately."""
        self._closed = True
        sock = self._sock
        if sock is not None:
            with contextlib.suppress(OSError):
                sock.shutdown(socket.SHUT_RDWR)  # wakes the other thread; close() alone would not
        if (lookup := self._lookup) is not None:
            lookup.cancel()
        self._disconnect_if_free()

    def _disconnect_if_free(self) -> None:
        if self._lock.acquire(blocking=False):
            try:
                if not self._is_call_running:
                    self._disconnect()
            finally:
                self._lock.release()

    def _deadline_error(self, seconds: float) -> DeadlineError:
        return DeadlineError(f"{self.uri} did not answer within {seconds:g} s")

    def _disconnect(self) -> None:
        sock, self._sock = self._sock, None
        if sock is not None:
            sock.close()

    def _exchange(self, request: bytes, transfer_deadline: TransferDeadline) -> Response:
        """Send a request and read the response; if the peer has closed the open connection, use a new one."""
        if self._sock is not None:
            if not _is_readable_now(self._sock):
                try:
                    return self._exchange_once(self._sock, request, transfer_deadline)
                except TimeoutError:
                    raise
                except (OSError, _ConnectionLostError):
                    if self._closed:
                        raise
            # The peer has closed the connection, or sent unexpected bytes.
            self._disconnect()
        return self._exchange_once(self._connect(transfer_deadline), request, transfer_deadline)

    def _connect(self, transfer_deadline: TransferDeadline) -> socket.socket:
        last_error: OSError = OSError("no address")
        addresses = self._look_up_addresses(transfer_deadline)
        for index, address in enumerate(addresses):
            sock = socket.socket(socket.AF_INET6 if ":" in address else socket.AF_INET, socket.SOCK_STREAM)
            self._sock = sock  # so that close() can interrupt the attempt
            self._parser = ResponseParser()
            if self._closed:
                raise OSError("closed")
            try:
                sock.settimeout(_remaining_time(transfer_deadline) / (len(addresses) - index))
                sock.connect((address, self._port))
                if sock.getsockname() == sock.getpeername():  # see net.connect
                    raise ConnectionRefusedError(os.strerror(111))
                sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                limit_unsent(sock)
            except OSError as error:
                last_error = error
                self._disconnect()
                continue
            return sock
        raise last_error

    def _look_up_addresses(self, transfer_deadline: TransferDeadline) -> list[str]:
        if self._lookup is None:  # otherwise, a look-up that took too long for an earlier call is still in progress
            self._lookup = HostLookup(self._host)
        if self._closed:
            raise OSError("closed")
        try:
            # If the deadline has already passed, waiting for 0 seconds raises the same error.
            addresses = self._lookup.wait(max(transfer_deadline.remaining(), 0.0))
        except TimeoutError as error:
            raise UnknownHostError(self._host, error) from error
        except OSError as error:
            self._lookup = None
            if self._closed:
                raise
            raise UnknownHostError(self._host, error) from error
        self._lookup = None
        return addresses

    def _exchange_once(self, sock: socket.socket, request: bytes, transfer_deadline: TransferDeadline) -> Response:
        remaining = memoryview(request)
        while remaining:
            sock.settimeout(_remaining_time(transfer_deadline))
            sent = sock.send(remaining)
            transfer_deadline.add_bytes(sent)
            remaining = remaining[sent:]
        parser = self._parser
        while True:
            sock.settimeout(_remaining_time(transfer_deadline))
            data = sock.recv(256 * 1024)
            transfer_deadline.add_bytes(len(data))
            if not data:
                response = parser.eof()
                if response is None:
                    raise _ConnectionLostError("the connection was closed before a response arrived")
                break
            parser.feed(data)
            response = parser.next_message()
            if response is not None:
                break
        if not response.keep_alive or parser.in_message:
            self._disconnect()
        return response


def _remaining_time(transfer_deadline: TransferDeadline) -> float:
    remaining = transfer_deadline.remaining()
    if remaining <= 0:
        raise TimeoutError
    return remaining


def _is_readable_now(sock: socket.socket) -> bool:
    """Return whether an idle connection is readable: the peer has closed it, or sent unexpected bytes."""
    if hasattr(select, "poll"):
        poll = select.poll()
        poll.register(sock, select.POLLIN)
        return bool(poll.poll(0))
    return bool(select.select([sock], [], [], 0)[0])
