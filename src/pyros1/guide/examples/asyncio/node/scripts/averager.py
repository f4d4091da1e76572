#!/usr/bin/env python3
"""Averages numbers in an asyncio program: subscribes, publishes and provides a service, all in one thread.

pyros1 run my_package averager.py
pyros1 topic pub -r 5 numbers std_msgs/Float64 1.5     publishes numbers, in another terminal
pyros1 topic echo average
pyros1 service call reset                        starts over
"""

import asyncio

import pyros1.aio
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.msgs.std_srvs.srv import Empty, EmptyResponse


class Averager:
    """Averages the received numbers. No locks are needed, since all its methods run on the asyncio loop."""

    def __init__(self, node):
        self.node = node
        self.count = 0
        self.sum = 0.0

    async def receive(self):
        async for message in self.node.messages("numbers", Float64):
            self.count += 1
            self.sum += message.data

    async def publish(self):
        publisher = await self.node.advertise("average", Float64, queue_size=1)
        while self.node.ok():
            if self.count:
                publisher.publish(Float64(self.sum / self.count))
            await asyncio.sleep(0.2)

    async def reset(self, request):
        self.count, self.sum = 0, 0.0
        return EmptyResponse()


async def main():
    async with pyros1.aio.Node("averager") as node:
        averager = Averager(node)
        await node.advertise_service("reset", Empty, averager.reset)
        await asyncio.gather(averager.receive(), averager.publish())  # until Ctrl-C


asyncio.run(main())
