"""The guide's program with a parameter that others change, words on errors, and a lenient client."""

from __future__ import annotations

import os
import queue
import signal
import subprocess
import sys
from typing import Any

import pytest

from pyros1.guide.documents import pages
from pyros1.msgs import from_definition
from pyros1.msgs.rosgraph_msgs.msg import Log
from pyros1.msgs.std_msgs.msg import Empty
from pyros1.msgs.std_srvs.srv import Trigger


class OpenValve(Trigger):
    """A service that says that it is a Trigger, and sends more."""

    _response_class = from_definition("firmware/OpenResponse", "bool success\nstring message\nuint32 checksum\n")


@pytest.mark.skipif(sys.platform == "win32", reason="SIGINT")
def test_the_program_of_the_page(make_node: Any, environ: dict[str, str]) -> None:
    (program,) = pages()["nodes"].code("python", "Parameters, errors, services of other nodes")
    node = make_node("test")
    said: queue.Queue[str] = queue.Queue()
    node.subscribe("/rosout", Log, lambda record: record.name == "/pump" and said.put(record.msg))
    start = node.advertise("start", Empty, latch=True)
    child = subprocess.Popen([sys.executable, "-c", program], env={**os.environ, **environ})
    try:
        start.publish(Empty())
        error = said.get(timeout=20)
        assert error.startswith("bad callback") and error.endswith("\nIs the valve open?")
        node.params["/pump/pressure"] = 2.5
        assert said.get(timeout=20) == "/pump/pressure is now 2.5"
        node.advertise_service("valve/open", OpenValve, lambda _: {"success": True, "message": "open", "checksum": 7})
        start.publish(Empty())
        assert {said.get(timeout=20), said.get(timeout=20)} == {
            "the response of /valve/open: a std_srvs/TriggerResponse with 4 surplus bytes at its end",
            "the valve says: open",
        }
    finally:
        child.send_signal(signal.SIGINT)
        assert child.wait(20) == 0
