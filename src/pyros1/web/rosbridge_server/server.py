"""Serves rosbridge clients on a port, without the page of `pyros1 web`.

As with the original, anyone who can reach the port may connect, even from pages of other sites; PYROS1_ALLOW restricts
access to some machines.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import os
import socket
import ssl
from collections.abc import AsyncIterator
from http import HTTPStatus

from websockets.asyncio.server import Server, ServerConnection, serve
from websockets.http11 import Request, Response

from pyros1.ground.errors import Error
from pyros1.ground.terminal_text import one_line
from pyros1.net.allowlist import make_allowlist
from pyros1.net.hosts import addresses_from_environment
from pyros1.node import Node
from pyros1.web.robot import Robot
from pyros1.web.rosbridge.driver import Bridge
from pyros1.web.rosbridge_server.clients import ClientList
from pyros1.web.rosbridge_server.settings import Settings
from pyros1.web.server.access import Access
from pyros1.web.server.pending_connections import PendingConnections
from pyros1.web.server.threads import ThreadPool
from pyros1.web.service_calls import MAX_CONCURRENT_CALLS

MAX_CLIENTS = 256
_CLEANUP_PERIOD = 10.0
"""Seconds between cleanups of publishers that are no longer used."""

_REPORT_PERIOD = 1.0
"""Minimum number of seconds between log messages about clients' errors."""


class TlsError(Error):
    """The files for TLS cannot be used."""


class BridgeServer:
    """Serves rosbridge clients for a node.

    Args:
        node: the node that publishes, subscribes and calls services for the clients.
        settings: the node's parameters.
    """

    def __init__(self, node: Node, settings: Settings) -> None:
        self._node = node
        self._settings = settings
        access = Access(
            token="",
            topics=settings.topics,
            services=settings.services,
            parameters=settings.parameters,
            allowlist=make_allowlist(addresses_from_environment(node.environ, node.arguments.special).allowed),
        )
        self._robot = Robot(node.master_uri, access, lambda: node, has_console=False)
        self._clients = ClientList(node)

    def run(self) -> None:
        """Serve clients until the node shuts down.

        Raises:
            TlsError: the files for TLS cannot be used.
        """
        try:
            asyncio.run(self._serve())
        finally:
            self._robot.close()

    async def _serve(self) -> None:
        ended = asyncio.Event()
        loop = asyncio.get_running_loop()

        def end() -> None:
            with contextlib.suppress(RuntimeError):  # the loop is closed
                loop.call_soon_threadsafe(ended.set)

        self._node.on_shutdown(end)
        async with self._listen(ended) as server:
            if server is None:
                return
            self._robot.start()
            port = next(iter(server.sockets)).getsockname()[1]
            self._node.params["~actual_port"] = port
            scheme = "wss" if self._settings.certificate else "ws"
            self._node.log.info("the rosbridge server listens at %s://%s:%d", scheme, self._settings.address, port)
            while not ended.is_set():
                with contextlib.suppress(asyncio.TimeoutError):
                    await asyncio.wait_for(ended.wait(), _CLEANUP_PERIOD)
                await asyncio.to_thread(self._robot.clean_up)
            await asyncio.to_thread(self._robot.close)  # ends everything that clients are waiting for

    def _report(self, text: str) -> None:
        """Log an error that was sent to a client, since many clients do not show it."""
        self._node.log.error("a client's request failed: %s", one_line(text, 300), throttle=_REPORT_PERIOD)

    @contextlib.asynccontextmanager
    async def _listen(self, ended: asyncio.Event) -> AsyncIterator[Server | None]:
        """Listen while the context is active; yield the listening server, or None if the node shuts down before the
        port is available.
        """
        threads = ThreadPool(MAX_CLIENTS * MAX_CONCURRENT_CALLS, "rosbridge: services")
        bridge = Bridge(self._robot, threads, self._report)
        pending = PendingConnections(self._robot.access.allowlist)
        logger = logging.getLogger("pyros1.web")
        logger.addHandler(logging.NullHandler())
        logger.propagate = False

        async def serve_client(connection: ServerConnection) -> None:
            pending.remove(connection)
            self._clients.add(connection, str(connection.remote_address[0]))
            try:
                await bridge.serve(connection)
            finally:
                self._clients.remove(connection)

        def refuse(connection: ServerConnection, request: Request) -> Response | None:
            origins = request.headers.get_all("Origin")
            if "null" in origins and not self._settings.allows_null_origin:
                return connection.respond(HTTPStatus.FORBIDDEN, "Pages without an origin may not connect.\n")
            if len(self._clients) >= MAX_CLIENTS:
                text = f"At most {MAX_CLIENTS} clients may be connected.\n"
                return connection.respond(HTTPStatus.SERVICE_UNAVAILABLE, text)
            return None

        settings = self._settings
        tls = _make_tls(settings)
        try:
            while not ended.is_set():
                try:
                    server = await serve(
                        serve_client,
                        settings.address,
                        settings.port,
                        ssl=tls,
                        create_connection=pending.create_connection,  # type: ignore[arg-type]  # returns a connection
                        process_request=refuse,
                        max_size=settings.max_message_size,
                        max_queue=2,  # low, since frames may be large
                        compression="deflate" if settings.compresses else None,
                        server_header=None,
                        close_timeout=2,
                        ping_interval=settings.ping_interval,
                        ping_timeout=settings.ping_timeout,
                        logger=logger,
                    )
                except OSError as error:
                    self._node.log.warn(
                        "cannot listen on %s:%d: %s. Trying again in %g s",
                        settings.address,
                        settings.port,
                        _describe(error),
                        settings.retry_delay,
                    )
                    with contextlib.suppress(asyncio.TimeoutError):
                        await asyncio.wait_for(ended.wait(), settings.retry_delay)
                    continue
                async with server:
                    yield server
                return
            yield None
        finally:
            threads.shutdown(wait=False, cancel_futures=True)
            bridge.close()


def _describe(error: OSError) -> str:
    """Return the system's error message. asyncio puts it into a sentence of its own, except for unknown hosts."""
    if isinstance(error, socket.gaierror) or not error.errno:
        return error.strerror or str(error)
    return os.strerror(error.errno)


def _make_tls(settings: Settings) -> ssl.SSLContext | None:
    if not settings.certificate:
        return None
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    try:
        context.load_cert_chain(settings.certificate, settings.key)
    except (OSError, ssl.SSLError) as error:
        raise TlsError(
            f"cannot use {settings.certificate} and {settings.key} for TLS: {error.strerror or error}"
        ) from None
    return context
