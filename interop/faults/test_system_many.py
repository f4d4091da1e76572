"""Hundreds of nodes register at once, with few descriptors for the master: all are known, and all are told."""

from __future__ import annotations

import resource
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import pytest
from harness import Master, until
from vitals import limited, vitals

from pyros1.net.loop import Loop
from pyros1.net.master_client import MasterClient
from pyros1.net.xmlrpc_server import XmlRpcServer

TEXT = "std_msgs/String"


class Light:
    """A node that has no more than what the master sees of one."""

    def __init__(self, loop: Loop, master: Master, number: int) -> None:
        self.name = f"/light{number}"
        self.told: list[list[str]] = []
        self._server = XmlRpcServer(loop, self._answer, bind_host="127.0.0.1", advertised_host="127.0.0.1")
        self._master = MasterClient(self.name, master.uri, timeout=120)

    def _answer(self, method: str, params: list[object]) -> list[object]:
        if method == "publisherUpdate":
            self.told.append(params[2])  # type: ignore[arg-type]
        return [1, "", 0]

    def register(self) -> None:
        self._master.register_publisher(f"{self.name}/own", TEXT, self._server.uri)
        self.told.append(self._master.register_subscriber("/all", TEXT, self._server.uri))
        self._master.register_publisher("/all", TEXT, self._server.uri)

    def close(self) -> None:
        self._master.close()
        self._server.close()


@pytest.mark.parametrize("kind", ["ours"])
def test_hundreds_of_nodes_register_at_once(own_master: Callable[[str], Master], kind: str, long: bool) -> None:
    count = 500 if long else 150
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, min(hard, 4096)), hard))
    master = own_master(kind)
    master.start()
    core = master.core[0]
    loop = Loop("light nodes")
    loop.start()
    nodes = [Light(loop, master, number) for number in range(count)]
    gate = threading.Barrier(32)

    def register(share: list[Light]) -> None:
        gate.wait(60)
        for node in share:
            node.register()

    try:
        with limited(core.pid, resource.RLIMIT_NOFILE, 1024 if long else 2 * count), ThreadPoolExecutor(32) as pool:
            began = time.monotonic()
            list(pool.map(register, [nodes[start::32] for start in range(32)]))
            registered = time.monotonic() - began
            until(lambda: all(node.told and len(node.told[-1]) == count for node in nodes), "all are told", 120)
            told = time.monotonic() - began
            print(
                f"{kind}: {count} registered after {registered:.1f} s, all told after {told:.1f} s, {vitals(core.pid)}"
            )
            assert len(master.publishers("/all")) == len(master.subscribers("/all")) == count
            late = master.ready_peer("roscpp", "late")
            late.advertise("/late", TEXT)
            assert master.publishers("/late") == ["/late"]
    finally:
        for node in nodes:
            node.close()
        loop.stop()
