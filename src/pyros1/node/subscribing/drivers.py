"""Drivers, which run deliveries: the node's threads (`threads.py`), or an asyncio loop (`pyros1.aio.driver`)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol


class Channel(Protocol):
    """A channel, which a driver runs: a subscription's `Delivery`.

    Attributes:
        driver: its current driver, which may change.
    """

    @property
    def driver(self) -> Driver: ...

    def run(self, fd: int | None) -> None:
        """Do the pending work; ``fd`` is a descriptor that can be read."""


class Driver(Protocol):
    """A driver, which calls `Channel.run` when work is pending.

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
        """Watch a socket again after its channel was run."""

    def unregister(self, fd: int) -> None:
        """Unregister a socket; call this before closing it."""

    def wake(self, channel: Channel) -> None:
        """Run a channel soon. Any thread."""

    def call(self, function: Callable[[], None], timeout: float) -> None:
        """Call a function that unregisters sockets, in the right thread; wait for it at most ``timeout`` seconds."""


class StreamState(Protocol):
    """A subscriber with its own queue, such as an asyncio iteration."""

    @property
    def full(self) -> bool:
        """Whether its queue is full, so that publishers must be held back."""

    @property
    def wants_newest(self) -> bool:
        """Whether messages must be received even while their consumer is busy, so that the newest ones are kept."""

    @property
    def urgent(self) -> bool:
        """Whether it waits for a message, so that full queues of other streams must not hold publishers back."""
