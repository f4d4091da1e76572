"""Frames that several clients share."""

from __future__ import annotations

import threading
from collections.abc import Callable

import pytest

from pyros1.ground.errors import MessageError
from pyros1.msgs import AnyMsg
from pyros1.observe.decoder import Decoder
from pyros1.web.hub import Arrival
from pyros1.web.rosbridge.shared_encodings import SharedEncodings


def arrival(size: int = 8) -> Arrival:
    raw = AnyMsg()
    raw._buff = bytes(size)
    return Arrival(raw, 0.0, 0.0, Decoder())


def for_two() -> SharedEncodings:
    shared = SharedEncodings()
    shared.add_client()
    shared.add_client()
    return shared


class Counter:
    """Makes frames of a size, and counts them."""

    def __init__(self, size: int = 10) -> None:
        self.size = size
        self.made = 0

    def __call__(self) -> str:
        self.made += 1
        return "x" * self.size


@pytest.mark.parametrize(("clients", "made"), [(1, 2), (2, 1)])
def test_one_client_needs_no_memory_for_frames(clients: int, made: int) -> None:
    shared, counter, message = SharedEncodings(), Counter(), arrival()
    for _ in range(clients):
        shared.add_client()
    assert shared.get(message, "none", "/a", counter, True) == shared.get(message, "none", "/a", counter, True)
    assert counter.made == made


def test_each_form_and_name_has_its_frame() -> None:
    shared = for_two()
    message, other = arrival(), arrival()
    keys = [(message, "none", "/a"), (message, "cbor", "/a"), (message, "none", "a"), (other, "none", "/a")]
    for number, key in [*enumerate(keys)] * 2:
        assert shared.get(*key, lambda number=number: f"frame {number}", True) == f"frame {number}"


@pytest.mark.parametrize(("raw", "frame"), [(1 << 20, 10), (10, 1 << 20)])
def test_what_is_kept_is_bounded(raw: int, frame: int) -> None:
    shared = for_two()
    messages = [arrival(raw) for _ in range(100)]
    counter = Counter(frame)
    for message in messages:
        shared.get(message, "none", "/a", counter, True)
    for message in reversed(messages):
        shared.get(message, "none", "/a", counter, True)
    assert 100 - 17 < counter.made - 100 < 100


def test_small_ones_are_bounded_too() -> None:
    shared = for_two()
    messages = [arrival() for _ in range(20_000)]
    counter = Counter()
    for message in messages:
        shared.get(message, "none", "/a", counter, True)
    shared.get(messages[0], "none", "/a", counter, True)
    assert counter.made == 20_001


@pytest.mark.parametrize("may_wait", [True, False])
def test_a_frame_that_is_being_made_is_waited_for(may_wait: bool) -> None:
    shared, message = for_two(), arrival()
    begun, may_end = threading.Event(), threading.Event()
    results: list[str | bytes] = []

    def slow() -> str:
        begun.set()
        assert may_end.wait(10)
        return "frame"

    def get(encode: Callable[[], str]) -> None:
        results.append(shared.get(message, "none", "/a", encode, may_wait))

    counter = Counter()
    threads = [threading.Thread(target=get, args=(slow,)), threading.Thread(target=get, args=(counter,))]
    threads[0].start()
    assert begun.wait(10)
    threads[1].start()
    if not may_wait:  # for example in the thread of the server's loop
        threads[1].join(10)
    may_end.set()
    for thread in threads:
        thread.join(10)
    assert sorted(results) == (["frame", "frame"] if may_wait else ["frame", "x" * 10])
    assert counter.made == (0 if may_wait else 1)


def test_errors_are_not_kept() -> None:
    shared, message = for_two(), arrival()

    def fail() -> str:
        raise MessageError("cut short")

    for _ in range(2):
        with pytest.raises(MessageError, match="cut short"):
            shared.get(message, "none", "/a", fail, True)
    assert shared.get(message, "none", "/a", Counter(2), True) == "xx"


def test_nothing_is_kept_when_one_client_is_left() -> None:
    shared, message, counter = for_two(), arrival(), Counter()
    shared.get(message, "none", "/a", counter, True)
    shared.remove_client()
    shared.add_client()
    shared.get(message, "none", "/a", counter, True)
    assert counter.made == 2


def test_frames_are_dropped_while_another_is_being_made() -> None:
    shared = for_two()
    counter = Counter(1 << 20)

    def slow() -> str:
        messages = [arrival() for _ in range(40)]
        for message in [*messages, messages[0]]:
            shared.get(message, "none", "/a", counter, True)
        return "frame"

    assert shared.get(arrival(), "png", "/a", slow, True) == "frame"
    assert counter.made == 41


def test_nothing_is_kept_if_the_other_client_goes_meanwhile() -> None:
    shared, message, counter = for_two(), arrival(), Counter()

    def encode() -> str:
        shared.remove_client()
        return "frame"

    shared.get(message, "none", "/a", encode, True)
    shared.add_client()
    shared.get(message, "none", "/a", counter, True)
    assert counter.made == 1
