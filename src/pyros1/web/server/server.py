"""Serves the page's files, and the WebSockets of pages, viewers and other programs, all on one port.

Everything that can take time runs in threads, so that a slow page, node or master does not delay others. WebSockets are
described in https://www.rfc-editor.org/rfc/rfc6455.
"""

from __future__ import annotations

import asyncio
import contextlib
import errno
import json
import logging
import socket
from collections.abc import AsyncIterator, Callable, Coroutine, Sequence
from concurrent.futures import Executor
from contextlib import closing
from http import HTTPStatus
from time import monotonic
from typing import Any
from urllib.parse import parse_qs, urlsplit

from websockets.asyncio.server import Server, ServerConnection, serve
from websockets.datastructures import Headers, MultipleValuesError
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response
from websockets.protocol import State
from websockets.typing import Subprotocol

from pyros1.web import calls
from pyros1.web.foxglove import PROTOCOLS as FOXGLOVE_PROTOCOLS
from pyros1.web.foxglove.connection import Viewer
from pyros1.web.foxglove.viewer_context import ViewerContext
from pyros1.web.package_files import FileError
from pyros1.web.robot import Robot
from pyros1.web.rosbridge.driver import Bridge
from pyros1.web.rosbridge.frame_decoder import MAX_FRAME
from pyros1.web.server import wire
from pyros1.web.server.access import MAX_PAGES, Access
from pyros1.web.server.assets import SECURITY_HEADERS, Assets
from pyros1.web.server.pending_connections import PendingConnections
from pyros1.web.server.sending import send_frames
from pyros1.web.server.session import Session
from pyros1.web.server.threads import ThreadPool
from pyros1.web.server.waiting import wait_for_event
from pyros1.web.server.wire import RequestError
from pyros1.web.service_calls import MAX_CONCURRENT_CALLS

PROTOCOL = Subprotocol("pyros1.v1")
SOCKET_PATH = "/ws"
"""Path of the page's WebSocket."""
PACKAGE_FILE_PATH = "/package_file"
"""Path of requests for meshes and textures: ``/package_file?token=...&uri=package://NAME/PATH``."""
_CONTENT_TYPES = {
    "bmp": "image/bmp",
    "dae": "application/octet-stream",
    "gif": "image/gif",
    "jpeg": "image/jpeg",
    "jpg": "image/jpeg",
    "mtl": "application/octet-stream",
    "obj": "application/octet-stream",
    "png": "image/png",
    "stl": "application/octet-stream",
    "tga": "application/octet-stream",
    "webp": "image/webp",
}
"""Suffix -> content type of the package files that are served. Browsers do not open any of these types as a page."""
_ROSBRIDGE_PATHS = ("/", "/rosbridge")
"""WebSocket paths for rosbridge clients."""
_MAX_CONCURRENT_CALLS = 16
"""Maximum number of concurrent calls per page; further calls wait."""
_MAX_FINAL_REQUESTS = 64
"""Maximum number of a page's remaining requests that are handled after the page has disconnected."""
_MAX_THREADS = 32
"""Maximum number of threads for pushes. The separate pool of threads for calls, which may take a long time, has the
same limit.
"""
_MAX_LOGGED_ERRORS = 100
_CLEANUP_PERIOD = 10.0
"""Seconds between cleanups of publishers that are no longer used."""
_MAX_PORT_ATTEMPTS = 20
"""Maximum number of attempts to find a port that is free at all of a host's addresses."""
_COALESCE_DELAY = 0.003
"""Seconds for which due pushes are collected, so that they are handled together."""


