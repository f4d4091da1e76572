"""aio: the asyncio face.

Feature: asyncio -- `async for message in node.messages(...)`; backpressure from slow loops; Ctrl-C ends it cleanly
"""

from __future__ import annotations

import asyncio
import itertools
import os
import signal
import subprocess
import sys
import textwrap
import threading
from collections.abc import Callable, Coroutine, Iterator
from typing import Any

import pytest

import pyros1.aio
from pyros1.aio.messages import MAX_PENDING
from pyros1.ground.errors import NodeShutdownError, ServiceError, WaitTimeoutError
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.node.subscribing.delivery_loop import MAX_BATCH


def run(work: Callable[[], Coroutine[Any, Any, None]]) -> None:
    asyncio.run(asyncio.wait_for(work(), 20))


def test_messages_arrive_in_order_and_the_iteration_ends_with_the_node(environ: dict[str, str]) -> None:
    async def work() -> None:
        async with (
            pyros1.aio.Node("talker", argv=[], environ=environ) as talker,
            pyros1.aio.Node("listener", argv=[], environ=environ) as listener,
        ):
            stream = await listener.subscribe("topic1", Float64)
            publisher = await talker.advertise("topic1", Float64, queue_size=0)
            assert await asyncio.to_thread(publisher.wait_for_subscribers, 1, 20.0)
            for number in range(1000):
                publisher.publish(float(number))
            got = [(await stream.__anext__()).data for _ in range(1000)]
            assert got == [float(number) for number in range(1000)]
            quiet = await listener.subscribe("quiet", Float64)
            task = asyncio.ensure_future(collect(quiet))
            await asyncio.to_thread(listener.sync.shutdown)
            assert await task == []

    async def collect(stream: pyros1.aio.Messages[Float64]) -> list[Any]:
        return [message async for message in stream]

    run(work)


def test_queue_size_keeps_the_newest(environ: dict[str, str]) -> None:
    async def work() -> None:
        async with pyros1.aio.Node("both", argv=[], environ=environ) as node:
            stream = await node.subscribe("topic1", Float64, queue_size=1)
            probe = await node.subscribe("topic1", Float64)
            publisher = await node.advertise("topic1", Float64)
            assert await asyncio.to_thread(publisher.wait_for_subscribers, 1, 20.0)
            for number in range(100):
                publisher.publish(float(number))
            while (await probe.__anext__()).data < 99:
                pass
            assert (await stream.__anext__()).data == 99

    run(work)


def test_services_with_coroutine_handlers(environ: dict[str, str]) -> None:
    async def flip(request: Any) -> Any:
        await asyncio.sleep(0)
        if request.data:
            raise RuntimeError("not today")
        return True, "flipped"

    async def work() -> None:
        async with pyros1.aio.Node("server", argv=[], environ=environ) as node:
            await node.advertise_service("flip", "std_srvs/SetBool", flip)
            await node.wait_for_service("flip", 20.0)
            client = node.service("flip", "std_srvs/SetBool")
            assert (await node.call(client, False)).message == "flipped"
            with pytest.raises(ServiceError, match="not today"):
                await node.call(client, True)

    run(work)


def test_wait_for_message_and_parameters(environ: dict[str, str]) -> None:
    async def work() -> None:
        async with pyros1.aio.Node("waiter", argv=[], environ=environ) as node:
            with pytest.raises(WaitTimeoutError, match="nothing"):
                await node.wait_for_message("nothing", Float64, timeout=0.05)
            publisher = await node.advertise("once", Float64, latch=True)
            publisher.publish(4.0)
            assert (await node.wait_for_message("once", Float64, timeout=20)).data == 4.0
            await node.set_param("~gain", 2.5)
            assert await node.get_param("~gain") == 2.5
            assert await node.get_param("~other", "none") == "none"

    run(work)


