"""Drivers, which run deliveries: the node's threads (`threads.py`), or an asyncio loop (`pyros1.aio.driver`)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol


class Channel(Protocol):
    """A channel, which a driver runs: a subscription's `Delivery`.

    Attributes:
        driver: its present driver, which may change.
    """

    @property
    def driver(self) -> Driver: ...

    def run(self, fd: int | None) -> None:
        """Do the waiting work; ``fd`` is a descriptor that can be read."""


class Driver(Protocol):
    """A driver, which calls `Channel.run` when work waits.

    Attributes:
        cooperative: whether `run` must return after each round of turns.
    """

    cooperative: bool

    @property
    def has_waiting_thread(self) -> bool:
        """Whether another thread waits for the next message, so that this one may wait for a link."""

    def register(self, fd: int, channel: Channel) -> None:
        """Run a channel when a socket can be read: once, and again after each `rearm`."""

    def rearm(self, fd: int) -> None:
        """Wait again for a socket whose channel was run."""

    def unregister(self, fd: int) -> None:
        """Forget a socket; call this before closing it."""

    def wake(self, channel: Channel) -> None:
        """Run a channel soon. Any thread."""

    def call(self, function: Callable[[], None], timeout: float) -> None:
        """Call a function that unregisters sockets, in the thread for that; wait for it at most ``timeout`` seconds."""


class StreamState(Protocol):
    """A subscriber with its own queue, such as an asyncio iteration."""

    @property
    def full(self) -> bool:
        """Whether its queue is full, so that publishers must be held back."""

    @property
    def wants_newest(self) -> bool:
        """Whether messages must be received even while whoever takes them is busy, so that the newest ones wait."""

    @property
    def urgent(self) -> bool:
        """Whether it waits for a message, so that full queues of others must not hold publishers back."""
