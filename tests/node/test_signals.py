"""signals: what a handler may do on top of whatever it has interrupted (the program is ``interrupted.py``).

Each case is a process of its own, that ends with all stacks shown if it hangs.

Feature: signal handlers can publish, log, use parameters, call services and shut the node down -- whatever they
    interrupt
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import pyros1
from pyros1.node.signals import SignalHandlers

SRC = str(Path(pyros1.__file__).parent.parent)
PROGRAM = Path(__file__).with_name("interrupted.py")
MAINS = ["rate", "sleep", "params", "cached", "log", "print", "service", "persistent", "spin", "advertise", "wait"]


@pytest.fixture
def run(environ: dict[str, str]) -> Callable[..., None]:
    """Return a function that runs a scenario."""

    def run(*words: object, **variables: str) -> None:
        process = subprocess.run(
            [sys.executable, "-W", "error", str(PROGRAM), *map(str, words)],
            env={**os.environ, **environ, "PYTHONPATH": SRC, **variables},
            capture_output=True,
            check=False,
            text=True,
            timeout=60,
        )
        said = "\n".join(line for line in process.stdout.splitlines() if "[INFO]" not in line)
        assert process.returncode == 0, f"{said[-2000:]}\n{process.stderr[-10_000:]}"

    return run


@pytest.mark.slow
@pytest.mark.parametrize("latch", ["", "latch"])
@pytest.mark.parametrize("queue_size", [None, 0, 10])
@pytest.mark.parametrize("transport", ["local", "tcp"])
def test_publishing_on_top_of_publishing(
    run: Callable[..., None], transport: str, queue_size: int | None, latch: str
) -> None:
    run("publishing", transport, queue_size, latch)


@pytest.mark.slow
@pytest.mark.parametrize("main", MAINS)
def test_everything_that_is_promised_on_top_of_everything(run: Callable[..., None], main: str) -> None:
    run(f"everything:{main}", "tcp" if main == "rate" else "local")


@pytest.mark.slow
@pytest.mark.parametrize("main", ["publish", "rate", "spin", "params"])
def test_the_last_message_and_the_end_of_the_node(run: Callable[..., None], main: str) -> None:
    run(f"ending:{main}", "tcp" if main == "publish" else "local")


@pytest.mark.parametrize("queue_size", [None, 0])
@pytest.mark.parametrize("transport", ["local", "tcp"])
def test_a_handler_that_raises_tears_no_frame(run: Callable[..., None], transport: str, queue_size: int | None) -> None:
    run("raising", transport, queue_size)


@pytest.mark.slow
@pytest.mark.parametrize(
    "words",
    [("publishing", "tcp", None, ""), ("everything:service", "tcp"), ("ending:publish", "tcp")],
    ids=lambda w: w[0],
)
def test_the_same_without_epoll(run: Callable[..., None], words: tuple[object, ...]) -> None:
    run(*words, PORTABLE="1")


COURSE = """
import asyncio, signal, sys, time
import pyros1, pyros1.aio
from pyros1.msgs.geometry_msgs.msg import Twist

moving = Twist()
moving.linear.x = 1.0
going = True

def stop(publisher, log):
    def handle(*_):
        global going
        going = False
        publisher.publish(Twist())
        log.info("stopped")
    signal.signal(signal.SIGINT, handle)

def sync(callbacks):
    with pyros1.Node("driver", callbacks=callbacks) as node:
        publisher = node.advertise("cmd_vel", Twist, queue_size=1)
        publisher.wait_for_subscribers()
        stop(publisher, node.log)
        rate = node.rate(1000)
        while going:
            publisher.publish(moving) if going else None
            node.spin_once(0.001) if callbacks == "spin" else rate.sleep()

async def driver():
    async with pyros1.aio.Node("driver") as node:
        publisher = await node.advertise("cmd_vel", Twist, queue_size=1)
        publisher.wait_for_subscribers()
        stop(publisher, node.sync.log)
        while going:
            publisher.publish(moving)
            await asyncio.sleep(0.001)

asyncio.run(driver()) if sys.argv[1] == "asyncio" else sync(sys.argv[1])
"""


@pytest.mark.parametrize("kind", ["inline", "spin", "asyncio"])
def test_a_sigint_handler_that_stops_the_robot(
    make_node: Any, collect: Any, environ: dict[str, str], kind: str
) -> None:
    robot, got = make_node("robot"), collect()
    robot.subscribe("cmd_vel", "geometry_msgs/Twist", lambda message: got(message.linear.x))
    process = subprocess.Popen(
        [sys.executable, "-W", "error", "-c", COURSE, kind],
        env={**os.environ, **environ, "PYTHONPATH": SRC},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        got.wait(20)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=20)
    finally:
        process.kill()
        process.wait()
    assert process.returncode == 0 and err == "" and "stopped" in out
    assert got.until(lambda speeds: speeds[-1] == 0.0)


def test_the_handler_of_the_program_comes_before_the_end_of_the_node() -> None:
    done: list[Any] = []
    signal.signal(signal.SIGINT, lambda number, _: done.append("program"))
    handlers = SignalHandlers(lambda number: done.append("node"))
    handlers.install()
    signal.raise_signal(signal.SIGINT)
    signal.raise_signal(signal.SIGINT)
    handlers.restore()
    assert done == ["program", "node", "program"]
