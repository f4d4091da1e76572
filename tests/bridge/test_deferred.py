"""What waits for the master, and messages that wait behind it."""

from __future__ import annotations

import threading
import tracemalloc

import pytest

from pyros1.bridge import deferred as module
from pyros1.bridge.deferred import RETURN_DELAY, Change, DeferredActions
from pyros1.bridge.exchange.actions import Advertise, Forget, Publish, SetOrigins, Source, Subscribe, Withdraw
from pyros1.bridge.names import SharedName

RED = ("red", SharedName("red", "/t"))


def advertise(local: str = "/t", md5sum: str = "1") -> Advertise:
    return Advertise(local, "a/B", md5sum, "", False)


def message(body: bytes = b"x", local: str = "/t", publisher: int = 1, expires: float | None = None) -> Publish:
    return Publish(local, Source(*RED, publisher), body, True, expires)


class Clock:
    """A clock that jumps by so much after each look that what was withdrawn may return."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        """Return the time."""
        self.now += RETURN_DELAY
        return self.now


def after(*changes: Change) -> DeferredActions:
    """Return one that has done some changes."""
    deferred = DeferredActions(Clock())
    for change in changes:
        deferred.put(change)
        assert deferred.pop() == [change] and deferred.finish() == []
    return deferred


def test_messages_wait_until_their_topic_is_published() -> None:
    deferred = DeferredActions()
    assert not deferred.hold(message())
    deferred.put(advertise())
    assert deferred.hold(message(b"1")) and not deferred.hold(message(local="/other"))
    assert deferred.pop() == [advertise()]
    assert deferred.hold(message(b"2"))
    assert deferred.finish() == [message(b"1"), message(b"2")] and not deferred.hold(message(b"3"))
    assert deferred.pop() == [] and deferred.finish() == []


def test_where_no_message_waits_nobody_else_has_to() -> None:
    """Otherwise the lock of the state machine would be needed, so that what waits goes first."""
    deferred = DeferredActions()
    deferred.put(advertise())
    assert deferred.pop() == [advertise()] and deferred.finish_if_nothing_waits()
    assert not deferred.hold(message())
    deferred.put(advertise(md5sum="2"))
    assert deferred.pop() == [advertise(md5sum="2")] and deferred.hold(message())
    assert not deferred.finish_if_nothing_waits() and deferred.hold(message(b"2"))
    assert deferred.finish() == [message(), message(b"2")] and not deferred.hold(message())


def test_a_topic_that_was_withdrawn_returns_a_little_later() -> None:
    """Subscribers must notice before that they have lost their connections."""
    now = [5.0]
    deferred = DeferredActions(lambda: now[0])
    deferred.put(advertise())
    assert deferred.pop() == [advertise()] and deferred.finish() == []
    deferred.put(Withdraw("/t"))
    deferred.put(advertise(md5sum="2"))
    assert deferred.pop() == [Withdraw("/t")] and deferred.hold(message())
    assert deferred.finish() == [] and deferred.hold(message(b"2")) and deferred.pop() == []
    deferred.put(advertise("/other"))
    assert deferred.pop() == [advertise("/other")] and deferred.finish() == []
    now[0] += 0.9 * RETURN_DELAY
    assert deferred.pop(0.01) == []
    now[0] += 0.2 * RETURN_DELAY
    assert deferred.pop() == [advertise(md5sum="2")] and deferred.finish() == [message(), message(b"2")]

    deferred.put(Withdraw("/t"))
    assert deferred.pop() == [Withdraw("/t")] and deferred.finish() == []
    deferred.put(advertise())
    assert deferred.pop() == []
    deferred.put(Withdraw("/t"))  # it has not begun yet
    now[0] += 2 * RETURN_DELAY
    assert deferred.pop() == []


def test_a_subscription_returns_at_once() -> None:
    deferred = DeferredActions(lambda: 5.0)
    for on in (True, False, True):
        deferred.put(Subscribe("/s", on))
        assert deferred.pop() == [Subscribe("/s", on)] and deferred.finish() == []


@pytest.mark.slow
def test_only_so_many_withdrawn_topics_are_remembered() -> None:
    """Another site may make up names for ever."""
    deferred = DeferredActions(lambda: 5.0)
    for number in range(10_001):
        for change in (advertise(f"/t{number}"), Withdraw(f"/t{number}")):
            deferred.put(change)
            assert deferred.pop() == [change] and deferred.finish() == []
    deferred.put(advertise("/t10000"))
    assert deferred.pop() == []
    deferred.put(advertise("/t0"))
    assert deferred.pop() == [advertise("/t0")]


def test_a_topic_that_could_not_be_withdrawn_is_withdrawn_before_it_returns() -> None:
    deferred = after(advertise())
    deferred.put(Withdraw("/t"))
    deferred.put(advertise(md5sum="2"))
    deferred.fail(deferred.pop())
    assert deferred.pop() == [Withdraw("/t")] and deferred.finish() == []
    assert deferred.pop() == [advertise(md5sum="2")]


def test_however_often_a_topic_comes_and_goes_no_more_waits() -> None:
    deferred = after(advertise(), Subscribe("/s", True))
    for number in range(1000):
        deferred.put(Withdraw("/t"))
        deferred.put(advertise(md5sum=str(number)))
        deferred.put(Subscribe("/s", False))
        deferred.put(Subscribe("/s", True))
    assert deferred.pop() == [Withdraw("/t")] and deferred.finish() == []
    assert deferred.pop() == [advertise(md5sum="999")] and deferred.finish() == []
    assert deferred.pop() == [Subscribe("/s", False), Subscribe("/s", True)] and deferred.finish() == []
    deferred.put(advertise())
    deferred.put(Withdraw("/t"))
    assert deferred.pop() == [Withdraw("/t")] and deferred.finish() == [] and deferred.pop() == []


def test_what_never_began_need_not_end() -> None:
    """A site may make up names faster than the master can be told, or while it is away."""
    deferred = after(advertise("/old"), Subscribe("/old", True), Withdraw("/old"), Subscribe("/old", False))
    for number in range(1000):
        for change in (advertise(f"/t{number}"), Subscribe(f"/t{number}", True)):
            deferred.put(change)
        deferred.hold(message(local=f"/t{number}"))
        for change in (Withdraw(f"/t{number}"), Subscribe(f"/t{number}", False), Withdraw("/old")):
            deferred.put(change)
    assert deferred.pop() == [] and deferred.dropped == 1000
    deferred.put(advertise())
    assert deferred.pop() == [advertise()]
    deferred.put(Withdraw("/t"))  # meanwhile
    assert deferred.finish() == [] and deferred.pop() == [Withdraw("/t")]


def test_messages_of_a_topic_that_is_withdrawn_are_not_published_later() -> None:
    """It may be published again with another type."""
    deferred = DeferredActions(Clock())
    deferred.put(advertise())
    deferred.hold(message(b"old"))
    deferred.pop()
    deferred.put(Withdraw("/t"))
    deferred.put(advertise(md5sum="2"))
    deferred.hold(message(b"new"))
    assert deferred.finish() == [] and deferred.dropped == 1
    assert deferred.pop() == [Withdraw("/t")] and deferred.finish() == []
    assert deferred.pop() == [advertise(md5sum="2")] and deferred.finish() == [message(b"new")]


def test_what_is_forgotten_does_not_wait() -> None:
    deferred = DeferredActions()
    assert not deferred.hold(Forget("/t", Source(*RED, 1)))
    deferred.put(advertise())
    messages = [message(str(number).encode(), publisher=number % 3) for number in range(9)]
    for each in messages:
        deferred.hold(each)
    assert not deferred.hold(Forget("/t", Source(*RED, 1))), "an earlier message may have been published"
    deferred.pop()
    assert deferred.finish() == [each for each in messages if each.source != Source(*RED, 1)]


def test_notes_of_publishers_that_are_gone_do_not_pile_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MAX_MESSAGES", 1)
    deferred = DeferredActions()
    deferred.put(advertise())
    for number in range(100):
        deferred.hold(message(publisher=number))
        deferred.hold(Forget("/t", Source(*RED, number)))
    assert deferred.dropped == 0 and deferred.pop() and deferred.finish() == []


def test_a_change_of_a_topic_that_is_published() -> None:
    deferred = after(advertise())
    first, second = (SetOrigins("/t", (f"red:/{name}",)) for name in "ab")
    deferred.put(first)
    deferred.put(second)
    assert deferred.pop() == [second]
    deferred.fail([second])
    deferred.put(first)
    assert deferred.pop() == [first] and deferred.finish() == []

    deferred.put(advertise())
    failed = deferred.pop()
    deferred.put(first)
    deferred.fail(failed)
    assert deferred.pop() == [advertise(), first], "a change does not replace the beginning"
    deferred.finish()
    deferred.put(first)
    deferred.put(Withdraw("/t"))
    assert deferred.pop() == [Withdraw("/t")]


def test_messages_do_not_wait_for_the_names_of_original_publishers() -> None:
    """Whoever starts to publish `/cmd_vel` must not hold up the commands of others while the master is slow."""
    deferred = after(advertise())
    first, second = (SetOrigins("/t", (f"red:/{name}",)) for name in "ab")
    deferred.put(first)
    assert not deferred.hold(message())
    assert deferred.pop() == [first] and not deferred.hold(message())
    deferred.fail([first])
    assert not deferred.hold(message())
    deferred.put(second)
    assert not deferred.hold(message()) and deferred.pop() == [second] and deferred.finish() == []

    deferred.put(advertise())
    assert deferred.hold(message(b"1")) and deferred.pop() == [advertise()]
    deferred.put(first)
    assert deferred.hold(message(b"2")), "it must not overtake the first one"
    assert deferred.finish() == [message(b"1"), message(b"2")] and not deferred.hold(message(b"3"))


def test_no_message_overtakes_those_that_wait_for_names_that_failed() -> None:
    deferred = DeferredActions()
    names = SetOrigins("/t", ("red:/a",))
    deferred.put(advertise())
    deferred.put(names)
    assert deferred.hold(message(b"1")) and deferred.pop() == [advertise(), names]
    deferred.fail([names])
    assert deferred.hold(message(b"2"))
    deferred.retry()
    assert deferred.pop() == [names] and deferred.finish() == [message(b"1"), message(b"2")]
    assert not deferred.hold(message(b"3"))


def test_messages_that_got_too_old_while_they_waited_are_dropped() -> None:
    now = [5.0]
    deferred = DeferredActions(lambda: now[0])
    deferred.put(advertise())
    for number, expires in enumerate((5.5, None, 7.5)):
        assert deferred.hold(message(b"%d" % number, publisher=number, expires=expires))
    assert deferred.pop() == [advertise()]
    now[0] = 7.0
    assert [each.body for each in deferred.finish()] == [b"1", b"2"] and deferred.dropped == 1


def test_old_messages_take_no_room_from_new_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MAX_MESSAGES", 3)
    now = [5.0]
    deferred = DeferredActions(lambda: now[0])
    deferred.put(advertise())
    for number in range(100):
        now[0] = 5.0 + number / 4
        assert deferred.hold(message(b"%d" % number, expires=now[0] + 0.5))
    assert deferred.pop() == [advertise()]
    assert [each.body for each in deferred.finish()] == [b"97", b"98", b"99"] and deferred.dropped == 97


def test_old_messages_take_no_room_from_other_topics(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of a topic that cannot be published, and whose source has stopped."""
    monkeypatch.setattr(module, "MAX_MESSAGES", 3)
    now = [5.0]
    deferred = DeferredActions(lambda: now[0])
    deferred.put(advertise())
    deferred.pop()
    deferred.fail([advertise()])
    for _ in range(3):
        assert deferred.hold(message(expires=6.0))
    deferred.put(advertise("/map"))
    assert deferred.hold(message(b"too early", "/map")) and deferred.dropped == 1
    now[0] = 6.1
    assert deferred.hold(message(b"map", "/map")) and deferred.dropped == 4
    assert deferred.pop() == [advertise("/map")] and deferred.finish() == [message(b"map", "/map")]


