"""Actions in asyncio programs."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from typing import Any

import pytest

import pyros1.aio
from pyros1.actions import AsyncClient, AsyncServer, GoalError, ServerGoal, Status
from pyros1.ground.errors import WaitTimeoutError
from pyros1.msgs.actionlib_tutorials.msg import FibonacciAction, FibonacciFeedback, FibonacciGoal, FibonacciResult


def run(work: Callable[[], Coroutine[Any, Any, None]]) -> None:
    asyncio.run(asyncio.wait_for(work(), 30))


async def execute(goal: ServerGoal) -> Any:
    match goal.goal.order:
        case 0:
            raise ValueError("no")
        case 100:
            await asyncio.sleep(30)
        case 101:
            try:
                await asyncio.sleep(30)
            except asyncio.CancelledError:
                goal.cancel(FibonacciResult(sequence=[9]), "stopped")
                return None
        case 102:
            return None
        case 103:  # ends when its client has seen what it says: a result may be quicker than feedback
            for number in range(3):
                goal.feedback(FibonacciFeedback(sequence=[number]))
            await asyncio.sleep(30)
    for number in range(goal.goal.order):
        goal.feedback(FibonacciFeedback(sequence=[number]))
        await asyncio.sleep(0)
    return FibonacciResult(sequence=[goal.goal.order])


def with_both(
    environ: dict[str, str], work: Callable[[AsyncClient], Coroutine[Any, Any, None]], **options: Any
) -> None:
    async def body() -> None:
        async with (
            pyros1.aio.Node("server", argv=[], environ=environ, handle_signals=False) as serving,
            pyros1.aio.Node("client", argv=[], environ=environ, handle_signals=False) as asking,
            AsyncServer(serving, "fibonacci", FibonacciAction, execute, **options),
            AsyncClient(asking, "fibonacci", FibonacciAction) as client,
        ):
            assert await client.wait_for_server(20)
            await work(client)

    run(body)


def test_goals_at_once_with_feedback(environ: dict[str, str]) -> None:
    async def work(client: AsyncClient) -> None:
        goals = [await client.send(FibonacciGoal(order=order)) for order in range(1, 11)]
        results = await asyncio.gather(*(goal.result(20) for goal in goals))
        assert [result.sequence for result in results] == [(order,) for order in range(1, 11)]
        assert all(goal.done and goal.status is Status.SUCCEEDED for goal in goals)
        goal = await client.send(FibonacciGoal(order=103))
        seen = []
        async for message in goal.feedback(20):
            seen.append(message.sequence[0])
            if len(seen) == 3:
                goal.cancel()
        assert seen == [0, 1, 2]
        assert goal.done

    with_both(environ, work)


def test_a_task_is_cancelled_with_its_goal(environ: dict[str, str]) -> None:
    async def work(client: AsyncClient) -> None:
        plain = await client.send(FibonacciGoal(order=100))
        answering = await client.send(FibonacciGoal(order=101))
        with pytest.raises(WaitTimeoutError):
            await plain.result(0.01)
        with pytest.raises(WaitTimeoutError):
            await anext(plain.feedback(0.01))
        plain.cancel()
        assert await plain.wait(20)
        assert plain.status in (Status.PREEMPTED, Status.RECALLED)
        assert not answering.done
        client.cancel_all()
        assert await answering.wait(20)
        assert answering.status in (Status.PREEMPTED, Status.RECALLED)

    with_both(environ, work)


def test_goals_that_fail(environ: dict[str, str]) -> None:
    async def work(client: AsyncClient) -> None:
        for order, text in (0, "ValueError: no"), (102, "returned without finishing the goal"):
            goal = await client.send(FibonacciGoal(order=order))
            with pytest.raises(GoalError, match=text):
                await goal.result(20)
            assert goal.text
        one = await client.send(FibonacciGoal(order=100))
        while one.status is not Status.ACTIVE:
            await asyncio.sleep(0.01)
        other = await client.send(FibonacciGoal(order=1))
        with pytest.raises(GoalError, match="REJECTED"):
            await other.result(20)
        one.forget()
        assert one.status is Status.LOST

    with_both(environ, work, most=1)


def test_a_client_needs_its_with(environ: dict[str, str]) -> None:
    client = AsyncClient(pyros1.aio.Node("client"), "fibonacci", FibonacciAction)
    with pytest.raises(RuntimeError, match="async with"):
        client.cancel_all()
