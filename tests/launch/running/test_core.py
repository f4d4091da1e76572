"""launch.running.core: the rosout node of a core."""

from __future__ import annotations

import os
import queue
from pathlib import Path
from xmlrpc.client import ServerProxy

from pyros1.launch.running.core import Core
from pyros1.net.hosts import LocalAddress
from pyros1.net.master_client import MasterClient


def test_the_rosout_node_comes_back_as_under_roscore(tmp_path: Path, free_port: int) -> None:
    uri = f"http://127.0.0.1:{free_port}/"
    said: queue.Queue[str] = queue.Queue()
    core = Core(
        port=free_port,
        address=LocalAddress("127.0.0.1", "127.0.0.1", ()),
        uri=uri,
        log_folder=tmp_path,
        environ={"ROS_HOSTNAME": "127.0.0.1"},
        on_shutdown=lambda reason: None,
    )
    core.start_master()
    client = MasterClient("/tool", uri)
    try:
        core.start_rosout(said.put)
        core.await_rosout()
        nodes = []
        for _ in range(2):
            nodes.append(client.lookup_node("/rosout"))
            with ServerProxy(nodes[-1]) as node:
                node.shutdown("/tool", "user request")
            assert said.get(timeout=20) == "[rosout-1] process has finished cleanly"
            assert said.get(timeout=20) == "[rosout-1] restarting process"
            assert said.get(timeout=20) == f"process[rosout-1]: started with pid [{os.getpid()}]"
        assert client.lookup_node("/rosout") not in nodes
    finally:
        client.close()
        core.stop_rosout()
        core.stop_master()
    assert said.empty()