class WebServer:
    """Serves the page's files and all WebSockets.

    Args:
        robot: the robot that pages show.
        access: the access rules.
    """

    def __init__(self, robot: Robot, access: Access) -> None:
        self._robot = robot
        self._access = access
        self._assets = Assets()
        self._push_threads = ThreadPool(_MAX_THREADS, "web: pushes")
        self._call_threads = ThreadPool(_MAX_THREADS, "web: calls")
        self._service_threads = ThreadPool(MAX_PAGES * MAX_CONCURRENT_CALLS, "web: services")
        self._bridge = Bridge(robot, self._service_threads)
        self._viewer_context = ViewerContext(robot)
        self._pending_connections = PendingConnections(access.allowlist)
        self._num_pages = 0

    @contextlib.asynccontextmanager
    async def listen(self, host: str, port: int) -> AsyncIterator[Server]:
        """Serve as long as the context is active.

        Args:
            host: host name or address of the network interface on which to listen.
            port: the port; 0 for any free port.

        Raises:
            OSError: the port is not available.
        """
        logger = logging.getLogger("pyros1.web")
        logger.addHandler(logging.NullHandler())
        logger.propagate = False
        # Otherwise, asyncio would warn about each frame sent to a closed connection.
        logging.getLogger("asyncio").setLevel(logging.ERROR)
        asyncio.get_running_loop().set_exception_handler(_LoopErrorLog())
        try:
            async with await self._start_listening(host, port) as server:
                cleanup_task = asyncio.create_task(self._clean_up_periodically())
                try:
                    yield server
                finally:
                    cleanup_task.cancel()
        finally:
            for threads in (self._push_threads, self._call_threads, self._service_threads):
                threads.shutdown(wait=False, cancel_futures=True)
            self._bridge.close()

    async def _start_listening(self, host: str, port: int) -> Server:
        """Start listening; port 0 stands for a port that is free at all of the host's addresses."""
        for remaining in range(_MAX_PORT_ATTEMPTS - 1, -1, -1):
            try:
                server: Server = await serve(
                    self._serve_connection,
                    host,
                    port or await _find_free_port(host),
                    create_connection=self._pending_connections.create_connection,  # type: ignore[arg-type]  # returns a connection
                    process_request=self._process_request,
                    select_subprotocol=_choose_protocol,
                    max_size=MAX_FRAME,
                    max_queue=2,  # low, since frames may be large; several small frames are read together
                    compression=None,
                    server_header=None,
                    close_timeout=2,
                    ping_interval=2,  # so that periodic publishing ends soon after its page has vanished
                    ping_timeout=4,
                    logger=logging.getLogger("pyros1.web"),
                )
                return server
            except OSError as error:
                if port or not remaining or error.errno != errno.EADDRINUSE:
                    raise
        raise AssertionError  # the last attempt returns or raises

    async def _clean_up_periodically(self) -> None:
        while True:
            await asyncio.sleep(_CLEANUP_PERIOD)
            await asyncio.get_running_loop().run_in_executor(self._call_threads, self._robot.clean_up)

    async def _process_request(self, connection: ServerConnection, request: Request) -> Response | None:
        """Return the response to an HTTP request; None to accept a WebSocket."""
        try:
            return await self._respond(request)
        except (ValueError, MultipleValuesError):  # from urlsplit, and from duplicate Host or Origin headers
            return _text_response(HTTPStatus.BAD_REQUEST, "This is not a valid request.\n")

    async def _respond(self, request: Request) -> Response | None:
        host = request.headers.get("Host")
        if not self._access.is_own_name(host):
            return _text_response(
                HTTPStatus.FORBIDDEN, "This server does not answer to this host name. Use the link that it printed.\n"
            )
        path = urlsplit(request.path).path
        if path == SOCKET_PATH or (path in _ROSBRIDGE_PATHS and _is_websocket_request(request)):
            return self._admit(request)
        if path == PACKAGE_FILE_PATH:
            if problem := self._access.token_problem(request.path):
                return _text_response(HTTPStatus.UNAUTHORIZED, f"{problem}\n")
            loop = asyncio.get_running_loop()
            return await loop.run_in_executor(self._call_threads, self._package_file, request.path)
        return self._page_file(path, request.headers.get("If-None-Match"))

    def _admit(self, request: Request) -> Response | None:
        """Return the response that refuses a WebSocket, or None to accept it; see
        `Access.allows_programs_from_anywhere`.
        """
        origin, host = request.headers.get("Origin"), request.headers.get("Host")
        is_allowed_program = _is_from_program(request) and self._access.allows_programs_from_anywhere
        if not is_allowed_program and not self._access.is_own_page(origin, host):
            return _text_response(HTTPStatus.FORBIDDEN, "Pages of other sites may not connect.\n")
        if problem := self._access.token_problem(request.path):
            return _text_response(HTTPStatus.UNAUTHORIZED, f"{problem}\n")
        if self._num_pages >= self._access.max_pages:
            message = f"At most {self._access.max_pages} pages and programs may be connected (option --max-pages).\n"
            return _text_response(HTTPStatus.SERVICE_UNAVAILABLE, message)
        return None

    def _page_file(self, path: str, etag: str | None) -> Response:
        if path == "/panels.json":
            return _make_response(
                HTTPStatus.OK, json.dumps(self._assets.panels).encode(), {"Content-Type": "application/json"}
            )
        asset = self._assets.get(path)
        if asset is None:
            return _text_response(HTTPStatus.NOT_FOUND, "Not found.\n")
        headers = {"Content-Type": asset.content_type, "ETag": asset.tag}
        if etag == asset.tag:
            return _make_response(HTTPStatus.NOT_MODIFIED, b"", headers)
        return _make_response(HTTPStatus.OK, asset.body, headers)

    def _package_file(self, path: str) -> Response:
        try:
            uri = parse_qs(urlsplit(path).query, max_num_fields=20).get("uri", [""])[0]
        except ValueError:
            uri = ""
        content_type = _CONTENT_TYPES.get(uri.rpartition(".")[2].lower())
        if content_type is None:
            return _text_response(HTTPStatus.FORBIDDEN, f"only {', '.join(_CONTENT_TYPES)} files are served\n")
        try:
            return _make_response(HTTPStatus.OK, self._robot.files.read(uri), {"Content-Type": content_type})
        except FileError as error:
            return _text_response(HTTPStatus.NOT_FOUND, f"{error}\n")

    async def _serve_connection(self, connection: ServerConnection) -> None:
        self._pending_connections.remove(connection)
        self._num_pages += 1
        try:
            # Each connection's tasks take turns with the tasks of other connections.
            push_queue, call_queue, service_queue = (
                threads.queue() for threads in (self._push_threads, self._call_threads, self._service_threads)
            )
            if connection.subprotocol in FOXGLOVE_PROTOCOLS:
                await Viewer(connection, self._viewer_context, push_queue, call_queue, service_queue).run()
            elif connection.request is not None and urlsplit(connection.request.path).path in _ROSBRIDGE_PATHS:
                await self._bridge.serve(connection)
            else:
                await _Page(connection, self._robot, push_queue, call_queue, service_queue).run()
        finally:
            self._num_pages -= 1


