"""Runs the web server until it is requested to exit."""

from __future__ import annotations

import asyncio
import contextlib
import signal
from collections.abc import Callable

from pyros1.web.robot import Robot
from pyros1.web.server.access import Access
from pyros1.web.server.server import WebServer

_SHUTDOWN_TIMEOUT = 10.0
"""Maximum duration of the shutdown in seconds."""


def run_server(robot: Robot, access: Access, host: str, port: int, on_started: Callable[[int], object]) -> bool:
    """Run the server until SIGINT or SIGTERM (in the main thread only), or until its node is requested to shut down.

    Args:
        robot: the robot, which is started at the beginning and closed at the end.
        access: the access rules.
        host: host name or address of the network interface on which the server listens.
        port: the port; 0 for any free port.
        on_started: called with the port number as soon as pages can connect.

    Returns:
        Whether the server's node was requested to shut down.

    Raises:
        OSError: the port is not available.
    """
    try:
        return asyncio.run(_serve(robot, access, host, port, on_started))
    except KeyboardInterrupt:
        return False
    finally:
        robot.close()


async def _serve(robot: Robot, access: Access, host: str, port: int, on_started: Callable[[int], object]) -> bool:
    exit_requested = asyncio.Event()
    was_killed = False
    loop = asyncio.get_running_loop()
    for signal_number in (signal.SIGINT, signal.SIGTERM):
        with contextlib.suppress(NotImplementedError, RuntimeError, ValueError):  # Windows; not the main thread
            loop.add_signal_handler(signal_number, exit_requested.set)

    def on_killed() -> None:
        nonlocal was_killed
        was_killed = True
        with contextlib.suppress(RuntimeError):  # the loop is already closed
            loop.call_soon_threadsafe(exit_requested.set)

    robot.on_killed = on_killed
    async with WebServer(robot, access).listen(host, port) as server:
        robot.start()
        on_started(next(iter(server.sockets)).getsockname()[1])
        await exit_requested.wait()
        # Close the robot before the pages, to end everything that they wait for.
        with contextlib.suppress(asyncio.TimeoutError):
            await asyncio.wait_for(asyncio.to_thread(robot.close), _SHUTDOWN_TIMEOUT)
    return was_killed
