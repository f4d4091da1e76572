"""The asyncio face: the same verbs as :class:`pyros1.Node`, awaitable.

::

    import asyncio
    import pyros1.aio
    from pyros1.msgs.std_msgs.msg import Float64

    async def main():
        async with pyros1.aio.Node("listener") as node:
            async for message in node.messages("topic1", Float64):
                print(message.data)

    asyncio.run(main())

The asyncio loop itself receives the messages that iterations wait for, by the same rules as the threads of a
:class:`pyros1.Node`: it drives the same deliveries (``driver.py``). A message is decoded when its turn in the iteration
comes. Whoever takes messages slowly holds the publishers back, or gets the newest, see ``queue_size``. Nothing here
blocks the asyncio loop: what must talk to the master or to another node runs in a worker thread.

SIGINT and SIGTERM end the node: its hooks run, iterations and waits end, and with them the body of ``async with``, so
that the program comes to its end with exit code 0. Other tasks of the program are its own affair. A second signal ends
the program at once.
"""

from pyros1.aio.messages import Messages
from pyros1.aio.node import Node

__all__ = ["Messages", "Node"]