class _Page:
    """Drives a `Session`: one task reads requests, one starts due pushes, and each push and call is a task."""

    def __init__(
        self,
        connection: ServerConnection,
        robot: Robot,
        push_threads: Executor,
        call_threads: Executor,
        service_threads: Executor,
    ) -> None:
        self._connection = connection
        self._push_threads = push_threads
        self._call_threads = call_threads
        self._service_threads = service_threads
        self._loop = asyncio.get_running_loop()
        self._wake_event = asyncio.Event()
        self._wake_scheduled = False
        self._session = Session(robot, self._wake)
        self._tasks: set[asyncio.Task[None]] = set()
        self._call_slots = asyncio.Semaphore(_MAX_CONCURRENT_CALLS)
        self._num_running_service_calls = 0  # no other requests wait for these calls to finish

    async def run(self) -> None:
        self._start_task(self._push_due_streams)
        remaining_requests = _MAX_FINAL_REQUESTS
        try:
            async for text in self._connection:
                await self._handle_request(text)
                remaining_requests -= self._connection.state is not State.OPEN
                if remaining_requests <= 0:
                    break
        except ConnectionClosed:
            pass
        finally:
            for task in self._tasks:
                task.cancel()
            await asyncio.gather(*self._tasks, return_exceptions=True)
            await self._loop.run_in_executor(self._push_threads, self._session.close)

    async def _handle_request(self, text: str | bytes) -> None:
        try:
            request = wire.parse(text)
        except RequestError as error:
            await self._connection.close(1008, str(error)[:100])
            return
        if isinstance(request, wire.Call):
            if request.name in calls.LONG_CALLS:
                if self._num_running_service_calls < MAX_CONCURRENT_CALLS:
                    self._num_running_service_calls += 1
                    self._start_task(self._run_long_call, request)
                else:
                    problem = f"{MAX_CONCURRENT_CALLS} service calls are already waiting for responses"
                    await self._connection.send(wire.failure(request.id, problem))
                return
            await self._call_slots.acquire()
            self._start_task(self._run_call, request)
            return
        for frame in await self._loop.run_in_executor(self._push_threads, self._session.handle, request):
            await self._connection.send(frame)

    async def _run_call(self, call: wire.Call) -> None:
        try:
            frame = await self._loop.run_in_executor(self._call_threads, self._session.run_call, call)
            await self._connection.send(frame)
        finally:
            self._call_slots.release()

    async def _run_long_call(self, call: wire.Call) -> None:
        try:
            frame = await self._loop.run_in_executor(self._service_threads, self._session.run_call, call)
            await self._connection.send(frame)
        finally:
            self._num_running_service_calls -= 1

    async def _push_due_streams(self) -> None:
        while True:
            self._wake_event.clear()
            self._wake_scheduled = False
            stream_numbers, next_time = self._session.take_due_streams(monotonic())
            for number in stream_numbers:
                self._start_task(self._push, number)
            timeout = None if next_time is None else max(0.0, next_time - monotonic())
            await wait_for_event(self._wake_event, timeout)
            await asyncio.sleep(_COALESCE_DELAY)

    async def _push(self, number: int) -> None:
        frame = await self._loop.run_in_executor(self._push_threads, self._session.push, number)
        if frame is not None:
            await send_frames(self._connection, (frame,))  # waits while the page is slow

    def _start_task(self, work: Callable[..., Coroutine[Any, Any, None]], *args: Any) -> None:
        async def guarded() -> None:
            with contextlib.suppress(ConnectionClosed):
                await work(*args)

        task = asyncio.create_task(guarded())
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def _wake(self) -> None:
        if not self._wake_scheduled:  # most messages arrive while a check is already scheduled
            self._wake_scheduled = True
            with contextlib.suppress(RuntimeError):  # the loop is closed
                self._loop.call_soon_threadsafe(self._wake_event.set)


