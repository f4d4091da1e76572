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
from pyros1.net.resolve import LookUp
from pyros1.net.timeouts import Patience, show_progress
from pyros1.wire.http import Response, ResponseParser, build_request
from pyros1.wire.xmlrpc import dumps_call, loads_response


class _LostError(Exception):
    """The connection ended before any byte of an answer came."""


class XmlRpcClient:
    """Client of one URI, over one connection that is kept open.

    Calls from several threads take turns. A signal handler that calls on top of a call of its own thread gets another
    connection, and so does a forked process.

    Args:
        uri: ``http://host:port/``.
        timeout: seconds that a call may take, connecting included; longer while much data move (`Patience`).

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
        self._look_up: LookUp | None = None  # under way
        self._begin()

    def _begin(self) -> None:
        self._lock = threading.RLock()
        self._busy = False  # the thread that has the lock is making a call
        self._parser = ResponseParser()  # of the connection: it remembers the form of the answers
        self._pid = os.getpid()

    def call(self, method: str, *params: Any, timeout: float | None = None) -> Any:
        """Call a method and wait for its answer.

        Args:
            timeout: seconds for this call; None: the client's timeout.

        Raises:
            UnreachableError: no connection, or it was lost, or the client was closed. UnknownHostError, if the host's
                name cannot be resolved.
            DeadlineError: no answer in time.
            ProtocolError: the answer is not XML-RPC over HTTP.
            XmlRpcFault: the answer is a fault.
            SerializationError: a parameter cannot be sent.
        """
        body = dumps_call(method, params)
        seconds = self.timeout if timeout is None else timeout
        patience = Patience(seconds)
        if self._pid != os.getpid():
            self._drop()  # the connection, the thread of a look-up, and who holds the lock, are the other process's
            self._look_up = None
            self._begin()
        if not self._lock.acquire(timeout=max(0.0, seconds)):
            raise self._too_late(seconds)
        if self._busy:
            return self._call_aside(method, params, seconds)
        try:
            self._busy = True
            response = self._exchange(build_request(f"{self._host}:{self._port}", self._path, body), patience)
        except TimeoutError as error:
            self._drop()
            raise self._too_late(seconds) from error
        except (OSError, _LostError, ProtocolError) as error:
            self._drop()
            if self._closed:
                raise UnreachableError(f"the call to {self.uri} was cancelled: the client was closed") from error
            if isinstance(error, ProtocolError):
                raise
            reason = getattr(error, "strerror", None) or str(error)
            raise UnreachableError(f"cannot reach {self.uri}: {reason}") from error
        except BaseException:
            self._drop()  # or the next call would get the answer to this one
            raise
        finally:
            self._busy = False
            self._lock.release()
            if self._closed:  # closed meanwhile by a thread that could not take the lock
                self._drop_if_free()
        if response.status != 200:
            raise ProtocolError(f"{self.uri} answered with HTTP status {response.status} {response.reason}".rstrip())
        return loads_response(response.body)

    def _call_aside(self, method: str, params: tuple[Any, ...], timeout: float) -> Any:
        other = XmlRpcClient(self.uri, timeout=timeout)
        try:
            if self._closed:
                other.close()
            return other.call(method, *params)
        finally:
            other.close()
            self._lock.release()

    def close(self) -> None:
        """Close the connection; a call that is pending in another thread fails at once."""
        self._closed = True
        sock = self._sock
        if sock is not None:
            with contextlib.suppress(OSError):
                sock.shutdown(socket.SHUT_RDWR)  # wakes the other thread; close() alone would not
        if (look_up := self._look_up) is not None:
            look_up.give_up()
        self._drop_if_free()

    def _drop_if_free(self) -> None:
        if self._lock.acquire(blocking=False):
            try:
                if not self._busy:
                    self._drop()
            finally:
                self._lock.release()

    def _too_late(self, seconds: float) -> DeadlineError:
        return DeadlineError(f"{self.uri} did not answer within {seconds:g} s")

    def _drop(self) -> None:
        sock, self._sock = self._sock, None
        if sock is not None:
            sock.close()

    def _exchange(self, request: bytes, patience: Patience) -> Response:
        """Send a request and read the answer, on a fresh connection if the kept one turns out to be closed."""
        if self._sock is not None:
            if not _readable_now(self._sock):
                try:
                    return self._once(self._sock, request, patience)
                except TimeoutError:
                    raise
                except (OSError, _LostError):
                    if self._closed:
                        raise
            # It was closed by the other side, or has unexpected bytes.
            self._drop()
        return self._once(self._connect(patience), request, patience)

    def _connect(self, patience: Patience) -> socket.socket:
        last: OSError = OSError("no address")
        addresses = self._addresses(patience)
        for number, address in enumerate(addresses):
            sock = socket.socket(socket.AF_INET6 if ":" in address else socket.AF_INET, socket.SOCK_STREAM)
            self._sock = sock  # so that close() can interrupt
            self._parser = ResponseParser()
            if self._closed:
                raise OSError("closed")
            try:
                sock.settimeout(_left(patience) / (len(addresses) - number))
                sock.connect((address, self._port))
                if sock.getsockname() == sock.getpeername():  # see net.connect
                    raise ConnectionRefusedError(os.strerror(111))
                sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                show_progress(sock)
            except OSError as error:
                last = error
                self._drop()
                continue
            return sock
        raise last

    def _addresses(self, patience: Patience) -> list[str]:
        if self._look_up is None:  # or one that took too long for an earlier call
            self._look_up = LookUp(self._host)
        if self._closed:
            raise OSError("closed")
        try:
            addresses = self._look_up.wait(_left(patience))
        except TimeoutError as error:
            raise UnknownHostError(self._host, error) from error
        except OSError as error:
            self._look_up = None
            if self._closed:
                raise
            raise UnknownHostError(self._host, error) from error
        self._look_up = None
        return addresses

    def _once(self, sock: socket.socket, request: bytes, patience: Patience) -> Response:
        rest = memoryview(request)
        while rest:
            sock.settimeout(_left(patience))
            sent = sock.send(rest)
            patience.moved(sent)
            rest = rest[sent:]
        parser = self._parser
        while True:
            sock.settimeout(_left(patience))
            data = sock.recv(256 * 1024)
            patience.moved(len(data))
            if not data:
                response = parser.eof()
                if response is None:
                    raise _LostError("the connection was closed before an answer came")
                break
            parser.feed(data)
            response = parser.next_message()
            if response is not None:
                break
        if not response.keep_alive or parser.in_message:
            self._drop()
        return response


def _left(patience: Patience) -> float:
    left = patience.left()
    if left <= 0:
        raise TimeoutError
    return left


def _readable_now(sock: socket.socket) -> bool:
    """Return whether an idle connection can be read: the other side has closed it, or sent unexpected bytes."""
    if hasattr(select, "poll"):
        poll = select.poll()
        poll.register(sock, select.POLLIN)
        return bool(poll.poll(0))
    return bool(select.select([sock], [], [], 0)[0])