def test_a_slow_coroutine_handler_answers(environ: dict[str, str]) -> None:
    async def slow(request: Any) -> Any:
        await asyncio.sleep(0.7)  # longer than the handler's thread waits at a time
        return True, "done"

    async def work() -> None:
        async with pyros1.aio.Node("server", argv=[], environ=environ) as node:
            await node.advertise_service("slow", "std_srvs/Trigger", slow)
            assert (await node.call(node.service("slow", "std_srvs/Trigger"))).message == "done"

    run(work)


def test_what_would_block_is_refused_and_nothing_is_used_before_it_is_there(environ: dict[str, str]) -> None:
    async def work() -> None:
        node = pyros1.aio.Node("early", argv=[], environ=environ)
        assert not node.ok()
        with pytest.raises(NodeShutdownError, match="async with"):
            _ = node.name
        async with node:
            assert node.ok() and node.name == "/early"
            with pytest.raises(ValueError, match="queue_size=None"):
                await node.advertise("t", Float64, queue_size=None)
        assert not node.ok()

    run(work)


def test_closing_a_stream_unsubscribes_and_ends_it(environ: dict[str, str]) -> None:
    async def work() -> None:
        async with pyros1.aio.Node("listener", argv=[], environ=environ) as node:
            stream = await node.subscribe("t", Float64)
            task = asyncio.ensure_future(_all(stream))
            await asyncio.sleep(0)
            await stream.aclose()
            await stream.aclose()
            assert await task == []
            assert "/t" not in dict(node.sync.master.get_system_state()[1])

    async def _all(stream: Any) -> list[Any]:
        return [message async for message in stream]

    run(work)


def test_a_wait_for_a_message_in_the_body_of_a_full_iteration(
    environ: dict[str, str], make_node: Any, transport: str
) -> None:
    """The iteration, which waits for it, holds the publisher back; the wait is served all the same."""
    publisher = make_node("talker").advertise("t", Float64, queue_size=None)  # waits for its subscribers
    enough = threading.Event()

    def talk() -> None:
        for number in itertools.count():
            publisher.publish(number)
            if enough.is_set():
                return

    async def work() -> None:
        async with pyros1.aio.Node("listener", argv=[], environ=environ) as node:
            stream = await node.subscribe("t", Float64)
            other = await node.subscribe("t", Float64)
            assert await asyncio.to_thread(publisher.wait_for_subscribers, 1, 10)
            talking = asyncio.ensure_future(asyncio.to_thread(talk))
            got = []
            try:
                for _ in range(3):
                    got.append((await stream.__anext__()).data)
                    while max(stream.waiting, other.waiting) < MAX_PENDING:
                        await asyncio.sleep(0.001)
                    waited = await node.wait_for_message("/t", Float64, timeout=10)
                    assert waited.data > got[-1]
            finally:
                enough.set()
                await other.aclose()
            while stream.waiting or not talking.done():
                if stream.waiting:
                    got.append((await stream.__anext__()).data)
                await asyncio.sleep(0)
            assert got == list(range(len(got)))

    run(work)


def test_wrong_arguments_are_refused_at_once(environ: dict[str, str], make_node: Any) -> None:
    async def work() -> None:
        with pytest.raises(TypeError, match="does not accept callbacks="):
            pyros1.aio.Node("n", callbacks="spin")
        with pytest.raises(NodeShutdownError, match="async with"):
            await pyros1.aio.Node("n").subscribe("t", Float64)
        async with pyros1.aio.Node("n", argv=[], environ=environ) as node:
            for wrong, text in (
                (node.subscribe("t", Float64, queue_size="x"), "queue_size must be a whole number or None, not 'x'"),  # type: ignore[arg-type]
                (node.subscribe(5, Float64), "subscribe: the name must be a str, not 5"),  # type: ignore[arg-type]
                (node.wait_for_message("t", Float64, "x"), "timeout must be a number of seconds, not 'x'"),  # type: ignore[arg-type]
                (node.wait_for_message(5, Float64), "wait_for_message: the name must be a str, not 5"),  # type: ignore[arg-type]
                (node.advertise_service("s", "std_srvs/Trigger", 5), "handler must be a function, not 5"),  # type: ignore[arg-type]
                (node.call(5), "call: the client must come from service"),  # type: ignore[arg-type]
            ):
                with pytest.raises(TypeError, match=text):
                    await wrong
            with pytest.raises(ValueError, match="queue_size must be at least 1, or None, not -1"):
                await node.subscribe("t", Float64, queue_size=-1)

    run(work)


