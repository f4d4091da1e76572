"""What runs deliveries: the node's threads (`threads.py`), or an asyncio loop (`pyros1.aio.driver`)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol


class Channel(Protocol):
    """What a driver runs: a subscription's `Delivery`.

    Attributes:
        driver: who runs it now; it may move to another.
    """

    @property
    def driver(self) -> Driver: ...

    def run(self, fd: int | None) -> None:
        """Do what there is to do; ``fd`` can be read."""


class Driver(Protocol):
    """Calls `Channel.run` when there is something to do.

    Attributes:
        cooperative: whether `run` gives its thread back after each round of turns.
    """

    cooperative: bool

    @property
    def someone_waits(self) -> bool:
        """Whether a thread is free for what comes next, so that this one may wait for a link."""

    def register(self, fd: int, channel: Channel) -> None:
        """Run a channel when a socket can be read: once, then again after each `rearm`."""

    def rearm(self, fd: int) -> None:
        """Wait again for a socket for which its channel was run."""

    def unregister(self, fd: int) -> None:
        """Forget a socket; to be called before it is closed."""

    def wake(self, channel: Channel) -> None:
        """Run a channel soon. Any thread."""

    def call(self, function: Callable[[], None], timeout: float) -> None:
        """Call a function that unregisters sockets, in the thread for that; wait at most ``timeout`` seconds for it."""


class Holding(Protocol):
    """A subscriber that queues its messages itself, such as an asyncio iteration."""

    @property
    def full(self) -> bool:
        """Whether it has too many, so that publishers are to be held back."""

    @property
    def urgent(self) -> bool:
        """Whether it waits for a message that others must not hold back."""
