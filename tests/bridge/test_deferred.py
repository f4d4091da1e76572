"""What waits for the master, and messages that wait behind it."""

from __future__ import annotations

import threading

import pytest

from pyros1.bridge import deferred as module
from pyros1.bridge.deferred import Deferred
from pyros1.bridge.exchange.actions import Advertise, Forget, Publish, SetOrigins, Subscribe, Withdraw


def advertise(local: str = "/t", md5sum: str = "1") -> Advertise:
    return Advertise(local, "a/B", md5sum, "", False)


def message(body: bytes = b"x", local: str = "/t", publisher: int = 1) -> Publish:
    return Publish(local, ("red", publisher), body, True)


def test_messages_wait_until_their_topic_is_published() -> None:
    deferred = Deferred()
    assert not deferred.hold(message())
    deferred.put(advertise())
    assert deferred.hold(message(b"1")) and not deferred.hold(message(local="/other"))
    assert deferred.pop() == [advertise()]
    assert deferred.hold(message(b"2"))
    assert deferred.done() == [message(b"1"), message(b"2")] and not deferred.hold(message(b"3"))
    assert deferred.pop() == [] and deferred.done() == []


def test_however_often_a_topic_comes_and_goes_no_more_waits() -> None:
    deferred = Deferred()
    for number in range(1000):
        deferred.put(Withdraw("/t"))
        deferred.put(advertise(md5sum=str(number)))
        deferred.put(Subscribe("/s", False))
        deferred.put(Subscribe("/s", True))
    assert deferred.pop() == [Withdraw("/t"), advertise(md5sum="999")] and deferred.done() == []
    assert deferred.pop() == [Subscribe("/s", False), Subscribe("/s", True)] and deferred.done() == []
    deferred.put(advertise())
    deferred.put(Withdraw("/t"))
    assert deferred.pop() == [Withdraw("/t")] and deferred.done() == [] and deferred.pop() == []


def test_messages_of_a_topic_that_is_withdrawn_are_not_published_later() -> None:
    """It may be published again with another type."""
    deferred = Deferred()
    deferred.put(advertise())
    deferred.hold(message(b"old"))
    deferred.pop()
    deferred.put(Withdraw("/t"))
    deferred.put(advertise(md5sum="2"))
    deferred.hold(message(b"new"))
    assert deferred.done() == [] and deferred.dropped == 1
    assert deferred.pop() == [Withdraw("/t"), advertise(md5sum="2")] and deferred.done() == [message(b"new")]


def test_what_is_forgotten_does_not_wait() -> None:
    deferred = Deferred()
    assert not deferred.hold(Forget("/t", ("red", 1)))
    deferred.put(advertise())
    for publisher in (1, 2):
        deferred.hold(message(publisher=publisher))
    assert deferred.hold(Forget("/t", ("red", 1)))
    deferred.pop()
    assert deferred.done() == [message(publisher=2), Forget("/t", ("red", 1))]


def test_a_change_of_a_topic_that_is_published() -> None:
    """What is forgotten meanwhile is forgotten afterwards, since the topic keeps its latched messages."""
    deferred = Deferred()
    first, second = (SetOrigins("/t", (f"red:/{name}",)) for name in "ab")
    deferred.put(first)
    assert deferred.hold(Forget("/t", ("red", 1)))
    deferred.put(second)
    assert deferred.pop() == [second]
    deferred.fail([second])
    deferred.put(first)
    assert deferred.pop() == [first] and deferred.done() == [Forget("/t", ("red", 1))]

    deferred.put(advertise())
    failed = deferred.pop()
    deferred.put(first)
    deferred.fail(failed)
    assert deferred.pop() == [advertise(), first], "a change does not replace the beginning"
    deferred.done()
    deferred.put(first)
    deferred.put(Withdraw("/t"))
    assert deferred.pop() == [Withdraw("/t")]


def test_what_failed_is_tried_again_unless_something_else_is_wanted() -> None:
    deferred = Deferred()
    deferred.put(Withdraw("/t"))
    deferred.put(advertise())
    deferred.hold(message())
    deferred.fail(deferred.pop()[1:])
    assert deferred.pop() == [] and deferred.hold(message())
    deferred.retry()
    assert deferred.pop() == [advertise()] and deferred.done() == [message(), message()]
    deferred.retry()
    assert deferred.pop() == []

    deferred.put(Withdraw("/t"))
    deferred.put(advertise())
    failed = deferred.pop()
    deferred.put(advertise(md5sum="2"))
    deferred.fail(failed)
    assert deferred.pop() == [Withdraw("/t"), advertise(md5sum="2")]
    deferred.done()

    deferred.put(advertise(md5sum="3"))
    deferred.fail(deferred.pop())
    deferred.put(Withdraw("/t"))
    deferred.retry()
    assert deferred.pop() == [Withdraw("/t")] and deferred.done() == [] and deferred.pop() == []

    deferred.put(Subscribe("/s", False))
    deferred.put(Subscribe("/s", True))
    deferred.fail(deferred.pop())
    deferred.put(Subscribe("/s", True))
    assert deferred.pop() == [Subscribe("/s", False), Subscribe("/s", True)]


def test_what_waits_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MAX_MESSAGES", 3)
    monkeypatch.setattr(module, "MAX_BYTES", 10)
    deferred = Deferred()
    deferred.put(advertise())
    for _ in range(5):
        assert deferred.hold(message(b"x"))
    assert deferred.dropped == 2
    deferred.pop()
    assert len(deferred.done()) == 3
    deferred.put(advertise())
    assert all(deferred.hold(message(body)) for body in (bytes(20), b"x"))
    assert deferred.dropped == 3 and deferred.pop() and deferred.done() == [message(bytes(20))]


def test_waiting_ends_when_there_is_something_to_do() -> None:
    deferred = Deferred()
    found: list[object] = []
    for end in (lambda: deferred.put(advertise()), deferred.wake):
        thread = threading.Thread(target=lambda: found.append(deferred.pop(60.0)))
        thread.start()
        while thread.is_alive():
            end()  # type: ignore[no-untyped-call]
            thread.join(0.01)
        deferred.done()
        while deferred.pop():
            deferred.done()
    assert found == [[advertise()], []]
