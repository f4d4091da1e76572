"""The server: the page's files, a WebSocket for each page, and other programs', on one port.

See https://www.rfc-editor.org/rfc/rfc6455. Everything that can take time runs in threads, so that a slow page, node or
master delays nobody else.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
from collections.abc import AsyncIterator
from concurrent.futures import ThreadPoolExecutor
from http import HTTPStatus
from time import monotonic
from typing import Any
from urllib.parse import urlsplit

from websockets.asyncio.server import Server, ServerConnection, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response
from websockets.typing import Subprotocol

from pyros1.web import wire
from pyros1.web.access import Access
from pyros1.web.assets import SECURITY, Assets
from pyros1.web.robot import Robot
from pyros1.web.rosbridge.driver import Driver
from pyros1.web.rosbridge.intake import MAX_FRAME
from pyros1.web.session import Session
from pyros1.web.wire import RequestError

PROTOCOL = Subprotocol("pyros1.v1")
SOCKET = "/ws"
"""Path of the page's WebSocket."""
_OTHERS = ("/", "/rosbridge")
"""Paths of the WebSockets of other programs."""
MOST_PAGES = 64
_MOST_CALLS = 32
"""Most calls of a page that run at the same time; more wait."""
_THREADS = 32
_MOST_CALLS_OF_ALL = 64
"""Most calls of services for rosbridge's clients that run at the same time; more wait."""


class WebServer:
    """The server.

    Args:
        robot: what the pages are about.
        access: who may come in.
    """

    def __init__(self, robot: Robot, access: Access) -> None:
        self._robot = robot
        self._access = access
        self._assets = Assets()
        self._threads = ThreadPoolExecutor(_THREADS, "web")
        self._calls = ThreadPoolExecutor(_MOST_CALLS_OF_ALL, "web call")
        self._pages = 0

    @contextlib.asynccontextmanager
    async def listen(self, host: str, port: int) -> AsyncIterator[Server]:
        """Serve while the context lasts.

        Args:
            host: name or address of the interface.
            port: 0 for any.

        Raises:
            OSError: the port cannot be had.
        """
        quiet = logging.getLogger("pyros1.web")
        quiet.addHandler(logging.NullHandler())
        quiet.propagate = False
        try:
            async with serve(
                self._page,
                host,
                port,
                process_request=self._answer,
                select_subprotocol=lambda _, offered: PROTOCOL if PROTOCOL in offered else None,
                max_size=MAX_FRAME,
                max_queue=16,
                compression=None,
                server_header=None,
                close_timeout=2,
                logger=quiet,
            ) as server:
                yield server
        finally:
            self._threads.shutdown(wait=False, cancel_futures=True)
            self._calls.shutdown(wait=False, cancel_futures=True)

    def _answer(self, connection: ServerConnection, request: Request) -> Response | None:
        """Answer an HTTP request; None lets a WebSocket begin."""
        host = request.headers.get("Host")
        if not self._access.is_our_name(host):
            return _plain(HTTPStatus.FORBIDDEN, "This server has another name. Use the link that it printed.\n")
        path = urlsplit(request.path).path
        if path == SOCKET or (path in _OTHERS and _wants_socket(request)):
            return self._admit(request)
        return self._file(path, request.headers.get("If-None-Match"))

    def _admit(self, request: Request) -> Response | None:
        """Let a page's WebSocket begin, or say why not."""
        if not self._access.is_our_page(request.headers.get("Origin"), request.headers.get("Host")):
            return _plain(HTTPStatus.FORBIDDEN, "Another site's page may not come in.\n")
        if not self._access.has_token(request.path):
            return _plain(HTTPStatus.UNAUTHORIZED, "The link has a token. Use the link that the server printed.\n")
        if self._pages >= MOST_PAGES:
            return _plain(HTTPStatus.SERVICE_UNAVAILABLE, "Too many pages are open.\n")
        return None

    def _file(self, path: str, known: str | None) -> Response:
        if path == "/panels.json":
            return _response(
                HTTPStatus.OK, json.dumps(self._assets.panels).encode(), {"Content-Type": "application/json"}
            )
        asset = self._assets.get(path)
        if asset is None:
            return _plain(HTTPStatus.NOT_FOUND, "There is nothing here.\n")
        headers = {"Content-Type": asset.content_type, "ETag": asset.tag}
        if known == asset.tag:
            return _response(HTTPStatus.NOT_MODIFIED, b"", headers)
        return _response(HTTPStatus.OK, asset.body, headers)

    async def _page(self, socket: ServerConnection) -> None:
        self._pages += 1
        try:
            if socket.request is not None and urlsplit(socket.request.path).path in _OTHERS:
                await Driver(socket, self._robot, self._threads, self._calls).run()
            else:
                await _Page(socket, self._robot, self._threads).run()
        finally:
            self._pages -= 1


