"""A stock rosmaster and a pyros1 master side by side, and nodes that write down what each of them is told."""

from __future__ import annotations

import os
import socket
import subprocess
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from xmlrpc.client import Fault, ServerProxy

from harness import free_port

from pyros1.master import Master
from pyros1.net.loop import Loop
from pyros1.net.xmlrpc_server import XmlRpcServer


class Recorder:
    """A node's API that answers everything with the same triple and keeps what it was called with."""

    def __init__(self, loop: Loop, name: str, answer: Sequence[Any] = (1, "", 0)) -> None:
        self.name = name
        self.calls: list[list[Any]] = []
        self._answer = list(answer)
        self._server = XmlRpcServer(loop, self._dispatch, bind_host="127.0.0.1", advertised_host="127.0.0.1")
        self.uri = self._server.uri
        self.close = self._server.close

    def _dispatch(self, method: str, params: Sequence[Any]) -> Any:
        self.calls.append([self.name, method, *params])
        return self._answer


class Side:
    """One of the two masters with recorders of its own; their URIs are written as their names in all results."""

    def __init__(self, uri: str, loop: Loop, recorders: dict[str, Sequence[Any]]) -> None:
        self.uri = uri
        self._proxy = ServerProxy(uri, allow_none=True)
        self._names = {uri: "MASTER"}
        self.recorders = {name: Recorder(loop, name, answer) for name, answer in recorders.items()}
        self._names.update({recorder.uri: name for name, recorder in self.recorders.items()})
        self._uris = {name: uri for uri, name in self._names.items()}

    def call(self, method: str, *params: Any) -> Any:
        """Calls the master; ``A`` in the parameters stands for the recorder of that name. A fault becomes its text."""
        try:
            return self._plain(getattr(self._proxy, method)(*self._with_uris(list(params))))
        except Fault as fault:
            # Stock puts the Python class of its exception before the text.
            return ["fault", fault.faultCode, fault.faultString.rpartition("'>:")[2]]

    def told(self) -> list[Any]:
        """What the recorders were told since last asked, sorted; updates of one thing in a row once."""
        found: list[Any] = []
        for recorder in self.recorders.values():
            calls, recorder.calls = recorder.calls, []
            found += [call for i, call in enumerate(calls) if i == 0 or call != calls[i - 1]]
        return sorted((self._plain(call) for call in found), key=repr)

    def close(self) -> None:
        self._proxy("close")()
        for recorder in self.recorders.values():
            recorder.close()

    def _plain(self, value: Any) -> Any:
        if isinstance(value, list):
            return [self._plain(item) for item in value]
        if isinstance(value, dict):
            return {key: self._plain(item) for key, item in value.items()}
        return self._names.get(value, value) if isinstance(value, str) else value

    def _with_uris(self, value: Any) -> Any:
        if isinstance(value, list):
            return [self._with_uris(item) for item in value]
        if isinstance(value, dict):
            return {key: self._with_uris(item) for key, item in value.items()}
        return self._uris.get(value, value) if isinstance(value, str) else value


@contextmanager
def stock_master(home: Path) -> Iterator[str]:
    """The URI of a rosmaster of its own."""
    port = free_port()
    environ = dict(os.environ, ROS_HOME=str(home), ROS_LOG_DIR=str(home), ROS_HOSTNAME="localhost")
    environ.pop("PYTHONPATH", None)
    process = subprocess.Popen(
        ["/usr/bin/python3", "/usr/bin/rosmaster", "--core", "-p", str(port)],
        env=environ,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        limit = time.monotonic() + 30
        while True:
            try:
                socket.create_connection(("localhost", port)).close()
                break
            except OSError:
                if process.poll() is not None or time.monotonic() > limit:
                    raise
                time.sleep(0.05)
        yield f"http://localhost:{port}/"
    finally:
        process.terminate()
        process.wait(10)


@contextmanager
def pair(home: Path, recorders: dict[str, Sequence[Any]]) -> Iterator[tuple[Side, Side]]:
    """Stock's side and ours."""
    loop = Loop("recorders")
    loop.start()
    ours = Master(port=0, bind_host="127.0.0.1")
    ours.start()
    try:
        with stock_master(home) as uri:
            sides = (Side(uri, loop, recorders), Side(ours.uri, loop, recorders))
            try:
                yield sides
            finally:
                for side in sides:
                    side.close()
    finally:
        ours.stop()
        loop.stop()


def told(sides: tuple[Side, Side], stock_lacks: Sequence[Any] = (), least: int = 0) -> tuple[list[Any], list[Any]]:
    """What each side's nodes were told since last asked.

    Nothing tells when a master is done: that it makes no further call is part of what is compared. So this waits for
    longer than stock's workers sleep (0.1 s), and on a busy machine longer, until the two agree.

    Args:
        stock_lacks: what only ours tells.
        least: how many calls stock's nodes get at least.
    """
    limit = time.monotonic() + 20
    heard: tuple[list[Any], list[Any]] = ([], [])
    while True:
        time.sleep(0.3)
        for i, side in enumerate(sides):
            heard[i].extend(side.told())
            heard[i].sort(key=repr)
        agree = len(heard[0]) >= least and sorted([*heard[0], *stock_lacks], key=repr) == heard[1]
        if agree or time.monotonic() > limit:
            return heard