def test_sources_whose_messages_are_dropped_take_no_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    """Another site may make up a source for each message."""
    monkeypatch.setattr(module, "MAX_MESSAGES", 3)
    deferred = DeferredActions(lambda: 5.0)
    deferred.put(advertise())
    for number in range(3):
        assert deferred.hold(message(publisher=number))
    tracemalloc.start()
    try:
        for number in range(1000):
            assert deferred.hold(message(publisher=number))
        assert tracemalloc.get_traced_memory()[0] < 100_000
    finally:
        tracemalloc.stop()
    assert deferred.dropped == 1000


def test_what_failed_is_tried_again_unless_something_else_is_wanted() -> None:
    deferred = after(advertise(), Subscribe("/s", True))
    deferred.put(Withdraw("/t"))
    deferred.put(advertise())
    deferred.hold(message())
    assert deferred.pop() == [Withdraw("/t")] and deferred.finish() == []
    deferred.fail(deferred.pop())
    assert deferred.pop() == [] and deferred.hold(message())
    deferred.retry()
    assert deferred.pop() == [advertise()] and deferred.finish() == [message(), message()]
    deferred.retry()
    assert deferred.pop() == []

    deferred.put(Withdraw("/t"))
    deferred.put(advertise())
    failed = deferred.pop()
    deferred.put(advertise(md5sum="2"))
    deferred.fail(failed)
    assert deferred.pop() == [Withdraw("/t")] and deferred.finish() == []
    assert deferred.pop() == [advertise(md5sum="2")] and deferred.finish() == []

    deferred.put(advertise(md5sum="3"))
    deferred.fail(deferred.pop())
    deferred.put(Withdraw("/t"))
    deferred.retry()
    assert deferred.pop() == [Withdraw("/t")] and deferred.finish() == [] and deferred.pop() == []

    deferred.put(Subscribe("/s", False))
    deferred.put(Subscribe("/s", True))
    deferred.fail(deferred.pop())
    deferred.put(Subscribe("/s", True))
    assert deferred.pop() == [Subscribe("/s", False), Subscribe("/s", True)]


