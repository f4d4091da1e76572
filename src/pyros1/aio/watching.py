"""The sightings of a watched node, for ``async for``."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import AsyncIterator
from types import TracebackType
from typing import TYPE_CHECKING

from pyros1.node.watching.notifiers import MAX_PENDING

if TYPE_CHECKING:
    from collections.abc import Callable

    from pyros1.node.watching.liveness import Sighting, State
    from pyros1.node.watching.watch import Watch


class Sightings:
    """The sightings of a watched node, for ``async for``; created by ``Node.watch``. Ends when the node shuts down.

    If more than 100 sightings are queued, the oldest are dropped. The object is also a context manager that ends the
    watch.

    Args:
        loop: the asyncio loop in which the iteration runs.
        begin: starts the watch and returns it; the argument is a function that the watch calls with each Sighting, in
            a thread of the node.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop, begin: Callable[[Callable[[Sighting], None]], Watch]) -> None:
        self._loop = loop
        self._queue: deque[Sighting] = deque(maxlen=MAX_PENDING)
        self._ready = asyncio.Event()
        self._ended = False
        self._watch = begin(self._on_sighting)

    def _on_sighting(self, sighting: Sighting) -> None:
        self._queue.append(sighting)
        self._wake()

    def _wake(self) -> None:
        try:
            self._loop.call_soon_threadsafe(self._ready.set)
        except RuntimeError:  # the asyncio loop is closed, so nothing iterates any more
            self._ended = True

    @property
    def state(self) -> State:
        """The current state of the watched node."""
        return self._watch.state

    @property
    def alive(self) -> bool:
        """Whether the watched node is running."""
        return self._watch.alive

    @property
    def last(self) -> Sighting | None:
        """The newest sighting, whether or not the iteration has returned it."""
        return self._watch.last

    def close(self) -> None:
        """End the watch, and the iteration after the queued sightings. Thread-safe."""
        self._ended = True
        self._watch.close()
        self._wake()

    def __aiter__(self) -> AsyncIterator[Sighting]:
        return self

    async def __anext__(self) -> Sighting:
        while not self._queue:
            if self._ended:
                raise StopAsyncIteration
            self._ready.clear()
            if not self._queue and not self._ended:  # check again, now that the event is cleared
                await self._ready.wait()
        return self._queue.popleft()

    def __enter__(self) -> Sightings:
        return self

    def __exit__(
        self, error_class: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
