"""The page's server in a thread, for tests."""

from __future__ import annotations

import asyncio
import threading

from pyros1.web.robot import Robot
from pyros1.web.server.access import Access
from pyros1.web.server.server import WebServer

PATIENCE = 20.0


class Served:
    """A server in a thread."""

    def __init__(self, robot: Robot, access: Access) -> None:
        self.port = 0
        self._loop = asyncio.new_event_loop()
        self._ended = asyncio.Event()
        self._started = threading.Event()
        self._server = WebServer(robot, access)
        self._thread = threading.Thread(target=self._run)
        self._thread.start()
        assert self._started.wait(PATIENCE)

    def _run(self) -> None:
        self._loop.run_until_complete(self._serve())
        self._loop.close()

    async def _serve(self) -> None:
        async with self._server.listen("127.0.0.1", 0) as server:
            self.port = next(iter(server.sockets)).getsockname()[1]
            self._started.set()
            await self._ended.wait()

    def close(self) -> None:
        self._loop.call_soon_threadsafe(self._ended.set)
        self._thread.join(PATIENCE)
        assert not self._thread.is_alive()
