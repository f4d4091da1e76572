"""What waits for the thread that handles actions."""

from __future__ import annotations

from pyros1.ros2.bridge.actions.inbox import Inbox


def test_order() -> None:
    inbox = Inbox()
    assert inbox.put(lambda: 1, 0) and inbox.put(lambda: 2, 0)
    tasks = [inbox.get(0), inbox.get(0)]
    assert [task() for task in tasks if task is not None] == [1, 2]
    assert inbox.get(0) is None


def test_bounds() -> None:
    inbox = Inbox(max_tasks=2, max_bytes=10)
    assert inbox.put(int, 100), "one may be larger"
    assert not inbox.put(int, 1)
    assert inbox.put(int, 1, is_due=True) and inbox.dropped == 1
    inbox.get(0)
    inbox.get(0)
    assert inbox.put(int, 5) and inbox.put(int, 5) and not inbox.put(int, 0)


def test_the_end() -> None:
    inbox = Inbox()
    inbox.put(int, 0)
    inbox.close()
    assert inbox.get(None) is None and not inbox.put(int, 0, is_due=True)
