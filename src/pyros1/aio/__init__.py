"""The asyncio interface: the methods of :class:`pyros1.Node`, awaitable.

::

    import asyncio
    import pyros1.aio
    from pyros1.msgs.std_msgs.msg import Float64

    async def main():
        async with pyros1.aio.Node("listener") as node:
            async for message in node.messages("topic1", Float64):
                print(message.data)

    asyncio.run(main())

Messages are received as in a :class:`pyros1.Node`. For iterations without a ``queue_size``, which must not lose any
message, the asyncio loop itself receives the messages (``driver.py``), and a slow iteration holds the publishers back.
For iterations with a ``queue_size``, the node's threads receive them, so the iteration gets the newest messages even
after other tasks have kept the loop busy. Messages are decoded when the iteration returns them. Nothing here blocks
the asyncio loop: calls to the master and to other nodes run in worker threads.

To wait for a message with a timeout: ``await asyncio.wait_for(anext(messages), 0.5)``. A message that arrives later is
not lost.

SIGINT and SIGTERM shut the node down: its hooks run, and iterations, waits and the body of ``async with`` end, so
that the program exits with code 0. The program must end other tasks itself. A second signal ends it immediately.
"""

from pyros1.aio.messages import Messages
from pyros1.aio.node import Node
from pyros1.aio.watching import Sightings

__all__ = ["Messages", "Node", "Sightings"]
