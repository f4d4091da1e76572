"""Remappings of an action's name move all its topics, and one of a single topic moves that topic."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

import pytest

import pyros1.aio
from pyros1.actions import AsyncClient, AsyncServer, Client, Server, ServerGoal, SimpleServer
from pyros1.msgs.actionlib_tutorials.msg import FibonacciAction, FibonacciGoal, FibonacciResult
from pyros1.node import Node
from pyros1.tf import Buffer, BufferClient, BufferServer

from ..parts import context_of

Make = Callable[..., Node]
ENDS = ("cancel", "feedback", "goal", "result", "status")
REMAPPINGS = ["work:=/other/job", "/other/job/status:=/where", "/other/job:=/not/again"]


def topics(node: Node) -> list[str]:
    """Return the topics of a node, without those of every node."""
    context = context_of(node)
    return sorted({*context.publications, *context.subscriptions} - {"/rosout"})


@pytest.mark.parametrize(
    ("argv", "name", "expected"),
    [
        ([], "work", [f"/ns/work/{end}" for end in ENDS]),
        (REMAPPINGS, "work", [*(f"/other/job/{end}" for end in ENDS[:-1]), "/where"]),
        (["/ns/work:=job"], "work/", [f"/ns/job/{end}" for end in ENDS]),
        (["work:=/not"], "/work", [f"/work/{end}" for end in ENDS]),
        (["~work:=/robot"], "~work", [f"/robot/{end}" for end in ENDS]),
        (["work/goal:=/goals"], "work", ["/goals", *(f"/ns/work/{end}" for end in ENDS if end != "goal")]),
    ],
)
@pytest.mark.parametrize("make", [
    lambda node, name: Client(node, name, FibonacciAction),
    lambda node, name: Server(node, name, FibonacciAction, print),
    lambda node, name: SimpleServer(node, name, FibonacciAction, print),
    lambda node, name: BufferServer(node, Buffer(), name),
    BufferClient,
])  # fmt: skip
def test_topics(make_node: Make, make: Callable[..., Any], argv: list[str], name: str, expected: list[str]) -> None:
    node = make_node("node", namespace="/ns", argv=argv)
    made = make(node, name)
    found = topics(node)
    if isinstance(made, BufferClient):  # asks for no feedback, and ends with its node
        expected = [each for each in expected if not each.endswith("/feedback")]
    else:
        made.close()
    assert found == expected


def test_asyncio_programs_are_remapped_too(environ: dict[str, str], make_node: Make) -> None:
    async def execute(goal: ServerGoal) -> Any:
        return FibonacciResult(sequence=[goal.goal.order])

    async def body() -> None:
        options: Any = {"environ": environ, "handle_signals": False}
        async with (
            pyros1.aio.Node("server", argv=REMAPPINGS, **options) as serving,
            pyros1.aio.Node("client", argv=["job:=/other/job", "/other/job/status:=/where"], **options) as asking,
            AsyncServer(serving, "work", FibonacciAction, execute),
            AsyncClient(asking, "job", FibonacciAction) as client,
        ):
            goal = await client.send(FibonacciGoal(order=7), timeout=20)
            assert (await goal.result(20)).sequence == (7,)

    asyncio.run(asyncio.wait_for(body(), 30))
