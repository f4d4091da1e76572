"""Lists the processes of all launches that use the same master."""

from __future__ import annotations

import http.client
from collections.abc import Iterable
from typing import Any
from urllib.parse import urlparse
from xmlrpc.client import Error, ServerProxy, Transport

import rosgraph

from pyros1.drop_in.module_attributes import module_getattr

__getattr__ = module_getattr(__name__)
_CALLER_ID = "/roslaunch_netapi"
_TIMEOUT = 10.0


class NetProcess:
    """A process of a launch.

    Args:
        name: the process's label.
        respawn_count: how many times it was started.
        is_alive: whether it is running.
        roslaunch_uri: address of the launch's XML-RPC server.

    Attributes:
        machine: host of the launch.
    """

    def __init__(self, name: str, respawn_count: int, is_alive: bool, roslaunch_uri: str) -> None:
        self.name = name
        self.respawn_count = respawn_count
        self.is_alive = is_alive
        self.roslaunch_uri = roslaunch_uri
        self.machine = urlparse(roslaunch_uri).hostname


def get_roslaunch_uris() -> Iterable[str] | None:
    """Return the URIs of all launches; None if there is no master, or no launch has registered its URI."""
    try:
        uris: dict[str, str] = rosgraph.Master(_CALLER_ID).getParam("/roslaunch/uris")
    except (rosgraph.MasterException, OSError):
        return None
    return uris.values()


def list_processes(roslaunch_uris: Iterable[str] | None = None) -> list[NetProcess]:
    """Return the processes of the given launches (None for all); launches that do not respond are left out."""
    if not roslaunch_uris:
        roslaunch_uris = get_roslaunch_uris() or ()
    return [process for uri in roslaunch_uris for process in _query_processes(uri)]


class _TimeoutTransport(Transport):
    """An XML-RPC transport with a timeout for responses."""

    def make_connection(self, host: Any) -> Any:
        """Return the connection to a host."""
        connection = super().make_connection(host)
        connection.timeout = _TIMEOUT
        return connection


def _query_processes(uri: str) -> list[NetProcess]:
    proxy: Any = ServerProxy(uri, _TimeoutTransport())
    try:
        code, _, (alive, dead) = proxy.list_processes()
        if code != 1:
            return []
        return [
            NetProcess(name, count, processes is alive, uri) for processes in (alive, dead) for name, count in processes
        ]
    except (OSError, Error, ValueError, TypeError, http.client.HTTPException):
        return []