def test_what_an_unexpected_exception_has_kept_from_being_done_is_tried_again() -> None:
    deferred = DeferredActions()
    deferred.put(advertise())
    assert deferred.pop() == [advertise()] and deferred.hold(message())
    assert deferred.pop() == [] and deferred.hold(message())
    deferred.retry()
    assert deferred.pop() == [advertise()] and deferred.finish() == [message(), message()]


def test_what_waits_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MAX_MESSAGES", 3)
    monkeypatch.setattr(module, "MAX_BYTES", 10)
    deferred = DeferredActions()
    deferred.put(advertise())
    for _ in range(5):
        assert deferred.hold(message(b"x"))
    assert deferred.dropped == 2
    deferred.pop()
    assert len(deferred.finish()) == 3
    deferred.put(advertise())
    assert all(deferred.hold(message(body)) for body in (bytes(20), b"x"))
    assert deferred.dropped == 3 and deferred.pop() and deferred.finish() == [message(bytes(20))]


def test_waiting_ends_when_there_is_something_to_do() -> None:
    deferred = DeferredActions()
    found: list[object] = []
    for end in (lambda: deferred.put(advertise()), deferred.wake):
        thread = threading.Thread(target=lambda: found.append(deferred.pop(60.0)))
        thread.start()
        while thread.is_alive():
            end()  # type: ignore[no-untyped-call]
            thread.join(0.01)
        deferred.finish()
        while deferred.pop():
            deferred.finish()
    assert found == [[advertise()], []]