class _LoopErrorLog:
    """Logs errors in the event loop, such as too many open files: each in one line, and only once."""

    def __init__(self) -> None:
        self._logged: set[str] = set()

    def __call__(self, _: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
        text = f"{context.get('message', 'an error occurred')}: {context.get('exception')!r}"[:500]
        if text not in self._logged and len(self._logged) < _MAX_LOGGED_ERRORS:
            self._logged.add(text)
            logging.getLogger("asyncio").error("pyros1 web: %s", text)


async def _find_free_port(host: str) -> int:
    """Return a port that is free at one of a host's addresses, and so probably at the others; 0 if there is none."""
    getaddrinfo = asyncio.get_running_loop().getaddrinfo
    for family, socket_type, protocol, _, address in await getaddrinfo(host or None, None, type=socket.SOCK_STREAM):
        with contextlib.suppress(OSError), closing(socket.socket(family, socket_type, protocol)) as probe:
            probe.bind((address[0], 0, *address[2:]))
            port: int = probe.getsockname()[1]
            return port
    return 0


def _is_websocket_request(request: Request) -> bool:
    return "websocket" in request.headers.get("Upgrade", "").lower()


def _is_from_program(request: Request) -> bool:
    """Return whether a request is from a rosbridge client or a viewer, rather than from the server's own page."""
    offered = [
        name.strip() for header in request.headers.get_all("Sec-WebSocket-Protocol") for name in header.split(",")
    ]
    is_viewer = not {*FOXGLOVE_PROTOCOLS}.isdisjoint(offered)
    return PROTOCOL not in offered and (is_viewer or urlsplit(request.path).path in _ROSBRIDGE_PATHS)


def _choose_protocol(_: ServerConnection, offered: Sequence[Subprotocol]) -> Subprotocol | None:
    return next((Subprotocol(name) for name in (PROTOCOL, *FOXGLOVE_PROTOCOLS) if name in offered), None)


def _text_response(status: HTTPStatus, text: str) -> Response:
    return _make_response(status, text.encode(), {"Content-Type": "text/plain; charset=utf-8"})


def _make_response(status: HTTPStatus, body: bytes, headers: dict[str, str]) -> Response:
    all_headers = {**SECURITY_HEADERS, **headers, "Content-Length": str(len(body)), "Connection": "close"}
    return Response(status.value, status.phrase, Headers(all_headers), body)