class _Page:
    """Drives a `Session`: one task reads, one sends, one per call."""

    def __init__(self, socket: ServerConnection, robot: Robot, threads: ThreadPoolExecutor) -> None:
        self._socket = socket
        self._threads = threads
        self._loop = asyncio.get_running_loop()
        self._awake = asyncio.Event()
        self._waking = False
        self._session = Session(robot, self._wake)
        self._turn = asyncio.Lock()  # of the session
        self._calls: set[asyncio.Task[None]] = set()
        self._room = asyncio.Semaphore(_MOST_CALLS)

    async def run(self) -> None:
        pushing = asyncio.create_task(self._push())
        try:
            async for text in self._socket:
                await self._take(text)
        except ConnectionClosed:
            pass
        finally:
            for task in (pushing, *self._calls):
                task.cancel()
            await asyncio.gather(pushing, *self._calls, return_exceptions=True)
            async with self._turn:
                await self._in_thread(self._session.close)

    async def _take(self, text: str | bytes) -> None:
        try:
            request = wire.parse(text)
        except RequestError as error:
            await self._socket.close(1008, str(error)[:100])
            return
        if isinstance(request, wire.Call):
            await self._room.acquire()
            task = asyncio.create_task(self._call(request))
            self._calls.add(task)
            task.add_done_callback(self._calls.discard)
            return
        async with self._turn:
            frames = await self._in_thread(self._session.handle, request)
        for frame in frames:
            await self._socket.send(frame)

    async def _call(self, call: wire.Call) -> None:
        try:
            frame = await self._in_thread(self._session.answer, call)
            with contextlib.suppress(ConnectionClosed):
                await self._socket.send(frame)
        finally:
            self._room.release()

    async def _push(self) -> None:
        with contextlib.suppress(ConnectionClosed):
            while True:
                self._awake.clear()
                self._waking = False
                async with self._turn:
                    frames, again = await self._in_thread(self._session.take, monotonic())
                for frame in frames:
                    await self._socket.send(frame)  # a slow page is waited for here, and only here
                wait = None if again is None else max(0.0, again - monotonic())
                with contextlib.suppress(asyncio.TimeoutError):
                    await asyncio.wait_for(self._awake.wait(), wait)
                if again is not None and (early := again - monotonic()) > 0:
                    await asyncio.sleep(min(early, 0.005))  # what comes together is sent together

    async def _in_thread(self, function: Any, *args: Any) -> Any:
        return await self._loop.run_in_executor(self._threads, function, *args)

    def _wake(self) -> None:
        if not self._waking:  # most messages come while a look is due already
            self._waking = True
            with contextlib.suppress(RuntimeError):  # the loop has ended
                self._loop.call_soon_threadsafe(self._awake.set)


def _wants_socket(request: Request) -> bool:
    return "websocket" in request.headers.get("Upgrade", "").lower()


def _plain(status: HTTPStatus, text: str) -> Response:
    return _response(status, text.encode(), {"Content-Type": "text/plain; charset=utf-8"})


def _response(status: HTTPStatus, body: bytes, headers: dict[str, str]) -> Response:
    every = {**SECURITY, **headers, "Content-Length": str(len(body)), "Connection": "close"}
    return Response(status.value, status.phrase, Headers(every), body)
