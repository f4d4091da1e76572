"""Synchronized messages for asyncio programs."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Mapping
from contextlib import AsyncExitStack
from typing import TYPE_CHECKING, Any

from pyros1.filters.synchronizers import make_matcher, stamp_of
from pyros1.ground.timing import Time

if TYPE_CHECKING:
    from pyros1.aio import Node


async def synchronized(
    node: Node,
    topics: Mapping[str, Any],
    *,
    queue_size: int = 10,
    slop: float | None = None,
    headerless: bool = False,
) -> AsyncIterator[tuple[Any, ...]]:
    """Iterate over sets of messages with equal or nearly equal time stamps, until the node shuts down.

    A slow iteration slows down the publishers, as with a single topic. When time jumps back, waiting messages are
    discarded.

    Args:
        node: an asyncio node.
        topics: the message class or type name of each topic; the messages in a set are in the order of the topics.
        queue_size, slop, headerless: see `pyros1.filters.Synchronizer`.

    Raises:
        TypeError: a message has no header, and ``headerless`` is False.
    """
    matcher = make_matcher(len(topics), queue_size, slop)
    ready: asyncio.Queue[tuple[Any, ...]] = asyncio.Queue(1)
    last_time = Time()

    async def read_topic(index: int, stream: Any) -> None:
        nonlocal last_time
        async for message in stream:
            now = node.now()
            if now < last_time:
                matcher.clear()
            last_time = now
            for messages in matcher.add(index, stamp_of(message, now if headerless else None), message):
                await ready.put(messages)

    async with AsyncExitStack() as stack:
        streams = [await stack.enter_async_context(await node.subscribe(*topic)) for topic in topics.items()]
        readers = asyncio.gather(*(read_topic(*indexed_stream) for indexed_stream in enumerate(streams)))
        try:
            while True:
                next_set = asyncio.ensure_future(ready.get())
                futures: set[asyncio.Future[Any]] = {next_set, readers}
                try:
                    await asyncio.wait(futures, return_when=asyncio.FIRST_COMPLETED)
                    if not next_set.done() and ready.empty():
                        break
                    messages = await next_set
                finally:
                    next_set.cancel()
                yield messages
            await readers  # raises the exception of a reader, if any
        finally:
            readers.cancel()
            await asyncio.gather(readers, return_exceptions=True)
