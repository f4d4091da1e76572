"""The thread that handles what comes from ROS 2."""

from __future__ import annotations

import queue
from typing import Any

import pytest

from pyros1.ground.errors import NodeError
from pyros1.ros2.bridge.worker import Worker
from pyros1.ros2.zenoh.names import DataKey

from ...bridge.conftest import PATIENCE

KEY = DataKey(0, "/a", "std_msgs/msg/String", "*")


def test_what_waits_and_what_is_raised(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.ros2.bridge.worker.POLL_PERIOD", 0.01)
    done: queue.Queue[Any] = queue.Queue()
    looks: queue.Queue[bool] = queue.Queue()

    def on_message(key: DataKey, body: bytes, attachment: bytes, session: str) -> None:
        done.put((key.name, body, attachment, session))
        if body == b"bad":
            raise NodeError("it is bad")
        if body == b"worse":
            raise KeyError("a mistake")

    worker = Worker(lambda *token: done.put(token), on_message, looks.put, done.put, done.put)
    worker.put_message(KEY, b"bad", b"1")
    worker.put_message(KEY, b"worse", b"2", "session")
    worker.put_token("@ros2_lv/0/x", True)
    worker.start()
    try:
        got = [done.get(timeout=PATIENCE) for _ in range(5)]
        assert got[:2] == [("@ros2_lv/0/x", True), ("/a", b"bad", b"1", "")], "who is there goes first"
        assert got[3] == ("/a", b"worse", b"2", "session") and str(got[2]) == "it is bad"
        assert isinstance(got[4], KeyError)
        assert looks.get(timeout=PATIENCE) is False, "before the token"
        while not looks.get(timeout=PATIENCE):
            pass
        assert looks.get(timeout=PATIENCE) is False, "each change is told once"
    finally:
        worker.close()
    worker.put_message(KEY, b"late", b"3")
    assert done.empty()