def test_who_takes_messages_slowly_holds_the_publisher_back(
    environ: dict[str, str], make_node: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.node.subscribing.connector.find_local_context", lambda uri: None)
    talker, count = make_node("talker"), 100 * MAX_PENDING
    publisher = talker.advertise("topic1", Float64, queue_size=None)

    def publish() -> None:
        assert publisher.wait_for_subscribers(timeout=20)
        for number in range(count):
            publisher.publish(float(number))

    async def work() -> None:
        async with pyros1.aio.Node("listener", argv=[], environ=environ) as node:
            stream = await node.subscribe("topic1", Float64)
            publishing = asyncio.ensure_future(asyncio.to_thread(publish))
            while stream.waiting < MAX_PENDING:
                await asyncio.sleep(0.001)
            most, got = 0, []
            async for message in stream:
                most = max(most, stream.waiting + 1)
                got.append(message.data)
                if len(got) == count:
                    break
            assert got == [float(number) for number in range(count)]
            assert most < MAX_PENDING + MAX_BATCH
            await publishing

    run(work)


def test_a_stream_that_nobody_reads_holds_up_no_end(
    environ: dict[str, str], make_node: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.node.subscribing.connector.find_local_context", lambda uri: None)
    publisher = make_node("talker").advertise("topic1", Float64, queue_size=0)

    async def work() -> None:
        async with pyros1.aio.Node("listener", argv=[], environ=environ) as node:
            kept = await node.subscribe("topic1", Float64)
            closed = await node.subscribe("topic1", Float64)
            await asyncio.to_thread(publisher.wait_for_subscribers, 1, 20.0)
            for number in range(10 * MAX_PENDING):
                publisher.publish(float(number))
            while kept.waiting < MAX_PENDING and closed.waiting < MAX_PENDING:
                await asyncio.sleep(0.001)
            await closed.aclose()

    run(work)


# In a process of their own --------------------------------------------------------------------------------------------

PROGRAM = """
import asyncio
import pyros1.aio
from pyros1.msgs.std_msgs.msg import Float64

async def main():
    async with pyros1.aio.Node("listener") as node:
        node.sync.on_shutdown(lambda: print("hook"))
        print("ready")
        BODY
    print("left")

asyncio.run(main())
"""


class Started:
    """A program that ignored SIGINT when it began, as one that a script starts with ``&``."""

    def __init__(self, text: str, environ: dict[str, str]) -> None:
        ignoring = "import signal, os, sys; signal.signal(2, signal.SIG_IGN); os.execv(sys.executable, sys.argv[1:])"
        words = [sys.executable, "-u", "-W", "error", "-c", text]
        self.process = subprocess.Popen(
            [sys.executable, "-c", ignoring, *words],
            env={**os.environ, **environ},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            bufsize=0,
        )

    def line(self) -> str:
        assert self.process.stdout is not None
        line: bytes = self.process.stdout.readline()
        return line.decode()

    def end(self) -> tuple[int, str, str]:
        out, err = self.process.communicate(timeout=20)
        return self.process.returncode, out.decode(), err.decode()


@pytest.fixture
def start(environ: dict[str, str]) -> Iterator[Callable[[str], Started]]:
    """Return a function that starts a program."""
    started: list[Started] = []

    def run_program(text: str) -> Started:
        started.append(Started(text, environ))
        return started[-1]

    yield run_program
    for program in started:
        if program.process.poll() is None:
            program.process.kill()
        program.process.communicate()


BODIES = {
    "messages": """
        async for message in node.messages("topic1", Float64):
            print(message.data)
        """,
    "a wait of asyncio": "await asyncio.Event().wait()",
    "a wait of the node": "await node.wait_for_message('topic1', Float64)",
    "a wait for a service": "await node.wait_for_service('nothing')",
    "tasks": "await asyncio.gather(asyncio.sleep(100), node.wait_for_service('nothing'))",
    "its loop": """
        while node.ok():
            await asyncio.sleep(0.01)
        """,
}


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES.keys())
def test_a_signal_ends_the_program_cleanly(start: Callable[[str], Started], body: str, number: int) -> None:
    body = textwrap.indent(textwrap.dedent(body).strip(), "        ").strip()
    program = start(PROGRAM.replace("BODY", body))
    assert program.line() == "ready\n"
    program.process.send_signal(number)
    assert program.end() == (0, "hook\nleft\n", "")


@pytest.mark.slow
def test_two_signals_at_once_are_one(start: Callable[[str], Started]) -> None:
    program = start(PROGRAM.replace("BODY", BODIES["a wait of asyncio"]))
    assert program.line() == "ready\n"
    program.process.send_signal(signal.SIGINT)
    program.process.send_signal(signal.SIGTERM)
    assert program.end() == (0, "hook\nleft\n", "")


@pytest.mark.slow
def test_a_signal_that_does_not_wake_the_loop_is_noticed(start: Callable[[str], Started]) -> None:
    """As one that comes just before the loop begins to wait: here another thread gets it."""
    body = """
        import signal, threading
        threading.Thread(target=lambda: signal.pthread_kill(threading.get_ident(), signal.SIGINT)).start()
        await asyncio.sleep(100)
    """
    assert start(PROGRAM.replace("BODY", body)).end() == (0, "ready\nhook\nleft\n", "")


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_second_signal_ends_a_program_that_goes_on(start: Callable[[str], Started], number: int) -> None:
    program = start(
        """
import asyncio, time
import pyros1.aio

async def robot():
    async with pyros1.aio.Node("robot") as node:
        print("ready")
        await asyncio.sleep(100)
    await asyncio.sleep(0.1)  # a second signal is one that a person can have meant
    print("left")

async def other():
    try:
        await asyncio.sleep(100)
    finally:
        print("cancelled")

async def main():
    await asyncio.gather(robot(), other())

asyncio.run(main())
"""
    )
    assert program.line() == "ready\n"
    program.process.send_signal(signal.SIGINT)
    assert program.line() == "left\n"
    program.process.send_signal(number)
    assert program.end() == (128 + number, "cancelled\n", "")


@pytest.mark.slow
def test_ctrl_c_while_the_master_is_asked_ends_the_program(start: Callable[[str], Started]) -> None:
    program = """
import asyncio, os, signal, threading
import pyros1.aio
import pyros1.node.node as starting
ask, ended = starting.set_private, threading.Event()

def interrupted(master, *others):
    close = master.close
    master.close = lambda: (close(), ended.set())
    os.kill(os.getpid(), signal.SIGINT)
    assert ended.wait(10)
    return ask(master, *others)

starting.set_private = interrupted

async def main():
    async with pyros1.aio.Node("early"):
        print("never")

asyncio.run(main())
"""
    assert start(program).end() == (130, "", "")


@pytest.mark.slow
def test_ctrl_c_while_waiting_for_the_master_ends_the_program(
    start: Callable[[str], Started], environ: dict[str, str], closed_port: int
) -> None:
    environ["ROS_MASTER_URI"] = f"http://localhost:{closed_port}/"
    program = start(PROGRAM.replace("BODY", "pass"))
    assert program.process.stderr is not None
    assert b"Unable to immediately register" in program.process.stderr.readline()
    program.process.send_signal(signal.SIGINT)
    assert program.end() == (130, "", "")


@pytest.mark.slow
def test_signals_may_stay_with_the_program(start: Callable[[str], Started]) -> None:
    text = PROGRAM.replace('Node("listener")', 'Node("listener", handle_signals=False)')
    program = start(
        "import signal\nsignal.signal(2, lambda *_: print('mine'))\n" + text.replace("BODY", "await asyncio.sleep(100)")
    )
    assert program.line() == "ready\n"
    program.process.send_signal(signal.SIGINT)
    assert program.line() == "mine\n"
    program.process.kill()
